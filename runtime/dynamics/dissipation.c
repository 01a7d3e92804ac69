/* The dissipation of a step, d D d / h with d = q' - q (design 4, 7), or d = N (q' - q) for a step
 * of energy (frequency_matching.c): D = alpha 1 + beta diag(omega^2) at rest, or alpha 1 + beta T
 * at the middle of the step in the tangent form. For the energy integrator and for the implicit
 * modes of imexv that is what the step takes out, to the tolerance of the solve; for explicit modes
 * it is so to second order in h, as these are damped at the time of the kick.
 *
 * T may be indefinite, so the tangent form may feed energy in: no sign is assumed here.
 * Cost: r operations; with the tangent form one product T v.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include "runtime/dynamics/dissipation.h"

#include "runtime/dynamics/frequency_matching.h"
#include "runtime/polynomial/polynomial_private.h"

/* d D d with T at the middle of the step; d = N (q' - q), the first `matched` nu are not 1. */
static double tangent_form(const thrum_model *model, const thrum_state *state,
                           const thrum_state_view *view, int32_t matched) {
  double *d = view->trial, *middle = view->point, sum = 0.0;
  for (int32_t i = 0; i < state->rank; i++) {
    d[i] = view->q_next[i] - view->q[i];
    middle[i] = view->q[i] + 0.5 * d[i];
  }
  for (int32_t i = 0; i < matched; i++)
    d[i] *= thrum_matched_step_of(model, state, i).speed;
  thrum_tangent_product_by(view->kernel, model, middle, d, view->product, view->work);
  for (int32_t i = 0; i < state->rank; i++)
    sum += d[i] * (state->def.damping_alpha * d[i] + state->def.damping_beta * view->product[i]);
  return sum;
}

double thrum_step_dissipation(const thrum_model *model, const thrum_state *state,
                              const thrum_state_view *view) {
  if (state->def.damping_alpha == 0.0 && state->def.damping_beta == 0.0)
    return 0.0;
  const double h = state->def.dt;
  const int32_t matched =
      state->scheme == THRUM_SCHEME_ENERGY ? thrum_matched_modes(model, state) : 0;
  if (thrum_tangent_damped(state))
    return tangent_form(model, state, view, matched) / h;

  double sum = 0.0;
  for (int32_t i = 0; i < state->rank; i++) {
    const double speed = i < matched ? thrum_matched_step_of(model, state, i).speed : 1.0;
    const double d = speed * (view->q_next[i] - view->q[i]);
    sum += d * d * thrum_rest_damping(model, state, i);
  }
  return sum / h;
}
