/* The time step that the energy integrator gives each mode; private to the runtime, see
 * frequency_matching.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_GUARD_FREQUENCY_MATCHING_H
#define THRUM_RUNTIME_GUARD_FREQUENCY_MATCHING_H

#include "core/schemes/schemes.h"

/* These functions as the core calls them. */
extern const thrum_mode_steps thrum_matched_mode_steps;

/* Finds the modes that follow softer ones, which are not matched, and notes them in the header. */
void thrum_find_following(const thrum_model *model, thrum_state *state);

/* How many of the first modes may be matched with the dt of the state; 0 where the def has it off.
 */
int32_t thrum_matched_modes(const thrum_model *model, const thrum_state *state);

/* How the energy integrator steps mode i, one of those modes. */
thrum_matched_step thrum_matched_step_of(const thrum_model *model, const thrum_state *state,
                                         int32_t i);

/* The same for the first `count` modes at once, into three vectors. */
void thrum_match_steps(const thrum_model *model, const thrum_state *state, int32_t count,
                       double *stretch, double *inverse, double *speed);

#endif
