/* Steps whose length changes from one to the next; private to libthrum, see step_length.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_STEP_STEP_LENGTH_H
#define THRUM_CORE_STEP_STEP_LENGTH_H

#include "core/state/state_layout.h"

/* The header of a state for steps of another length: dt, and the split where the stability of the
 * explicit modes, or a much shorter step, asks for another one. */
void thrum_step_length_enter(const thrum_model *model, thrum_state *state, double dt);

/* The steps to come are all of dt, as far as is known: the split is theirs. */
void thrum_step_length_begin(thrum_state *state);

/* Before a step; `state` is the header to be. Where all steps lately were shorter than those that
 * the split is for, more modes may become explicit; then view->p is the momentum that goes with
 * them. A status < 0 where that could not be done. */
thrum_status thrum_step_length_settle(const thrum_model *model, thrum_state *state,
                                      thrum_state_view *view);

#endif
