/* Tests for NaN and infinity. SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/finite.h"

#include <math.h>

bool thrum_all_finite(const double *values, int64_t n) {
  for (int64_t i = 0; i < n; i++)
    if (!isfinite(values[i]))
      return false;
  return true;
}
