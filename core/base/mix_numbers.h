/* A hash of numbers by their bits, which finds accidents: one number of another model, say. Each is
 * mixed in by a multiplication and a shift; about four cycles a number.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_MIX_NUMBERS_H
#define THRUM_CORE_BASE_MIX_NUMBERS_H

#include <stdint.h>
#include <string.h>

/* Mixes one number in; for a given hash no two numbers give the same. */
static inline uint64_t thrum_mix_number(uint64_t hash, uint64_t number) {
  hash = (hash ^ number) * UINT64_C(0x9e3779b97f4a7c15);
  return hash ^ (hash >> 32);
}

/* Mixes the bits of `count` numbers in. */
static inline uint64_t thrum_mix_numbers(uint64_t hash, const double *values, int64_t count) {
  for (int64_t n = 0; n < count; n++) {
    uint64_t bits;
    memcpy(&bits, &values[n], sizeof bits);
    hash = thrum_mix_number(hash, bits);
  }
  return hash;
}

#endif
