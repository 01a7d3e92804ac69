/* The dissipation of a step, d D d / h with d = q' - q (design 4, 7), or d = N (q' - q) for a step
 * of energy (frequency_matching.c): D = alpha 1 + beta diag(omega^2) at rest, or alpha 1 + beta T
 * at the middle of the step in the tangent form. For the energy integrator and for the implicit
 * modes of imexv that is what the step takes out, to the tolerance of the solve; for explicit modes
 * it is so to second order in h, as these are damped at the time of the kick.
 *
 * Newmark's rule damps by the mean v of its two velocities, and only with beta = 1/4 is d = h v.
 * For fox-goodwin
 *
 *   [d D d - e D e]/h = v D (2 d - h v),  e = d - h v = h^2/6 (a - a'),
 *
 * is the decrement of 1/2 |p|^2 + V to the fourth order in h omega. Where a mode leaps from side to
 * side, near the limit of stability, v is next to nothing: it is then next to undamped, and d D d
 * would count much that is never taken out.
 *
 * The same befalls an explicit mode whose momentum is staggered where damping takes more than all
 * of it in a step, h D > 2: each kick turns it round, with next to no v in the middle of the kick,
 * which is what is damped. Its b is h v then.
 *
 * T may be indefinite, so the tangent form may feed energy in: no sign is assumed here.
 * Cost: r operations; with the tangent form one product T v.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/schemes/dissipation.h"

#include "core/polynomial/polynomial_private.h"
#include "core/schemes/schemes.h"
#include "core/schemes/staggered_momentum.h"

/* `own`: how many modes have a rule of their own. */
static thrum_damped_part part_of(const thrum_model *model, const thrum_state *state,
                                 const thrum_state_view *view, int32_t own, int32_t i) {
  const double d = view->q_next[i] - view->q[i], h = state->def.dt;
  if (i < thrum_staggered_modes(state) && h * thrum_rest_damping(model, state, i) > 2.0) {
    const double kicked = 0.5 * h * (view->p[i] + view->p_next[i]);
    return (thrum_damped_part){kicked, kicked};
  }
  return i < own ? thrum_row_of(state)->damped(model, state, view, i) : (thrum_damped_part){d, d};
}

/* a D b with T at the middle of the step. */
static double tangent_form(const thrum_model *model, const thrum_state *state,
                           const thrum_state_view *view, int32_t own) {
  double *b = view->trial, *middle = view->point, sum = 0.0;
  for (int32_t i = 0; i < state->rank; i++) {
    b[i] = part_of(model, state, view, own, i).b;
    middle[i] = view->q[i] + 0.5 * (view->q_next[i] - view->q[i]);
  }
  thrum_tangent_product_by(view->kernel, model, middle, b, view->product, view->work);
  for (int32_t i = 0; i < state->rank; i++) {
    const double a = part_of(model, state, view, own, i).a;
    sum += a * (thrum_mass_damping(model, state, i) * b[i] +
                state->def.damping_beta * view->product[i]);
  }
  return sum;
}

double thrum_step_dissipation(const thrum_model *model, const thrum_state *state,
                              const thrum_state_view *view) {
  if (!thrum_is_damped(model, state))
    return 0.0;
  const thrum_scheme_row *row = thrum_row_of(state);
  const int32_t own = row->own_modes ? row->own_modes(model, state) : 0;
  if (thrum_tangent_damped(state))
    return tangent_form(model, state, view, own) / state->def.dt;

  double sum = 0.0;
  for (int32_t i = 0; i < state->rank; i++) {
    const thrum_damped_part d = part_of(model, state, view, own, i);
    sum += d.a * d.b * thrum_rest_damping(model, state, i);
  }
  return sum / state->def.dt;
}
