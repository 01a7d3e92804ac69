/* The check of a state that other parts of the runtime share; see state.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_DYNAMICS_STATE_PRIVATE_H
#define THRUM_RUNTIME_DYNAMICS_STATE_PRIVATE_H

#include "thrum/state.h"

/* Refuses NULL, memory that holds no state, and a model of another rank. */
thrum_status thrum_state_check(const thrum_model *model, const thrum_state *state,
                               thrum_error *error);

#endif
