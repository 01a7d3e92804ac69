/* The staggered momentum of the explicit modes: it belongs to a time half a step before q. Its kick
 * (stage 1), and the half-step shift from and to a momentum of the time of q (design (2) and
 * section 5).
 *
 *   kick           (1 + h/2 D_EE) p^+_E = (1 - h/2 D_EE) p^-_E - h [R_E + D_EI p_I - f_E]
 *   synchronise    (1 + h/2 D_EE) p_E = p^-_E - h/2 [R_E + D_EI p_I - f_{k-1}]
 *   unsynchronise  p^-_E = p_E + h/2 [R_E + (D p)_E - f_{k-1}]
 *
 * In the quadratic split (6) all modes are staggered, and R is R - kappa q.
 * Here f_E = (f_{k-1} + f_k)/2, so that a load's impulse counts once and equally for every mode.
 * Rest damping is diagonal; the tangent form alpha 1 + beta T(q_k) needs a dense solve of |E|.
 * Cost: one force evaluation, and one tangent for the tangent form.
 * Source: Stern & Grinspun 2009, doi:10.1137/080732936.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/schemes/staggered_momentum.h"

#include "core/linear_algebra/dense.h"
#include "core/polynomial/polynomial_private.h"
#include "core/schemes/schemes.h"

/* LU factors of 1 + h/2 D_EE with the T in view->tangent, into jacobian_next. */
static thrum_status factor_damped(const thrum_model *model, const thrum_state *state,
                                  thrum_state_view *view) {
  const int32_t n = thrum_staggered_modes(state);
  const double half = 0.5 * state->def.dt;
  double *matrix = view->jacobian_next;
  for (int32_t i = 0; i < n; i++) {
    const double *row = view->tangent + (size_t)i * (size_t)state->rank;
    for (int32_t j = 0; j < n; j++)
      matrix[(size_t)i * (size_t)n + (size_t)j] = half * state->def.damping_beta * row[j];
    matrix[(size_t)i * (size_t)n + (size_t)i] += 1.0 + half * thrum_mass_damping(model, state, i);
  }

  // T may be indefinite, and so may the matrix: LU, not Cholesky
  int32_t *pivots = (int32_t *)(void *)view->pivots_next;
  return thrum_dense_factor(matrix, n, pivots) ? THRUM_OK : THRUM_SINGULAR;
}

/* Solves (1 + h/2 D_EE) x = x with those factors. */
static void solve_damped(const thrum_state *state, const thrum_state_view *view, double *x) {
  const int32_t *pivots = (const int32_t *)(const void *)view->pivots_next;
  thrum_dense_solve(view->jacobian_next, thrum_staggered_modes(state), pivots, x);
}

/* x -= scale (T p)_E over the columns first..last-1, with the T in view->tangent. */
static void subtract_tangent(const thrum_state *state, const thrum_state_view *view, double scale,
                             int32_t first, int32_t last, double *x) {
  for (int32_t i = 0; i < thrum_staggered_modes(state); i++) {
    const double *row = view->tangent + (size_t)i * (size_t)state->rank;
    double sum = 0.0;
    for (int32_t j = first; j < last; j++)
      sum += row[j] * view->p[j];
    x[i] -= scale * sum;
  }
}

double thrum_staggered_force(const thrum_model *model, const thrum_state *state,
                             thrum_state_view *view, const double *q) {
  const double energy = thrum_internal_force_part(view->kernel, model, thrum_staggered_modes(state),
                                                  q, view->force, view->work);
  for (int32_t i = state->split; i < thrum_staggered_modes(state); i++)
    view->force[i] -= model->omega2[i] * q[i];
  return energy;
}

thrum_status thrum_staggered_kick(const thrum_model *model, const thrum_state *state,
                                  thrum_state_view *view) {
  const double h = state->def.dt;
  const int32_t n = thrum_staggered_modes(state);

  // without damping there is nothing to divide by
  if (!thrum_is_damped(model, state)) {
    for (int32_t i = 0; i < n; i++) {
      const double load = 0.5 * (view->load_before[i] + view->load[i]);
      view->p_next[i] = view->p[i] - h * (view->force[i] - load);
    }
    return THRUM_OK;
  }

  // rest damping: each mode on its own
  if (!thrum_tangent_damped(state)) {
    for (int32_t i = 0; i < n; i++) {
      const double damping = 0.5 * h * thrum_rest_damping(model, state, i);
      const double load = 0.5 * (view->load_before[i] + view->load[i]);
      view->p_next[i] =
          ((1.0 - damping) * view->p[i] - h * (view->force[i] - load)) / (1.0 + damping);
    }
    return THRUM_OK;
  }

  // tangent form: both halves of the damping with T at q_k, D_EI p_I on the right
  const double beta = h * state->def.damping_beta;
  thrum_tangent_stiffness_by(view->kernel, model, view->q, view->tangent, view->work);
  for (int32_t i = 0; i < n; i++) {
    const double load = 0.5 * (view->load_before[i] + view->load[i]);
    const double alpha = 0.5 * h * thrum_mass_damping(model, state, i);
    view->p_next[i] = (1.0 - alpha) * view->p[i] - h * (view->force[i] - load);
  }
  subtract_tangent(state, view, 0.5 * beta, 0, n, view->p_next);
  subtract_tangent(state, view, beta, n, state->rank, view->p_next);
  THRUM_TRY(factor_damped(model, state, view));
  solve_damped(state, view, view->p_next);

  // the synchronised p, for which the factors are there
  for (int32_t i = 0; i < n; i++)
    view->p_before_next[i] = view->p[i] - 0.5 * h * (view->force[i] - view->load_before[i]);
  subtract_tangent(state, view, 0.5 * beta, n, state->rank, view->p_before_next);
  solve_damped(state, view, view->p_before_next);
  return THRUM_OK;
}

thrum_status thrum_staggered_synchronise(const thrum_model *model, const thrum_state *state,
                                         thrum_state_view *view, double *potential) {
  const thrum_scheme_row *row = thrum_row_of(state);
  if (row->synchronise)
    return row->synchronise(model, state, view, potential);
  const double half = 0.5 * state->def.dt;
  const int32_t n = thrum_staggered_modes(state);

  // the implicit momentum is of the time of q already
  for (int32_t i = n; i < state->rank; i++)
    view->p_next[i] = view->p[i];
  if (n == 0) {
    if (potential)
      *potential = thrum_strain_energy_by(view->kernel, model, view->q, view->work);
    return THRUM_OK;
  }

  // half a kick, with the load of the step before: its other half comes with the next kick
  const double energy = thrum_staggered_force(model, state, view, view->q);
  if (potential)
    *potential = energy;
  for (int32_t i = 0; i < n; i++)
    view->p_next[i] = view->p[i] - half * (view->force[i] - view->load_before[i]);

  // and half of its damping
  if (!thrum_tangent_damped(state)) {
    for (int32_t i = 0; i < n; i++)
      view->p_next[i] /= 1.0 + half * thrum_rest_damping(model, state, i);
    return THRUM_OK;
  }
  thrum_tangent_stiffness_by(view->kernel, model, view->q, view->tangent, view->work);
  subtract_tangent(state, view, half * state->def.damping_beta, n, state->rank, view->p_next);
  THRUM_TRY(factor_damped(model, state, view));
  solve_damped(state, view, view->p_next);
  return THRUM_OK;
}

thrum_status thrum_staggered_unsynchronise(const thrum_model *model, const thrum_state *state,
                                           thrum_state_view *view, const double *q,
                                           const double *load_before, double *p) {
  const thrum_scheme_row *row = thrum_row_of(state);
  if (row->unsynchronise)
    return row->unsynchronise(model, state, view, q, p);
  const double half = 0.5 * state->def.dt;
  const int32_t n = thrum_staggered_modes(state);
  if (n == 0)
    return THRUM_OK;
  thrum_staggered_force(model, state, view, q);
  const bool tangent = thrum_tangent_damped(state);
  if (tangent)
    thrum_tangent_product_by(view->kernel, model, q, p, view->product, view->work);

  // the half kick backwards is explicit: D acts on the p that is known
  for (int32_t i = 0; i < n; i++) {
    const double damped = tangent ? thrum_mass_damping(model, state, i) * p[i] +
                                        state->def.damping_beta * view->product[i]
                                  : thrum_rest_damping(model, state, i) * p[i];
    const double load = load_before ? load_before[i] : 0.0;
    p[i] += half * (view->force[i] + damped - load);
  }
  return THRUM_OK;
}
