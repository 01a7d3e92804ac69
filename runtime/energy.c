/* One energy-conserving step of all modes, the average vector field (design 7):
 *
 *   p' = p - h [R-bar + D v - f],  q' = q + h/2 (p + p'),  v = (q' - q)/h,
 *   R-bar = integral over s in [0, 1] of R(q + s d),  d = q' - q.
 *
 * R is cubic, so Simpson's rule is exact, R-bar = [R(q) + 4 R(q + d/2) + R(q')]/6, and
 * 1/2 |p|^2 + V changes by the work of the load less the dissipation at any h; what the solver's
 * tolerance leaves is taken up by a scale of p'. The first term is the last one of the step before.
 * While the residual is large one force does for two: Radau's rule 1/4 R(q) + 3/4 R(q + 2/3 d)
 * misses only what is cubic in d, which is taken from the step before, and the tangent that a new
 * Jacobian needs is the one at the same point. R-bar is a gradient in d, so solve.c can search
 * along the step's potential, P(d) = h^2/2 [R(q) d + 8 V(q + d/2) + V(q + d)]/6. Tangent damping
 * takes T at the midpoint, and Simpson's rule throughout. Cost: one or two force evaluations an
 * iteration, a tangent and r^3 where the Jacobian is anew. Source: Quispel & McLaren 2008, A new
 * class of energy-preserving numerical integration methods, doi:10.1088/1751-8113/41/4/045206.
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
#define CENTROID (2.0 / 3.0)
#define GROWTH_MOST 2.0 /* of |d| from one step to the next */
#define CLOSE 1e-7      /* residual beside the step whose correction R(q') and V(q') can follow */

/* point = q + s d */
static void place(const thrum_solver *s, double at, double *point) {
  for (int32_t i = 0; i < s->n; i++)
    point[i] = s->view->q[i] + at * s->view->unknown[i];
}

/* --- R-bar by Simpson's rule ------------------------------------------------------------------ */

/* R-bar into view->force, R(q') into view->force_2, V(q') into the report; returns P up to a
 * constant. */
static double evaluate(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  place(s, 0.5, view->point);
  place(s, 1.0, view->point_2);
  const double *const points[2] = {view->point, view->point_2};
  double *const forces[2] = {view->force, view->force_2}, energies[2];
  thrum_forces_by(view->kernel, s->model, points, forces, energies, view->work);
  double along = 0.0;
  for (int32_t i = 0; i < s->n; i++) {
    view->force[i] = (view->force_start[i] + 4.0 * view->force[i] + view->force_2[i]) / 6.0;
    along += view->force_start[i] * view->unknown[i];
  }
  s->report->potential = energies[1];
  return s->weight * (along + 8.0 * energies[0] + energies[1]) / 6.0;
}

/* matrix += weight factor T(q + s d) */
static void add_tangent(const thrum_solver *s, double at, double factor, double *matrix) {
  thrum_state_view *view = s->view;
  place(s, at, view->point);
  thrum_tangent_by(view->kernel, s->model, view->point, view->tangent, view->work);
  const size_t count = (size_t)s->n * (size_t)s->n;
  for (size_t a = 0; a < count; a++)
    matrix[a] += s->weight * factor * view->tangent[a];
}

/* weight (T(q-bar)/3 + T(q')/6), and weight rate beta T(q-bar) for the tangent form of damping.
 * Quasi-Newton makes do with weight/2 T(q + 2/3 d): 2/3 is the centroid of the weight s of the
 * integral of s T(q + s d), so that what is missing is of second order in d. */
static void stiffness(const thrum_solver *s, double *matrix) {
  memset(matrix, 0, (size_t)s->n * (size_t)s->n * sizeof *matrix);
  if (s->report->newton) {
    add_tangent(s, 0.5, 1.0 / 3.0, matrix);
    add_tangent(s, 1.0, 1.0 / 6.0, matrix);
  } else {
    add_tangent(s, CENTROID, 0.5, matrix);
  }
  if (s->tangent)
    add_tangent(s, 0.5, s->rate * s->state->damping_beta, matrix);
}

/* --- R-bar from one force, by Radau's rule ---------------------------------------------------- */

static double length(const thrum_solver *s) {
  double sum = 0.0;
  for (int32_t i = 0; i < s->n; i++)
    sum += s->view->unknown[i] * s->view->unknown[i];
  return sqrt(sum);
}

/* How much larger what the rule misses is than in the step before, if d has the same direction. */
static double growth(const thrum_solver *s) {
  const double ratio = fmin(length(s) / s->state->missed_step, GROWTH_MOST);
  return s->state->missed_step > 0.0 ? ratio * ratio * ratio : 0.0;
}

/* view->force = R-bar, from R(q + 2/3 d) there. */
static void complete(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  const double grown = growth(s);
  for (int32_t i = 0; i < s->n; i++)
    view->force[i] = 0.25 * view->force_start[i] + 0.75 * view->force[i] + grown * view->missed[i];
}

static void approximate(const thrum_solver *s) {
  place(s, CENTROID, s->view->point);
  thrum_force_by(s->view->kernel, s->model, s->view->point, s->view->force, s->view->work);
  complete(s);
}

static void both(const thrum_solver *s, double *matrix) {
  thrum_state_view *view = s->view;
  place(s, CENTROID, view->point);
  thrum_force_tangent_by(view->kernel, s->model, view->point, view->force, matrix, view->work);
  complete(s);
  thrum_solve_weigh(s, matrix);
}

/* The correction before was to leave no residual: what there is is what the rule missed, nearly. */
static void missed(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double grown = growth(s);
  for (int32_t i = 0; i < s->n; i++)
    view->missed_next[i] = grown * view->missed[i] + view->residual[i] / s->weight;
  s->report->missed_step = thrum_all_finite(view->missed_next, s->n) ? length(s) : 0.0;
}

/* --- the step --------------------------------------------------------------------------------- */

/* R(q) into view->force_start; returns V(q). */
static double start(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  if (s->state->potential_step != s->state->steps)
    return thrum_force_by(view->kernel, s->model, view->q, view->force_start, view->work);
  memcpy(view->force_start, view->force_now, (size_t)s->n * sizeof *view->force_start);
  return s->state->potential;
}

/* R(q') and V(q'), from those of the last evaluation. */
static void arrive(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  s->report->potential_known = s->report->verified || s->report->reached <= CLOSE;
  if (s->report->verified)
    return;
  if (!s->report->potential_known) {
    s->report->potential = thrum_energy_by(view->kernel, s->model, view->q_next, view->work);
    return;
  }
  // d was corrected by -direction, and (5) says what that did to R-bar: half of what it did to
  // R(q')
  double gained = 0.0;
  for (int32_t i = 0; i < s->n; i++) {
    const double back = view->direction[i];
    const double damped = s->rate * thrum_rest_damping(s->model, s->state, i) * back;
    const double change = (back - view->residual[i]) / s->weight + damped;
    gained -= back * (view->force_2[i] + change);
    view->force_2[i] += 2.0 * change;
  }
  s->report->potential += gained;
}

/* Scales p' so that the balance holds; the factor differs from 1 by about the tolerance. With p' =
 * p - h total the kinetic energy changes by -total (d - g), g the residual left, and it should by
 * that of R-bar d less the change of V more. */
static void balance(const thrum_solver *s, double before) {
  const thrum_state_view *view = s->view;
  double owed = before - s->report->potential, square = 0.0;
  for (int32_t i = 0; i < s->n; i++) {
    const double left = s->report->verified ? view->residual[i] : 0.0;
    owed += view->force[i] * view->unknown[i] - view->total[i] * left;
    square += view->p_next[i] * view->p_next[i];
  }
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
  s.both = s.tangent ? NULL : both;
  s.approximate = s.tangent ? NULL : approximate;
  s.missed = missed;
  report->potential_known = false;
  const double before = start(&s);
  if (!thrum_solve_increment(&s))
    return report->saw_nonfinite ? THRUM_NOT_FINITE : THRUM_NOT_CONVERGED;
  thrum_solve_advance(&s);
  arrive(&s);
  balance(&s, before);
  return THRUM_OK;
}
