/* The energy-conserving step; private to libthrum, see discrete_gradient.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SCHEMES_DISCRETE_GRADIENT_H
#define THRUM_CORE_SCHEMES_DISCRETE_GRADIENT_H

#include "core/schemes/schemes.h"
#include "core/solve/implicit_problem.h"
#include "core/solve/quasi_newton.h"

/* One step: candidates into q_next and p_next, also force, force_2, pairs and, when refreshed,
 * jacobian_next; nothing that persists is written. THRUM_OK, THRUM_NOT_CONVERGED or
 * THRUM_NOT_FINITE. */
thrum_status thrum_step_energy(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, thrum_solve_report *report);

/* Its row. */
extern const thrum_scheme_row thrum_energy_scheme;

/* The end of the step before, which is where the present one begins for all who look. */
typedef struct thrum_step_start {
  double *q, *p;
  double potential; /* V(q) [J] */
} thrum_step_start;

/* A step in parts, so that a batch can evaluate several states together. Begins the solve with the
 * trapezoidal discrete gradient, whose `accept` and `weigh` a batch calls; false where this step
 * takes the average vector field, which is made alone. */
bool thrum_energy_begin(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                        thrum_solve_report *report, thrum_solver *s, thrum_step_start *from);

/* Does what thrum_quasi_take does, for that solve. */
thrum_quasi_next thrum_energy_take(const thrum_solver *s, const thrum_step_start *from,
                                   thrum_quasi *quasi);

/* Ends the step; where it is not solved, by the average vector field. As thrum_step_energy. */
thrum_status thrum_energy_finish(const thrum_solver *s, const thrum_step_start *from, bool solved);

/* The problem of its step with the trapezoidal discrete gradient, without the kick. */
thrum_solver thrum_energy_problem(const thrum_model *model, const thrum_state *state,
                                  thrum_state_view *view, thrum_solve_report *report);

/* Keeps what the next step starts from, in the header to be and in the state's arrays. */
void thrum_energy_keep(const thrum_model *model, thrum_state *next, const thrum_state_view *view,
                       const thrum_solve_report *report);

/* Forgets all of it, and what was learnt about the solves. */
void thrum_energy_forget(thrum_state *state);

#endif
