/* The energy that actuators add to V, and what a state keeps of them; private to the runtime, see
 * acting.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_ACTUATION_ACTING_H
#define THRUM_RUNTIME_ACTUATION_ACTING_H

#include "core/polynomial/kernel_private.h"

/* The numbers of model->levels: a row of each for all actuators, and behind them what follows from
 * the levels and the model (acting.c). */
typedef enum thrum_acting_row {
  THRUM_ACTING_LEVEL,
  THRUM_ACTING_MEASURE, /* where the work was summed up last: P, */
  THRUM_ACTING_BASE,    /* and the energy of level 0 [J] */
  THRUM_ACTING_WORK,    /* up to there [J] */
  THRUM_ACTING_CARRY,   /* and the rounding of its sum */
  THRUM_ACTING_ROWS
} thrum_acting_row;

/* Doubles of it; what follows from the model filled in, with no levels; and what follows from the
 * levels, which is due after each change of one. */
int64_t thrum_acting_count(const thrum_model *model);
void thrum_acting_fill(const thrum_model *model, double *levels);
void thrum_acting_sum(const thrum_model *model, double *levels);

/* The P of each actuator at q, whose level a adds base - a P to V, and the base, which only a gas
 * has; force += the gradient of the sum of weights times P (either NULL: not wanted). */
void thrum_acting_measures(const thrum_kernel *by, const thrum_model *model, const double *q,
                           const double *weights, double *force, double *measures, double *bases);

/* The volumes of chambers and the lengths of tendons at q, and of a strain its P. */
void thrum_acting_sizes(const thrum_kernel *by, const thrum_model *model, const double *q,
                        double *sizes);

/* thrum_passes.act and act_along. */
double thrum_acting_energy(const thrum_kernel *by, const thrum_model *model, const double *q,
                           double *gradient, double *hessian, double weight);
void thrum_acting_product(const thrum_kernel *by, const thrum_model *model, const double *q,
                          const double *v, double *product);

#endif
