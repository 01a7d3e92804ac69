/* One imexv step in its thesis split: Stoermer-Verlet on the explicit modes E, the implicit
 * midpoint rule on the implicit modes I, coupled through one V (design (2)-(5)).
 *
 *   kick   p^+_E by (2), drift q'_E = q_E + h p^+_E                                      (2), (3)
 *   solve  0 = d - h p_I + h^2/2 [R(q-bar) + D v - f]_I,  d = q'_I - q_I,
 *          q-bar = q + d/2, v = d/h on I and p^+ on E                                         (4)
 *   then   p'_I = p_I - h [R(q-bar) + D v - f]_I at the accepted iterate                      (5)
 *
 * |I| = 0 is Stoermer-Verlet and |I| = r the implicit midpoint rule. The unknown is the increment,
 * so that nothing cancels (implicit_problem.h). The problem's potential has P(d) = h^2 V(q-bar).
 * With q_E held, V is a quartic in q_I alone: one contraction a step.
 * Cost: one force evaluation and one contraction over all coefficients, then C(|I|+4, 4) an
 * iteration; with tangent damping one more pass over the coefficients an iteration.
 * Source: Stern & Grinspun 2009, doi:10.1137/080732936.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/schemes/imexv.h"

#include "core/base/finite.h"
#include "core/polynomial/polynomial_private.h"
#include "core/schemes/staggered_momentum.h"
#include "core/solve/implicit_solve.h"

/* Copies the restricted polynomial into view->restricted, where a batch has it elsewhere. */
static void fetch(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  if (!view->restricted_from)
    return;
  const int64_t count = thrum_restriction_count(s->model, s->n);
  for (int64_t c = 0; c < count; c++)
    view->restricted[c] = view->restricted_from[c * view->restricted_stride];
  view->restricted_from = NULL;
}

/* R(q-bar)_I into view->force; returns h^2 V(q-bar) up to a constant. */
static double evaluate(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  fetch(s);
  return s->weight / s->at *
         thrum_restricted_gradient(view->kernel, s->model, s->first, view->restricted,
                                   view->middle + s->first, view->force + s->first, view->work);
}

/* (h^2/4 + h/2 beta) T_II(q-bar), beta for the tangent form of damping only. */
static void stiffness(const thrum_solver *s, double *matrix) {
  thrum_state_view *view = s->view;
  fetch(s);
  thrum_restricted_hessian(view->kernel, s->model, s->first, view->restricted,
                           view->middle + s->first, matrix, view->work);
  thrum_problem_weigh(s, matrix);
}

thrum_solver thrum_imexv_solver(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, thrum_solve_report *report) {
  // nothing to solve for
  const double h = state->def.dt;
  if (state->split == state->rank)
    return (thrum_solver){
        .model = model, .state = state, .view = view, .report = report, .first = state->split};

  thrum_solver s =
      thrum_problem_make(model, state, view, report, state->split, 0.5, 0.5 * h * h, 1.0 / h);
  for (int32_t i = s.first; i < state->rank; i++)
    view->kick[i] = h * view->p[i];

  // with explicit modes the solve evaluates the restricted polynomial
  if (s.first > 0) {
    s.evaluate = evaluate;
    s.stiffness = stiffness;
    s.both = NULL;
  }
  return s;
}

thrum_status thrum_imexv_drift(const thrum_solver *s, double potential) {
  thrum_state_view *view = s->view;
  if (s->first > 0) {
    if (thrum_staggered_kick(s->model, s->state, view) < 0)
      return THRUM_NOT_CONVERGED;
    THRUM_CALL_HOOKS(thrum_on_kicked, kicked, s->model, s->state, view, potential, s->report);
  }

  // the implicit modes see the explicit ones at the midpoint of their drift
  const double h = s->state->def.dt;
  for (int32_t i = 0; i < s->first; i++) {
    view->q_next[i] = view->q[i] + h * view->p_next[i];
    view->middle[i] = view->q[i] + 0.5 * h * view->p_next[i];
    view->velocity[i] = view->p_next[i];
  }
  const bool finite =
      thrum_all_finite(view->q_next, s->first) && thrum_all_finite(view->p_next, s->first);
  return finite ? THRUM_OK : THRUM_NOT_FINITE;
}

thrum_status thrum_imexv_finish(const thrum_solver *s, bool solved) {
  if (!solved)
    return s->report->saw_nonfinite ? THRUM_NOT_FINITE : THRUM_NOT_CONVERGED;
  thrum_solve_advance(s);
  return THRUM_OK;
}

thrum_status thrum_step_imexv(const thrum_model *model, const thrum_state *state,
                              thrum_state_view *view, thrum_solve_report *report) {
  const thrum_solver s = thrum_imexv_solver(model, state, view, report);

  // the explicit modes first
  const double potential = s.first > 0 ? thrum_staggered_force(model, state, view, view->q) : 0.0;
  THRUM_TRY(thrum_imexv_drift(&s, potential));
  if (s.n == 0)
    return THRUM_OK;

  // then V as a quartic in q_I, with q_E at its midpoint, and the solve
  view->restricted_from = NULL;
  if (s.first > 0)
    thrum_polynomial_restrict(view->kernel, model, s.first, view->middle, view->restricted,
                              view->work);
  return thrum_imexv_finish(&s, thrum_solve_increment(&s));
}

/* --- its row ---------------------------------------------------------------------------------- */

thrum_mode_factor thrum_imexv_frequency(const thrum_model *model, const thrum_state *state,
                                        int32_t i, double z) {
  (void)model;
  return thrum_newmark_factor(z, i < state->split ? 0.0 : 0.25, 0.5);
}

bool thrum_imexv_problem(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                         thrum_solve_report *report, thrum_solver *s) {
  *s = thrum_imexv_solver(model, state, view, report);
  return true;
}

const thrum_scheme_row thrum_thesis_scheme = {
    .scheme = THRUM_SCHEME_THESIS,
    .integrator = THRUM_INTEGRATOR_IMEXV,
    .form = THRUM_FORM_THESIS,
    .restricts = true,
    .step = thrum_step_imexv,
    .frequency = thrum_imexv_frequency,
    .problem = thrum_imexv_problem,
};
