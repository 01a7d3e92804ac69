/* Newmark's step with beta by mode; private to the runtime, see fox_goodwin.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_COMPARISON_FOX_GOODWIN_H
#define THRUM_RUNTIME_COMPARISON_FOX_GOODWIN_H

#include "core/schemes/schemes.h"

/* How many modes have beta = 1/12: the first ones. */
int32_t thrum_fox_goodwin_modes(const thrum_model *model, const thrum_state *state);

extern const thrum_scheme_row thrum_fox_goodwin_scheme;

/* The problem of its step, and the candidates of the step from its solution, as those of newmark.h.
 */
thrum_solver thrum_fox_goodwin_begin(const thrum_model *model, const thrum_state *state,
                                     thrum_state_view *view, thrum_solve_report *report);
thrum_status thrum_fox_goodwin_finish(const thrum_solver *s, bool solved);

#endif
