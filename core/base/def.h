/* Definitions that a program may know in a shorter form than the library: it was compiled with the
 * headers of an earlier minor version. A def begins with its cookie, which is its size for the
 * caller; what it lacks has its default. New members stand at the end of a def, behind its size so
 * far. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_DEF_H
#define THRUM_CORE_BASE_DEF_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* A cookie with at least one member behind it. */
#define THRUM_DEF_LEAST 16

/* Is this the size of a def of which the library has `whole` bytes? */
static inline int thrum_def_fits(uint32_t cookie, size_t whole) {
  return cookie >= THRUM_DEF_LEAST && cookie <= whole && cookie % sizeof(uint32_t) == 0;
}

/* Fills the caller's `size` bytes at `def` from the defaults, `whole` bytes. What a longer def of a
 * later version has besides is 0. */
static inline void thrum_def_fill(void *def, size_t size, const void *defaults, size_t whole) {
  const uint32_t cookie = (uint32_t)(size < whole ? size : whole);
  if (size < THRUM_DEF_LEAST)
    return;
  memset(def, 0, size);
  memcpy(def, defaults, cookie);
  memcpy(def, &cookie, sizeof cookie);
}

/* The def as the library knows it: itself where it is whole, or `defaults` (`whole` bytes) with
 * what it has written over. NULL where it is none. */
static inline const void *thrum_def_whole(const void *def, void *defaults, size_t whole) {
  if (!def || !thrum_def_fits(*(const uint32_t *)def, whole))
    return NULL;
  const uint32_t cookie = *(const uint32_t *)def, full = (uint32_t)whole;
  if (cookie == full)
    return def;
  memcpy(defaults, def, cookie);
  memcpy(defaults, &full, sizeof full);
  return defaults;
}

#endif
