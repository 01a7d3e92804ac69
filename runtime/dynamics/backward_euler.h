/* The step of backward Euler; private to the runtime, see backward_euler.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_DYNAMICS_BACKWARD_EULER_H
#define THRUM_RUNTIME_DYNAMICS_BACKWARD_EULER_H

#include "runtime/dynamics/implicit_problem.h"

/* The problem of its step, without the kick. */
thrum_solver thrum_backward_euler_problem(const thrum_model *model, const thrum_state *state,
                                          thrum_state_view *view, thrum_solve_report *report);

/* One step: candidates into q_next and p_next, also middle, force, pairs and, when refreshed,
 * jacobian_next; nothing that persists is written. THRUM_OK, THRUM_NOT_CONVERGED or
 * THRUM_NOT_FINITE. */
thrum_status thrum_step_backward_euler(const thrum_model *model, const thrum_state *state,
                                       thrum_state_view *view, thrum_solve_report *report);

#endif
