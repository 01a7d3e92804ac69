/* The fallback chain after full Newton; private to the runtime, see fallback.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_DYNAMICS_FALLBACK_H
#define THRUM_RUNTIME_DYNAMICS_FALLBACK_H

#include "runtime/dynamics/solve_report.h"
#include "runtime/dynamics/state_layout.h"

/* Runs the fallback levels for a step that ended in `failure`; returns that where there are none.
 * Candidates as those of a step. */
thrum_status thrum_fallback_run(const thrum_model *model, thrum_state *state,
                                thrum_state_view *view, thrum_status failure,
                                thrum_solve_report *report);

#endif
