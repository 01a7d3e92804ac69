/* Checks of memory of the caller into which an object is laid. Private to Thrum's libraries.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_ALIGNMENT_CHECK_H
#define THRUM_CORE_BASE_ALIGNMENT_CHECK_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

#define THRUM_ALIGNMENT 64u /* alignment of every such object [bytes] */

/* The next multiple of the alignment. */
static inline size_t thrum_round_up(size_t size) {
  return (size + (THRUM_ALIGNMENT - 1)) / THRUM_ALIGNMENT * THRUM_ALIGNMENT;
}

/* Takes an aligned array from the memory at *at, which moves on behind it. */
static inline double *thrum_cut_doubles(unsigned char **at, size_t doubles) {
  double *part = (double *)(void *)*at;
  *at += thrum_round_up(doubles * sizeof(double));
  return part;
}

/* Is `memory`, of memory_size bytes, aligned and large enough for the `size` bytes of `what`? */
static inline thrum_status thrum_alignment_check(const char *what, const void *memory,
                                                 size_t memory_size, size_t size,
                                                 thrum_error *error) {
  if ((uintptr_t)memory % THRUM_ALIGNMENT != 0)
    return thrum_error_set(error, THRUM_MISALIGNED, "the %s's memory is not aligned to %u bytes",
                           what, THRUM_ALIGNMENT);
  if (memory_size < size)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                           "the %s needs %zu bytes, the memory has %zu", what, size, memory_size);
  return THRUM_OK;
}

#endif
