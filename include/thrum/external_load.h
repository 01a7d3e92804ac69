/* External loads in reduced coordinates, f = U^T f_ext, and their course over time as the mean over
 * each step (design 5). The internal force R(q) is in thrum/polynomial.h.
 *
 * Loads on vertices need a model with a basis (THRUM_MISSING otherwise), gravity one with
 * axis_mass. Pure functions; any thread; nothing allocated. A failure leaves the outputs as they
 * were.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_EXTERNAL_LOAD_H
#define THRUM_EXTERNAL_LOAD_H

#include "thrum/api.h"
#include "thrum/fields.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* reduced (rank) += U^T of a force (x, y, z) [N] at one vertex (0-based). */
THRUM_API thrum_status thrum_load_add_vertex(const thrum_model *model, int64_t vertex,
                                             const double force[3], double *reduced,
                                             thrum_error *error);

/* reduced (rank) += U^T f of one force (x, y, z) [N] that `count` vertices (0-based) share equally,
 * held ones included: the support carries their part. vertices NULL: all of the model, and count is
 * ignored. */
THRUM_API thrum_status thrum_load_add_shared(const thrum_model *model, const int32_t *vertices,
                                             int64_t count, const double force[3], double *reduced,
                                             thrum_error *error);

/* reduced (rank) += U^T f; forces: vertex_count x 3 [N]. */
THRUM_API thrum_status thrum_load_add_field(const thrum_model *model, const double *forces,
                                            double *reduced, thrum_error *error);

/* reduced (rank) += U^T M a, a uniform acceleration (x, y, z) [m/s^2] such as gravity. */
THRUM_API thrum_status thrum_load_add_gravity(const thrum_model *model,
                                              const double acceleration[3], double *reduced,
                                              thrum_error *error);

/* The course of a load over time: its direction times thrum_load_mean. */
typedef enum thrum_load_shape {
  THRUM_LOAD_CONSTANT = 0, /* 1 in [from, until) */
  THRUM_LOAD_SINE = 1,     /* sin(2 pi frequency (t - from)) in [from, until) */
  THRUM_LOAD_RAMP = 2      /* (t - from) / (until - from) in [from, until), 0 without end */
} thrum_load_shape;

/* A course over time: the rows of thrum/fields.h, which have their units and defaults. Set
 * `until`: 0 is no load. */
typedef struct thrum_load {
  THRUM_COURSE_FIELDS(THRUM_MEMBER)
} thrum_load;

/* Exact mean of the load over [step dt, (step+1) dt) [1]; dt [s]. Window ends within 1e-6 of a
 * whole step are taken as that step, so 0.003 s is 1 step and 0.3 s is 100 steps at dt = 0.003; a
 * shorter window keeps its impulse. */
THRUM_API double thrum_load_mean(const thrum_load *load, int64_t step, double dt);

/* reduced (rank) = sum over `count` loads of their mean over the step times their row of
 * `directions` (count x rank). */
THRUM_API void thrum_load_sum(const thrum_load *loads, const double *directions, int64_t count,
                              int64_t rank, int64_t step, double dt, double *reduced);

/* Work [J] of a step's mean load (rank) from q to q_next (rank): f (q_next - q). */
THRUM_API double thrum_load_work(const double *load, const double *q, const double *q_next,
                                 int64_t rank);

/* Energy [J] that Rayleigh damping with the stiffness at rest takes in a step of length dt [s] from
 * q to q_next (rank): sum (alpha + beta omega_i^2) (q_next - q)_i^2 / dt; alpha [1/s], beta [s].
 * energy with frequency_matched takes more from fast modes, by up to 9 % at dt omega = 1:
 * thrum_state_report.dissipated has what each integrator took. */
THRUM_API double thrum_damping_loss(const thrum_model *model, double alpha, double beta,
                                    const double *q, const double *q_next, double dt);

#ifdef __cplusplus
}
#endif
#endif
