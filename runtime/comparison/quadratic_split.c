/* One imexv step in the quadratic split (6): 1/2 q kappa q implicitly, by the midpoint rule, and
 * the rest of V explicitly; kappa_i = omega_i^2 on I and 0 on E:
 *
 *   p+ = p- - h (R(q) - kappa q - f),  with D centred as in (2)
 *   q' = [(1 - h^2/4 kappa) q + h p+] / (1 + h^2/4 kappa),  p' = p+ - h/2 kappa (q + q')
 *
 * A composition of exact flows of potentials and the midpoint rule: symplectic. |E| = r is
 * Stoermer-Verlet, |I| = r the midpoint rule for the linear part only. Stable for a frozen positive
 * T - kappa iff h^2 lambda_max(T - kappa) < 4, over all modes.
 * Cost: one force evaluation; no iteration.
 * Source: Stern & Grinspun 2009, doi:10.1137/080732936.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/comparison/quadratic_split.h"

#include <math.h>

#include "core/schemes/imexv.h"
#include "core/schemes/staggered_momentum.h"

static thrum_status step(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                         thrum_solve_report *report) {
  const double h = state->def.dt;

  // kick of all modes by the explicit part; a monitor needs the energy that comes with it
  const double potential = thrum_staggered_force(model, state, view, view->q);
  if (thrum_staggered_kick(model, state, view) < 0)
    return THRUM_NOT_CONVERGED;
  THRUM_CALL_HOOKS(thrum_on_kicked, kicked, model, state, view, potential, report);

  // drift on E, the midpoint rule of a linear oscillator on I
  for (int32_t i = 0; i < state->rank; i++) {
    const double q = view->q[i], kick = view->p_next[i];
    if (i < state->split) {
      view->q_next[i] = q + h * kick;
    } else {
      const double kappa = model->omega2[i], quarter = 0.25 * h * h * kappa;
      view->q_next[i] = ((1.0 - quarter) * q + h * kick) / (1.0 + quarter);
      view->p_next[i] = kick - 0.5 * h * kappa * (q + view->q_next[i]);
    }
    if (!isfinite(view->q_next[i]) || !isfinite(view->p_next[i]))
      return THRUM_NOT_FINITE;
  }
  return THRUM_OK;
}

const thrum_scheme_row thrum_quadratic_scheme = {
    .scheme = THRUM_SCHEME_QUADRATIC,
    .integrator = THRUM_INTEGRATOR_IMEXV,
    .form = THRUM_FORM_QUADRATIC,
    .step = step,
    .frequency = thrum_imexv_frequency,
};
