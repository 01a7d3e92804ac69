/* The parts of the equation that an implicit step solves (implicit_problem.h; design 5, 6, 7).
 *
 * R is a function of q + at d, and v = rate d + drift on I and p^+ on E. For the midpoint rule
 * kick = h p_I, weight = h^2/2, at = 1/2, rate = 1/h and drift = 0; each integrator says what R,
 * the mean internal force of the step, is. Norms are scaled by the Jacobian at rest, so that a
 * residual and the increment that it leads to are compared in one measure.
 * Cost: an evaluation of R and about 10 r a residual.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/solve/implicit_problem.h"

#include <math.h>
#include <string.h>

#include "core/base/lane_sums.h"
#include "core/polynomial/polynomial_private.h"

/* Iterations that cost less than a new Jacobian, measured: where a part of the modes is solved for,
 * or the next step makes a Jacobian anyway; of all modes with a tangent by lists; or by pairs. */
#define CHEAPER_MOST 3
#define CHEAPER_LISTS 2
#define CHEAPER_PAIRS 1

/* --- R of the whole model at the middle ------------------------------------------------------- */

static double evaluate(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  return s->weight / s->at *
         thrum_internal_force_by(view->kernel, s->model, view->middle, view->force, view->work);
}

void thrum_problem_weigh(const thrum_solver *s, double *matrix) {
  const double damping = s->tangent ? s->rate * s->state->def.damping_beta : 0.0;
  const double stiff = s->weight * (s->at + damping);
  const size_t n = (size_t)s->n;
  for (size_t a = 0; a < n * n; a++)
    matrix[a] *= stiff;
  if (damping == 0.0 || s->own == 0)
    return;

  // T nu is not symmetric: the geometric mean of both modes' eta nu, which iterations make good
  const double *speed = s->view->speed + s->first, *drag = s->view->drag + s->first;
  for (size_t i = 0; i < n; i++)
    for (size_t j = 0; j < n; j++) {
      const double both = speed[i] * drag[i] * (speed[j] * drag[j]);
      matrix[i * n + j] *= (s->at + damping * sqrt(both)) / (s->at + damping);
    }
}

static void stiffness(const thrum_solver *s, double *matrix) {
  thrum_tangent_stiffness_by(s->view->kernel, s->model, s->view->middle, matrix, s->view->work);
  thrum_problem_weigh(s, matrix);
}

static void evaluate_both(const thrum_solver *s, double *matrix) {
  thrum_state_view *view = s->view;
  thrum_internal_force_tangent_by(view->kernel, s->model, view->middle, view->force, matrix,
                                  view->work);
  thrum_problem_weigh(s, matrix);
}

/* --- the problem ------------------------------------------------------------------------------ */

static int32_t cheaper_than_jacobian(const thrum_model *model, const thrum_state *state,
                                     int32_t first) {
  if (first > 0 || state->report.steps < state->eager_end)
    return CHEAPER_MOST;
  return thrum_pairs_count(model->rank) > 0 ? CHEAPER_PAIRS : CHEAPER_LISTS;
}

thrum_solver thrum_problem_make(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, thrum_solve_report *report, int32_t first,
                                double at, double weight, double rate) {
  const thrum_solver s = {.model = model,
                          .state = state,
                          .view = view,
                          .report = report,
                          .evaluate = evaluate,
                          .stiffness = stiffness,
                          .both = evaluate_both,
                          .weigh = thrum_problem_weigh,
                          .evaluated = view->force,
                          .at = at,
                          .weight = weight,
                          .rate = rate,
                          .tolerance =
                              state->def.tolerance > 0.0 ? state->def.tolerance : THRUM_TOLERANCE,
                          .cheaper = cheaper_than_jacobian(model, state, first),
                          .past_count = state->past_count,
                          .first = first,
                          .n = state->rank - first,
                          .tangent = thrum_tangent_damped(state)};

  // only the discrete gradient has a part along d
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
  for (int32_t i = first; i < state->rank; i++)
    view->mass[i] = view->speed[i] = view->drag[i] = 1.0;
  return s;
}

void thrum_problem_take_own(thrum_solver *s, int32_t count) {
  thrum_state_view *view = s->view;
  s->own = count;
  for (int32_t i = s->first; i < count; i++) {
    const double damping = thrum_rest_damping(s->model, s->state, i);
    const double damped = s->rate * (view->speed[i] * view->drag[i]) * damping;
    view->scale[i] = view->mass[i] + s->weight * (s->at * s->model->omega2[i] + damped);
    view->unscale[i] = 1.0 / view->scale[i];
  }
}

void thrum_problem_place(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double *q = view->q, *d = view->unknown, *drift = view->drift, at = s->at, rate = s->rate;
  const double *speed = view->speed;
  double *restrict middle = view->middle, *restrict velocity = view->velocity;
  const int32_t rank = s->state->rank;
  for (int32_t i = s->first; i < rank; i++) {
    middle[i] = q[i] + at * d[i];
    velocity[i] = speed[i] * rate * d[i] + drift[i];
  }

  // tangent damping acts at the same point
  if (s->tangent)
    thrum_tangent_product_by(s->view->kernel, s->model, view->middle, view->velocity, view->product,
                             view->work);
}

double thrum_problem_residual(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double alpha = s->state->def.damping_alpha, beta = s->state->def.damping_beta;
  const double weight = s->weight, twice = 2.0 * s->report->along_step, *omega2 = s->model->omega2;
  const double *force = s->evaluated, *velocity = view->velocity, *product = view->product;
  const double *d = view->unknown, *load = view->load, *kick = view->kick, *mass = view->mass;
  const double *drag = view->drag;
  double *restrict total = view->total, *restrict residual = view->residual;
  const int32_t rank = s->state->rank;
  const bool tangent = s->tangent;

  // locals and restrict, so that the loop is vectorised
  for (int32_t i = s->first; i < rank; i++) {
    const double v = velocity[i];
    const double damped = drag[i] * (alpha * v + beta * (tangent ? product[i] : omega2[i] * v));
    total[i] = force[i] + twice * d[i] + damped - load[i];
    residual[i] = mass[i] * (d[i] - kick[i]) + weight * total[i];
  }
  // damping of single modes, which most bodies have not
  const double *own = s->model->damping;
  for (int32_t i = s->first; own && i < rank; i++) {
    const double damped = drag[i] * (own[i] * velocity[i]);
    total[i] += damped;
    residual[i] += weight * damped;
  }
  const double *left = residual + s->first;
  return sqrt(thrum_sum_of(s->n, left, left, view->unscale + s->first));
}

double thrum_problem_norm(const thrum_solver *s) {
  const double *unknown = s->view->unknown + s->first;
  return sqrt(s->beside + thrum_sum_of(s->n, unknown, unknown, s->view->scale + s->first));
}

double thrum_problem_goal(const thrum_solver *s, double step) {
  return s->tolerance * step + THRUM_ROUNDING_FLOOR * s->state->amplitude;
}

bool thrum_problem_is_rounding(const thrum_solver *s, double norm) {
  return norm <= THRUM_ROUNDING_FLOOR * s->state->amplitude;
}

bool thrum_problem_accept(const thrum_solver *s, double norm, double step) {
  if (!(norm <= thrum_problem_goal(s, step)))
    return false;
  s->report->residual = step > 0.0 ? norm / step : 0.0;
  return true;
}

void thrum_problem_assemble(const thrum_solver *s, bool stiffness_there) {
  double *matrix = s->view->jacobian_next;
  const double beta = s->state->def.damping_beta;
  if (!stiffness_there)
    s->stiffness(s, matrix);

  // mass and rest damping are diagonal
  const size_t n = (size_t)s->n;
  for (size_t i = 0; i < n; i++) {
    const double rest = s->tangent ? 0.0 : beta * s->model->omega2[(size_t)s->first + i];
    const size_t mode = (size_t)s->first + i;
    const double mass = s->view->mass[mode];
    const double damped = s->view->speed[mode] * s->view->drag[mode] / mass *
                          (thrum_mass_damping(s->model, s->state, (int64_t)mode) + rest);
    matrix[i * n + i] += mass * (1.0 + s->weight * s->rate * damped);
  }
}
