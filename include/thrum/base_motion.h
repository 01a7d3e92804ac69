/* The motion of what holds a body: an earthquake under a tower, a hand that base motions a held
 * thing.
 *
 * Seen from the base, a base that accelerates by a(t) is the inertial load f = -U^T M 1 a(t); its
 * mean over a step is what a step takes (design 12). q and p are then relative to the base:
 *
 *   thrum_base_motion_mean(&motion, step, dt, a);        mean of a over the step [m/s^2]
 *   thrum_base_motion_load(model, a, f, error);          f -= U^T M 1 a
 *   thrum_state_set_force(model, state, f, error);
 *
 * Needs a model with axis_mass. Pure functions; nothing is allocated; any thread.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_BASE_MOTION_H
#define THRUM_BASE_MOTION_H

#include "thrum/api.h"
#include "thrum/external_load.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Acceleration at given times, linear between them and zero before the first and after the last.
 * The arrays are the caller's and must stay. */
typedef struct thrum_base_motion {
  int64_t count;               /* >= 2 */
  const double *times;         /* count, ascending [s] */
  const double *accelerations; /* count x 3 [m/s^2] */
  const double *velocities;    /* count x 3 of the base at these times [m/s]; NULL: not known */
  const double *positions;     /* count x 3 [m], from where it began; NULL: not known */
} thrum_base_motion;

/* THRUM_BAD_VALUE for numbers that are not finite or times that do not ascend; the message counts
 * from 1. */
THRUM_API thrum_status thrum_base_motion_check(const thrum_base_motion *motion, thrum_error *error);

/* Exact mean of the acceleration over [step dt, (step+1) dt). Cost: log count. */
THRUM_API void thrum_base_motion_mean(const thrum_base_motion *motion, int64_t step, double dt,
                                      double mean[3]);

/* reduced -= U^T M 1 a; reduced: rank. */
THRUM_API thrum_status thrum_base_motion_load(const thrum_model *model,
                                              const double acceleration[3], double *reduced,
                                              thrum_error *error);

/* Fills velocities and positions (count x 3 each) of a base that is at rest at the first time:
 * the exact integrals. A record of accelerations that was not corrected for it drifts. */
THRUM_API void thrum_base_motion_integrate(int64_t count, const double *times,
                                           const double *accelerations, double *velocities,
                                           double *positions);

/* Fills accelerations and velocities (count x 3 each) of the cubic spline through `positions`: at
 * rest at the first time, without acceleration at the last. Between the times its acceleration is
 * linear. work: count. */
THRUM_API void thrum_base_motion_spline(int64_t count, const double *times, const double *positions,
                                        double *accelerations, double *velocities, double *work);

/* Where the base is at `time`, and its velocity; either may be NULL. Before the first time at rest
 * at positions[0], after the last in steady motion. Needs velocities and positions. */
THRUM_API void thrum_base_motion_at(const thrum_base_motion *motion, double time,
                                    double position[3], double velocity[3]);

/* Position, divided by the amplitude of the acceleration [s^2], of a base in steady harmonic motion
 * whose acceleration is a sine load's course: -sin(2 pi f (t - from)) / (2 pi f)^2 within its
 * window, and where the window ends it stops. */
THRUM_API double thrum_base_motion_sine(const thrum_load *course, double time);

#ifdef __cplusplus
}
#endif
#endif
