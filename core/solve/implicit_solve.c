/* The solve of an implicit problem (implicit_problem.h; design 5, 6, 7, 8): quasi-Newton first, and
 * full Newton where that is stuck.
 *
 * Full Newton takes the exact Jacobian in each iteration and searches along its direction. Unless D
 * is in tangent form, the residual g is the gradient in d of the step's potential
 *   m(d) = mu (1/2 |d|^2 - d kick) + w [d eta D (drift + nu rate d/2) - d f] + P(d),
 *   grad P = w R,
 * which is bounded below, so a line search on m finds a solution at any h.
 * Cost of full Newton: an evaluation of R, a tangent and n^3/3 an iteration.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/solve/implicit_solve.h"

#include <math.h>
#include <string.h>

#include "core/linear_algebra/dense.h"
#include "core/polynomial/polynomial_private.h"
#include "core/solve/newton.h"
#include "core/solve/quasi_newton.h"

#define SHIFTS_MAX 8      /* of an indefinite Jacobian, in scales at rest: the first is 1, each */
#define SHIFT_GROWTH 10.0 /* times the one before */
#define LENGTHS_MAX 40    /* of a line search */
#define PROMISED 1e-4     /* share of the fall that the slope promises (Armijo) */
#define OUTSIDE 8.0 /* times the residual: the quartic terms rule, and the next length is 1/16 */

/* The merit of an increment. */
typedef struct merit {
  double norm;      /* scaled norm of the residual */
  double potential; /* m(d), up to a constant; useless for the tangent form */
} merit;

static merit evaluate(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  thrum_problem_place(s);
  double potential = s->evaluate(s);
  const double norm = thrum_problem_residual(s);

  // the quadratic terms of m beyond P
  for (int32_t i = s->first; i < s->state->rank; i++) {
    const double d = view->unknown[i], mass = view->mass[i];
    const double v = view->drift[i] + 0.5 * view->speed[i] * s->rate * d;
    const double damped = view->drag[i] * (thrum_rest_damping(s->model, s->state, i) * v);
    potential += d * (mass * (0.5 * d - view->kick[i]) + s->weight * (damped - view->load[i]));
  }
  const merit found = {norm, potential};
  return found;
}

static bool accept(const thrum_solver *s, double norm) {
  return thrum_problem_accept(s, norm, thrum_problem_norm(s));
}

/* jacobian_next += weight at beta eta dT(middle)[v]: T is quadratic in q, so a central difference
 * of it is exact. */
static void assemble_tangent_change(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double h = s->state->def.dt;
  for (int32_t i = 0; i < s->state->rank; i++) {
    view->q_next[i] = view->middle[i] + 0.5 * h * view->velocity[i];
    view->point[i] = view->middle[i] - 0.5 * h * view->velocity[i];
  }
  thrum_tangent_stiffness_by(s->view->kernel, s->model, view->point, view->tangent, view->work);
  thrum_tangent_stiffness_by(s->view->kernel, s->model, view->q_next, view->tangent_2, view->work);

  // only the rows and columns that are solved for
  const double scale = s->weight * s->at * s->state->def.damping_beta / h;
  const size_t n = (size_t)s->n, rank = (size_t)s->state->rank, first = (size_t)s->first;
  for (size_t i = 0; i < n; i++)
    for (size_t j = 0; j < n; j++) {
      const size_t at = (first + i) * rank + first + j;
      view->jacobian_next[i * n + j] +=
          view->drag[first + i] * scale * (view->tangent_2[at] - view->tangent[at]);
    }
}

/* direction = J^-1 residual; false where J is singular. */
static bool solve_direction(const thrum_solver *s) {
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
  for (int k = 0; k < SHIFTS_MAX; k++) {
    thrum_problem_assemble(s, false);
    if (s->tangent)
      assemble_tangent_change(s);
    for (size_t i = 0; i < n; i++)
      s->view->jacobian_next[i * n + i] += shift * s->view->scale[(size_t)s->first + i];
    shift = shift > 0.0 ? SHIFT_GROWTH * shift : 1.0;
    if (!solve_direction(s))
      continue;

    // a direction of descent has a positive product with the gradient
    *slope = 0.0;
    for (int32_t i = s->first; i < s->state->rank; i++)
      *slope += s->view->direction[i] * s->view->residual[i];
    if (isfinite(*slope) && *slope > 0.0)
      return true;
  }
  return false;
}

/* Line search: goes along the direction by 1 and then by less, until the residual halves or m falls
 * enough (for the tangent form, until the residual falls). False when it never does. */
static bool search(const thrum_solver *s, double slope, merit *here) {
  thrum_state_view *view = s->view;
  memcpy(view->trial, view->unknown, (size_t)s->state->rank * sizeof *view->trial);
  double length = 1.0;
  for (int k = 0; k < LENGTHS_MAX; k++) {
    for (int32_t i = s->first; i < s->state->rank; i++)
      view->unknown[i] = view->trial[i] - length * view->direction[i];
    const merit there = evaluate(s);

    // Armijo's condition on m
    const bool fell = s->tangent
                          ? there.norm < here->norm
                          : there.norm < 0.5 * here->norm ||
                                there.potential < here->potential - PROMISED * length * slope;
    s->report->saw_nonfinite = !isfinite(there.norm);
    if (isfinite(there.norm) && (fell || accept(s, there.norm))) {
      *here = there;
      return true;
    }

    // far outside, where the quartic rules, halves would take too long
    length *= there.norm < OUTSIDE * here->norm ? 0.5 : 0.0625;
  }
  return false;
}

bool thrum_solve_newton(const thrum_solver *s) {
  // from no motion, and without what quasi-Newton has left
  memset(s->view->unknown, 0, (size_t)s->state->rank * sizeof *s->view->unknown);
  s->report->newton = s->report->verified = true;
  s->report->refreshed = s->report->extrapolated = false;
  s->report->learnt = 0;

  merit here = evaluate(s);
  if (!isfinite(here.norm)) {
    s->report->saw_nonfinite = true;
    return false;
  }
  for (int32_t j = 0; !accept(s, here.norm); j++) {
    double slope;
    if (j == s->state->def.iterations_max || !descend(s, &slope) || !search(s, slope, &here))
      return false;
  }
  return true;
}

/* Solves by the solver of the def alone, without full Newton after it. */
static bool solve_by_def(const thrum_solver *s) {
  return s->state->def.solver == THRUM_SOLVER_NEWTON ? thrum_newton_solve(s) : thrum_quasi_solve(s);
}

bool thrum_solve_increment(const thrum_solver *s) {
  if (solve_by_def(s))
    return true;

  // the thesis' solver alone has nothing behind it
  const bool alone = s->state->def.solver == THRUM_SOLVER_NEWTON && !s->state->def.fallback;
  return !alone && thrum_solve_newton(s);
}

void thrum_solve_advance(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  for (int32_t i = s->first; i < s->state->rank; i++) {
    view->q_next[i] = view->q[i] + view->unknown[i];
    view->p_next[i] = view->p[i] - s->state->def.dt * view->total[i];
  }
  s->report->solved = true;
}
