/* The energy that actuators add to V, and what a state keeps of them; private to the runtime, see
 * acting.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_ACTUATION_ACTING_H
#define THRUM_RUNTIME_ACTUATION_ACTING_H

#include "core/polynomial/kernel_private.h"

/* The numbers of model->levels: a row of each for all actuators, and behind them the rows of guides
 * of each tendon, rank x 3 guides. */
typedef enum thrum_acting_row {
  THRUM_ACTING_LEVEL,
  THRUM_ACTING_MEASURE, /* where the work was summed up last: P, */
  THRUM_ACTING_BASE,    /* and the energy of level 0 [J] */
  THRUM_ACTING_WORK,    /* up to there [J] */
  THRUM_ACTING_CARRY,   /* and the rounding of its sum */
  THRUM_ACTING_ROWS
} thrum_acting_row;

/* Doubles of it, and what follows from the model filled in. */
int64_t thrum_acting_count(const thrum_model *model);
void thrum_acting_fill(const thrum_model *model, double *levels);

/* The chambers before actuator k. */
int64_t thrum_acting_chamber(const thrum_model *model, int64_t k);

/* The P of actuator k at q, whose level a adds base - a P to V; its gradient into `gradient` (rank;
 * NULL: not wanted) and the base, of a gas alone, into *base. */
double thrum_acting_measure(const thrum_kernel *by, const thrum_model *model, int64_t k,
                            const double *q, double *gradient, double *base);

/* The volume of a chamber or the length of a tendon at q. */
double thrum_acting_size(const thrum_kernel *by, const thrum_model *model, int64_t k,
                         const double *q);

/* thrum_passes.act and act_along. */
double thrum_acting_energy(const thrum_kernel *by, const thrum_model *model, const double *q,
                           double *gradient, double *hessian);
void thrum_acting_product(const thrum_kernel *by, const thrum_model *model, const double *q,
                          const double *v, double *product);

#endif
