/* The fallback chain after full Newton; private to the runtime, see fallback.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_GUARD_FALLBACK_H
#define THRUM_RUNTIME_GUARD_FALLBACK_H

#include "core/state/solve_report.h"
#include "core/state/state_layout.h"

/* Runs the fallback levels for a step that ended in `failure`; returns that where there are none.
 * Candidates as those of a step. */
thrum_status thrum_fallback_run(const thrum_model *model, thrum_state *state,
                                thrum_state_view *view, thrum_status failure,
                                thrum_solve_report *report);

/* The longest chain of shorter steps that takes the place of one. */
#define THRUM_SUBSTEPS_MAX 256

/* One step from the q and p of the view to its candidates; `context` is the caller's. */
typedef thrum_status (*thrum_sub_step)(void *context, const thrum_model *model,
                                       const thrum_state *state, thrum_state_view *view,
                                       thrum_solve_report *report);

/* `count` steps of dt/count from view->q and view->p to candidates, with the dissipation of all of
 * them; nothing is kept between them. */
thrum_status thrum_fallback_substeps(const thrum_model *model, const thrum_state *state,
                                     thrum_state_view *view, int32_t count, thrum_sub_step by,
                                     void *context, thrum_solve_report *report);

#endif
