/* The step of the average vector field (design 7; discrete_gradient.c):
 *
 *   R-bar = integral over s in [0, 1] of R(q + s d) = [R(q) + 4 R(q + d/2) + R(q')]/6
 *
 * The kinetic energy of the p' that the equation leads to changes by the work of the load less that
 * of the damping and of the residual; scaling p' takes that residual out again.
 * Cost: two force evaluations and about 2 r^2 an iteration, two tangents and r^3 a new Jacobian.
 * Source: Quispel & McLaren 2008, doi:10.1088/1751-8113/41/4/045206.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "core/base/lane_sums.h"
#include "core/base/model_law.h"
#include "core/polynomial/polynomial_private.h"
#include "core/schemes/discrete_gradient_private.h"
#include "core/solve/implicit_solve.h"

#define SCALE_MOST 0.5         /* energy error over kinetic energy: more is a standstill */
#define ERROR_MOST 1e-3        /* energy error at a standstill over the energy: more is a failure */
#define LAW_ERROR_MOST 1e-13   /* the same where Simpson's rule is not exact: a shorter step is */
#define RESIDUAL_FOLLOWED 1e-7 /* over the step: R(q') and V(q') can follow its correction */

/* point = q + s d */
static void place(const thrum_solver *s, double at, double *point) {
  for (int32_t i = 0; i < s->n; i++)
    point[i] = s->view->q[i] + at * s->view->unknown[i];
}

/* matrix += weight factor T(q + s d) */
static void add_tangent(const thrum_solver *s, double at, double factor, double *matrix) {
  thrum_state_view *view = s->view;
  place(s, at, view->point);
  thrum_tangent_stiffness_by(view->kernel, s->model, view->point, view->tangent, view->work);
  const size_t count = (size_t)s->n * (size_t)s->n;
  for (size_t a = 0; a < count; a++)
    matrix[a] += s->weight * factor * view->tangent[a];
}

/* matrix += weight rate beta N T(q-bar) N, with the tangent form of damping */
static void add_damping(const thrum_solver *s, double *matrix) {
  thrum_state_view *view = s->view;
  const double factor = s->weight * (s->rate * s->state->def.damping_beta);
  place(s, 0.5, view->point);
  thrum_tangent_stiffness_by(view->kernel, s->model, view->point, view->tangent, view->work);
  const size_t n = (size_t)s->n;
  for (size_t i = 0; i < n; i++)
    for (size_t j = 0; j < n; j++)
      matrix[i * n + j] += factor * (view->drag[i] * view->speed[j]) * view->tangent[i * n + j];
}

/* R-bar into view->force, R(q') into view->force_2, V(q') into the report; returns P up to a
 * constant. */
static double evaluate_average(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  place(s, 0.5, view->point);
  place(s, 1.0, view->point_2);
  const double *const points[2] = {view->point, view->point_2};
  double *const forces[2] = {view->force, view->force_2}, energies[2];
  thrum_internal_forces_by(view->kernel, s->model, points, forces, energies, view->work);

  // Simpson's rule is exact where R is cubic along d; of points of another law balance() takes the
  // rest
  for (int32_t i = 0; i < s->n; i++)
    view->force[i] = (view->force_start[i] + 4.0 * view->force[i] + view->force_2[i]) / 6.0;
  s->report->potential = energies[1];
  const double along = thrum_sum_of(s->n, view->force_start, view->unknown, NULL);
  return s->weight * (along + 8.0 * energies[0] + energies[1]) / 6.0;
}

/* weight (T(q-bar)/3 + T(q')/6), and weight rate beta N T(q-bar) N for the tangent form of damping.
 */
static void stiffness_of_average(const thrum_solver *s, double *matrix) {
  memset(matrix, 0, (size_t)s->n * (size_t)s->n * sizeof *matrix);
  add_tangent(s, 0.5, 1.0 / 3.0, matrix);
  add_tangent(s, 1.0, 1.0 / 6.0, matrix);
  if (s->tangent)
    add_damping(s, matrix);
}

/* R(q') and V(q') of an increment that was corrected and not evaluated again, to first order: it
 * was corrected by -direction. */
static void follow_correction(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  const double inverse = 1.0 / s->weight, *back = view->direction;
  const double before = thrum_sum_of(s->n, back, view->force_2, NULL);

  // the equation says what the correction did to R-bar; twice that to R(q')
  for (int32_t i = 0; i < s->n; i++) {
    const double damped = thrum_solved_damping(s, i) * back[i];
    view->force_2[i] += 2.0 * ((view->mass[i] * back[i] - view->residual[i]) * inverse + damped);
  }

  // V changes by the mean of R over the correction
  const double after = thrum_sum_of(s->n, back, view->force_2, NULL);
  s->report->potential -= 0.5 * (before + after);
}

/* R(q') and V(q') at the end of the step. */
static void arrive(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  thrum_solve_report *report = s->report;
  report->potential_known = report->verified || report->reached <= RESIDUAL_FOLLOWED;
  if (report->verified)
    return;

  // a correction too large to be followed costs an evaluation of V
  if (report->potential_known)
    follow_correction(s);
  else
    report->potential = thrum_strain_energy_by(view->kernel, s->model, view->q_next, view->work);
}

/* q' and p' from d: p - h L F is 2 (L^-1 d - L g)/h - p with the residual g, and there the forces
 * of stiff modes do not cancel. */
static void advance(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double twice = 2.0 / s->state->def.dt;
  for (int32_t i = 0; i < s->n; i++) {
    const double left = s->report->verified ? view->stretch[i] * view->residual[i] : 0.0;
    view->q_next[i] = view->q[i] + view->unknown[i];
    view->p_next[i] = twice * (view->unstretch[i] * view->unknown[i] - left) - view->p[i];
  }
  s->report->solved = true;
}

/* The error that the balance of this step is left with. With p' = p - h L F the kinetic energy
 * changes by -F (d - L^2 g), g the residual left; it should change by R-bar d less the change of V
 * more. */
static double energy_error_of(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  double error = s->report->potential_start - s->report->potential +
                 thrum_sum_of(s->n, view->force, view->unknown, NULL);
  if (!s->report->verified)
    return error;

  double *left = view->image;
  for (int32_t i = 0; i < s->n; i++)
    left[i] = view->stretch[i] * view->residual[i];
  return error - thrum_sum_less(s->n, view->p, view->p_next, left) / s->state->def.dt;
}

/* Scales p' so that the balance holds; the factor differs from 1 by about the tolerance. False at a
 * standstill whose energy error is more than rounding: a loose tolerance at a large step, or a law
 * whose forces Simpson's rule does not integrate exactly. */
static bool balance(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double error = energy_error_of(s);
  if (thrum_momentum_take(s, error, SCALE_MOST, view->p_next, view->p_next))
    return true;
  const double square = thrum_sum_of(s->n, view->p_next, view->p_next, NULL);
  const bool exact = thrum_law_of_model(s->model) == THRUM_LAW_STVK;
  const double most = exact ? ERROR_MOST : LAW_ERROR_MOST;
  return !(fabs(error) > most * (fabs(s->report->potential) + 0.5 * square));
}

thrum_status thrum_average_step(thrum_solver *s) {
  s->evaluate = evaluate_average;
  s->stiffness = stiffness_of_average;
  s->both = NULL;
  if (!thrum_solve_increment(s))
    return s->report->saw_nonfinite ? THRUM_NOT_FINITE : THRUM_NOT_CONVERGED;
  advance(s);
  arrive(s);
  return balance(s) ? THRUM_OK : THRUM_NOT_CONVERGED;
}
