/* Between a body's vertices and its reduced coordinates: loads in, displacements out; and loads
 * over time as the mean over each step (design 5). Needs a model with a basis (THRUM_MISSING
 * otherwise), gravity one with axis_mass. Pure functions; any thread; nothing allocated.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_FORCE_H
#define THRUM_FORCE_H

#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* reduced += U^T of a force (x, y, z) [N] at one vertex; reduced: rank. */
thrum_status thrum_force_add_vertex(const thrum_model *model, int64_t vertex,
                                    const double force[3], double *reduced, thrum_error *error);

/* reduced += U^T f; forces: vertex_count x 3 [N]. */
thrum_status thrum_force_add_field(const thrum_model *model, const double *forces,
                                   double *reduced, thrum_error *error);

/* reduced += U^T M a, a uniform acceleration (x, y, z) [m/s^2] such as gravity. */
thrum_status thrum_force_add_gravity(const thrum_model *model, const double acceleration[3],
                                     double *reduced, thrum_error *error);

/* u = U q of `count` vertices from `first`: displacements, count x 3 [m]. */
thrum_status thrum_displacement(const thrum_model *model, const double *q, int64_t first,
                                int64_t count, double *displacements, thrum_error *error);

/* A load's course over time: its direction times thrum_load_mean. */
typedef enum thrum_load_shape {
  THRUM_LOAD_CONSTANT = 0, /* 1 in [from, until) */
  THRUM_LOAD_SINE = 1      /* sin(2 pi frequency (t - from)) in [from, until) */
} thrum_load_shape;

typedef struct thrum_load {
  thrum_load_shape shape;
  double from;      /* [s] */
  double until;     /* [s], may be INFINITY */
  double frequency; /* [Hz], for the sine */
} thrum_load;

/* Exact mean of the load over [step dt, (step+1) dt). Window ends within 1e-6 of a whole step are
 * taken as that step, so 0.003 s is 1 step and 0.3 s is 100 steps at dt = 0.003; a shorter window
 * keeps its impulse. */
double thrum_load_mean(const thrum_load *load, int64_t step, double dt);

#ifdef __cplusplus
}
#endif
#endif
