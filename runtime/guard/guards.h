/* What guards a step, as hooks (schemes.h): the stability monitor of imexv, the energy balance of
 * the schemes that have none, the target energy of `energy`, and the fallback chain. Private to the
 * runtime, see guards.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_GUARD_GUARDS_H
#define THRUM_RUNTIME_GUARD_GUARDS_H

#include "core/step/step.h"

/* A state: forgets what was compared with what; forgets the state before the last step. */
void thrum_guards_forget(thrum_state *state);
void thrum_guards_forget_step(thrum_state *state);

/* After a step: something else has taken an amount of the energy [J], or given it where it is
 * below 0, which is no error. */
void thrum_guards_take(thrum_state *state, double amount);

/* A step, in the order of its moments: see the types in schemes.h. */
thrum_status thrum_guards_before(const thrum_model *model, thrum_step_run *run);
thrum_status thrum_guards_sample(const thrum_model *model, thrum_step_run *run, bool product_there);
bool thrum_guards_attempt(const thrum_model *model, thrum_step_run *run, thrum_status *status);
thrum_status thrum_guards_settle(const thrum_model *model, thrum_step_run *run,
                                 thrum_status failure);
bool thrum_guards_solved(const thrum_model *model, thrum_step_run *run, thrum_status *status);
void thrum_guards_accepted(const thrum_model *model, thrum_step_run *run);
void thrum_guards_coupled(const thrum_model *model, thrum_step_run *run);
void thrum_guards_keep(const thrum_model *model, thrum_step_run *run);

#endif
