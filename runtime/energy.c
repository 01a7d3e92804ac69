/* One energy-conserving step of all modes by a discrete gradient (design 7):
 *
 *   p' = p - h [R-bar + D v - f],  q' = q + h/2 (p + p'),  v = (q' - q)/h,  d = q' - q,
 *
 * with a mean force for which R-bar d = V(q') - V(q), so that 1/2 |p|^2 + V changes by the work of
 * the load less the dissipation at any h; what the solver's tolerance leaves is taken up by a scale
 * of p'. Two mean forces are such ones:
 *
 *   of the ends  R-bar = 1/2 [R(q) + R(q')] + sigma d,
 *                sigma = (V(q') - V(q) - 1/2 [R(q) + R(q')] d)/|d|^2
 *   of the path  R-bar = integral over s in [0, 1] of R(q + s d) = [R(q) + 4 R(q + d/2) + R(q')]/6
 *
 * R(q) is the R(q') of the step before and V(q') comes with R(q'), so the first takes one force an
 * iteration, as Newmark does. The second takes two, but is a gradient in d: solve.c can search
 * along the step's potential, P(d) = h^2/2 [R(q) d + 8 V(q + d/2) + V(q + d)]/6, and always finds a
 * solution. So it is for steps that the first does not solve, for some steps after them, for the
 * rungs of the ladder, and for tangent damping, which takes T at the midpoint.
 * Cost: an iteration takes one force evaluation (the path two) and about 2 r^2, now and then a
 * tangent and r^3. Sources: Gonzalez 1996, Time integration and discrete Hamiltonian systems,
 * doi:10.1007/BF02440162, with the forces of the ends where it has the one of the middle; Quispel &
 * McLaren 2008, A new class of energy-preserving numerical integration methods,
 * doi:10.1088/1751-8113/41/4/045206.
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
#define OWED_MOST 1e-3  /* of the energy, at a standstill */
#define STILL 1e-5      /* 1/what an error of all of V may add to the residual, beside the step */
#define MOVING 100.0    /* times what the forces do in a step: V beyond it is not of the step */
#define CLOSE 1e-7      /* residual beside the step whose correction R(q') and V(q') can follow */

/* point = q + s d */
static void place(const thrum_solver *s, double at, double *point) {
  for (int32_t i = 0; i < s->n; i++)
    point[i] = s->view->q[i] + at * s->view->unknown[i];
}

/* matrix += weight factor T(q + s d) */
static void add_tangent(const thrum_solver *s, double at, double factor, double *matrix) {
  thrum_state_view *view = s->view;
  place(s, at, view->point);
  thrum_tangent_by(view->kernel, s->model, view->point, view->tangent, view->work);
  view->tangents_used = true;
  const size_t count = (size_t)s->n * (size_t)s->n;
  for (size_t a = 0; a < count; a++)
    matrix[a] += s->weight * factor * view->tangent[a];
}

/* --- R-bar of the path ------------------------------------------------------------------------ */

/* R-bar into view->force, R(q') into view->force_2, V(q') into the report; returns P up to a
 * constant. */
static double evaluate_path(const thrum_solver *s) {
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
  s->report->along_step = s->report->along_change = 0.0;
  return s->weight * (along + 8.0 * energies[0] + energies[1]) / 6.0;
}

/* weight (T(q-bar)/3 + T(q')/6), and weight rate beta T(q-bar) for the tangent form of damping. */
static void stiffness_of_path(const thrum_solver *s, double *matrix) {
  memset(matrix, 0, (size_t)s->n * (size_t)s->n * sizeof *matrix);
  add_tangent(s, 0.5, 1.0 / 3.0, matrix);
  add_tangent(s, 1.0, 1.0 / 6.0, matrix);
  if (s->tangent)
    add_tangent(s, 0.5, s->rate * s->state->damping_beta, matrix);
}

/* --- R-bar of the ends ------------------------------------------------------------------------ */

/* view->force = R-bar and view->force_2 = R(q'), from R(q') in view->force and V(q'). */
static void complete(const thrum_solver *s, double potential) {
  thrum_state_view *view = s->view;
  const double *d = view->unknown;
  double along = 0.0, moved = 0.0, square = 0.0, step = 0.0, residual = 0.0;
  for (int32_t i = 0; i < s->n; i++) {
    view->force_2[i] = view->force[i];
    view->force[i] = 0.5 * (view->force_start[i] + view->force_2[i]);
    along += view->force[i] * d[i];
    moved += (fabs(view->force_start[i]) + fabs(view->force_2[i])) * fabs(d[i]);
    square += d[i] * d[i];
    step += d[i] * d[i] * view->scale[i];
    residual += d[i] * d[i] * view->unscale[i];
  }
  // less of sigma where the difference of the energies would be rounding, as in little motion where
  // V is large: that makes a residual of weight rounding/|d|, to be compared with d in the measure
  // of the solve; not where the step is what V is large by
  thrum_solve_report *report = s->report;
  const double still = fabs(potential) + fabs(report->potential_start) - MOVING * moved;
  const double share = STILL * s->weight * fmax(0.0, still) * sqrt(residual / step) / square;
  const double inverse = 1.0 / (square * (1.0 + share * share));
  report->potential = potential;
  report->inverse_square = isfinite(inverse) ? inverse : 0.0;
  const double sigma = (potential - report->potential_start - along) * report->inverse_square;
  for (int32_t i = 0; i < s->n; i++)
    view->force[i] += sigma * d[i];
  report->along_step = sigma;
}

static double evaluate_ends(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  place(s, 1.0, view->point);
  complete(s, thrum_force_by(view->kernel, s->model, view->point, view->force, view->work));
  return 0.0; // R-bar has no potential
}

/* weight (T(q')/2 + sigma) from T(q'); border() has the rest. */
static void weigh_ends(const thrum_solver *s, double *matrix) {
  thrum_solve_weigh(s, matrix);
  const size_t n = (size_t)s->n;
  for (size_t i = 0; i < n; i++)
    matrix[i * n + i] += s->weight * s->report->along_step;
}

static void stiffness_of_ends(const thrum_solver *s, double *matrix) {
  thrum_state_view *view = s->view;
  place(s, 1.0, view->point);
  thrum_tangent_by(view->kernel, s->model, view->point, matrix, view->work);
  weigh_ends(s, matrix);
}

static void both_of_ends(const thrum_solver *s, double *matrix) {
  thrum_state_view *view = s->view;
  place(s, 1.0, view->point);
  complete(s, thrum_force_tangent_by(view->kernel, s->model, view->point, view->force, matrix,
                                     view->work));
  weigh_ends(s, matrix);
}

/* The Jacobian is J0 + weight d grad(sigma)^T with J0 = 1 + weight (T(q')/2 + sigma + rate D): one
 * product with J0^-1 more by Sherman & Morrison. |d|^2 grad(sigma) = 1/2 [R(q') - R(q)] -
 * 1/2 T(q') d - 2 sigma d, and d T x follows from J0 x, as J0 is symmetric. On entry image =
 * J0^-1 residual; then image = J^-1 residual and residual = J0 image. */
static void border(const thrum_solver *s, const thrum_secant *inverse, double *residual,
                   double *image) {
  thrum_state_view *view = s->view;
  const double *d = view->unknown;
  double *bordered = view->bordered;
  thrum_secant_apply(inverse, d, bordered);
  // weight grad(sigma) times image, and times J0^-1 d
  double change = 0.0, own = 0.0;
  for (int32_t i = 0; i < s->n; i++) {
    const double damped = s->rate * thrum_rest_damping(s->model, s->state, i);
    const double risen = 0.5 * s->weight * (view->force_2[i] - view->force_start[i]);
    const double slope = risen + d[i] * (1.0 + s->weight * (damped - s->report->along_step));
    change += slope * image[i] - d[i] * residual[i];
    own += slope * bordered[i] - d[i] * d[i];
  }
  change *= s->report->inverse_square;
  own *= s->report->inverse_square;
  // too much of it is not to be trusted
  const bool used = fabs(own) < 0.5;
  const double along = used ? change / (1.0 + own) : change;
  for (int32_t i = 0; used && i < s->n; i++) {
    image[i] -= along * bordered[i];
    residual[i] -= along * d[i];
  }
  s->report->along_change = -along / s->weight;
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
  thrum_solve_report *report = s->report;
  report->potential_known = report->verified || report->reached <= CLOSE;
  if (report->verified)
    return;
  if (!report->potential_known) {
    report->potential = thrum_energy_by(view->kernel, s->model, view->q_next, view->work);
    return;
  }
  // d was corrected by -direction, and (5) says what that did to R-bar: half of what it did to
  // R(q'), but for what lies along d
  double gained = 0.0;
  for (int32_t i = 0; i < s->n; i++) {
    const double back = view->direction[i];
    const double damped = s->rate * thrum_rest_damping(s->model, s->state, i) * back;
    const double along = report->along_change * view->unknown[i] - report->along_step * back;
    const double change = (back - view->residual[i]) / s->weight + damped - along;
    gained -= back * (view->force_2[i] + change);
    view->force_2[i] += 2.0 * change;
  }
  report->potential += gained;
}

/* Scales p' so that the balance holds; the factor differs from 1 by about the tolerance. With p' =
 * p - h total the kinetic energy changes by -total (d - g), g the residual left, and it should by
 * that of R-bar d less the change of V more. False where there is too little of p' for that, though
 * more than rounding is owed: a loose tolerance at a large step. */
static bool balance(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  double owed = s->report->potential_start - s->report->potential, square = 0.0;
  for (int32_t i = 0; i < s->n; i++) {
    const double left = s->report->verified ? view->residual[i] : 0.0;
    owed += view->force[i] * view->unknown[i] - view->total[i] * left;
    square += view->p_next[i] * view->p_next[i];
  }
  const double share = 2.0 * owed / square;
  // at a standstill no scale helps, and none is needed
  if (!(fabs(share) < SCALED_MOST))
    return !(fabs(owed) > OWED_MOST * (fabs(s->report->potential) + 0.5 * square));
  // the factor less 1, so that a long run is not rounded one way
  const double more = share / (1.0 + sqrt(1.0 + share));
  for (int32_t i = 0; i < s->n; i++)
    view->p_next[i] += more * view->p_next[i];
  return true;
}

static bool solve(const thrum_solver *of_path) {
  if (!of_path->tangent && of_path->state->steps >= of_path->state->path_end) {
    thrum_solver of_ends = *of_path;
    of_ends.evaluate = evaluate_ends;
    of_ends.stiffness = stiffness_of_ends;
    of_ends.both = both_of_ends;
    of_ends.border = border;
    if (thrum_solve_quasi(&of_ends))
      return true;
    of_path->report->path = true;
  }
  return thrum_solve_increment(of_path);
}

thrum_status thrum_step_energy(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, thrum_solve_report *report) {
  thrum_solver s = thrum_solver_of(model, state, view, report, 0);
  s.evaluate = evaluate_path;
  s.stiffness = stiffness_of_path;
  s.both = NULL;
  s.cheaper = 3;
  report->potential_known = false;
  report->potential_start = start(&s);
  if (!solve(&s))
    return report->saw_nonfinite ? THRUM_NOT_FINITE : THRUM_NOT_CONVERGED;
  thrum_solve_advance(&s);
  arrive(&s);
  return balance(&s) ? THRUM_OK : THRUM_NOT_CONVERGED;
}
