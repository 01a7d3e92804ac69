/* See allocate.h. SPDX-License-Identifier: Apache-2.0 */
#include "platform/allocate.h"

#include <stdlib.h>

void *thrum_allocate(int64_t count, size_t size, const char *what, thrum_error *error) {
  void *memory = NULL;
  if (count >= 0 && (uint64_t)count <= SIZE_MAX / 2 / size)
    memory = malloc((size_t)count * size + 1);
  if (!memory)
    thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %s (%.0f MB)", what,
                    (double)count * (double)size / 1048576);
  return memory;
}
