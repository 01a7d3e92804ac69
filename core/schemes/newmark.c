/* One Newmark step, the baseline (design 6), for the increment d = q' - q:
 *
 *   q' = q + h v + h^2/2 [(1 - 2 beta_N) a + 2 beta_N a'],  v' = v + h [(1 - gamma) a + gamma a']
 *   0 = a' + R(q') + D v' - f_k,   Jacobian 1 + beta_N h^2 T(q') + gamma h D
 *
 * Both a and a' of a step use f_k: the stored a is corrected by f_k - f_{k-1}, so that an impulse
 * counts once. With beta_N > 0 the first equation gives a' for d, and the implicit solve finds d.
 * With beta_N = 0 q' is explicit and a' solves a linear system, diagonal for rest damping.
 * Cost: an iteration takes one force evaluation and about r^2, a new Jacobian a tangent and r^3.
 * Sources: Newmark 1959; Kane et al. 2000,
 * doi:10.1002/1097-0207(20001210)49:10<1295::AID-NME993>3.0.CO;2-W (variational for gamma = 1/2).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/schemes/newmark.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/polynomial/polynomial_private.h"
#include "core/solve/implicit_solve.h"
#include "core/solve/tangent_damping.h"

/* total += R(q) + D v, v in `velocity`. Overwrites view->force and view->product. */
static void add_forces(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                       const double *q, const double *velocity, double *total) {
  const double beta = state->def.damping_beta;
  const bool tangent = thrum_tangent_damped(state);
  thrum_internal_force_by(view->kernel, model, q, view->force, view->work);
  if (tangent)
    thrum_tangent_product_by(view->kernel, model, q, velocity, view->product, view->work);

  // D v is alpha v + beta times T v or omega^2 v
  for (int32_t i = 0; i < state->rank; i++) {
    const double stiff = tangent ? view->product[i] : model->omega2[i] * velocity[i];
    const double own = thrum_mass_damping(model, state, i) * velocity[i];
    total[i] += view->force[i] + (own + beta * stiff);
  }
}

void thrum_newmark_acceleration(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, const double *q, const double *v,
                                double *acceleration) {
  memset(acceleration, 0, (size_t)state->rank * sizeof *acceleration);
  add_forces(model, state, view, q, v, acceleration);
  for (int32_t i = 0; i < state->rank; i++)
    acceleration[i] = -acceleration[i];
}

/* beta_N = 0: q' is known, and a' is the solution of
 * (1 + gamma h D(q')) a' = f - R(q') - D(q') [v + h (1 - gamma) a]. */
static thrum_status step_explicit(const thrum_model *model, const thrum_state *state,
                                  thrum_state_view *view, thrum_solve_report *report) {
  const double h = state->def.dt, gamma = state->def.newmark_gamma;
  const bool tangent = thrum_tangent_damped(state);
  const size_t rank = (size_t)state->rank;

  // q', the known part of v', and the right-hand side
  double *a_next = view->unknown;
  for (size_t i = 0; i < rank; i++) {
    view->q_next[i] =
        view->q[i] + h * (view->p[i] + 0.5 * h * thrum_newmark_acceleration_now(view, (int32_t)i));
    view->velocity[i] =
        view->p[i] + h * (1.0 - gamma) * thrum_newmark_acceleration_now(view, (int32_t)i);
    a_next[i] = -view->load[i];
  }
  add_forces(model, state, view, view->q_next, view->velocity, a_next);

  // rest damping is diagonal, the tangent form is a dense system
  for (size_t i = 0; i < rank; i++)
    a_next[i] = -a_next[i] /
                (tangent ? 1.0 : 1.0 + gamma * h * thrum_rest_damping(model, state, (int64_t)i));
  if (tangent) {
    report->factorisations++;
    if (!thrum_tangent_damping_solve(model, state, view, view->q_next, gamma * h,
                                     view->jacobian_next, a_next))
      return THRUM_NOT_CONVERGED;
  }

  for (size_t i = 0; i < rank; i++) {
    view->acceleration_next[i] = a_next[i];
    view->p_next[i] = view->velocity[i] + h * gamma * a_next[i];
  }
  return thrum_all_finite(view->q_next, state->rank) && thrum_all_finite(view->p_next, state->rank)
             ? THRUM_OK
             : THRUM_NOT_FINITE;
}

thrum_solver thrum_newmark_problem(const thrum_model *model, const thrum_state *state,
                                   thrum_state_view *view, thrum_solve_report *report) {
  const double h = state->def.dt, beta = state->def.newmark_beta;
  return thrum_problem_make(model, state, view, report, 0, 1.0, beta * h * h,
                            state->def.newmark_gamma / (beta * h));
}

thrum_solver thrum_newmark_begin(const thrum_model *model, const thrum_state *state,
                                 thrum_state_view *view, thrum_solve_report *report) {
  const double h = state->def.dt, beta = state->def.newmark_beta;
  const thrum_solver s = thrum_newmark_problem(model, state, view, report);

  // a' and v' are linear in d; `drift` is v' for d = 0
  for (int32_t i = 0; i < state->rank; i++) {
    const double a = thrum_newmark_acceleration_now(view, i);
    view->kick[i] = h * view->p[i] + h * h * (0.5 - beta) * a;
    view->drift[i] = view->p[i] + h * (1.0 - state->def.newmark_gamma) * a - s.rate * view->kick[i];
  }
  return s;
}

thrum_status thrum_newmark_finish(const thrum_solver *s, bool solved) {
  if (!solved)
    return s->report->saw_nonfinite ? THRUM_NOT_FINITE : THRUM_NOT_CONVERGED;

  // v' from a', not from d: for a small beta_N the latter would cancel
  const double h = s->state->def.dt, gamma = s->state->def.newmark_gamma;
  thrum_state_view *view = s->view;
  for (int32_t i = 0; i < s->n; i++) {
    const double a_next = -view->total[i];
    view->q_next[i] = view->middle[i];
    view->p_next[i] =
        view->p[i] + h * ((1.0 - gamma) * thrum_newmark_acceleration_now(view, i) + gamma * a_next);
    view->acceleration_next[i] = a_next;
  }
  s->report->solved = true;
  return THRUM_OK;
}

thrum_status thrum_step_newmark(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, thrum_solve_report *report) {
  if (state->def.newmark_beta == 0.0)
    return step_explicit(model, state, view, report);
  const thrum_solver s = thrum_newmark_begin(model, state, view, report);
  return thrum_newmark_finish(&s, thrum_solve_increment(&s));
}

static thrum_mode_factor frequency(const thrum_model *model, const thrum_state *state, int32_t i,
                                   double z) {
  (void)model, (void)i;
  return thrum_newmark_factor(z, state->def.newmark_beta, state->def.newmark_gamma);
}

static bool problem(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                    thrum_solve_report *report, thrum_solver *s) {
  *s = thrum_newmark_problem(model, state, view, report);
  return state->def.newmark_beta > 0.0;
}

static thrum_mode_answer answer(const thrum_model *model, const thrum_state *state, int32_t own,
                                int32_t i) {
  (void)model, (void)own, (void)i;
  return (thrum_mode_answer){1.0, 0.5, 0.5, state->def.newmark_beta};
}

const thrum_scheme_row thrum_newmark_scheme = {
    .scheme = THRUM_SCHEME_NEWMARK,
    .integrator = THRUM_INTEGRATOR_NEWMARK,
    .form = -1,
    .carries_acceleration = true,
    .step = thrum_step_newmark,
    .frequency = frequency,
    .answer = answer,
    .problem = problem,
};
