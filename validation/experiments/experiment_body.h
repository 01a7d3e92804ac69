/* A body as the experiments see it: a model, where it is pushed, and what is measured there.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_EXPERIMENT_BODY_H
#define THRUM_VALIDATION_EXPERIMENTS_EXPERIMENT_BODY_H

#include "thrum/thrum.h"

typedef struct experiment_body {
  const char *name;         /* borrowed */
  const thrum_model *model; /* borrowed */
  double length;            /* largest side of the box at rest [m] */
  double direction[3];      /* of the push, of length 1 */
  double compliance;        /* linear, static: displacement of the group under 1 N [m/N] */
  double *push;             /* rank: U^T of 1 N that the group shares [kg^-1/2] */
  double *tip;              /* 3 x rank: mean displacement of the group is tip q [m] */
} experiment_body;

/* `direction` zero: the axis in which the group is softest at rest. The model needs a mesh, a basis
 * and the group. On failure nothing is left to free. */
thrum_status experiment_body_init(const char *name, const thrum_model *model, const char *group,
                                  const double direction[3], experiment_body *body,
                                  thrum_error *error);
void experiment_body_free(experiment_body *body);

/* How far the group is displaced on average, as a share of the body's length. */
double experiment_body_amplitude(const experiment_body *body, const double *q);

/* The integrators that are compared. X(name, def's value) */
#define EXPERIMENT_INTEGRATOR_LIST(X)                                                              \
  X(imexv, THRUM_INTEGRATOR_IMEXV)                                                                 \
  X(newmark, THRUM_INTEGRATOR_NEWMARK)                                                             \
  X(energy, THRUM_INTEGRATOR_ENERGY)

typedef enum experiment_integrator {
#define X(name, value) EXPERIMENT_##name,
  EXPERIMENT_INTEGRATOR_LIST(X)
#undef X
      EXPERIMENT_INTEGRATOR_COUNT
} experiment_integrator;

extern const char *const experiment_integrator_names[EXPERIMENT_INTEGRATOR_COUNT];
extern const thrum_integrator experiment_integrators[EXPERIMENT_INTEGRATOR_COUNT];

/* The impulse [N s] along the push after which the group swings to `amplitude` times the body's
 * length, found with `energy` at `dt`; *reached is what the nearest trial did reach. */
thrum_status experiment_impulse(const experiment_body *body, double amplitude, double dt,
                                double *impulse, double *reached, thrum_error *error);

/* Steps a state at rest through a constant force of EXPERIMENT_IMPULSE_SECONDS with this impulse [N
 * s], and takes the force away. */
#define EXPERIMENT_IMPULSE_SECONDS 0.003
thrum_status experiment_strike(const experiment_body *body, double impulse, double dt,
                               thrum_state *state, thrum_error *error);

/* Puts the state at rest but for the momentum that an impulse [N s] leaves: p = impulse push.
 * *energy gets 1/2 |p|^2 [J]. */
thrum_status experiment_kick(const experiment_body *body, double impulse, thrum_state *state,
                             double *energy, thrum_error *error);

#endif
