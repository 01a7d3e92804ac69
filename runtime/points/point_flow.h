/* Plastic flow at the cubature points of a state; private to the runtime, see point_flow.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_POINTS_POINT_FLOW_H
#define THRUM_RUNTIME_POINTS_POINT_FLOW_H

#include "core/state/state_layout.h"

/* Refuses a def whose flow this model or its integrator does not have. */
thrum_status thrum_point_flow_check(const thrum_model *model, const thrum_state_def *def,
                                    thrum_error *error);

/* The arrays of a state that may flow. */
void thrum_point_flow_plan(const thrum_model *model, thrum_state *state);

/* Finds what of a new state follows from its model, where it can flow. */
void thrum_point_flow_prepare(const thrum_model *model, thrum_state *state);

/* The model as a state that belongs to it sees it: `copy` with what has flowed in the state, where
 * it can flow, and the model itself otherwise. `copy` holds as long as model and state do. */
const thrum_model *thrum_flowed_model(const thrum_model *model, thrum_state *state,
                                      thrum_model *copy);

/* Lets the points of a state flow for the step that it has made, with the model above. Of the view
 * the kernel, q, and the scratch `restricted` and `work` are used. */
void thrum_point_flow(const thrum_model *flowed, thrum_state *state, const thrum_state_view *view);

/* Makes the next step evaluate V and R and start from q and p, because the known values belong to
 * the material before a change. */
void thrum_forget_forces(thrum_state *state);

#endif
