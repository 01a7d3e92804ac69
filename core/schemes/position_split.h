/* The step of the position form; private to libthrum, see position_split.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SCHEMES_POSITION_SPLIT_H
#define THRUM_CORE_SCHEMES_POSITION_SPLIT_H

#include "core/schemes/imexv.h"

/* One step: candidates into q_next and p_next, also middle, force, pairs and, when refreshed,
 * jacobian_next; nothing that persists is written. THRUM_OK, THRUM_NOT_CONVERGED or
 * THRUM_NOT_FINITE. */
thrum_status thrum_step_position(const thrum_model *model, const thrum_state *state,
                                 thrum_state_view *view, thrum_solve_report *report);

extern const thrum_scheme_row thrum_position_scheme;

/* The first drift, q_E at its midpoint into view->middle, and the implicit problem that follows.
 * Not for tangent damping. */
thrum_solver thrum_position_drift(const thrum_model *model, const thrum_state *state,
                                  thrum_state_view *view, thrum_solve_report *report);

/* Kick and second drift of the explicit modes, from R(q-bar) in view->force. */
void thrum_position_kick(const thrum_solver *s);

#endif
