/* The number of steps in a time (thrum/state.h). SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "thrum/state.h"

/* A quotient of decimal numbers errs by rounding: 0.3 / 0.003 is not 100 in floating point. */
#define WHOLE_STEP 1e-6

int64_t thrum_step_count(double time, double dt) {
  if (!(time > 0.0) || !(dt > 0.0))
    return 0;

  // 2^63 is the first double that does not fit
  const double steps = ceil(time / dt - WHOLE_STEP);
  if (!(steps < 0x1p63))
    return INT64_MAX;
  return steps > 0.0 ? (int64_t)steps : 0;
}
