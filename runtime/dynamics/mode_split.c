/* Which modes are explicit: Stoermer-Verlet on an oscillator is stable iff h omega < 2 (design 4).
 *
 * Modes ascend in omega, so a split is one number: E = 0..n-1, I = n..r-1. Cost: r comparisons.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>

#include "runtime/dynamics/state_private.h"

int32_t thrum_split_explicit(const thrum_model *model, thrum_split_rule rule, double dt,
                             double safety, int32_t count) {
  if (rule == THRUM_SPLIT_COUNT)
    return count;
  // the thesis' rule f < 1/h is h omega < 2 pi, beyond the bound of stability
  const double two_pi = 6.283185307179586;
  int32_t n = 0;
  for (; n < model->rank; n++) {
    const double angle = dt * sqrt(model->omega2[n]);
    const bool is_explicit = rule == THRUM_SPLIT_SAMPLING ? angle < two_pi : angle <= 2.0 * safety;
    if (!is_explicit)
      break;
  }
  return n;
}

int32_t thrum_split_of(const thrum_model *model, const thrum_state *state) {
  switch ((thrum_integrator)state->integrator) {
  case THRUM_INTEGRATOR_IMEXV:
    return thrum_split_explicit(model, (thrum_split_rule)state->split_rule, state->dt,
                                state->split_safety, state->explicit_count);
  case THRUM_INTEGRATOR_VERLET:
    return state->rank;
  case THRUM_INTEGRATOR_NEWMARK:
  case THRUM_INTEGRATOR_ENERGY:
  case THRUM_INTEGRATOR_MIDPOINT:
    break;
  }
  return 0;
}
