/* Base excitation: the supports of a body move, such as the ground under a tower in an earthquake.
 *
 * In the frame of the base, its acceleration a(t) is the inertial load f = -U^T M 1 a(t); a step
 * takes the mean of it (design 12). q and p are then relative to the base:
 *
 *   thrum_base_motion_mean(&motion, step, dt, a);        mean of a over the step [m/s^2]
 *   thrum_base_motion_load(model, a, f, error);          f -= U^T M 1 a
 *   thrum_state_set_force(model, state, f, error);
 *
 * The load needs a model with axis_mass (THRUM_MISSING otherwise). Pure functions; nothing is
 * allocated; any thread. A failure leaves the outputs as they were.
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
 * Zero-initialise it and set count, times and accelerations. The arrays are the caller's and must
 * outlive the motion. */
typedef struct thrum_base_motion {
  int64_t count;               /* samples, >= 2; larger: a finer or longer record */
  const double *times;         /* count: strictly ascending, finite [s] */
  const double *accelerations; /* count x 3, finite; larger: a stronger excitation [m/s^2] */
  const double *velocities;    /* count x 3 of the base at these times [m/s]; NULL: not known */
  const double *positions;     /* count x 3 from the start of the base [m]; NULL: not known */
} thrum_base_motion;

/* Checks a motion: THRUM_BAD_VALUE for fewer than two samples, numbers that are not finite or
 * beyond 1e30, or times that do not ascend, with the sample counted from 1; THRUM_INVALID_ARGUMENT
 * for NULL. */
THRUM_API thrum_status thrum_base_motion_check(const thrum_base_motion *motion, thrum_error *error);

/* Exact mean of the acceleration over [step dt, (step+1) dt) into `mean` [m/s^2]; dt [s]. Cost: log
 * count, plus the samples in the step. */
THRUM_API void thrum_base_motion_mean(const thrum_base_motion *motion, int64_t step, double dt,
                                      double mean[3]);

/* reduced (rank) -= U^T M 1 a of an acceleration a of the base [m/s^2]. THRUM_MISSING for a model
 * without axis_mass. */
THRUM_API thrum_status thrum_base_motion_load(const thrum_model *model,
                                              const double acceleration[3], double *reduced,
                                              thrum_error *error);

/* Fills velocities [m/s] and positions [m] (count x 3 each) of a base that is at rest at the first
 * time: the exact integrals of the accelerations (count x 3) [m/s^2] over times (count) [s]. The
 * positions drift where the record has no baseline correction. */
THRUM_API void thrum_base_motion_integrate(int64_t count, const double *times,
                                           const double *accelerations, double *velocities,
                                           double *positions);

/* Fills accelerations [m/s^2] and velocities [m/s] (count x 3 each) of the cubic spline through
 * `positions` (count x 3) [m] at times (count) [s]: at rest at the first time, without acceleration
 * at the last. Between the times its acceleration is linear. work: count doubles of scratch. */
THRUM_API void thrum_base_motion_spline(int64_t count, const double *times, const double *positions,
                                        double *accelerations, double *velocities, double *work);

/* Position [m] and velocity [m/s] of the base at `time` [s]; either may be NULL. The base is at
 * rest at positions[0] before the first time and moves steadily after the last. Needs velocities
 * and positions. */
THRUM_API void thrum_base_motion_at(const thrum_base_motion *motion, double time,
                                    double position[3], double velocity[3]);

/* Position of a base in steady harmonic motion whose acceleration is a sine load's course, divided
 * by the amplitude of the acceleration [s^2]: -sin(2 pi f (t - from)) / (2 pi f)^2 at `time` t [s]
 * within its window; the base stops where the window ends. */
THRUM_API double thrum_base_motion_sine(const thrum_load *course, double time);

#ifdef __cplusplus
}
#endif
#endif
