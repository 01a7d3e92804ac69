/* The step of the trapezoidal discrete gradient (design 7; discrete_gradient.c), and how it ends
 * with one force evaluation:
 *
 *   R-bar = 1/2 [R(q) + R(q')] + sigma d,
 *   sigma = (V(q') - V(q) - 1/2 [R(q) + R(q')] d)/|d|^2
 *
 * The solve ends at an increment d that was evaluated. What the inverse says is still missing, the
 * correction c = -J^-1 g for the residual g, is not applied to q' but carried to the next step:
 *
 *   end of the step        q' = q + d, with R(q') and V(q') as evaluated
 *   start of the next one  x' = q' + c, p'' = 2 L^-1 (d + c)/h - p, R'' by the equation,
 *                          V'' = V(q') + 1/2 [R(q') + R''] c
 *   momentum at q'         p' = p'' scaled to 1/2 |p'|^2 = 1/2 |p''|^2 + V'' - V(q') - f c
 *
 * (q and V(q) above are those of the start that the step before has left in the same way.) So the
 * energy of q' and p' is exact with nothing evaluated twice, while the motion goes on with the
 * error of a corrected increment. Near a standstill, where p' would have to be scaled by much, the
 * correction is evaluated after all.
 * Cost: a force evaluation and about 3 r^2 an iteration, a tangent and r^3 a new Jacobian.
 * Source of the mean force: Gonzalez 1996, doi:10.1007/BF02440162, with the trapezoidal force in
 * place of the one of the midpoint.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "core/base/lane_sums.h"
#include "core/polynomial/polynomial_private.h"
#include "core/schemes/discrete_gradient_private.h"
#include "core/solve/newton.h"

#define ROUNDING_SHARE 1e-5 /* cancellation threshold: 1e-16 of V over a residual of 1e-11 */
#define WORK_FACTOR 100.0   /* times the work of the forces up to which V belongs to the step */
#define LOSS_LEAST 0x1p-10  /* a smaller loss of sigma is none */
#define CARRIED_MOST                                                                               \
  0.02                    /* energy that p' is scaled by for a carried correction, over |p'|^2/2   \
                           */
#define CHEAPER_CARRIED 3 /* iterations that cost less than a Jacobian ahead of its time */
#define ENERGY_ROUNDING 0x1p-46 /* energy missing at a standstill, of all, that is rounding */
#define MISSING_MOST 1e-9       /* of all: more is a failure */
#define RESIDUAL_ROUNDING 1e-12 /* of the step: no correction makes it smaller */

/* --- the mean force --------------------------------------------------------------------------- */

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
  const double lost =
      fmax(0.0, ROUNDING_SHARE * thrum_mean_weight(s) * still * sqrt(residual / step) / square -
                    LOSS_LEAST);
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
  if (!(ROUNDING_SHARE * thrum_mean_weight(s) * all <= LOSS_LEAST * square ||
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
  const double along = thrum_mean_weight(s) * s->report->along_step;
  for (size_t i = 0; i < n; i++)
    matrix[i * n + i] += along;
}

static void stiffness_of_discrete(const thrum_solver *s, double *matrix) {
  thrum_state_view *view = s->view;
  thrum_tangent_stiffness_near(view->kernel, s->model, 0.5 * thrum_mean_weight(s), view->middle,
                               matrix, view->work);
  weigh_discrete(s, matrix);
}

static void both_of_discrete(const thrum_solver *s, double *matrix) {
  thrum_state_view *view = s->view;
  put_sigma(s, thrum_internal_force_tangent_near(view->kernel, s->model, 0.5 * thrum_mean_weight(s),
                                                 view->middle, view->force_2, matrix, view->work));
  weigh_discrete(s, matrix);
}

/* |d|^2 grad(sigma) = 1/2 [R(q') - R(q)] - 1/2 T(q') d - 2 sigma d, and d T x follows from J0 x, as
 * J0 is symmetric: with the residual g
 *   h^2/2 |d|^2 grad(sigma) = slope - J0 d,
 *   slope = g + mu h L p - h^2/2 [R(q) - f] - h^2 sigma d */
static void put_slope(const thrum_solver *s, const double *residual) {
  const thrum_state_view *view = s->view;
  double *slope = view->slope;
  const double known = thrum_mean_weight(s) * (1.0 - thrum_share_of(s));
  const double twice = 2.0 * thrum_mean_weight(s) * s->report->along_step;
  for (int32_t i = 0; i < s->n; i++)
    slope[i] = residual[i] + view->mass[i] * view->kick[i] -
               known * (view->force_start[i] - view->load[i]) - twice * view->unknown[i];
}

/* h^2/2 grad(sigma) x from the slope, x and image = J0 x. */
static double gradient_along(const thrum_solver *s, const double *x, const double *image) {
  return (thrum_sum_of(s->n, s->view->slope, x, NULL) -
          thrum_sum_of(s->n, s->view->unknown, image, NULL)) *
         s->report->inverse_square;
}

/* The Jacobian is J0 + h^2/2 d grad(sigma)^T with J0 = mu + h^2/2 (T(q')/2 + sigma) + h/2 N D N: by
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

/* --- the end of the step ---------------------------------------------------------------------- */

/* R'' and V'' of the corrected increment, to first order, into view->force_2 and the report: the
 * correction is -direction, and trial is J0 direction (or less, of what the inverse has learnt of
 * grad(sigma) itself). */
static void follow_correction(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  thrum_solve_report *report = s->report;
  const double share = thrum_share_of(s), inverse = 1.0 / s->weight, sigma = report->along_step;
  const double *back = view->direction, *residual = view->residual, *d = view->unknown;
  const double *mass = view->mass;
  const double before = thrum_sum_of(s->n, back, view->force_2, NULL);

  // the change of sigma
  double sigma_change = 0.0;
  if (sigma != 0.0) {
    put_slope(s, residual);
    sigma_change = -gradient_along(s, back, view->trial) / thrum_mean_weight(s);
  }

  // the equation says what the correction does to E, and share times that to R-bar: half of the
  // change of R(q'), but for the part along d
  double *restrict force = view->force_2;
  for (int32_t i = 0; i < s->n; i++) {
    const double damped = thrum_solved_damping(s, i) * back[i];
    const double change = share * ((mass[i] * back[i] - residual[i]) * inverse + damped);
    force[i] += 2.0 * (change - sigma_change * d[i] + sigma * back[i]);
  }

  // V changes by the mean of R over the correction
  const double after = thrum_sum_of(s->n, back, force, NULL);
  report->potential_corrected = report->potential - 0.5 * (before + after);
}

/* The end of the step, the start of the next one, and E there, from which the next first guess
 * extrapolates. */
static void advance(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double twice = 2.0 / s->state->def.dt, inverse = 1.0 / s->weight;
  const double *q = view->q, *p = view->p, *d = view->unknown, *back = view->direction;
  const double *kick = view->kick, *load = view->load, *mass = view->mass;
  const double *unstretch = view->unstretch;
  double *restrict q_next = view->q_next;
  double *restrict q_start = view->q_corrected_next, *restrict p_start = view->p_corrected_next;
  double *restrict past = view->middle, *restrict force = view->force;

  // all of the increment but the correction is in the step that is shown
  for (int32_t i = 0; i < s->n; i++) {
    const double all = d[i] - back[i];
    q_next[i] = q[i] + d[i];
    past[i] = q_start[i] = q[i] + all;
    p_start[i] = twice * all * unstretch[i] - p[i];
    force[i] = mass[i] * (kick[i] - all) * inverse + load[i] - thrum_solved_damping(s, i) * all;
  }
}

/* Scales the momenta so that the energy at q' is that of `from` plus the work of the load less the
 * dissipation, and the energy where the next step starts differs from it by the work of the load on
 * the way there. Returns the energy that is missing near a standstill, over all energies; 0: none.
 */
static double balance(const thrum_solver *s, const thrum_step_start *from) {
  thrum_state_view *view = s->view;
  const thrum_solve_report *report = s->report;
  const double *load = view->load, *p = from->p, *p_end = view->p_corrected_next;
  double work = 0.0, dissipated = 0.0, kinetic = 0.0, square = 0.0;
  for (int32_t i = 0; i < s->n; i++) {
    const double d = view->q_next[i] - from->q[i];
    work += load[i] * d;
    dissipated +=
        thrum_rest_damping(s->model, s->state, i) * (view->speed[i] * d * (view->speed[i] * d));
    kinetic += (p[i] - p_end[i]) * (p[i] + p_end[i]);
    square += p[i] * p[i];
  }
  const double gained = work + 0.5 * kinetic - dissipated / s->state->def.dt;

  // both from the momentum as the equation has it
  const double error = from->potential - report->potential + gained;
  const double error_start = from->potential - report->potential_corrected + gained -
                             thrum_sum_of(s->n, load, view->direction, NULL);
  const bool end = thrum_momentum_take(s, error, CARRIED_MOST, p_end, view->p_next);
  const bool start =
      thrum_momentum_take(s, error_start, CARRIED_MOST, p_end, view->p_corrected_next);

  const double all = fabs(from->potential) + fabs(report->potential) + square + fabs(work);
  const double missing = fmax(end ? 0.0 : fabs(error), start ? 0.0 : fabs(error_start));
  return missing <= ENERGY_ROUNDING * all ? 0.0 : missing / all;
}

/* The end of the step; returns what balance() does. */
static double end_step(const thrum_solver *s, const thrum_step_start *from) {
  follow_correction(s);
  advance(s);
  s->report->potential_known = s->report->solved = s->report->carries = true;
  return balance(s, from);
}

/* The step with the thesis' solver, which keeps nothing and so has no correction to carry. */
static bool step_by_newton(const thrum_solver *s, const thrum_step_start *from) {
  if (!thrum_newton_solve(s))
    return false;
  const size_t vector = (size_t)s->n * sizeof(double);
  memset(s->view->direction, 0, vector);
  memset(s->view->trial, 0, vector);
  memset(s->view->residual, 0, vector);
  return end_step(s, from) <= MISSING_MOST;
}

void thrum_trapezoid_prepare(thrum_solver *s) {
  s->evaluate = evaluate_discrete;
  s->evaluated = s->view->force_2;
  s->stiffness = stiffness_of_discrete;
  s->both = both_of_discrete;
  s->accept = put_sigma;
  s->weigh = weigh_discrete;
  s->border = border;
  s->carries = true;
  s->cheaper = CHEAPER_CARRIED;
}

thrum_quasi_next thrum_trapezoid_take(const thrum_solver *s, const thrum_step_start *from,
                                      thrum_quasi *quasi) {
  const thrum_quasi_next next = thrum_quasi_take(s, quasi);
  if (next != THRUM_QUASI_DONE)
    return next;

  // near a standstill the correction is evaluated, as long as there is one
  const double missing = end_step(s, from);
  if (missing == 0.0)
    return THRUM_QUASI_DONE;
  if (quasi->done >= s->state->def.iterations_max || thrum_problem_is_rounding(s, quasi->norm) ||
      !(s->report->reached > RESIDUAL_ROUNDING))
    return missing <= MISSING_MOST ? THRUM_QUASI_DONE : THRUM_QUASI_STUCK;
  thrum_quasi_go_on(s, quasi);
  return THRUM_QUASI_EVALUATE;
}

bool thrum_trapezoid_solve(const thrum_solver *s, const thrum_step_start *from) {
  if (s->state->def.solver == THRUM_SOLVER_NEWTON)
    return step_by_newton(s, from);
  thrum_quasi quasi;
  thrum_quasi_next next;
  thrum_quasi_begin(s, &quasi);
  do {
    thrum_quasi_evaluate(s, &quasi);
    next = thrum_trapezoid_take(s, from, &quasi);
  } while (next == THRUM_QUASI_EVALUATE);
  return next == THRUM_QUASI_DONE;
}
