/* The step of linearly implicit Euler; private to the runtime, see semi_implicit_euler.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_DYNAMICS_SEMI_IMPLICIT_EULER_H
#define THRUM_RUNTIME_DYNAMICS_SEMI_IMPLICIT_EULER_H

#include "runtime/dynamics/solve_report.h"
#include "runtime/dynamics/state_layout.h"

/* One step: candidates into q_next and p_next; nothing that persists is written. THRUM_OK,
 * THRUM_NOT_CONVERGED or THRUM_NOT_FINITE. */
thrum_status thrum_step_semi_implicit_euler(const thrum_model *model, const thrum_state *state,
                                            thrum_state_view *view, thrum_solve_report *report);

#endif
