/* Quasi-Newton for the increment d of a step (design 5), one evaluation of R at a time.
 *
 * The first guess extrapolates q-bar and R of the past solves in time, as many as are smooth, and
 * corrects the result as if R had been evaluated there: no evaluation is spent on it. Each
 * iteration corrects by the inverse Jacobian that is kept from step to step and learns from it by
 * BFGS (secant.c). A new Jacobian is made where more iterations would be left than are cheaper.
 * Fast motion would need one in every step; then every other step makes one, and the inverse
 * between is extrapolated from the last three, which leaves its third difference. An iteration
 * whose residual is sure to be small enough, by the contraction of the one before and a margin, is
 * not evaluated: the equation then holds for d exactly, and R follows from it.
 *
 * A solve that carries its correction (discrete_gradient_trapezoid.c) ends at an evaluation instead
 * and leaves the correction to its caller. It ends as soon as
 *
 *   |g| (kappa + |g|/D) <= tol D,   D the scaled norm of the increment, or of larger ones lately,
 *
 * where kappa is what the inverse leaves of a residual g: |g - J H g|/|g| as measured by the last
 * iteration, or where a new Jacobian J is made; a first guess may leave ten times as much. Mostly
 * it is that good, and the step takes one evaluation. What such solves leave is small but never
 * corrected, so that it must not pump energy from some modes to others: the inverse does not learn,
 * new Jacobians are planned ahead, and the first guess extrapolates three points, as the errors of
 * more would be amplified by the inverse's own.
 *
 * Cost: an evaluation of R and about n^2 an iteration; a tangent and n^3 for a new Jacobian.
 * Source of the stop without evaluation: Hairer & Wanner, Solving Ordinary Differential Equations
 * II, 1996, section IV.8, doi:10.1007/978-3-642-05221-7.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/solve/quasi_newton.h"

#include <math.h>
#include <string.h>

#include "core/base/lane_sums.h"
#include "core/linear_algebra/dense.h"
#include "core/solve/spurious_work.h"

#define GUESS_POOR 0.2       /* residual of a first guess: the next extrapolates two points only */
#define LINEAR_KNOWN 0.9     /* share of the linear part of R that an older inverse knows */
#define GUESS_QUIET 0.02     /* residual of a first guess: beyond it the Jacobian changes at once */
#define INVERSES_APART 2     /* most steps between two inverses that are extrapolated */
#define CORRECTION_FAR 100.0 /* times its residual, both scaled: the largest one not evaluated */
#define RATE_MOST 4.0        /* h dv/dd up to which an increment may be left unevaluated */
#define CONTRACTION_MARGIN 10.0  /* safety factor on the extrapolated residual */
#define TEACHING_LEAST 1e-12     /* residual over the step: a smaller one is rounding in part */
#define CARRIED_SOLVES 3         /* past solves that a first guess extrapolates, if it carries */
#define CARRIED_RESIDUAL 0.01    /* of the step: no correction of a larger residual is carried, */
#define CARRIED_TOLERANCES 100.0 /* nor of one of more tolerances; the first binds above 1e-4 */
#define SINGLE_TOLERANCES 10.0   /* left by the correction of a first guess, at most */

/* --- first guess ------------------------------------------------------------------------------ */

/* The share of each order in the extrapolation of the past solves, latest first: Newton's divided
 * differences at the time where the solve to come evaluates R, times the distances to it. With
 * steps of one length these are the plain differences. */
typedef struct terms_of_guess {
  double of[THRUM_PAST_SOLVES][THRUM_PAST_SOLVES]; /* order x past solve; unless even */
  bool even;                                       /* all steps are of one length */
} terms_of_guess;

static terms_of_guess find_terms(const thrum_solver *s, int32_t count) {
  const double h = s->state->def.dt;
  double distance[THRUM_PAST_SOLVES], before = 0.0;
  terms_of_guess terms = {.even = true};

  // how far each past solve lies back, and whether all steps had one length
  for (int32_t j = 0; j < count; j++) {
    const double dt = s->state->past_dt[thrum_past_place(s->state->report.steps - 1 - j)];
    distance[j] = s->at * h + before + (1.0 - s->at) * dt;
    before += dt;
    terms.even = terms.even && dt == h;
  }

  // divided differences where they had not
  for (int32_t order = 0; !terms.even && order < count; order++)
    for (int32_t j = 0; j <= order; j++) {
      double share = 1.0;
      for (int32_t m = 0; m < order; m++)
        share *= distance[m];
      for (int32_t m = 0; m <= order; m++)
        share /= m == j ? 1.0 : distance[m] - distance[j];
      terms.of[order][j] = share;
    }
  return terms;
}

/* The sums over the modes that smooth_count compares, for steps of several lengths. */
static void add_uneven(const thrum_solver *s, const double *const past_q[THRUM_PAST_SOLVES],
                       const double *const past_r[THRUM_PAST_SOLVES], int32_t count,
                       const terms_of_guess *terms, double sums[THRUM_PAST_SOLVES]) {
  for (int32_t i = s->first; i < s->state->rank; i++) {
    const double weight = s->view->unscale[i], linear = LINEAR_KNOWN * s->model->omega2[i];
    for (int32_t order = 0; order < count; order++) {
      double term = 0.0;
      for (int32_t j = 0; j <= order; j++)
        term += terms->of[order][j] * (past_r[j][i] - linear * past_q[j][i]);
      sums[order] += term * term * weight;
    }
  }
}

/* The highest order below `count` at which differences still fall, by steps of two below the
 * fourth. */
static int32_t highest_order(const double sums[THRUM_PAST_SOLVES], int32_t count) {
  int32_t order = count - 1;
  while (order > 1 && !(sums[order] < sums[order - 1]))
    order -= order == 4 ? 1 : 2;
  return order > 0 ? order : 0;
}

/* How many of the `count` past solves, latest first, to extrapolate: differences that grow with
 * their order say that the motion is too fast for them. They are those of R without most of its
 * linear part, which the inverse knows and which follows q however fast. */
static int32_t smooth_count(const thrum_solver *s, const double *const past_q[THRUM_PAST_SOLVES],
                            const double *const past_r[THRUM_PAST_SOLVES], int32_t count,
                            const terms_of_guess *terms) {
  double sums[THRUM_PAST_SOLVES] = {0.0};
  if (!terms->even) {
    add_uneven(s, past_q, past_r, count, terms, sums);
    return highest_order(sums, count) + 1;
  }

  // differences of order k take the first k + 1 solves; those beyond `count` are not looked at
  const double *q[THRUM_PAST_SOLVES], *r[THRUM_PAST_SOLVES];
  for (int32_t j = 0; j < THRUM_PAST_SOLVES; j++) {
    q[j] = past_q[j < count ? j : 0];
    r[j] = past_r[j < count ? j : 0];
  }

  for (int32_t i = s->first; i < s->state->rank; i++) {
    const double weight = s->view->unscale[i], linear = LINEAR_KNOWN * s->model->omega2[i];
    const double a = r[0][i] - linear * q[0][i], b = r[1][i] - linear * q[1][i];
    const double c = r[2][i] - linear * q[2][i], d = r[3][i] - linear * q[3][i];
    const double e = r[4][i] - linear * q[4][i];
    const double first = a - b, first_1 = b - c, first_2 = c - d, first_3 = d - e;
    const double second = first - first_1, second_1 = first_1 - first_2;
    const double third = second - second_1, third_1 = second_1 - (first_2 - first_3);
    const double fourth = third - third_1;
    sums[0] += a * a * weight;
    sums[1] += first * first * weight;
    sums[2] += second * second * weight;
    sums[3] += third * third * weight;
    sums[4] += fourth * fourth * weight;
  }

  return highest_order(sums, count) + 1;
}

static double weighted(const double weight[THRUM_PAST_SOLVES],
                       const double *const past[THRUM_PAST_SOLVES], int64_t i) {
  return weight[0] * past[0][i] + weight[1] * past[1][i] + weight[2] * past[2][i] +
         weight[3] * past[3][i] + weight[4] * past[4][i];
}

/* The extrapolated increment into unknown, its expected residual into residual, and that over its
 * scale into direction. */
static void expect(const thrum_solver *s, const double weight[THRUM_PAST_SOLVES],
                   const double *const past_q[THRUM_PAST_SOLVES],
                   const double *const past_r[THRUM_PAST_SOLVES]) {
  const thrum_state_view *view = s->view;
  const double by = 1.0 / s->at, rate = s->rate, of_force = s->weight;
  const double *q = view->q, *drift = view->drift, *kick = view->kick, *load = view->load;
  const double *unscale = view->unscale, *mass = view->mass;
  const double *speed = view->speed, *drag = view->drag;
  double *restrict unknown = view->unknown, *restrict residual = view->residual;
  double *restrict direction = view->direction;
  const int32_t rank = s->state->rank;

  // as thrum_problem_residual, with the extrapolated R
  for (int32_t i = s->first; i < rank; i++) {
    const double d = (weighted(weight, past_q, i) - q[i]) * by;
    const double v = speed[i] * rate * d + drift[i];
    const double damped = drag[i] * (thrum_rest_damping(s->model, s->state, i) * v);
    unknown[i] = d;
    residual[i] =
        mass[i] * (d - kick[i]) + of_force * (weighted(weight, past_r, i) + damped - load[i]);
    direction[i] = residual[i] * unscale[i];
  }
}

static void correct_increment(const thrum_solver *s) {
  const double *direction = s->view->direction;
  double *restrict unknown = s->view->unknown;
  const int32_t rank = s->state->rank;
  for (int32_t i = s->first; i < rank; i++)
    unknown[i] -= direction[i];
}

/* Finds the solves that the first guess extrapolates, and their weights; returns how many they are,
 * 0: there is none to begin with. Entries beyond them repeat the first. */
static int32_t choose_past(const thrum_solver *s, const double *past_q[THRUM_PAST_SOLVES],
                           const double *past_r[THRUM_PAST_SOLVES],
                           double weight[THRUM_PAST_SOLVES]) {
  // extrapolation by one step, exact for polynomials of degree 0 to 4
  static const double even[THRUM_PAST_SOLVES][THRUM_PAST_SOLVES] = {
      {1.0}, {2.0, -1.0}, {3.0, -3.0, 1.0}, {4.0, -6.0, 4.0, -1.0}, {5.0, -10.0, 10.0, -5.0, 1.0}};
  thrum_state_view *view = s->view;
  int32_t count = s->past_count;
  if (s->carries && count > CARRIED_SOLVES)
    count = CARRIED_SOLVES;
  const terms_of_guess terms = find_terms(s, count);
  for (int32_t j = 0; j < count; j++) {
    const int64_t at = thrum_past_at(view, s->state->report.steps - 1 - j);
    past_q[j] = view->past_q + at;
    past_r[j] = view->past_r + at;
  }

  if (count > 0) {
    count = smooth_count(s, past_q, past_r, count, &terms);
    // the step of a part of the modes may be small beside any residual, which then says nothing
    if (count > 2 && s->first == 0 && s->state->guess_last > GUESS_POOR)
      count = 2;
  } else if (s->first > 0) {
    // a restricted polynomial gives R at q_k for little
    for (int32_t i = s->first; i < s->state->rank; i++)
      view->middle[i] = view->q[i];
    s->evaluate(s);
    past_q[count] = view->q;
    past_r[count++] = view->force;
  }

  for (int32_t j = count; count > 0 && j < THRUM_PAST_SOLVES; j++) {
    past_q[j] = past_q[0];
    past_r[j] = past_r[0];
  }

  // the weights of all orders together
  memcpy(weight, even[count > 0 ? count - 1 : 0], sizeof even[0]);
  for (int32_t j = 0; !terms.even && j < count; j++) {
    weight[j] = 0.0;
    for (int32_t order = j; order < count; order++)
      weight[j] += terms.of[order][j];
  }
  return count;
}

/* The first guess: the extrapolated increment, corrected by the inverse for the residual that is
 * expected there. */
static void guess(const thrum_solver *s, const thrum_quasi *quasi) {
  thrum_state_view *view = s->view;
  const double *past_q[THRUM_PAST_SOLVES], *past_r[THRUM_PAST_SOLVES];
  double weight[THRUM_PAST_SOLVES];
  const int32_t count = choose_past(s, past_q, past_r, weight);
  if (count == 0) {
    memset(view->unknown, 0, (size_t)s->state->rank * sizeof *view->unknown);
    return;
  }

  expect(s, weight, past_q, past_r);
  if (quasi->known)
    thrum_secant_apply(&quasi->inverse, view->residual + s->first, view->direction + s->first);
  correct_increment(s);
}

/* --- inverses --------------------------------------------------------------------------------- */

/* The inverse of this step by extrapolation of the last two or three that were factored, into
 * jacobian_next; false where they are not near enough. */
static bool extrapolate(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  const int64_t *made = s->state->inverse_step, now = s->state->report.steps;
  if (made[0] != now - 1 || made[1] < 0 || made[0] - made[1] > INVERSES_APART ||
      !(s->state->guess_last <= GUESS_QUIET))
    return false;

  const int64_t count = (int64_t)s->n * s->n;
  const double *a = view->inverse[0], *b = view->inverse[1], *c = view->inverse[2];
  double *restrict to = view->jacobian_next;
  const double back = (double)(now - made[1]);

  // a line through two
  if (made[2] < 0 || made[1] - made[2] > INVERSES_APART) {
    const double on = 1.0 / (back - 1.0);
    for (int64_t i = 0; i < count; i++)
      to[i] = a[i] + on * (a[i] - b[i]);
    return true;
  }

  // the parabola through three, made 1, `back` and `far` steps ago
  const double far = (double)(now - made[2]);
  const double of_a = back * far / ((back - 1.0) * (far - 1.0));
  const double of_b = -far / ((back - 1.0) * (far - back));
  const double of_c = back / ((far - 1.0) * (far - back));
  for (int64_t i = 0; i < count; i++)
    to[i] = of_a * a[i] + of_b * b[i] + of_c * c[i];
  return true;
}

/* The inverse of the Jacobian in jacobian_next; false where it is singular. */
static bool invert(const thrum_solver *s, thrum_quasi *quasi) {
  s->report->factorisations++;
  if (!thrum_dense_invert(s->view->kernel, s->view->jacobian_next, s->n, s->view->work))
    return false;

  // it has learnt nothing yet
  s->report->refreshed = true;
  s->report->extrapolated = false;
  s->report->learnt = 0;
  quasi->inverse.base = s->view->jacobian_next;
  quasi->inverse.count = 0;
  quasi->known = true;
  return true;
}

/* The inverse of the Jacobian at the increment evaluated last; false where it is singular. */
static bool refresh(const thrum_solver *s, thrum_quasi *quasi) {
  thrum_problem_assemble(s, quasi->assembled);
  return invert(s, quasi);
}

void thrum_quasi_begin(const thrum_solver *s, thrum_quasi *quasi) {
  thrum_state_view *view = s->view;
  memset(quasi, 0, sizeof *quasi);
  quasi->before = INFINITY;
  quasi->known = s->state->jacobian_kept != 0;
  quasi->inverse.by = view->kernel;
  quasi->inverse.base = view->inverse[0];
  quasi->inverse.pairs = view->pairs;
  quasi->inverse.stride = view->stride;
  quasi->inverse.n = s->n;
  s->report->refreshed = false;
  s->report->late_refresh = false;
  s->report->learnt = 0;

  // a new Jacobian at once: there is none, or the last steps needed one late, or it is planned
  const int64_t now = s->state->report.steps;
  quasi->ahead =
      !quasi->known || (s->carries ? now >= s->state->jacobian_due : now < s->state->eager_end);
  s->report->extrapolated = !s->carries && quasi->known && quasi->ahead && extrapolate(s);
  if (s->report->extrapolated) {
    quasi->inverse.base = view->jacobian_next;
    quasi->ahead = false;
  }

  guess(s, quasi);
  thrum_problem_place(s);
}

/* --- iterations ------------------------------------------------------------------------------- */

/* True when the inverse would still need more iterations than are cheaper than a new Jacobian. */
static bool is_slow(const thrum_solver *s, double contraction, double norm, double goal) {
  for (int32_t k = 0; k < s->cheaper; k++)
    norm *= contraction;
  return !(CONTRACTION_MARGIN * norm <= goal);
}

/* The correction of the increment by the inverse, negated, into view->direction; the inverse first
 * learns from the last iteration if it teaches. */
static void find_correction(const thrum_solver *s, thrum_quasi *quasi, bool teaches) {
  thrum_state_view *view = s->view;
  const double *residual = view->residual + s->first;
  double *restrict step = view->direction + s->first, *restrict change = view->trial + s->first;
  double *image = view->image + s->first;
  thrum_secant_apply(&quasi->inverse, residual, image);

  // the secant condition: this step led to this change of the residual
  if (teaches) {
    for (int32_t i = 0; i < s->n; i++) {
      step[i] = -step[i];
      change[i] = residual[i] - change[i];
    }
    thrum_secant_learn(&quasi->inverse, step, change, residual, image);
    s->report->learnt = quasi->inverse.count;
  }
  memcpy(change, residual, (size_t)s->n * sizeof *change);

  // an inverse of past steps has learnt of the border as well; new ones have not
  if (s->border &&
      (s->report->refreshed || s->report->extrapolated || !(s->report->guess <= GUESS_QUIET)))
    s->border(s, &quasi->inverse, quasi->done == 0 || quasi->fresh, change, image);
  memcpy(step, image, (size_t)s->n * sizeof *step);
}

void thrum_quasi_go_on(const thrum_solver *s, thrum_quasi *quasi) {
  correct_increment(s);
  s->report->iterations++;
  quasi->before = quasi->norm;
  quasi->done++;
  thrum_problem_place(s);
}

/* R + D v - f and R as the equation demands them for an increment that is not evaluated. */
static void conclude(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  const double weight = s->weight;
  const double *kick = view->kick, *d = view->unknown, *load = view->load, *v = view->velocity;
  const double *mass = view->mass, *drag = view->drag;
  double *restrict total = view->total, *restrict force = view->force;
  const int32_t rank = s->state->rank;
  for (int32_t i = s->first; i < rank; i++) {
    total[i] = mass[i] * (kick[i] - d[i]) / weight;
    const double damped = drag[i] * (thrum_rest_damping(s->model, s->state, i) * v[i]);
    force[i] = total[i] + load[i] - damped;
  }
}

/* A residual relative to the step, or to rounding if that is more. */
static double relative(const thrum_solver *s, double norm, double step) {
  const double goal = thrum_problem_goal(s, step);
  return goal > 0.0 ? s->tolerance * norm / goal : 0.0;
}

/* True when the residual of the increment just corrected is sure to be small enough. */
static bool is_sure(const thrum_solver *s, double contraction, double norm, double step) {
  // the tangent form knows D only where it was evaluated; and where v is much more than d/h, as for
  // a small beta_N, R + D v - f from the equation would be rounding
  if (s->tangent || !(s->rate * s->state->def.dt <= RATE_MOST) ||
      !(CONTRACTION_MARGIN * contraction * norm <= thrum_problem_goal(s, step)))
    return false;

  // a correction that is large beside the residual meets a soft direction, where the inverse errs
  const double *direction = s->view->direction + s->first;
  return sqrt(thrum_sum_of(s->n, direction, direction, s->view->scale + s->first)) <=
         CORRECTION_FAR * norm;
}

/* --- a solve that carries its correction ------------------------------------------------------ */

/* True when the correction of a residual of this norm leaves little enough. */
static bool may_carry(const thrum_solver *s, const thrum_quasi *quasi, double contraction,
                      double norm, double step) {
  // a standstill needs no more than the motion around it
  const double scale = fmax(step, s->state->step_recent);
  const double allowed = (quasi->done == 0 ? SINGLE_TOLERANCES : 1.0) * s->tolerance;
  const double most = fmin(CARRIED_RESIDUAL, CARRIED_TOLERANCES * s->tolerance);
  const double left = norm * (contraction + norm / scale);
  return (norm <= most * scale && left <= allowed * scale) || norm <= thrum_problem_goal(s, step);
}

/* Makes the Jacobian that is due at the first evaluation, and measures what the inverse that it
 * replaces would have left of the residual. False where it is singular. */
static bool refresh_as_planned(const thrum_solver *s, thrum_quasi *quasi, double norm,
                               bool *compared) {
  thrum_state_view *view = s->view;
  *compared = quasi->known;
  thrum_problem_assemble(s, quasi->assembled);
  quasi->assembled = true;
  if (*compared) {
    double *left = view->image;
    view->kernel->product(s->n, s->n, view->inverse[0], view->residual, view->correction);
    view->kernel->product(s->n, s->n, view->jacobian_next, view->correction, left);
    for (int32_t i = 0; i < s->n; i++)
      left[i] = view->residual[i] - left[i];
    s->report->contraction =
        norm > 0.0 ? sqrt(thrum_sum_of(s->n, left, left, view->unscale)) / norm : 0.0;
  }
  return invert(s, quasi);
}

static thrum_quasi_next take_carrying(const thrum_solver *s, thrum_quasi *quasi) {
  const double norm = thrum_problem_residual(s), step = thrum_problem_norm(s);
  const bool first = quasi->done == 0;
  thrum_solve_report *report = s->report;
  if (!isfinite(norm))
    return THRUM_QUASI_STUCK;
  quasi->norm = norm;
  report->reached = relative(s, norm, step);
  report->step = step;
  if (first)
    report->guess = report->reached;

  // what the inverse leaves of a residual: as remembered, or as the last iteration shows
  double contraction = first ? s->state->contraction : norm / quasi->before;
  if (!first && !quasi->fresh)
    report->contraction = contraction;

  const bool good =
      quasi->known && contraction > 0.0 && may_carry(s, quasi, contraction, norm, step);
  if (!good && (quasi->done == s->state->def.iterations_max ||
                (!first && quasi->fresh && norm > quasi->before)))
    return THRUM_QUASI_STUCK;

  // a new Jacobian, where one is due or the contraction is too slow
  bool compared = false;
  const bool rests = quasi->known && thrum_problem_is_rounding(s, norm);
  const bool planned = quasi->ahead && first && !rests;
  const bool late = !first && !good && is_slow(s, contraction, norm, thrum_problem_goal(s, step));
  quasi->fresh = planned || late;
  report->late_refresh = report->late_refresh || late;
  if ((planned && !refresh_as_planned(s, quasi, norm, &compared)) || (late && !refresh(s, quasi)))
    return THRUM_QUASI_STUCK;
  quasi->assembled = false;

  // it leaves the square of a residual
  find_correction(s, quasi, false);
  if (compared && good)
    thrum_spurious_work_sample(s);
  if (quasi->fresh)
    contraction = 0.0;
  if (good || may_carry(s, quasi, contraction, norm, step)) {
    report->residual = step > 0.0 ? norm * (contraction + norm / step) / step : 0.0;
    report->verified = true;
    return THRUM_QUASI_DONE;
  }
  thrum_quasi_go_on(s, quasi);
  return THRUM_QUASI_EVALUATE;
}

/* --- all solves ------------------------------------------------------------------------------- */

thrum_quasi_next thrum_quasi_take(const thrum_solver *s, thrum_quasi *quasi) {
  if (s->carries)
    return take_carrying(s, quasi);
  const double norm = thrum_problem_residual(s), step = thrum_problem_norm(s);
  const bool second = quasi->done > 0;
  if (!isfinite(norm))
    return THRUM_QUASI_STUCK;
  quasi->norm = norm;
  s->report->reached = relative(s, norm, step);
  if (!second)
    s->report->guess = s->report->reached;

  // converged, or out of iterations, or not even a new Jacobian brings the residual down
  if (thrum_problem_accept(s, norm, step)) {
    s->report->verified = true;
    return THRUM_QUASI_DONE;
  }
  if (quasi->done == s->state->def.iterations_max ||
      (second && quasi->fresh && norm > quasi->before))
    return THRUM_QUASI_STUCK;

  // a new Jacobian, where one was planned or the contraction is too slow
  const double contraction = norm / quasi->before;
  const bool late = second && is_slow(s, contraction, norm, thrum_problem_goal(s, step));
  quasi->fresh = late || (quasi->ahead && !second);
  s->report->late_refresh = s->report->late_refresh || (late && !quasi->ahead);
  if (quasi->fresh && !refresh(s, quasi))
    return THRUM_QUASI_STUCK;
  quasi->assembled = false;

  // the correction
  find_correction(s, quasi, second && !quasi->fresh && quasi->before > TEACHING_LEAST * step);
  thrum_quasi_go_on(s, quasi);
  if (!second || quasi->fresh || !is_sure(s, contraction, norm, step))
    return THRUM_QUASI_EVALUATE;

  // no evaluation is needed any more
  s->report->residual = step > 0.0 ? CONTRACTION_MARGIN * contraction * norm / step : 0.0;
  conclude(s);
  s->report->verified = false;
  return THRUM_QUASI_DONE;
}

void thrum_quasi_evaluate(const thrum_solver *s, thrum_quasi *quasi) {
  quasi->assembled = s->both && quasi->ahead && quasi->done == 0;
  if (quasi->assembled)
    s->both(s, s->view->jacobian_next);
  else
    s->evaluate(s);
}

/* Evaluates and takes until the solve is done; false when it is stuck. */
static bool run_quasi(const thrum_solver *s, thrum_quasi *quasi) {
  thrum_quasi_next next;
  do {
    thrum_quasi_evaluate(s, quasi);
    next = thrum_quasi_take(s, quasi);
  } while (next == THRUM_QUASI_EVALUATE);
  return next == THRUM_QUASI_DONE;
}

bool thrum_quasi_solve(const thrum_solver *s) {
  thrum_quasi quasi;
  thrum_quasi_begin(s, &quasi);
  return run_quasi(s, &quasi);
}
