/* A change of scheme between two steps; private to libthrum, see scheme_change.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_STEP_SCHEME_CHANGE_H
#define THRUM_CORE_STEP_SCHEME_CHANGE_H

#include "core/state/state_layout.h"

/* Counts a switch to the energy integrator in the report. */
void thrum_scheme_count_switch(thrum_state *state);

/* Makes `state`, the header to be, one of this scheme and split. view->p then points to
 * view->p_start, which has p of the present time as that scheme stores it. THRUM_OK, THRUM_SINGULAR
 * or THRUM_NOT_FINITE. */
thrum_status thrum_scheme_change(const thrum_model *model, thrum_state *state,
                                 thrum_state_view *view, thrum_scheme scheme, int32_t split);

#endif
