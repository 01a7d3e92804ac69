/* Newmark's step with gamma = 1/2 and beta by mode (design 6): 1/12 on the low modes L, those with
 * h omega <= 1 and h (alpha + beta omega^2) <= 1 at rest, and 1/4 on the others.
 *
 *   q' = q + h v + h^2 [(1/2 - beta_i) a + beta_i a'],  v' = v + h/2 (a + a')
 *   0 = mu_i (d - k) + h^2/4 [R(q + d) + D v' - f],  mu_i = 1/(4 beta_i),  d = q' - q
 *
 * With beta = 1/12, the method of Fox and Goodwin (Numerov, Cowell, Stoermer), an undamped mode has
 * its frequency to order 4. It is stable while h^2 times the largest eigenvalue of T_LL is below 6.
 * The equation is multiplied by mu_i, so that its Jacobian mu + h^2/4 T is symmetric.
 * v is the velocity only up to h^2: v + h^2/12 dR/dt = v + h^2/12 T(q) v is it to order 4 on L, and
 * that is the p that callers see. A state stores v.
 * Cost: as Newmark; reading p takes one product T v, setting it one tangent and |L|^3.
 * Sources: Fox & Goodwin 1949, doi:10.1017/S0305004100025007; Kane et al. 2000,
 * doi:10.1002/1097-0207(20001210)49:10<1295::AID-NME993>3.0.CO;2-W (variational for constant beta).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/comparison/fox_goodwin.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/linear_algebra/dense.h"
#include "core/polynomial/polynomial_private.h"
#include "core/schemes/newmark.h"
#include "core/solve/implicit_solve.h"

#define ANGLE_MOST 1.0 /* h omega at rest of a mode with beta = 1/12 */
#define DECAY_MOST 1.0 /* and h times its damping: it overshoots by a third of that */

int32_t thrum_fox_goodwin_modes(const thrum_model *model, const thrum_state *state) {
  const double h = state->def.dt;
  int32_t count = 0;
  while (count < model->rank && h * h * model->omega2[count] <= ANGLE_MOST * ANGLE_MOST &&
         h * thrum_rest_damping(model, state, count) <= DECAY_MOST)
    count++;
  return count;
}

static thrum_solver problem_of(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, thrum_solve_report *report) {
  const double h = state->def.dt;
  thrum_solver s = thrum_problem_make(model, state, view, report, 0, 1.0, 0.25 * h * h, 2.0 / h);
  const int32_t low = thrum_fox_goodwin_modes(model, state);
  for (int32_t i = 0; i < low; i++)
    view->mass[i] = view->speed[i] = 3.0;
  thrum_problem_take_own(&s, low);
  return s;
}

thrum_solver thrum_fox_goodwin_begin(const thrum_model *model, const thrum_state *state,
                                     thrum_state_view *view, thrum_solve_report *report) {
  const double h = state->def.dt;
  const thrum_solver s = problem_of(model, state, view, report);
  const int32_t low = s.own;

  // a' and v' are linear in d; `drift` is v' for d = 0
  for (int32_t i = 0; i < state->rank; i++) {
    const double a = thrum_newmark_acceleration_now(view, i), rest = i < low ? 5.0 / 12.0 : 0.25;
    view->kick[i] = h * view->p[i] + h * h * rest * a;
    view->drift[i] = view->p[i] + 0.5 * h * a - view->mass[i] * s.rate * view->kick[i];
  }
  return s;
}

thrum_status thrum_fox_goodwin_finish(const thrum_solver *s, bool solved) {
  if (!solved)
    return s->report->saw_nonfinite ? THRUM_NOT_FINITE : THRUM_NOT_CONVERGED;

  // a' from the equation, and v' from both accelerations
  const double h = s->state->def.dt;
  thrum_state_view *view = s->view;
  for (int32_t i = 0; i < s->n; i++) {
    const double a_next = -view->total[i];
    view->q_next[i] = view->middle[i];
    view->p_next[i] = view->p[i] + 0.5 * h * (thrum_newmark_acceleration_now(view, i) + a_next);
    view->acceleration_next[i] = a_next;
  }
  s->report->solved = true;
  return THRUM_OK;
}

static thrum_status step(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                         thrum_solve_report *report) {
  const thrum_solver s = thrum_fox_goodwin_begin(model, state, view, report);
  return thrum_fox_goodwin_finish(&s, thrum_solve_increment(&s));
}

static thrum_status synchronise(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, double *potential) {
  const double share = state->def.dt * state->def.dt / 12.0;
  const int32_t low = thrum_fox_goodwin_modes(model, state);
  if (potential)
    *potential = thrum_strain_energy_by(view->kernel, model, view->q, view->work);
  if (low > 0)
    thrum_tangent_product_by(view->kernel, model, view->q, view->p, view->product, view->work);
  for (int32_t i = 0; i < state->rank; i++)
    view->p_next[i] = view->p[i] + (i < low ? share * view->product[i] : 0.0);
  return THRUM_OK;
}

/* Overwrites jacobian_next and unknown; after a failure p is as it was. */
static thrum_status unsynchronise(const thrum_model *model, const thrum_state *state,
                                  thrum_state_view *view, const double *q, double *p) {
  const double share = state->def.dt * state->def.dt / 12.0;
  const int32_t low = thrum_fox_goodwin_modes(model, state), rank = state->rank;
  if (low == 0)
    return THRUM_OK;

  // (1 + h^2/12 T_LL) v_L = p_L - h^2/12 T_LH v_H, with v_H = p_H
  double *matrix = view->jacobian_next, *x = view->unknown;
  thrum_tangent_stiffness_by(view->kernel, model, q, matrix, view->work);
  for (int32_t i = 0; i < low; i++) {
    const double *row = matrix + (size_t)i * (size_t)rank;
    x[i] = p[i];
    for (int32_t j = low; j < rank; j++)
      x[i] -= share * row[j] * p[j];
  }
  for (int32_t i = 0; i < low; i++)
    for (int32_t j = 0; j < low; j++)
      matrix[(size_t)i * (size_t)low + (size_t)j] =
          share * matrix[(size_t)i * (size_t)rank + (size_t)j] + (i == j ? 1.0 : 0.0);

  if (!thrum_all_finite(matrix, low * low))
    return THRUM_NOT_FINITE;

  // T may be indefinite, and so may the matrix: LU, not Cholesky
  int32_t *pivots = (int32_t *)(void *)view->pivots_next;
  if (!thrum_dense_factor(matrix, low, pivots))
    return THRUM_SINGULAR;
  thrum_dense_solve(matrix, low, pivots, x);
  memcpy(p, x, (size_t)low * sizeof *p);
  return THRUM_OK;
}

/* --- its row ---------------------------------------------------------------------------------- */

static bool problem(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                    thrum_solve_report *report, thrum_solver *s) {
  *s = problem_of(model, state, view, report);
  return true;
}

static thrum_mode_factor frequency(const thrum_model *model, const thrum_state *state, int32_t i,
                                   double z) {
  const int32_t low = thrum_fox_goodwin_modes(model, state);
  return thrum_newmark_factor(z, i < low ? 1.0 / 12.0 : 0.25, 0.5);
}

/* v D (2 d - h v) / h, see dissipation.c. */
static thrum_damped_part damped(const thrum_model *model, const thrum_state *state,
                                const thrum_state_view *view, int32_t i) {
  const double d = view->q_next[i] - view->q[i], h = state->def.dt;
  const double mean = 0.5 * h * (view->p[i] + view->p_next[i]);
  (void)model;
  return (thrum_damped_part){mean, 2.0 * d - mean};
}

static thrum_mode_answer answer(const thrum_model *model, const thrum_state *state, int32_t own,
                                int32_t i) {
  (void)model, (void)state;
  return (thrum_mode_answer){1.0, 0.5, 0.5, i < own ? 1.0 / 12.0 : 0.25};
}

const thrum_scheme_row thrum_fox_goodwin_scheme = {
    .scheme = THRUM_SCHEME_FOX_GOODWIN,
    .integrator = THRUM_INTEGRATOR_FOX_GOODWIN,
    .form = -1,
    .carries_acceleration = true,
    .velocity_by_dt = true,
    .step = step,
    .frequency = frequency,
    .answer = answer,
    .problem = problem,
    .synchronise = synchronise,
    .unsynchronise = unsynchronise,
    .own_modes = thrum_fox_goodwin_modes,
    .damped = damped,
};
