/* A load's course over time as its exact mean over each step, f_k = (1/h) int f dt, design 5.
 *
 * Time is counted in steps. A window end within 1e-6 of a whole step is that step, because 0.3 s is
 * 100 steps of 0.003 s although 0.3 / 0.003 is not 100 in floating point. The mean of a sine over
 * [a, b] is sin(middle) sin(x)/x with x half the phase that it covers; that of a ramp is its value
 * in the middle.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "thrum/external_load.h"

#include <math.h>

#include "core/base/pi.h"

#define WHOLE_STEP 1e-6 /* steps: a time this near to a whole step is that step */

/* Time in steps, whole where it is nearly so. */
static double steps_of(double time, double dt) {
  double steps = time / dt, whole = nearbyint(steps);
  return fabs(steps - whole) <= WHOLE_STEP ? whole : steps;
}

double thrum_load_mean(const thrum_load *load, int64_t step, double dt) {
  double from = steps_of(load->from, dt), until = steps_of(load->until, dt);
  double first = fmax(from, (double)step), last = fmin(until, (double)step + 1);

  // written so that NaN anywhere gives no load
  if (!(dt > 0) || !(last > first) || isnan(load->from) || isnan(load->until))
    return 0;

  // the mean of a constant and of a ramp is known without an integral
  if (load->shape == THRUM_LOAD_CONSTANT)
    return last - first;
  if (load->shape == THRUM_LOAD_RAMP)
    return isfinite(until - from) ? (last - first) * (0.5 * (first + last) - from) / (until - from)
                                  : 0;

  // phases in turns from the start of the window; whole turns are dropped before pi comes in
  double turns = load->frequency * dt;
  double middle = fmod(turns * (0.5 * (first + last) - from), 1.0);
  double half = THRUM_PI * turns * (last - first);
  double shrink = half != 0 ? sin(half) / half : 1;
  double mean = (last - first) * sin(2 * THRUM_PI * middle) * shrink;
  return isfinite(mean) ? mean : 0;
}
