/* One Newmark step, the baseline (design 6), by full Newton in the new acceleration a':
 *
 *   q' = q + h v + h^2/2 [(1 - 2 beta_N) a + 2 beta_N a'],  v' = v + h [(1 - gamma) a + gamma a']
 *   0 = a' + R(q') + D v' - f_k,   Jacobian 1 + beta_N h^2 T(q') + gamma h D
 *
 * Both a and a' of a step use f_k: the stored a is corrected by f_k - f_{k-1}, so that an impulse
 * counts once. beta_N = 0 with rest damping is explicit. The tangent form D = alpha 1 + beta T(q')
 * adds beta_N h^2 beta dT(q')[v'] to the Jacobian.
 * Cost: an iteration takes one force and one tangent evaluation and a solve with r unknowns.
 * Sources: Newmark 1959; Kane et al. 2000,
 * doi:10.1002/1097-0207(20001210)49:10<1295::AID-NME993>3.0.CO;2-W (variational for gamma = 1/2).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#include <math.h>
#include <string.h>

#include "dense.h"
#include "polynomial.h"
#include "state.h"

typedef struct solver {
  const thrum_model *model;
  const thrum_state *state;
  thrum_state_view *view;
  thrum_solve_report *report;
  bool tangent; /* damping in tangent form */
} solver;

/* 1 + beta_N h^2 omega^2 + gamma h d: the Jacobian at rest. */
static double scale_of(const solver *s, int32_t i) {
  const double h = s->state->dt;
  return 1.0 + s->state->newmark_beta * h * h * s->model->omega2[i] +
         s->state->newmark_gamma * h * thrum_rest_damping(s->model, s->state, i);
}

/* view->total += R(q) + D v, with R in view->force and v in `velocity`. */
static void add_forces(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                       const double *q, const double *velocity, double *total) {
  const double alpha = state->damping_alpha, beta = state->damping_beta;
  const bool tangent = thrum_tangent_damped(state);
  thrum_force_by(view->kernel, model, q, view->force, view->work);
  if (tangent)
    thrum_tangent_vector_by(view->kernel, model, q, velocity, view->product, view->work);
  for (int32_t i = 0; i < state->rank; i++) {
    const double stiff = tangent ? view->product[i] : model->omega2[i] * velocity[i];
    total[i] += view->force[i] + (alpha * velocity[i] + beta * stiff);
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

/* q' into q_next and v' into p_next from a' in view->unknown and the corrected a in view->trial. */
static void advance(const solver *s) {
  thrum_state_view *view = s->view;
  const double h = s->state->dt, beta = s->state->newmark_beta, gamma = s->state->newmark_gamma;
  for (int32_t i = 0; i < s->state->rank; i++) {
    const double a = view->trial[i], a_next = view->unknown[i];
    view->middle[i] = h * view->p[i] + h * h * ((0.5 - beta) * a + beta * a_next);
    view->q_next[i] = view->q[i] + view->middle[i];
    view->p_next[i] = view->p[i] + h * ((1.0 - gamma) * a + gamma * a_next);
  }
}

/* Residual of a', and its norm scaled as a displacement: h^2/2 |residual| / sqrt(scale). */
static double evaluate(const solver *s) {
  thrum_state_view *view = s->view;
  const double h = s->state->dt;
  advance(s);
  for (int32_t i = 0; i < s->state->rank; i++)
    view->residual[i] = view->unknown[i] - view->load[i];
  add_forces(s->model, s->state, view, view->q_next, view->p_next, view->residual);
  double sum = 0.0;
  for (int32_t i = 0; i < s->state->rank; i++) {
    const double scaled = 0.5 * h * h * view->residual[i];
    sum += scaled * scaled / scale_of(s, i);
  }
  return sqrt(sum);
}

static bool accept(const solver *s, double norm) {
  double sum = 0.0;
  for (int32_t i = 0; i < s->state->rank; i++)
    sum += s->view->middle[i] * s->view->middle[i] * scale_of(s, i);
  const double step = sqrt(sum);
  if (!(norm <= s->state->tolerance * step + THRUM_ROUNDING_FLOOR * s->state->amplitude))
    return false;
  s->report->residual = step > 0.0 ? norm / step : 0.0;
  return true;
}

/* jacobian_next += beta_N h^2 beta dT(q')[v']: T is quadratic in q, so a difference is exact. */
static void assemble_change(const solver *s) {
  thrum_state_view *view = s->view;
  const double h = s->state->dt;
  const int32_t rank = s->state->rank;
  for (int32_t i = 0; i < rank; i++) {
    view->velocity[i] = view->q_next[i] + 0.5 * h * view->p_next[i];
    view->direction[i] = view->q_next[i] - 0.5 * h * view->p_next[i];
  }
  thrum_tangent_by(s->view->kernel, s->model, view->velocity, view->tangent, view->work);
  thrum_tangent_by(s->view->kernel, s->model, view->direction, view->tangent_2, view->work);
  const double scale = s->state->newmark_beta * h * s->state->damping_beta;
  const size_t count = (size_t)rank * (size_t)rank;
  for (size_t a = 0; a < count; a++)
    view->jacobian_next[a] += scale * (view->tangent[a] - view->tangent_2[a]);
}

static bool factorise(const solver *s) {
  const double h = s->state->dt, gamma = s->state->newmark_gamma;
  const double alpha = s->state->damping_alpha, beta = s->state->damping_beta;
  const size_t rank = (size_t)s->state->rank;
  double *matrix = s->view->jacobian_next;
  thrum_tangent_by(s->view->kernel, s->model, s->view->q_next, matrix, s->view->work);
  s->view->matrices_used = true;
  const double stiff = s->state->newmark_beta * h * h + (s->tangent ? gamma * h * beta : 0.0);
  for (size_t a = 0; a < rank * rank; a++)
    matrix[a] *= stiff;
  for (size_t i = 0; i < rank; i++) {
    const double rest = s->tangent ? 0.0 : beta * s->model->omega2[i];
    matrix[i * rank + i] += 1.0 + gamma * h * (alpha + rest);
  }
  if (s->tangent)
    assemble_change(s);
  s->report->factorisations++;
  return thrum_dense_factor(matrix, s->state->rank, (int32_t *)(void *)s->view->pivots_next);
}

static thrum_status newton(const solver *s) {
  thrum_state_view *view = s->view;
  for (int32_t j = 0;; j++) {
    const double norm = evaluate(s);
    if (!isfinite(norm))
      return THRUM_NOT_FINITE;
    if (accept(s, norm))
      return THRUM_OK;
    if (j == s->state->iterations_max || !factorise(s))
      return THRUM_NOT_CONVERGED;
    s->report->iterations++;
    thrum_dense_solve(view->jacobian_next, s->state->rank,
                      (const int32_t *)(const void *)view->pivots_next, view->residual);
    for (int32_t i = 0; i < s->state->rank; i++)
      view->unknown[i] -= view->residual[i];
  }
}

thrum_status thrum_step_newmark(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, thrum_solve_report *report) {
  const solver s = {model, state, view, report, thrum_tangent_damped(state)};
  for (int32_t i = 0; i < state->rank; i++) {
    view->trial[i] = view->acceleration[i] + (view->load[i] - view->load_before[i]);
    view->unknown[i] = view->trial[i];
  }
  if (state->newmark_beta == 0.0 && !s.tangent) {
    // q' does not depend on a', and D is diagonal: one division a mode
    evaluate(&s);
    for (int32_t i = 0; i < state->rank; i++)
      view->unknown[i] -= view->residual[i] / scale_of(&s, i);
    advance(&s);
  } else {
    const thrum_status status = newton(&s);
    if (status != THRUM_OK)
      return status;
  }
  memcpy(view->acceleration_next, view->unknown, (size_t)state->rank * sizeof(double));
  return THRUM_OK;
}
