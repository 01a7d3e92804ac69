/* The energy balance of the schemes that nothing else keeps an account of; private to the runtime,
 * see energy_balance.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_GUARD_ENERGY_BALANCE_H
#define THRUM_RUNTIME_GUARD_ENERGY_BALANCE_H

#include "core/state/solve_report.h"
#include "core/state/state_layout.h"

/* True for a state whose balance is followed: `energy` and a monitored imexv see to theirs, but for
 * the former after a switch until the energy is explained again. */
static inline bool thrum_energy_balance_follows(const thrum_state *state) {
  if (state->scheme == THRUM_SCHEME_ENERGY)
    return state->balance.grew;
  return !thrum_is_monitored_imexv(state) && state->scheme != THRUM_SCHEME_MANIFOLD;
}

/* Forgets the balance: the next step begins a new one. */
void thrum_energy_balance_reset(thrum_state *state);

/* Of a state that is followed: enters a step whose candidates and dissipation are known, and sets
 * state->balance.grew. True where a monitored fox-goodwin is to make this step by the energy
 * integrator instead. Overwrites force_2, trial, tangent_2 and what belongs to the polynomial. */
bool thrum_energy_balance_enter(const thrum_model *model, thrum_state *state,
                                const thrum_state_view *view, const thrum_solve_report *report);

/* Makes the header and the view those of the energy integrator, for the step that was just
 * examined. THRUM_OK, or what thrum_scheme_change says. */
thrum_status thrum_energy_balance_switch(const thrum_model *model, thrum_state *state,
                                         thrum_state_view *view);

#endif
