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

#include "polynomial.h"
#include "solve.h"

#define SCALED_MOST 0.5 /* of the kinetic energy: more is a standstill */

/* 1/2 -+ 1/(2 sqrt 3) */
static const double gauss[2] = {0.21132486540518713, 0.78867513459481287};

/* view->point = q + s d */
static void place(const thrum_solver *s, double at) {
  thrum_state_view *view = s->view;
  for (int32_t i = 0; i < s->n; i++)
    view->point[i] = view->q[i] + at * view->unknown[i];
}

/* R-bar into view->force; returns P up to a constant. */
static double evaluate(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  place(s, gauss[0]);
  double sum =
      thrum_force_by(s->view->kernel, s->model, view->point, view->force, view->work) / gauss[0];
  place(s, gauss[1]);
  sum +=
      thrum_force_by(s->view->kernel, s->model, view->point, view->force_2, view->work) / gauss[1];
  for (int32_t i = 0; i < s->n; i++)
    view->force[i] = 0.5 * (view->force[i] + view->force_2[i]);
  return 0.5 * s->weight * sum;
}

/* h^2/2 sum_g s_g/2 T(q + s_g d), and h/2 beta T(q-bar) for the tangent form of damping. */
static void stiffness(const thrum_solver *s, double *matrix) {
  thrum_state_view *view = s->view;
  const size_t count = (size_t)s->n * (size_t)s->n;
  for (int g = 0; g < 2; g++) {
    double *tangent = g == 0 ? matrix : view->tangent;
    place(s, gauss[g]);
    thrum_tangent_by(s->view->kernel, s->model, view->point, tangent, view->work);
    const double weight = 0.5 * s->weight * gauss[g];
    for (size_t a = 0; a < count; a++)
      matrix[a] = g == 0 ? weight * tangent[a] : matrix[a] + weight * tangent[a];
  }
  if (!s->tangent)
    return;
  thrum_tangent_by(s->view->kernel, s->model, view->middle, view->tangent, view->work);
  const double damping = s->weight * s->rate * s->state->damping_beta;
  for (size_t a = 0; a < count; a++)
    matrix[a] += damping * view->tangent[a];
}

/* With p' = p - h total the kinetic energy changes by -total (d - g), where g is the residual left:
 * p' is scaled so that it changes by -total d, which is what the balance says. The factor differs
 * from 1 by about the tolerance. */
static void balance(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  double excess = 0.0, square = 0.0;
  for (int32_t i = 0; i < s->n; i++) {
    excess += view->total[i] * view->residual[i];
    square += view->p_next[i] * view->p_next[i];
  }
  const double share = 2.0 * excess / square;
  // at a standstill no scale helps, and none is needed
  if (!(fabs(share) < SCALED_MOST))
    return;
  // the factor less 1, so that a long run is not rounded one way
  const double more = -share / (1.0 + sqrt(1.0 - share));
  for (int32_t i = 0; i < s->n; i++)
    view->p_next[i] += more * view->p_next[i];
}

thrum_status thrum_step_energy(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, thrum_solve_report *report) {
  thrum_solver s = thrum_solver_of(model, state, view, report, 0);
  s.evaluate = evaluate;
  s.stiffness = stiffness;
  s.verified = true;
  if (!thrum_solve_increment(&s))
    return report->saw_nonfinite ? THRUM_NOT_FINITE : THRUM_NOT_CONVERGED;
  thrum_solve_advance(&s);
  balance(&s);
  return THRUM_OK;
}
