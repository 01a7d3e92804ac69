/* Which modes are explicit: Stoermer-Verlet on an oscillator is stable iff h omega < 2 (design 4).
 *
 * Modes ascend in omega, so a split is one number: E = 0..n-1, I = n..r-1. Cost: r comparisons.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/schemes/mode_split.h"

#include <math.h>

#include "core/base/pi.h"

int32_t thrum_mode_split_by(const thrum_model *model, thrum_split_rule rule, double dt,
                            double safety, int32_t count) {
  if (rule == THRUM_SPLIT_COUNT)
    return count;

  // the thesis' rule f < 1/h is h omega < 2 pi, beyond the stability limit
  int32_t n = 0;
  for (; n < model->rank; n++) {
    const double number = dt * sqrt(model->omega2[n]);
    const bool is_explicit =
        rule == THRUM_SPLIT_SAMPLING ? number < THRUM_TWO_PI : number <= 2.0 * safety;
    if (!is_explicit)
      break;
  }
  return n;
}

int32_t thrum_mode_split(const thrum_model *model, const thrum_state *state) {
  const thrum_state_def *def = &state->def;
  if (def->integrator == THRUM_INTEGRATOR_IMEXV)
    return thrum_mode_split_by(model, def->split_rule, state->split_dt, def->split_safety,
                               def->explicit_count);

  // no mode is explicit in the others
  return def->integrator == THRUM_INTEGRATOR_VERLET ? state->rank : 0;
}
