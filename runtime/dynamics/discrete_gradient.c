/* One energy-conserving step of all modes by a discrete gradient (design 7):
 *
 *   p' = p - h F,  F = R-bar + D v - f,  q' = q + h/2 (p + p'),  v = (q' - q)/h,  d = q' - q,
 *
 * with a mean force R-bar for which R-bar d = V(q') - V(q). So 1/2 |p|^2 + V changes by the work of
 * the load less the dissipation at any h; the rest that the solver's tolerance leaves is taken up
 * by a scale of p'. Two mean forces have that property:
 *
 *   trapezoidal discrete gradient  R-bar = 1/2 [R(q) + R(q')] + sigma d,
 *                  sigma = (V(q') - V(q) - 1/2 [R(q) + R(q')] d)/|d|^2
 *   average vector field           R-bar = integral over s in [0, 1] of R(q + s d)
 *                  = [R(q) + 4 R(q + d/2) + R(q')]/6
 *
 * R(q) is the R(q') of the step before and V(q') comes with R(q'), so the first takes one force an
 * iteration, as Newmark does. The second takes two, but it is a gradient in d: full Newton can
 * search along the step's potential and always finds a solution. So it serves steps that the first
 * does not solve, some steps after them, the fallback levels, and tangent damping, which takes T at
 * the midpoint.
 *
 * With the trapezoidal discrete gradient the known half of F when a step begins, R(q) - f, goes to
 * the kick, and the solve has the other half, as that of Newmark's step has it (share = 1/2; for
 * the average vector field share = 1, E = R-bar):
 *
 *   0 = d - kick + share h^2/2 [E + D v/share - f],  kick = h p - (1 - share) h^2/2 [R(q) - f],
 *   R-bar = (1 - share) R(q) + share E,  E = R(q') + 2 sigma d
 *
 * The first guess then extrapolates only the unknown part.
 * Cost: an iteration takes one force evaluation (the average vector field two) and about 2 r^2, a
 * new Jacobian a tangent and r^3. Sources: Gonzalez 1996, Time integration and discrete Hamiltonian
 * systems, doi:10.1007/BF02440162, with the trapezoidal force in place of the one of the midpoint;
 * Quispel & McLaren 2008, A new class of energy-preserving numerical integration methods,
 * doi:10.1088/1751-8113/41/4/045206.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include "runtime/dynamics/discrete_gradient.h"

#include <math.h>
#include <string.h>

#include "runtime/base/lane_sums.h"
#include "runtime/dynamics/implicit_solve.h"
#include "runtime/polynomial/polynomial_private.h"

#define SCALE_MOST 0.5         /* energy error over kinetic energy: more is a standstill */
#define ERROR_MOST 1e-3        /* energy error at a standstill over the energy: more is a failure */
#define ROUNDING_SHARE 1e-5    /* cancellation threshold: 1e-16 of V over a residual of 1e-11 */
#define WORK_FACTOR 100.0      /* times the work of the forces up to which V belongs to the step */
#define LOSS_LEAST 0x1p-10     /* a smaller loss of sigma is none */
#define RESIDUAL_FOLLOWED 1e-7 /* over the step: R(q') and V(q') can follow its correction */

/* point = q + s d */
static void place(const thrum_solver *s, double at, double *point) {
  for (int32_t i = 0; i < s->n; i++)
    point[i] = s->view->q[i] + at * s->view->unknown[i];
}

/* The share of F that the solve has. */
static double share_of(const thrum_solver *s) {
  return 0.5 / s->at;
}

/* h^2/2 */
static double mean_weight(const thrum_solver *s) {
  return 2.0 * s->at * s->weight;
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

/* --- average vector field --------------------------------------------------------------------- */

/* R-bar into view->force, R(q') into view->force_2, V(q') into the report; returns P up to a
 * constant. */
static double evaluate_average(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  place(s, 0.5, view->point);
  place(s, 1.0, view->point_2);
  const double *const points[2] = {view->point, view->point_2};
  double *const forces[2] = {view->force, view->force_2}, energies[2];
  thrum_internal_forces_by(view->kernel, s->model, points, forces, energies, view->work);

  // Simpson's rule is exact: R is cubic along d
  for (int32_t i = 0; i < s->n; i++)
    view->force[i] = (view->force_start[i] + 4.0 * view->force[i] + view->force_2[i]) / 6.0;
  s->report->potential = energies[1];
  const double along = thrum_sum_of(s->n, view->force_start, view->unknown, NULL);
  return s->weight * (along + 8.0 * energies[0] + energies[1]) / 6.0;
}

/* weight (T(q-bar)/3 + T(q')/6), and weight rate beta T(q-bar) for the tangent form of damping. */
static void stiffness_of_average(const thrum_solver *s, double *matrix) {
  memset(matrix, 0, (size_t)s->n * (size_t)s->n * sizeof *matrix);
  add_tangent(s, 0.5, 1.0 / 3.0, matrix);
  add_tangent(s, 1.0, 1.0 / 6.0, matrix);
  if (s->tangent)
    add_tangent(s, 0.5, s->rate * s->state->def.damping_beta, matrix);
}

/* --- trapezoidal discrete gradient ------------------------------------------------------------ */

/* Share of sigma that is kept where the difference of the energies would be rounding, as in little
 * motion at a large V: rounding makes a residual of h^2/2 rounding/|d|, to be compared with d in
 * the measure of the solve. All of it where V is large by this step. */
static double kept_of_sigma(const thrum_solver *s, double all, double square) {
  const thrum_state_view *view = s->view;
  const double *d = view->unknown;

  // V beyond the work of the forces over d was there before the step
  double moved[2] = {0.0, 0.0};
  for (int32_t i = 0; i < s->n; i++)
    moved[i & 1] += (fabs(view->force_start[i]) + fabs(view->force_2[i])) * fabs(d[i]);
  const double still = all - WORK_FACTOR * (moved[0] + moved[1]);
  if (!(still > 0.0))
    return 1.0;

  // the residual that its rounding makes, over the step
  const double step = thrum_sum_of(s->n, d, d, view->scale);
  const double residual = thrum_sum_of(s->n, d, d, view->unscale);
  const double lost = fmax(
      0.0, ROUNDING_SHARE * mean_weight(s) * still * sqrt(residual / step) / square - LOSS_LEAST);
  return 1.0 / (1.0 + lost * lost);
}

/* sigma into the report, from R(q') in view->force_2 and V(q'). */
static void put_sigma(const thrum_solver *s, double potential) {
  const thrum_state_view *view = s->view;
  thrum_solve_report *report = s->report;
  const double *d = view->unknown;
  const double square = thrum_sum_of(s->n, d, d, NULL);
  const double along = 0.5 * thrum_sum_both(s->n, view->force_start, view->force_2, d);
  double inverse = 1.0 / square;

  // mostly it is clear that nothing of sigma is lost, without a look at the modes: in the first
  // bound residual <= step, as scale >= 1; the second is one on the work of the forces
  const double all = fabs(potential) + fabs(report->potential_start);
  if (!(ROUNDING_SHARE * mean_weight(s) * all <= LOSS_LEAST * square ||
        all <= WORK_FACTOR * fabs(along)))
    inverse *= kept_of_sigma(s, all, square);

  report->potential = potential;
  report->inverse_square = isfinite(inverse) ? inverse : 0.0;
  report->along_step = (potential - report->potential_start - along) * report->inverse_square;
}

static double evaluate_discrete(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  put_sigma(
      s, thrum_internal_force_by(view->kernel, s->model, view->middle, view->force_2, view->work));
  return 0.0; // R-bar has no potential
}

/* h^2/2 (T(q')/2 + sigma) from T(q'); border() has the rest. */
static void weigh_discrete(const thrum_solver *s, double *matrix) {
  thrum_problem_weigh(s, matrix);
  const size_t n = (size_t)s->n;
  const double along = mean_weight(s) * s->report->along_step;
  for (size_t i = 0; i < n; i++)
    matrix[i * n + i] += along;
}

static void stiffness_of_discrete(const thrum_solver *s, double *matrix) {
  thrum_state_view *view = s->view;
  thrum_tangent_stiffness_by(view->kernel, s->model, view->middle, matrix, view->work);
  weigh_discrete(s, matrix);
}

static void both_of_discrete(const thrum_solver *s, double *matrix) {
  thrum_state_view *view = s->view;
  put_sigma(s, thrum_internal_force_tangent_by(view->kernel, s->model, view->middle, view->force_2,
                                               matrix, view->work));
  weigh_discrete(s, matrix);
}

/* |d|^2 grad(sigma) = 1/2 [R(q') - R(q)] - 1/2 T(q') d - 2 sigma d, and d T x follows from J0 x, as
 * J0 is symmetric: with the residual g
 *   h^2/2 |d|^2 grad(sigma) = slope - J0 d,
 *   slope = g + h p - h^2/2 [R(q) - f] - h^2 sigma d */
static void put_slope(const thrum_solver *s, const double *residual) {
  const thrum_state_view *view = s->view;
  double *slope = view->slope;
  const double known = mean_weight(s) * (1.0 - share_of(s));
  const double twice = 2.0 * mean_weight(s) * s->report->along_step;
  for (int32_t i = 0; i < s->n; i++)
    slope[i] = residual[i] + view->kick[i] - known * (view->force_start[i] - view->load[i]) -
               twice * view->unknown[i];
}

/* h^2/2 grad(sigma) x from the slope, x and image = J0 x. */
static double gradient_along(const thrum_solver *s, const double *x, const double *image) {
  return (thrum_sum_of(s->n, s->view->slope, x, NULL) -
          thrum_sum_of(s->n, s->view->unknown, image, NULL)) *
         s->report->inverse_square;
}

/* The Jacobian is J0 + h^2/2 d grad(sigma)^T with J0 = 1 + h^2/2 (T(q')/2 + sigma) + h/2 D: by
 * Sherman & Morrison one more product with J0^-1, in the first correction with this J0; later ones
 * take the same. On entry image = J0^-1 residual; then image = J^-1 residual and residual = J0
 * image. */
static void border(const thrum_solver *s, const thrum_secant *inverse, bool first, double *residual,
                   double *image) {
  thrum_state_view *view = s->view;
  thrum_solve_report *report = s->report;
  const double *d = view->unknown;
  double *bordered = view->bordered;
  put_slope(s, residual);
  if (first) {
    thrum_secant_apply(inverse, d, bordered);
    report->bordered = gradient_along(s, bordered, d);
  }

  // near -1 the quotient is singular: without the border the iteration is slower, but safe
  if (!(fabs(report->bordered) < 0.5))
    return;
  const double by = gradient_along(s, image, residual) / (1.0 + report->bordered);
  for (int32_t i = 0; i < s->n; i++) {
    image[i] -= by * bordered[i];
    residual[i] -= by * d[i];
  }
}

/* --- the step --------------------------------------------------------------------------------- */

/* R(q) into view->force_start; returns V(q). */
static double start(const thrum_model *model, const thrum_state *state, thrum_state_view *view) {
  if (state->potential_step != state->report.steps)
    return thrum_internal_force_by(view->kernel, model, view->q, view->force_start, view->work);
  memcpy(view->force_start, view->force_now, (size_t)state->rank * sizeof *view->force_start);
  return state->potential;
}

/* R(q') and V(q') of an increment that was corrected and not evaluated again, to first order: it
 * was corrected by -direction, and trial is J0 direction (or less, of what the inverse has learnt
 * of grad(sigma) itself). */
static void follow_correction(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  thrum_solve_report *report = s->report;
  const double share = share_of(s), inverse = 1.0 / s->weight;
  const double *back = view->direction;
  const double before = thrum_sum_of(s->n, back, view->force_2, NULL);

  // the change of sigma
  double along_change = 0.0;
  if (report->along_step != 0.0) {
    if (!report->refreshed)
      put_slope(s, view->residual);
    along_change = -gradient_along(s, back, view->trial) / mean_weight(s);
  }

  // the equation says what the correction did to E, and share times that to R-bar: half of the
  // change of R(q'), but for the part along d
  for (int32_t i = 0; i < s->n; i++) {
    const double damped = s->rate * thrum_rest_damping(s->model, s->state, i) * back[i];
    const double change = share * ((back[i] - view->residual[i]) * inverse + damped);
    view->force_2[i] +=
        2.0 * (change - along_change * view->unknown[i] + report->along_step * back[i]);
  }

  // V changes by the mean of R over the correction
  const double after = thrum_sum_of(s->n, back, view->force_2, NULL);
  report->potential -= 0.5 * (before + after);
}

/* R(q') and V(q') at the end of the step, and E where that was evaluated there. */
static void arrive(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  thrum_solve_report *report = s->report;
  report->potential_known = report->verified || report->reached <= RESIDUAL_FOLLOWED;
  if (report->verified) {
    const double twice = 2.0 * report->along_step;
    for (int32_t i = 0; report->discrete && i < s->n; i++)
      view->force[i] = view->force_2[i] + twice * view->unknown[i];
    return;
  }

  // a correction too large to be followed costs an evaluation of V
  if (report->potential_known)
    follow_correction(s);
  else
    report->potential = thrum_strain_energy_by(view->kernel, s->model, view->q_next, view->work);
}

/* q' and p' from d: p - h F is 2 (d - g)/h - p with the residual g, and there the forces of stiff
 * modes do not cancel. */
static void advance(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double twice = 2.0 / s->state->def.dt;
  for (int32_t i = 0; i < s->n; i++) {
    const double left = s->report->verified ? view->residual[i] : 0.0;
    view->q_next[i] = view->q[i] + view->unknown[i];
    view->p_next[i] = twice * (view->unknown[i] - left) - view->p[i];
  }
  s->report->solved = true;
}

/* The error that the balance of this step is left with. With p' = p - h F the kinetic energy
 * changes by -F (d - g), g the residual left; it should change by R-bar d less the change of V
 * more. */
static double energy_error_of(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  const double share = share_of(s), *d = view->unknown;
  double error = s->report->potential_start - s->report->potential +
                 (1.0 - share) * thrum_sum_of(s->n, view->force_start, d, NULL) +
                 share * thrum_sum_of(s->n, view->force, d, NULL);
  if (s->report->verified)
    error -= thrum_sum_less(s->n, view->p, view->p_next, view->residual) / s->state->def.dt;
  return error;
}

/* Scales p' so that the balance holds; the factor differs from 1 by about the tolerance. False
 * where p' has too little energy for that, and the error is more than rounding: a loose tolerance
 * at a large step. */
static bool balance(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  const double energy_error = energy_error_of(s);
  const double square = thrum_sum_of(s->n, view->p_next, view->p_next, NULL);
  const double share = 2.0 * energy_error / square;

  // at a standstill no scale helps, and none is needed
  if (!(fabs(share) < SCALE_MOST))
    return !(fabs(energy_error) > ERROR_MOST * (fabs(s->report->potential) + 0.5 * square));

  // the factor less 1, so that a long run is not rounded one way; mostly two terms of it are exact
  const double more =
      fabs(share) < 1e-8 ? 0.5 * share - 0.125 * share * share : share / (1.0 + sqrt(1.0 + share));
  for (int32_t i = 0; i < s->n; i++)
    view->p_next[i] += more * view->p_next[i];
  return true;
}

/* The problem in which the solve has this share of F. */
static thrum_solver problem_of(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, thrum_solve_report *report, double share) {
  const double h = state->def.dt, known = 0.5 * h * h * (1.0 - share);
  thrum_solver s = thrum_problem_make(model, state, view, report, 0, 0.5 / share,
                                      0.5 * share * h * h, 1.0 / (share * h));
  for (int32_t i = 0; i < s.n; i++)
    view->kick[i] = h * view->p[i] - known * (view->force_start[i] - view->load[i]);

  // past solves of the other mean force do not continue this one
  report->discrete = share < 1.0;
  if (state->past_discrete != report->discrete)
    s.past_count = 0;
  return s;
}

static thrum_status finish(const thrum_solver *s) {
  advance(s);
  arrive(s);
  return balance(s) ? THRUM_OK : THRUM_NOT_CONVERGED;
}

thrum_status thrum_step_energy(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, thrum_solve_report *report) {
  report->potential_known = false;
  report->potential_start = start(model, state, view);

  // the cheaper mean force first; it has no potential, so full Newton could not search along it
  thrum_solver s;
  if (!thrum_tangent_damped(state) && state->report.steps >= state->average_field_end) {
    s = problem_of(model, state, view, report, 0.5);
    s.evaluate = evaluate_discrete;
    s.evaluated = view->force_2;
    s.stiffness = stiffness_of_discrete;
    s.both = both_of_discrete;
    s.border = border;
    if (thrum_solve_by_def(&s))
      return finish(&s);
    report->discrete_failed = true;
  }

  s = problem_of(model, state, view, report, 1.0);
  s.evaluate = evaluate_average;
  s.stiffness = stiffness_of_average;
  s.both = NULL;
  if (!thrum_solve_increment(&s))
    return report->saw_nonfinite ? THRUM_NOT_FINITE : THRUM_NOT_CONVERGED;
  return finish(&s);
}
