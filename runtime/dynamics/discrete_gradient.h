/* The energy-conserving step; private to the runtime, see discrete_gradient.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_DYNAMICS_DISCRETE_GRADIENT_H
#define THRUM_RUNTIME_DYNAMICS_DISCRETE_GRADIENT_H

#include "runtime/dynamics/implicit_problem.h"

/* One step: candidates into q_next and p_next, also force, force_2, pairs and, when refreshed,
 * jacobian_next; nothing that persists is written. THRUM_OK, THRUM_NOT_CONVERGED or
 * THRUM_NOT_FINITE. */
thrum_status thrum_step_energy(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, thrum_solve_report *report);

/* The problem of its step with the trapezoidal discrete gradient, without the kick. */
thrum_solver thrum_energy_problem(const thrum_model *model, const thrum_state *state,
                                  thrum_state_view *view, thrum_solve_report *report);

/* Keeps what the next step starts from, in the header to be and in the state's arrays. */
void thrum_energy_keep(thrum_state *next, const thrum_state_view *view,
                       const thrum_solve_report *report);

/* Forgets all of it, and what was learnt about the solves. */
void thrum_energy_forget(thrum_state *state);

#endif
