/* Tests for NaN and infinity. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/finite.h"

#include <math.h>
#include <string.h>

/* The exponent of a double, which is all ones in NaN and infinity, and its lowest bit. */
static const uint64_t exponent = UINT64_C(0x7ff0000000000000);
static const uint64_t exponent_lowest = UINT64_C(0x0010000000000000);

bool thrum_all_finite(const double *values, int64_t n) {
  // one more carries into the sign of an exponent of ones alone; integers, so that the compiler may
  // take several at a time
  uint64_t carried = 0;
  for (int64_t i = 0; i < n; i++) {
    uint64_t bits;
    memcpy(&bits, &values[i], sizeof bits);
    carried |= (bits & exponent) + exponent_lowest;
  }
  return carried >> 63 == 0;
}

bool thrum_all_within(const double *values, int64_t n, double most) {
  bool within = true;
  for (int64_t i = 0; i < n; i++)
    within = within && fabs(values[i]) <= most;
  return within;
}
