/* The implicit solve of a step, shared by the integrators that solve for the increment d = q' - q
 * of the modes I (design 5, 6, 7, 8):
 *
 *   0 = g(d) = d - kick + w [R + D v - f]_I,  v = rate d + drift on I and p^+ on E
 *
 * with R a function of q + at d. For the midpoint rule kick = h p_I, w = h^2/2, at = 1/2,
 * rate = 1/h, drift = 0; each integrator says what R, the mean internal force of the step, is.
 * Quasi-Newton (quasi.c) comes first. Full Newton comes second: unless D is in tangent form, g is
 * the gradient in d of the step's potential
 *   m(d) = 1/2 |d|^2 - d kick + w [d D (drift + rate d/2) - d f] + P(d),  grad P = w R,
 * which is bounded below, so a line search on m finds a solution at any h.
 * Cost of full Newton: an evaluation of R, a tangent and n^3/3 an iteration.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include "runtime/dynamics/implicit_solve.h"

#include <math.h>
#include <string.h>

#include "runtime/base/lane_sums.h"
#include "runtime/linear_algebra/dense.h"
#include "runtime/polynomial/polynomial_private.h"

/* Iterations that cost less than a Jacobian, measured: of a part of the modes; of all, with a
 * tangent by lists or by pairs; and in steps that make their Jacobians at once, where an inverse
 * that is extrapolated does well and the next step makes another anyway. */
#define CHEAPER_PART 3
#define CHEAPER_LISTS 2
#define CHEAPER_PAIRS 1
#define CHEAPER_EAGER 3

double thrum_solve_force(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  return s->weight / s->at *
         thrum_internal_force_by(view->kernel, s->model, view->middle, view->force, view->work);
}

void thrum_solve_weigh(const thrum_solver *s, double *matrix) {
  const double damping = s->tangent ? s->rate * s->state->damping_beta : 0.0;
  const double stiff = s->weight * (s->at + damping);
  const size_t count = (size_t)s->n * (size_t)s->n;
  for (size_t a = 0; a < count; a++)
    matrix[a] *= stiff;
}

void thrum_solve_stiffness(const thrum_solver *s, double *matrix) {
  thrum_tangent_stiffness_by(s->view->kernel, s->model, s->view->middle, matrix, s->view->work);
  thrum_solve_weigh(s, matrix);
}

void thrum_solve_both(const thrum_solver *s, double *matrix) {
  thrum_state_view *view = s->view;
  thrum_internal_force_tangent_by(view->kernel, s->model, view->middle, view->force, matrix,
                                  view->work);
  thrum_solve_weigh(s, matrix);
}

static int32_t cheaper_than_jacobian(const thrum_model *model, const thrum_state *state,
                                     int32_t first) {
  if (state->steps < state->eager_end)
    return CHEAPER_EAGER;
  if (first > 0)
    return CHEAPER_PART;
  return thrum_pairs_count(model->rank) > 0 ? CHEAPER_PAIRS : CHEAPER_LISTS;
}

thrum_solver thrum_solver_of(const thrum_model *model, const thrum_state *state,
                             thrum_state_view *view, thrum_solve_report *report, int32_t first,
                             double at, double weight, double rate) {
  const thrum_solver s = {.model = model,
                          .state = state,
                          .view = view,
                          .report = report,
                          .evaluate = thrum_solve_force,
                          .stiffness = thrum_solve_stiffness,
                          .both = thrum_solve_both,
                          .evaluated = view->force,
                          .at = at,
                          .weight = weight,
                          .rate = rate,
                          .cheaper = cheaper_than_jacobian(model, state, first),
                          .past_count = state->past_count,
                          .first = first,
                          .n = state->rank - first,
                          .tangent = thrum_tangent_damped(state)};
  report->along_step = 0.0;
  // the Jacobian at rest, 1 + weight (at omega^2 + rate d): the scale of a mode's residual
  const double *omega2 = model->omega2;
  double *restrict scale = view->scale, *restrict unscale = view->unscale;
  for (int32_t i = first; i < state->rank; i++) {
    const double damping = thrum_rest_damping(model, state, i);
    scale[i] = 1.0 + weight * (at * omega2[i] + rate * damping);
    unscale[i] = 1.0 / scale[i];
  }
  memset(view->drift + first, 0, (size_t)s.n * sizeof *view->drift);
  return s;
}

void thrum_solve_place(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double *q = view->q, *d = view->unknown, *drift = view->drift, at = s->at, rate = s->rate;
  double *restrict middle = view->middle, *restrict velocity = view->velocity;
  const int32_t rank = s->state->rank;
  for (int32_t i = s->first; i < rank; i++) {
    middle[i] = q[i] + at * d[i];
    velocity[i] = rate * d[i] + drift[i];
  }
  if (s->tangent)
    thrum_tangent_product_by(s->view->kernel, s->model, view->middle, view->velocity, view->product,
                             view->work);
}

double thrum_solve_assess(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double alpha = s->state->damping_alpha, beta = s->state->damping_beta, weight = s->weight;
  const double twice = 2.0 * s->report->along_step, *omega2 = s->model->omega2;
  const double *force = s->evaluated, *velocity = view->velocity, *product = view->product;
  const double *d = view->unknown, *load = view->load, *kick = view->kick;
  double *restrict total = view->total, *restrict residual = view->residual;
  const int32_t rank = s->state->rank;
  const bool tangent = s->tangent;
  for (int32_t i = s->first; i < rank; i++) {
    const double v = velocity[i];
    const double damped = alpha * v + beta * (tangent ? product[i] : omega2[i] * v);
    total[i] = force[i] + twice * d[i] + damped - load[i];
    residual[i] = d[i] - kick[i] + weight * total[i];
  }
  const double *left = residual + s->first;
  return sqrt(thrum_sum_of(s->n, left, left, view->unscale + s->first));
}

/* Scaled norm of the increment, in the same measure as the residual's. */
double thrum_solve_norm(const thrum_solver *s) {
  const double *unknown = s->view->unknown + s->first;
  return sqrt(thrum_sum_of(s->n, unknown, unknown, s->view->scale + s->first));
}

/* Stop: tolerance times the step, or rounding beside the motion seen so far. */
bool thrum_solve_accept(const thrum_solver *s, double norm, double step) {
  if (!(norm <= s->state->tolerance * step + THRUM_ROUNDING_FLOOR * s->state->amplitude))
    return false;
  s->report->residual = step > 0.0 ? norm / step : 0.0;
  return true;
}

/* Without dT of the tangent form. */
void thrum_solve_assemble(const thrum_solver *s, bool stiffness_there) {
  double *matrix = s->view->jacobian_next;
  const double alpha = s->state->damping_alpha, beta = s->state->damping_beta;
  if (!stiffness_there)
    s->stiffness(s, matrix);
  const size_t n = (size_t)s->n;
  for (size_t i = 0; i < n; i++) {
    const double rest = s->tangent ? 0.0 : beta * s->model->omega2[(size_t)s->first + i];
    matrix[i * n + i] += 1.0 + s->weight * s->rate * (alpha + rest);
  }
}

/* --- full Newton ------------------------------------------------------------------------------ */

/* How good an increment is. */
typedef struct measure {
  double norm;  /* scaled, of the residual */
  double merit; /* m(d), up to a constant; useless for the tangent form */
} measure;

static measure evaluate(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  thrum_solve_place(s);
  double merit = s->evaluate(s);
  const double norm = thrum_solve_assess(s);
  for (int32_t i = s->first; i < s->state->rank; i++) {
    const double d = view->unknown[i];
    const double damped =
        thrum_rest_damping(s->model, s->state, i) * (view->drift[i] + 0.5 * s->rate * d);
    merit += d * (0.5 * d - view->kick[i] + s->weight * (damped - view->load[i]));
  }
  const measure found = {norm, merit};
  return found;
}

static bool accept(const thrum_solver *s, double norm) {
  return thrum_solve_accept(s, norm, thrum_solve_norm(s));
}

/* jacobian_next += weight at beta dT(middle)[v]: T is quadratic in q, so a difference of it is
 * exact. */
static void assemble_change(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double h = s->state->dt;
  for (int32_t i = 0; i < s->state->rank; i++) {
    view->q_next[i] = view->middle[i] + 0.5 * h * view->velocity[i];
    view->point[i] = view->middle[i] - 0.5 * h * view->velocity[i];
  }
  thrum_tangent_stiffness_by(s->view->kernel, s->model, view->point, view->tangent, view->work);
  thrum_tangent_stiffness_by(s->view->kernel, s->model, view->q_next, view->tangent_2, view->work);
  const double scale = s->weight * s->at * s->state->damping_beta / h;
  const size_t n = (size_t)s->n, rank = (size_t)s->state->rank, first = (size_t)s->first;
  for (size_t i = 0; i < n; i++)
    for (size_t j = 0; j < n; j++) {
      const size_t at = (first + i) * rank + first + j;
      view->jacobian_next[i * n + j] += scale * (view->tangent_2[at] - view->tangent[at]);
    }
}

/* direction = J^-1 residual; false where J is singular. */
static bool direct(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  int32_t *pivots = (int32_t *)(void *)view->pivots_next;
  double *direction = view->direction + s->first;
  s->report->factorisations++;
  if (!thrum_dense_factor(view->jacobian_next, s->n, pivots))
    return false;
  memcpy(direction, view->residual + s->first, (size_t)s->n * sizeof *direction);
  thrum_dense_solve(view->jacobian_next, s->n, pivots, direction);
  s->report->iterations++;
  return true;
}

/* Newton's direction at the present increment, and its slope: the rate at which m falls along it.
 * Where the Jacobian is indefinite a multiple of its rest scale is added until m does fall. */
static bool descend(const thrum_solver *s, double *slope) {
  const size_t n = (size_t)s->n;
  double shift = 0.0;
  for (int k = 0; k<8; k++, shift = shift> 0.0 ? 10.0 * shift : 1.0) {
    thrum_solve_assemble(s, false);
    if (s->tangent)
      assemble_change(s);
    for (size_t i = 0; i < n; i++)
      s->view->jacobian_next[i * n + i] += shift * s->view->scale[(size_t)s->first + i];
    if (!direct(s))
      continue;
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
  s->report->newton = s->report->verified = true;
  s->report->refreshed = s->report->extrapolated = false;
  s->report->learnt = 0;
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

bool thrum_solve_quasi(const thrum_solver *s) {
  thrum_quasi quasi;
  thrum_quasi_begin(s, &quasi);
  thrum_quasi_next next;
  do {
    quasi.assembled = s->both && quasi.ahead && quasi.done == 0;
    if (quasi.assembled) {
      s->both(s, s->view->jacobian_next);
    } else {
      s->evaluate(s);
    }
    next = thrum_quasi_take(s, &quasi);
  } while (next == THRUM_QUASI_EVALUATE);
  return next == THRUM_QUASI_DONE;
}

bool thrum_solve_increment(const thrum_solver *s) {
  return thrum_solve_quasi(s) || thrum_solve_newton(s);
}

void thrum_solve_advance(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  for (int32_t i = s->first; i < s->state->rank; i++) {
    view->q_next[i] = view->q[i] + view->unknown[i];
    view->p_next[i] = view->p[i] - s->state->dt * view->total[i];
  }
  s->report->solved = true;
}
