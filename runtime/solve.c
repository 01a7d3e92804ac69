/* The implicit solve of a step, shared by the integrators that solve for the increment d = q' - q
 * of the modes I (design 5, 7, 8):
 *
 *   0 = g(d) = d - h p_I + h^2/2 [R + D v - f]_I,  v = d/h on I and p^+ on E
 *
 * where each integrator says what R, the mean internal force of the step, is as a function of d.
 * Quasi-Newton keeps its factors over several steps. Full Newton comes second: unless D is in
 * tangent form, g is the gradient in d of the step's potential
 *   m(d) = 1/2 |d|^2 + h/4 d D d - d (h p_I + h^2/2 f) + P(d),  grad P = h^2/2 R,
 * which is bounded below, so a line search on m finds a solution at any h.
 * Cost: an evaluation of R an iteration, a tangent and |I|^3/3 a factorisation.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#include "solve.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "polynomial.h"

/* How good an increment is. */
typedef struct measure {
  double norm;  /* scaled, of the residual */
  double merit; /* m(d), up to a constant; useless for the tangent form */
} measure;

/* 1 + h^2/4 omega^2 + h/2 d: the solve's Jacobian at rest, and the scale of a mode's residual. */
static double scale_of(const thrum_solver *s, int32_t i) {
  return 1.0 + 0.25 * s->h * s->h * s->model->omega2[i] +
         0.5 * s->h * thrum_rest_damping(s->model, s->state, i);
}

/* Where the increment in view->unknown is to be evaluated. */
static void place(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double h = s->h;
  for (int32_t i = s->first; i < s->state->rank; i++) {
    view->middle[i] = view->q[i] + 0.5 * view->unknown[i];
    view->velocity[i] = view->unknown[i] / h;
  }
  if (s->tangent)
    thrum_tangent_vector_by(s->view->kernel, s->model, view->middle, view->velocity, view->product,
                            view->work);
}

/* Residual g of the increment placed last, from its R in view->force and its P. */
static measure assess(const thrum_solver *s, double potential) {
  thrum_state_view *view = s->view;
  const double h = s->h, alpha = s->state->damping_alpha, beta = s->state->damping_beta;
  double sum = 0.0, merit = potential;
  for (int32_t i = s->first; i < s->state->rank; i++) {
    const double d = view->unknown[i], v = view->velocity[i], kick = h * view->p[i];
    const double damped =
        alpha * v + beta * (s->tangent ? view->product[i] : s->model->omega2[i] * v);
    view->total[i] = view->force[i] + damped - view->load[i];
    view->residual[i] = d - kick + 0.5 * h * h * view->total[i];
    sum += view->residual[i] * view->residual[i] / scale_of(s, i);
    merit += d * (0.5 * d - kick + 0.5 * h * h * (0.5 * damped - view->load[i]));
  }
  const measure found = {sqrt(sum), merit};
  return found;
}

static measure evaluate(const thrum_solver *s) {
  place(s);
  return assess(s, s->evaluate(s));
}

/* Scaled norm of the increment, in the same measure as the residual's. */
static double step_norm(const thrum_solver *s) {
  double sum = 0.0;
  for (int32_t i = s->first; i < s->state->rank; i++)
    sum += s->view->unknown[i] * s->view->unknown[i] * scale_of(s, i);
  return sqrt(sum);
}

/* Stop: tolerance times the step, or rounding beside the motion seen so far. */
static bool accept(const thrum_solver *s, double norm) {
  const double step = step_norm(s);
  if (!(norm <= s->state->tolerance * step + THRUM_ROUNDING_FLOOR * s->state->amplitude))
    return false;
  s->report->residual = step > 0.0 ? norm / step : 0.0;
  return true;
}

/* Jacobian 1 + h^2/4 T + h/2 D into jacobian_next, without dT of the tangent form. */
static void assemble(const thrum_solver *s) {
  double *matrix = s->view->jacobian_next;
  const double h = s->h, alpha = s->state->damping_alpha, beta = s->state->damping_beta;
  s->stiffness(s, matrix);
  s->view->matrices_used = true;
  const size_t n = (size_t)s->n;
  for (size_t i = 0; i < n; i++) {
    const double rest = s->tangent ? 0.0 : beta * s->model->omega2[(size_t)s->first + i];
    matrix[i * n + i] += 1.0 + 0.5 * h * (alpha + rest);
  }
}

/* jacobian_next += h^2/4 beta dT(q-bar)[v]: T is quadratic in q, so (T(q') - T(q)) / h is exact. */
static void assemble_change(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  for (int32_t i = s->first; i < s->state->rank; i++)
    view->q_next[i] = view->q[i] + view->unknown[i];
  thrum_tangent_by(s->view->kernel, s->model, view->q, view->tangent, view->work);
  thrum_tangent_by(s->view->kernel, s->model, view->q_next, view->tangent_2, view->work);
  const double scale = 0.25 * s->h * s->state->damping_beta;
  const size_t n = (size_t)s->n, rank = (size_t)s->state->rank, first = (size_t)s->first;
  for (size_t i = 0; i < n; i++)
    for (size_t j = 0; j < n; j++) {
      const size_t at = (first + i) * rank + first + j;
      view->jacobian_next[i * n + j] += scale * (view->tangent_2[at] - view->tangent[at]);
    }
}

static bool factorise(const thrum_solver *s) {
  s->report->factorisations++;
  s->report->refreshed =
      thrum_dense_factor(s->view->jacobian_next, s->n, (int32_t *)(void *)s->view->pivots_next);
  return s->report->refreshed;
}

/* direction = J^-1 residual, by the factors made in this step or by those kept. */
static void solve(const thrum_solver *s, bool kept) {
  const thrum_state_view *view = s->view;
  double *direction = view->direction + s->first;
  memcpy(direction, view->residual + s->first, (size_t)s->n * sizeof *direction);
  thrum_dense_solve(kept ? view->jacobian : view->jacobian_next, s->n,
                    (const int32_t *)(const void *)(kept ? view->pivots : view->pivots_next),
                    direction);
  s->report->iterations++;
}

/* First guess: the rest-state linear step under the nonlinear force extrapolated from the steps
 * before, or taken at q_k from the kick; no motion when neither is known. */
static void guess(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const int32_t known = s->state->past_count;
  const double h = s->h;
  for (int32_t i = s->first; i < s->state->rank; i++) {
    const double linear = s->model->omega2[i] * view->q[i];
    double nonlinear = view->force[i] - linear;
    if (known > 0)
      nonlinear = known > 1 ? 2.0 * view->past_1[i] - view->past_2[i] : view->past_1[i];
    const double pull = linear + nonlinear - view->load[i];
    view->unknown[i] =
        known > 0 || s->first > 0 ? (h * view->p[i] - 0.5 * h * h * pull) / scale_of(s, i) : 0.0;
  }
}

/* Contraction of the residual above which the kept factors are too old. */
#define SLOW 0.01

/* Where an exact solve ends: in the step, and beside the motion seen so far. */
#define EXACT 1e-14
#define EXACT_FLOOR 0x1p-50

/* An accepted residual that can still fall: the energy of design 7 is conserved as far as its solve
 * is exact, so that one goes on until rounding stops it. */
static bool can_fall(const thrum_solver *s, double norm, double before) {
  const double exact = EXACT * step_norm(s) + EXACT_FLOOR * s->state->amplitude;
  return s->exact && norm > exact && norm < 0.5 * before;
}

void thrum_quasi_begin(const thrum_solver *s, thrum_quasi *quasi) {
  quasi->before = INFINITY;
  quasi->done = 0;
  quasi->kept = s->state->jacobian_kept != 0;
  quasi->fresh = false;
  guess(s);
  place(s);
}

thrum_quasi_next thrum_quasi_take(const thrum_solver *s, thrum_quasi *quasi, double potential) {
  const double norm = assess(s, potential).norm;
  if (!isfinite(norm))
    return THRUM_QUASI_STUCK;
  const bool accepted = accept(s, norm);
  if (accepted && !can_fall(s, norm, quasi->before))
    return THRUM_QUASI_DONE;
  if (quasi->done == s->state->iterations_max || (quasi->fresh && norm > quasi->before))
    return accepted ? THRUM_QUASI_DONE : THRUM_QUASI_STUCK;
  // a refresh costs a few iterations, and over the next steps saves one or two in each
  quasi->fresh =
      (!quasi->kept && !s->report->refreshed) || (norm > SLOW * quasi->before && !accepted);
  if (quasi->fresh) {
    assemble(s);
    if (!factorise(s))
      return THRUM_QUASI_STUCK;
    quasi->kept = false;
  }
  quasi->before = norm;
  solve(s, quasi->kept);
  for (int32_t i = s->first; i < s->state->rank; i++)
    s->view->unknown[i] -= s->view->direction[i];
  quasi->done++;
  place(s);
  return THRUM_QUASI_EVALUATE;
}

static bool quasi_newton(const thrum_solver *s) {
  thrum_quasi quasi;
  thrum_quasi_begin(s, &quasi);
  thrum_quasi_next next;
  do
    next = thrum_quasi_take(s, &quasi, s->evaluate(s));
  while (next == THRUM_QUASI_EVALUATE);
  return next == THRUM_QUASI_DONE;
}

/* Newton's direction at the present increment, and its slope: the rate at which m falls along it.
 * Where the Jacobian is indefinite a multiple of its rest scale is added until m does fall. */
static bool descend(const thrum_solver *s, double *slope) {
  const size_t n = (size_t)s->n;
  double shift = 0.0;
  for (int k = 0; k<8; k++, shift = shift> 0.0 ? 10.0 * shift : 1.0) {
    assemble(s);
    if (s->tangent)
      assemble_change(s);
    for (size_t i = 0; i < n; i++)
      s->view->jacobian_next[i * n + i] += shift * scale_of(s, s->first + (int32_t)i);
    if (!factorise(s))
      continue;
    // shifted factors serve this direction, not the steps to come
    s->report->refreshed = shift == 0.0;
    solve(s, false);
    *slope = 0.0;
    for (int32_t i = s->first; i < s->state->rank; i++)
      *slope += s->view->direction[i] * s->view->residual[i];
    if (isfinite(*slope) && *slope > 0.0)
      return true;
  }
  return false;
}

/* Goes along the direction by 1 and then shorter, until the residual halves or m falls enough (for
 * the tangent form, until the residual falls). False when it never does. */
static bool shorten(const thrum_solver *s, double slope, measure *here) {
  thrum_state_view *view = s->view;
  memcpy(view->trial, view->unknown, (size_t)s->state->rank * sizeof *view->trial);
  double length = 1.0;
  for (int k = 0; k < 40; k++) {
    for (int32_t i = s->first; i < s->state->rank; i++)
      view->unknown[i] = view->trial[i] - length * view->direction[i];
    const measure there = evaluate(s);
    const bool fell = s->tangent ? there.norm < here->norm
                                 : there.norm < 0.5 * here->norm ||
                                       there.merit < here->merit - 1e-4 * length * slope;
    s->report->saw_nonfinite = !isfinite(there.norm);
    if (isfinite(there.norm) && (fell || accept(s, there.norm))) {
      *here = there;
      return true;
    }
    // far outside, where the quartic rules, halves would take too long
    length *= there.norm < 8.0 * here->norm ? 0.5 : 0.0625;
  }
  return false;
}

/* From no motion, with the exact Jacobian in every iteration. */
bool thrum_solve_newton(const thrum_solver *s) {
  memset(s->view->unknown, 0, (size_t)s->state->rank * sizeof *s->view->unknown);
  s->report->newton = true;
  measure here = evaluate(s);
  if (!isfinite(here.norm)) {
    s->report->saw_nonfinite = true;
    return false;
  }
  for (int32_t j = 0; !accept(s, here.norm); j++) {
    double slope;
    if (j == s->state->iterations_max || !descend(s, &slope) || !shorten(s, slope, &here))
      return false;
  }
  return true;
}

bool thrum_solve_increment(const thrum_solver *s) {
  return quasi_newton(s) || thrum_solve_newton(s);
}

void thrum_solve_advance(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  for (int32_t i = s->first; i < s->state->rank; i++) {
    view->q_next[i] = view->q[i] + view->unknown[i];
    view->p_next[i] = view->p[i] - s->h * view->total[i];
    view->past_next[i] = view->force[i] - s->model->omega2[i] * view->middle[i];
  }
}
