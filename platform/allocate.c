/* See allocate.h. SPDX-License-Identifier: Apache-2.0 */
#include "platform/allocate.h"

#include <stdbool.h>
#include <stdlib.h>

#include "runtime/base/large_memory.h"

/* The memory, or an error that says how much was asked for. */
static void *checked(void *memory, double size, const char *what, thrum_error *error) {
  if (!memory)
    thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %s (%.0f MB)", what, size / 1048576);
  return memory;
}

void *thrum_allocate(int64_t count, size_t size, const char *what, thrum_error *error) {
  const bool fits = count >= 0 && (uint64_t)count <= SIZE_MAX / 2 / size;
  return checked(fits ? malloc((size_t)count * size + 1) : NULL, (double)count * (double)size, what,
                 error);
}

void *thrum_allocate_aligned(size_t size, const char *what, thrum_error *error) {
  const bool fits = size <= SIZE_MAX / 2;
  return checked(fits ? thrum_large_memory(size + 1) : NULL, (double)size, what, error);
}
