/* An allocator that can be told to fail, for tests that link with --wrap (tests/CMakeLists.txt):
 * every call of the C library's allocator from the libraries and the test comes here.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_FAILING_ALLOCATOR_H
#define THRUM_TESTS_SUPPORT_FAILING_ALLOCATOR_H

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

/* Calls until one fails; 0: none will. */
static int64_t calls_left;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);

static inline bool fails_now(void) {
  return calls_left > 0 && --calls_left == 0;
}

void *__wrap_malloc(size_t size) {
  return fails_now() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size) {
  return fails_now() ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *memory, size_t size) {
  return fails_now() ? NULL : __real_realloc(memory, size);
}

void *__wrap_aligned_alloc(size_t alignment, size_t size) {
  return fails_now() ? NULL : __real_aligned_alloc(alignment, size);
}

/* The next `call` calls but one succeed, that one fails. */
static inline void fail_call(int64_t call) {
  calls_left = call;
}

/* Ends it; whether the call that was to fail has come. */
static inline bool has_failed(void) {
  const bool failed = calls_left == 0;
  calls_left = 0;
  return failed;
}

#endif
