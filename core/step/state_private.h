/* The functions of state.c that other parts of the runtime share.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_STEP_STATE_PRIVATE_H
#define THRUM_CORE_STEP_STATE_PRIVATE_H

#include <stdbool.h>

#include "thrum/state.h"

/* Refuses NULL, memory that holds no state, and another model than its own. */
thrum_status thrum_state_check(const thrum_model *model, const thrum_state *state,
                               thrum_error *error);

/* Refuses a state without scratch as well. */
thrum_status thrum_state_check_ready(const thrum_model *model, const thrum_state *state,
                                     thrum_error *error);

/* Fills the sizes of the arrays in the header, `bytes` included, from the def in it. */
void thrum_state_plan(thrum_state *state, const thrum_model *model);

/* True when a state of this def may take steps of the energy integrator. */
bool thrum_state_uses_energy(const thrum_state_def *def);

#endif
