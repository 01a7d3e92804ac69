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

/* The same body, pushed in its first basis vector alone: a push that excites no fast mode. Free
 * with experiment_body_free. */
thrum_status experiment_body_smooth(const experiment_body *body, experiment_body *smooth,
                                    thrum_error *error);

/* How far the group is displaced on average, as a share of the body's length. */
double experiment_body_amplitude(const experiment_body *body, const double *q);

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
