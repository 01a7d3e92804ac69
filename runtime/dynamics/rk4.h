/* The step of the classical Runge-Kutta method; private to the runtime, see rk4.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_DYNAMICS_RK4_H
#define THRUM_RUNTIME_DYNAMICS_RK4_H

#include "runtime/dynamics/solve_report.h"
#include "runtime/dynamics/state_layout.h"

/* One step: candidates into q_next and p_next; nothing that persists is written. THRUM_OK,
 * THRUM_NOT_CONVERGED or THRUM_NOT_FINITE. */
thrum_status thrum_step_rk4(const thrum_model *model, const thrum_state *state,
                            thrum_state_view *view, thrum_solve_report *report);

#endif
