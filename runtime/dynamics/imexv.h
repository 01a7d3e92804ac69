/* The stages of an imexv step in its component split, for several states side by side; see imexv.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_DYNAMICS_IMEXV_H
#define THRUM_RUNTIME_DYNAMICS_IMEXV_H

#include "runtime/dynamics/implicit_solve.h"

/* The solver of a step. */
thrum_solver thrum_imexv_solver(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, thrum_solve_report *report);

/* Stage 1 and drift, with R(q_k) in view->force and V(q_k) in `potential`: q_next, middle and
 * velocity of the explicit modes. */
thrum_status thrum_imexv_drift(const thrum_solver *s, double potential);

/* The step's candidates from a solved increment, or what went wrong. */
thrum_status thrum_imexv_finish(const thrum_solver *s, bool solved);

#endif
