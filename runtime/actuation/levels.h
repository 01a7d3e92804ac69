/* The actuators of a state, as the core asks for them; private to the runtime, see levels.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_ACTUATION_LEVELS_H
#define THRUM_RUNTIME_ACTUATION_LEVELS_H

#include "core/state/state_layout.h"

/* The levels of a state, and what follows from the model in a new one. */
void thrum_actuation_plan(const thrum_model *model, thrum_state *state);
void thrum_actuation_prepare(const thrum_model *model, thrum_state *state);

/* The model as a state that belongs to it sees it: with its levels, and what has flowed in it.
 * `copy` holds as long as model and state do. */
const thrum_model *thrum_actuated_model(const thrum_model *model, thrum_state *state,
                                        thrum_model *copy);

/* Sums the work up where a state is about to be set to another q, and goes on from there. */
void thrum_actuation_leave(const thrum_model *model, thrum_state *state);
void thrum_actuation_arrive(const thrum_model *model, thrum_state *state);

#endif
