/* One energy-conserving step of all modes, the average vector field (design 7):
 *
 *   p' = p - h [R-bar + D v - f],  q' = q + h/2 (p + p'),  v = (q' - q)/h,
 *   R-bar = integral over s in [0, 1] of R(q + s (q' - q)).
 *
 * R is cubic, so two Gauss points s_g = 1/2 -+ 1/(2 sqrt 3) make the integral exact and
 * 1/2 |p|^2 + V changes by the work of the load less the dissipation at any h; what the solver's
 * tolerance leaves is taken up by a scale of p'. R-bar is a gradient in d = q' - q, so solve.c can
 * search along the step's potential: P(d) = h^2/2 sum_g 1/2 V(q + s_g d)/s_g. Tangent damping takes
 * T at the midpoint. Cost: two force evaluations an iteration, two tangents and r^3/3 a
 * factorisation. Source: Quispel & McLaren 2008, A new class of energy-preserving numerical
 * integration methods, doi:10.1088/1751-8113/41/4/045206.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#include <math.h>
#include <string.h>

#include "polynomial.h"
#include "solve.h"

#define SCALED_MOST 0.5 /* of the kinetic energy: more is a standstill */

/* 1/2 -+ 1/(2 sqrt 3) */
static const double gauss[2] = {0.21132486540518713, 0.78867513459481287};

/* R-bar into view->force; returns P up to a constant. */
static double evaluate(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  for (int32_t i = 0; i < s->n; i++) {
    view->point[i] = view->q[i] + gauss[0] * view->unknown[i];
    view->point_2[i] = view->q[i] + gauss[1] * view->unknown[i];
  }
  const double *const points[2] = {view->point, view->point_2};
  double *const forces[2] = {view->force, view->force_2}, energies[2];
  thrum_forces_by(view->kernel, s->model, points, forces, energies, view->work);
  for (int32_t i = 0; i < s->n; i++)
    view->force[i] = 0.5 * (view->force[i] + view->force_2[i]);
  return 0.5 * s->weight * (energies[0] / gauss[0] + energies[1] / gauss[1]);
}

/* matrix += weight factor T(q + s d) */
static void add_tangent(const thrum_solver *s, double at, double factor, double *matrix) {
  thrum_state_view *view = s->view;
  for (int32_t i = 0; i < s->n; i++)
    view->point[i] = view->q[i] + at * view->unknown[i];
  thrum_tangent_by(view->kernel, s->model, view->point, view->tangent, view->work);
  const size_t count = (size_t)s->n * (size_t)s->n;
  for (size_t a = 0; a < count; a++)
    matrix[a] += s->weight * factor * view->tangent[a];
}

/* weight sum_g s_g/2 T(q + s_g d), and weight rate beta T(q-bar) for the tangent form of damping.
 * Quasi-Newton makes do with weight/2 T(q + 2/3 d): 2/3 is the centroid of the weight s, so that
 * what is missing is of second order in d. */
static void stiffness(const thrum_solver *s, double *matrix) {
  memset(matrix, 0, (size_t)s->n * (size_t)s->n * sizeof *matrix);
  if (s->report->newton) {
    for (int g = 0; g < 2; g++)
      add_tangent(s, gauss[g], 0.5 * gauss[g], matrix);
  } else {
    add_tangent(s, 2.0 / 3.0, 0.5, matrix);
  }
  if (s->tangent)
    add_tangent(s, 0.5, s->rate * s->state->damping_beta, matrix);
}

/* Kinetic energy that the balance wants p_next to have more, of an increment where R was evaluated:
 * with p' = p - h total the kinetic energy changes by -total (d - g), where g is the residual left,
 * not by -total d. */
static double owed_evaluated(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  double sum = 0.0;
  for (int32_t i = 0; i < s->n; i++)
    sum -= view->total[i] * view->residual[i];
  return sum;
}

/* The same where it was not: p' = p - h total changes the kinetic energy by -total d, and V must
 * change by R-bar d. */
static double owed_unevaluated(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double before = s->state->potential_step == s->state->steps
                            ? s->state->potential
                            : thrum_energy_by(view->kernel, s->model, view->q, view->work);
  const double after = thrum_energy_by(view->kernel, s->model, view->q_next, view->work);
  s->report->potential = after;
  s->report->potential_known = true;
  double work = 0.0;
  for (int32_t i = 0; i < s->n; i++)
    work += view->force[i] * view->unknown[i];
  return work - (after - before);
}

/* Scales p' so that the balance holds. The factor differs from 1 by about the tolerance. */
static void balance(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  const double owed = s->report->verified ? owed_evaluated(s) : owed_unevaluated(s);
  double square = 0.0;
  for (int32_t i = 0; i < s->n; i++)
    square += view->p_next[i] * view->p_next[i];
  const double share = 2.0 * owed / square;
  // at a standstill no scale helps, and none is needed
  if (!(fabs(share) < SCALED_MOST))
    return;
  // the factor less 1, so that a long run is not rounded one way
  const double more = share / (1.0 + sqrt(1.0 + share));
  for (int32_t i = 0; i < s->n; i++)
    view->p_next[i] += more * view->p_next[i];
}

thrum_status thrum_step_energy(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, thrum_solve_report *report) {
  thrum_solver s = thrum_solver_of(model, state, view, report, 0);
  s.evaluate = evaluate;
  s.stiffness = stiffness;
  s.both = NULL;
  report->potential_known = false;
  if (!thrum_solve_increment(&s))
    return report->saw_nonfinite ? THRUM_NOT_FINITE : THRUM_NOT_CONVERGED;
  thrum_solve_advance(&s);
  balance(&s);
  return THRUM_OK;
}
