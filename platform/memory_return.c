/* See memory_return.h. SPDX-License-Identifier: Apache-2.0 */
#include "platform/memory_return.h"

#include <stdlib.h>

#ifdef __GLIBC__
#include <malloc.h>

#define LARGE (4 << 20)      /* bytes from which on an array has pages of its own */
#define ARRAYS_MAX (1 << 16) /* with pages of their own, as the library has it by default */
#define TOP_KEPT (32 << 20)  /* bytes that may stay free at the end of the heap */

void memory_return_begin(void) {
  (void)mallopt(M_MMAP_MAX, ARRAYS_MAX);
  (void)mallopt(M_MMAP_THRESHOLD, LARGE);
  (void)mallopt(M_TRIM_THRESHOLD, TOP_KEPT);
}

void memory_return(void) {
  (void)malloc_trim(0);
}

#else

void memory_return_begin(void) {}

void memory_return(void) {}

#endif
