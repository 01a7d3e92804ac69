/* The dissipation of a step, d D d / h with d = q' - q (design 4, 7): D = alpha 1 + beta
 * diag(omega^2) at rest, or alpha 1 + beta T(q + d/2) in the tangent form. For the energy
 * integrator and for the implicit modes of imexv that is what the step takes out, to the tolerance
 * of the solve; for explicit modes it is so to second order in h, as these are damped at the time
 * of the kick.
 *
 * T may be indefinite, so the tangent form may feed energy in: no sign is assumed here.
 * Cost: r operations; with the tangent form one product T v.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include "runtime/dynamics/dissipation.h"

#include "runtime/polynomial/polynomial_private.h"

/* d D d with T at the middle of the step. */
static double tangent_form(const thrum_model *model, const thrum_state *state,
                           const thrum_state_view *view) {
  double *d = view->trial, *middle = view->point, sum = 0.0;
  for (int32_t i = 0; i < state->rank; i++) {
    d[i] = view->q_next[i] - view->q[i];
    middle[i] = view->q[i] + 0.5 * d[i];
  }
  thrum_tangent_product_by(view->kernel, model, middle, d, view->product, view->work);
  for (int32_t i = 0; i < state->rank; i++)
    sum += d[i] * (state->def.damping_alpha * d[i] + state->def.damping_beta * view->product[i]);
  return sum;
}

double thrum_step_dissipation(const thrum_model *model, const thrum_state *state,
                              const thrum_state_view *view) {
  double sum = 0.0;
  if (thrum_tangent_damped(state)) {
    sum = tangent_form(model, state, view);
  } else {
    for (int32_t i = 0; i < state->rank; i++) {
      const double d = view->q_next[i] - view->q[i];
      sum += d * d * thrum_rest_damping(model, state, i);
    }
  }
  return sum / state->def.dt;
}
