/* Tests for NaN and infinity. SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/finite.h"

#include <math.h>

bool thrum_all_finite(const double *values, int64_t n) {
  // to the end in any case, so that several numbers are looked at together
  bool finite = true;
  for (int64_t i = 0; i < n; i++)
    finite &= isfinite(values[i]) != 0;
  return finite;
}
