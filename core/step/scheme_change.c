/* A change of scheme between two steps (design 4): q stays, p is synchronised by the old scheme and
 * shifted again by the new one. Cost: two force evaluations where both have explicit modes.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/step/scheme_change.h"

#include <string.h>

#include "core/base/finite.h"
#include "core/schemes/staggered_momentum.h"

void thrum_scheme_count_switch(thrum_state *state) {
  state->report.scheme_switches++;
  if (state->report.first_switch < 0)
    state->report.first_switch = state->report.steps;
}

thrum_status thrum_scheme_change(const thrum_model *model, thrum_state *state,
                                 thrum_state_view *view, thrum_scheme scheme, int32_t split) {
  THRUM_TRY(thrum_staggered_synchronise(model, state, view, NULL));

  // a Jacobian and past solves of other implicit modes are of no use
  state->scheme = (int32_t)scheme;
  state->split = split;
  state->jacobian_kept = 0;
  state->past_count = 0;

  memcpy(view->p_start, view->p_next, (size_t)state->rank * sizeof *view->p_start);
  THRUM_TRY(
      thrum_staggered_unsynchronise(model, state, view, view->q, view->load_before, view->p_start));
  view->p = view->p_start;
  return thrum_all_finite(view->p, state->rank) ? THRUM_OK : THRUM_NOT_FINITE;
}
