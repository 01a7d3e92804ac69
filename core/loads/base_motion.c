/* A base's motion sampled in time (thrum/base_motion.h, design 12): acceleration linear between
 * samples, so its mean over a step, its velocity and its position are polynomials, and all exact.
 *
 * A record of positions becomes one of accelerations by the cubic spline through them, whose second
 * derivative is linear between samples: one tridiagonal system (de Boor 1978, A practical guide to
 * splines, doi:10.1007/978-1-4612-6333-3, chapter IV).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/base/finite.h"
#include "core/base/intervals.h"
#include "core/base/pi.h"
#include "thrum/base_motion.h"
#include "thrum/external_load.h"

#include <inttypes.h>
#include <math.h>

thrum_status thrum_base_motion_check(const thrum_base_motion *motion, thrum_error *error) {
  if (!motion || !motion->times || !motion->accelerations)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the motion, its times or its accelerations are NULL");
  if (motion->count < 2)
    return thrum_error_set(error, THRUM_BAD_VALUE, "a motion has two samples or more, not %" PRId64,
                           motion->count);

  // every sample is finite and later than the one before
  for (int64_t k = 0; k < motion->count; k++) {
    const double *a = motion->accelerations + 3 * k;
    if (!thrum_all_within(motion->times + k, 1, THRUM_PLACE_MAX) ||
        !thrum_all_within(a, 3, THRUM_PLACE_MAX))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "sample %" PRId64 " of the motion is not finite, or beyond 1e30",
                             k + 1);
    if (k > 0 && !(motion->times[k] > motion->times[k - 1]))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "sample %" PRId64 " of the motion is not later than the one before",
                             k + 1);
  }
  return THRUM_OK;
}

void thrum_base_motion_mean(const thrum_base_motion *motion, int64_t step, double dt,
                            double mean[3]) {
  const double from = fmax((double)step * dt, motion->times[0]);
  const double until = fmin((double)(step + 1) * dt, motion->times[motion->count - 1]);
  mean[0] = mean[1] = mean[2] = 0.0;
  if (!(until > from) || !(dt > 0.0))
    return;
  for (int64_t k = thrum_interval_at(motion->times, motion->count, from);
       k + 1 < motion->count && motion->times[k] < until; k++) {
    // the mean of a line over a part of it is its value in the middle of the part
    const double first = fmax(from, motion->times[k]), last = fmin(until, motion->times[k + 1]);
    const double length = motion->times[k + 1] - motion->times[k];
    const double at = (0.5 * (first + last) - motion->times[k]) / length;
    const double *a = motion->accelerations + 3 * k;
    for (int axis = 0; axis < 3; axis++)
      mean[axis] += (last - first) / dt * (a[axis] + at * (a[3 + axis] - a[axis]));
  }
}

thrum_status thrum_base_motion_load(const thrum_model *model, const double acceleration[3],
                                    double *reduced, thrum_error *error) {
  const double inertial[3] = {-acceleration[0], -acceleration[1], -acceleration[2]};
  return thrum_load_add_gravity(model, inertial, reduced, error);
}

void thrum_base_motion_integrate(int64_t count, const double *times, const double *accelerations,
                                 double *velocities, double *positions) {
  for (int axis = 0; axis < 3; axis++)
    velocities[axis] = positions[axis] = 0.0;
  for (int64_t k = 0; k + 1 < count; k++) {
    const double h = times[k + 1] - times[k];
    const double *a = accelerations + 3 * k;
    const double *v = velocities + 3 * k, *x = positions + 3 * k;
    for (int axis = 0; axis < 3; axis++) {
      velocities[3 * k + 3 + axis] = v[axis] + 0.5 * h * (a[axis] + a[3 + axis]);
      positions[3 * k + 3 + axis] =
          x[axis] + h * v[axis] + h * h * (a[axis] / 3.0 + a[3 + axis] / 6.0);
    }
  }
}

/* Second derivatives of the spline of one axis, by elimination from the first row on. */
static void solve_spline(int64_t count, const double *times, const double *x, double *a,
                         double *work) {
  // clamped: 2 h a_0 + h a_1 = 6 (x_1 - x_0) / h; work holds what stays above the diagonal
  const double h0 = times[1] - times[0];
  work[0] = 0.5;
  a[0] = 3.0 * (x[3] - x[0]) / (h0 * h0);
  for (int64_t k = 1; k + 1 < count; k++) {
    const double before = times[k] - times[k - 1], after = times[k + 1] - times[k];
    const double slope = (x[3 * k + 3] - x[3 * k]) / after - (x[3 * k] - x[3 * k - 3]) / before;
    const double pivot = 2.0 * (before + after) - before * work[k - 1];
    work[k] = after / pivot;
    a[3 * k] = (6.0 * slope - before * a[3 * k - 3]) / pivot;
  }
  a[3 * (count - 1)] = 0.0;
  for (int64_t k = count - 2; k >= 0; k--)
    a[3 * k] -= work[k] * a[3 * k + 3];
}

void thrum_base_motion_spline(int64_t count, const double *times, const double *positions,
                              double *accelerations, double *velocities, double *work) {
  for (int axis = 0; axis < 3; axis++) {
    solve_spline(count, times, positions + axis, accelerations + axis, work);
    velocities[axis] = 0.0;
    for (int64_t k = 0; k + 1 < count; k++) {
      const double h = times[k + 1] - times[k];
      velocities[3 * k + 3 + axis] =
          velocities[3 * k + axis] +
          0.5 * h * (accelerations[3 * k + axis] + accelerations[3 * k + 3 + axis]);
    }
  }
}

void thrum_base_motion_at(const thrum_base_motion *motion, double time, double position[3],
                          double velocity[3]) {
  // the interval that the time lies in; before the first sample nothing has moved yet
  const int64_t last = motion->count - 1;
  const double end = motion->times[last];
  const int64_t k = time >= end ? last : thrum_interval_at(motion->times, motion->count, time);
  const double t = time < motion->times[0] ? 0.0 : time - motion->times[k];
  const double *v = motion->velocities + 3 * k, *x = motion->positions + 3 * k;

  // the acceleration is linear within an interval and zero after the last sample, so velocity and
  // position are its integrals
  for (int axis = 0; axis < 3; axis++) {
    double a = 0.0, jerk = 0.0;
    if (k < last) {
      a = motion->accelerations[3 * k + axis];
      jerk =
          (motion->accelerations[3 * k + 3 + axis] - a) / (motion->times[k + 1] - motion->times[k]);

      // within an interval as short as this nothing moves
      jerk = isfinite(jerk) ? jerk : 0.0;
    }
    if (position)
      position[axis] = x[axis] + t * (v[axis] + t * (a / 2.0 + t * jerk / 6.0));
    if (velocity)
      velocity[axis] = v[axis] + t * (a + t * jerk / 2.0);
  }
}

double thrum_base_motion_sine(const thrum_load *course, double time) {
  const double t = fmax(fmin(time, course->until), course->from) - course->from;
  const double omega = THRUM_TWO_PI * course->frequency;
  return omega > 0.0 ? -sin(THRUM_TWO_PI * fmod(course->frequency * t, 1.0)) / (omega * omega)
                     : 0.0;
}
