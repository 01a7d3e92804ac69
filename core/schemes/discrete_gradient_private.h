/* The parts that the files of the energy-conserving step share, see discrete_gradient.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SCHEMES_DISCRETE_GRADIENT_PRIVATE_H
#define THRUM_CORE_SCHEMES_DISCRETE_GRADIENT_PRIVATE_H

#include "core/schemes/discrete_gradient.h"
#include "core/solve/quasi_newton.h"

/* The share of F that the solve has: 1/2 of the trapezoidal discrete gradient, 1 of the average
 * vector field. */
static inline double thrum_share_of(const thrum_solver *s) {
  return 0.5 / s->at;
}

/* Rest damping of mode i in the solve's equation, per unit of d: rate eta D nu. */
static inline double thrum_solved_damping(const thrum_solver *s, int32_t i) {
  return s->rate * (s->view->speed[i] * s->view->drag[i]) *
         thrum_rest_damping(s->model, s->state, i);
}

/* h^2/2 */
static inline double thrum_mean_weight(const thrum_solver *s) {
  return 2.0 * s->at * s->weight;
}

/* to = from, scaled so that its kinetic energy grows by energy_error [J]; `to` may be `from`. False
 * where that is more than the share `most` of the kinetic energy: then to = from. */
bool thrum_momentum_take(const thrum_solver *s, double energy_error, double most,
                         const double *from, double *to);

/* Makes a problem that of the trapezoidal discrete gradient. The view's q and p are those that the
 * solve starts from, with R in view->force_start and V in the report. */
void thrum_trapezoid_prepare(thrum_solver *s);

/* As thrum_quasi_take; once solved, puts the end of the step and the start of the next one into the
 * view. STUCK where quasi-Newton does not converge, or p' cannot take up what is missing of the
 * balance. */
thrum_quasi_next thrum_trapezoid_take(const thrum_solver *s, const thrum_step_start *from,
                                      thrum_quasi *quasi);

/* The whole solve. False where it is stuck. */
bool thrum_trapezoid_solve(const thrum_solver *s, const thrum_step_start *from);

/* The same with the average vector field, without a correction for the next step. THRUM_OK,
 * THRUM_NOT_CONVERGED or THRUM_NOT_FINITE. */
thrum_status thrum_average_step(thrum_solver *s);

#endif
