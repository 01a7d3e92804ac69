/* See allocate.h. SPDX-License-Identifier: Apache-2.0 */
#include "platform/allocate.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/large_memory.h"

/* The memory, or an error that says how much was asked for. */
static void *checked(void *memory, double size, const char *what, thrum_error *error) {
  if (!memory)
    thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %s (%.0f MB)", what, size / 1048576);
  return memory;
}

thrum_status thrum_reserve(void *memory, int64_t count, size_t size, const char *what,
                           thrum_error *error) {
  const bool fits = count >= 0 && (uint64_t)count <= SIZE_MAX / 2 / size;
  void *reserved = checked(fits ? calloc((size_t)count * size + 1, 1) : NULL,
                           (double)count * (double)size, what, error);
  memcpy(memory, &reserved, sizeof reserved);
  return reserved ? THRUM_OK : THRUM_OUT_OF_MEMORY;
}

void *thrum_allocate_aligned(size_t size, const char *what, thrum_error *error) {
  return checked(size <= SIZE_MAX / 2 ? thrum_large_memory(size + 1) : NULL, (double)size, what,
                 error);
}

thrum_status thrum_reserve_aligned(void **memory, size_t size, const char *what,
                                   thrum_error *error) {
  *memory = thrum_allocate_aligned(size, what, error);
  return *memory ? THRUM_OK : THRUM_OUT_OF_MEMORY;
}

/* One allocation of a scope. The memory is a block of its own, so that a sanitizer
 * still finds what writes past its end, and large memory keeps its alignment. */
typedef struct thrum_scope_block {
  struct thrum_scope_block *before;
  void *memory;
} thrum_scope_block;

thrum_scope thrum_scope_begin(const char *what, thrum_error *error) {
  return (thrum_scope){.what = what, .error = error};
}

/* Keeps what was allocated, or nothing where there was no memory for it. */
static void *keep(thrum_scope *scope, void *memory) {
  thrum_scope_block *block = NULL;
  if (!memory || thrum_reserve(&block, 1, sizeof *block, scope->what, scope->error) < 0) {
    free(memory);
    scope->status = THRUM_OUT_OF_MEMORY;
    return NULL;
  }
  *block = (thrum_scope_block){scope->last, memory};
  scope->last = block;
  return memory;
}

void *thrum_scope_allocate(thrum_scope *scope, int64_t count, size_t size) {
  if (scope->status < 0)
    return NULL;
  void *memory;
  thrum_reserve(&memory, count, size, scope->what, scope->error);
  return keep(scope, memory);
}

void *thrum_scope_allocate_aligned(thrum_scope *scope, size_t size) {
  if (scope->status < 0)
    return NULL;
  return keep(scope, thrum_allocate_aligned(size, scope->what, scope->error));
}

void thrum_scope_free(thrum_scope *scope) {
  while (scope->last) {
    thrum_scope_block *block = scope->last;
    scope->last = block->before;
    free(block->memory);
    free(block);
  }
}
