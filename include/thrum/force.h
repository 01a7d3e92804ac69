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
thrum_status thrum_force_add_vertex(const thrum_model *model, int64_t vertex, const double force[3],
                                    double *reduced, thrum_error *error);

/* reduced += U^T f; forces: vertex_count x 3 [N]. */
thrum_status thrum_force_add_field(const thrum_model *model, const double *forces, double *reduced,
                                   thrum_error *error);

/* reduced += U^T M a, a uniform acceleration (x, y, z) [m/s^2] such as gravity. */
thrum_status thrum_force_add_gravity(const thrum_model *model, const double acceleration[3],
                                     double *reduced, thrum_error *error);

/* u = U q of `count` vertices from `first`: displacements, count x 3 [m]. */
thrum_status thrum_displacement(const thrum_model *model, const double *q, int64_t first,
                                int64_t count, double *displacements, thrum_error *error);

/* Mean displacement (x, y, z) [m] of `count` vertices under q, what a force that they share works
 * on. vertices NULL: all of the model, count is ignored. */
thrum_status thrum_displacement_mean(const thrum_model *model, const int32_t *vertices,
                                     int64_t count, const double *q, double mean[3],
                                     thrum_error *error);

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

/* reduced += U^T f of one force [N] that `count` vertices share equally, held ones included: the
 * support carries their part. vertices NULL: all of the model, count is ignored. */
thrum_status thrum_force_add_shared(const thrum_model *model, const int32_t *vertices,
                                    int64_t count, const double force[3], double *reduced,
                                    thrum_error *error);

/* reduced = sum over `count` loads of their mean over the step times their row of `directions`
 * (count x rank). */
void thrum_load_sum(const thrum_load *loads, const double *directions, int64_t count, int64_t rank,
                    int64_t step, double dt, double *reduced);

/* Work [J] of a step's mean load (rank) from q to q_next: f (q_next - q). */
double thrum_load_work(const double *load, const double *q, const double *q_next, int64_t rank);

/* What Rayleigh damping of the stiffness at rest takes from the energy in a step of length dt from
 * q to q_next [J]: sum (alpha + beta omega_i^2) (q_next - q)_i^2 / dt. */
double thrum_damping_loss(const thrum_model *model, double alpha, double beta, const double *q,
                          const double *q_next, double dt);

/* q += the multiple of basis vector `mode` (0-based) under which the vertex that moves furthest is
 * displaced by |amplitude| [m]; the sign is the amplitude's. */
thrum_status thrum_mode_add(const thrum_model *model, int64_t mode, double amplitude, double *q,
                            thrum_error *error);

/* extents (rank): the largest vertex displacement under a unit of each basis vector [kg^-1/2]. */
thrum_status thrum_basis_extents(const thrum_model *model, double *extents, thrum_error *error);

/* Keeps a running peak: where a vertex moves further under q than *length [m], *length becomes the
 * largest displacement and *vertex (0-based) the vertex. `extents` of thrum_basis_extents bounds
 * the displacement, so that most calls cost `rank` operations and not the whole body. */
thrum_status thrum_displacement_peak(const thrum_model *model, const double *extents,
                                     const double *q, double *length, int64_t *vertex,
                                     thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
