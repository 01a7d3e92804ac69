/* Quasi-Newton for the increment d of a step (design 5), one evaluation of R at a time.
 *
 * The first guess extrapolates q-bar and R of the steps before, as many as are smooth, and corrects
 * it as if R had been evaluated there: no evaluation is spent on it. Each iteration corrects by the
 * inverse Jacobian kept from the steps before, which learns from it (secant.c). The Jacobian is
 * made anew only where more iterations would be left than are cheaper; and while the motion is so
 * fast that it would be in every step, in every other one: between them the inverse is extrapolated
 * from the last three, which leaves its third difference. An iteration whose residual is sure to be
 * small enough, by the contraction of the one before and a margin, is not evaluated: (5) then holds
 * for d exactly, R is what it says. Cost: an evaluation of R and about n^2 an iteration; a tangent
 * and n^3 where the Jacobian is anew. Source of the stop without evaluation:
 * Hairer & Wanner, Solving Ordinary Differential Equations II, 1996, section IV.8,
 * doi:10.1007/978-3-642-05221-7.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "runtime/base/lane_sums.h"
#include "runtime/dynamics/implicit_solve.h"
#include "runtime/linear_algebra/dense.h"

#define POOR 0.2      /* residual of a first guess: the next takes no more than two points */
#define KNOWN 0.9     /* of the linear part of R, by an inverse that is not of this step */
#define QUIET 0.02    /* residual of a first guess: beyond it the Jacobian may change at once */
#define APART 2       /* steps between two inverses from which the next is extrapolated, at most */
#define FAR 100.0     /* times its residual, both scaled: the largest correction left unevaluated */
#define RATE_MOST 4.0 /* h/d v with which an increment may be left unevaluated */
#define MARGIN                                                                                     \
  10.0 /* of an expected residual: the contraction of one iteration is not the next's */

/* Residuals this small beside the step are rounding in part, and teach nothing. */
#define TEACHING 1e-12

/* Scaled norm of the residual that ends a solve: tolerance times the step, or rounding beside the
 * motion seen so far. */
static double goal(const thrum_solver *s, double step) {
  return s->state->tolerance * step + THRUM_ROUNDING_FLOOR * s->state->amplitude;
}

/* --- first guess ------------------------------------------------------------------------------ */

/* How many of the `count` steps before, latest first, are worth extrapolating: higher differences
 * that grow say that the motion is too fast for them. Of R, but with little of its linear part:
 * what H knows of R follows q, however fast. */
static int32_t smooth(const thrum_solver *s, const double *const past_q[THRUM_PAST],
                      const double *const past_r[THRUM_PAST], int32_t count) {
  double sums[THRUM_PAST] = {0.0};
  // differences of order k take the first k + 1 steps; what lies beyond `count` is not looked at
  const double *q[THRUM_PAST], *r[THRUM_PAST];
  for (int32_t j = 0; j < THRUM_PAST; j++) {
    q[j] = past_q[j < count ? j : 0];
    r[j] = past_r[j < count ? j : 0];
  }
  for (int32_t i = s->first; i < s->state->rank; i++) {
    const double weight = s->view->unscale[i], linear = KNOWN * s->model->omega2[i];
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
  int32_t order = count - 1;
  while (order > 1 && !(sums[order] < sums[order - 1]))
    order -= order == 4 ? 1 : 2;
  return (order > 0 ? order : 0) + 1;
}

static double weighted(const double weight[THRUM_PAST], const double *const past[THRUM_PAST],
                       int64_t i) {
  return weight[0] * past[0][i] + weight[1] * past[1][i] + weight[2] * past[2][i] +
         weight[3] * past[3][i] + weight[4] * past[4][i];
}

/* d~ into unknown, g~ into residual, and over its scale into direction. */
static void expect(const thrum_solver *s, const double weight[THRUM_PAST],
                   const double *const past_q[THRUM_PAST], const double *const past_r[THRUM_PAST]) {
  const thrum_state_view *view = s->view;
  const double by = 1.0 / s->at, rate = s->rate, of_force = s->weight;
  const double *q = view->q, *drift = view->drift, *kick = view->kick, *load = view->load;
  const double *unscale = view->unscale;
  double *restrict unknown = view->unknown, *restrict residual = view->residual;
  double *restrict direction = view->direction;
  const int32_t rank = s->state->rank;
  for (int32_t i = s->first; i < rank; i++) {
    const double d = (weighted(weight, past_q, i) - q[i]) * by;
    const double damped = thrum_rest_damping(s->model, s->state, i) * (rate * d + drift[i]);
    unknown[i] = d;
    residual[i] = d - kick[i] + of_force * (weighted(weight, past_r, i) + damped - load[i]);
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

/* unknown = d~ - H g~, where d~ is the increment that leads to the middle expected, and g~ its
 * residual with the R expected there. */
static void guess(const thrum_solver *s, const thrum_quasi *quasi) {
  static const double weights[THRUM_PAST][THRUM_PAST] = {
      {1.0}, {2.0, -1.0}, {3.0, -3.0, 1.0}, {4.0, -6.0, 4.0, -1.0}, {5.0, -10.0, 10.0, -5.0, 1.0}};
  thrum_state_view *view = s->view;
  const double *past_q[THRUM_PAST], *past_r[THRUM_PAST];
  int32_t count = s->past_count;
  for (int32_t j = 0; j < count; j++) {
    const int64_t at = thrum_past_at(view, s->state->steps - 1 - j);
    past_q[j] = view->past_q + at;
    past_r[j] = view->past_r + at;
  }
  if (count > 0) {
    count = smooth(s, past_q, past_r, count);
    // a step of the implicit modes alone may be small beside any residual
    if (count > 2 && s->first == 0 && s->state->guess_last > POOR)
      count = 2;
  } else if (s->first > 0) {
    // what is restricted has R at q_k for little
    for (int32_t i = s->first; i < s->state->rank; i++)
      view->middle[i] = view->q[i];
    s->evaluate(s);
    past_q[count] = view->q;
    past_r[count++] = view->force;
  } else {
    memset(view->unknown, 0, (size_t)s->state->rank * sizeof *view->unknown);
    return;
  }
  for (int32_t j = count; j < THRUM_PAST; j++) {
    past_q[j] = past_q[0];
    past_r[j] = past_r[0];
  }
  expect(s, weights[count - 1], past_q, past_r);
  if (quasi->known)
    thrum_secant_apply(&quasi->inverse, view->residual + s->first, view->direction + s->first);
  correct_increment(s);
}

/* --- iterations ------------------------------------------------------------------------------- */

/* H by extrapolation of the last inverses that were made anew, three or two, into jacobian_next;
 * false where they are not near enough. */
static bool extrapolate(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  const int64_t *made = s->state->inverse_step, now = s->state->steps;
  if (made[0] != now - 1 || made[1] < 0 || made[0] - made[1] > APART ||
      !(s->state->guess_last <= QUIET))
    return false;
  const int64_t count = (int64_t)s->n * s->n;
  const double *a = view->inverse[0], *b = view->inverse[1], *c = view->inverse[2];
  double *restrict to = view->jacobian_next;
  const double back = (double)(now - made[1]);
  if (made[2] < 0 || made[1] - made[2] > APART) {
    const double on = 1.0 / (back - 1.0);
    for (int64_t i = 0; i < count; i++)
      to[i] = a[i] + on * (a[i] - b[i]);
    return true;
  }
  const double far = (double)(now - made[2]);
  const double of_a = back * far / ((back - 1.0) * (far - 1.0));
  const double of_b = -far / ((back - 1.0) * (far - back));
  const double of_c = back / ((far - 1.0) * (far - back));
  for (int64_t i = 0; i < count; i++)
    to[i] = of_a * a[i] + of_b * b[i] + of_c * c[i];
  return true;
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
  quasi->ahead = !quasi->known || s->state->steps < s->state->eager_end;
  s->report->refreshed = false;
  s->report->slow = false;
  s->report->learnt = 0;
  s->report->extrapolated = quasi->known && quasi->ahead && extrapolate(s);
  if (s->report->extrapolated) {
    quasi->inverse.base = view->jacobian_next;
    quasi->ahead = false;
  }
  guess(s, quasi);
  thrum_solve_place(s);
}

/* Would the inverse as it is need many more iterations? */
static bool slow(const thrum_solver *s, double contraction, double norm, double wanted) {
  for (int32_t k = 0; k < s->cheaper; k++)
    norm *= contraction;
  return !(MARGIN * norm <= wanted);
}

/* H of the Jacobian at the increment evaluated last. */
static bool refresh(const thrum_solver *s, thrum_quasi *quasi) {
  thrum_solve_assemble(s, quasi->assembled);
  s->report->factorisations++;
  if (!thrum_dense_invert(s->view->kernel, s->view->jacobian_next, s->n, s->view->work))
    return false;
  s->report->refreshed = true;
  s->report->extrapolated = false;
  s->report->learnt = 0;
  quasi->inverse.base = s->view->jacobian_next;
  quasi->inverse.count = 0;
  quasi->known = true;
  return true;
}

/* direction = H residual, with an H that knows what the last iteration did. */
static void correct(const thrum_solver *s, thrum_quasi *quasi, bool teaches) {
  thrum_state_view *view = s->view;
  const double *residual = view->residual + s->first;
  double *restrict step = view->direction + s->first, *restrict change = view->trial + s->first;
  double *image = view->image + s->first;
  thrum_secant_apply(&quasi->inverse, residual, image);
  if (teaches) {
    for (int32_t i = 0; i < s->n; i++) {
      step[i] = -step[i];
      change[i] = residual[i] - change[i];
    }
    thrum_secant_learn(&quasi->inverse, step, change, residual, image);
    s->report->learnt = quasi->inverse.count;
  }
  memcpy(change, residual, (size_t)s->n * sizeof *change);
  // an inverse of steps before has learnt of the rest as well, those made anew have not
  if (s->border &&
      (s->report->refreshed || s->report->extrapolated || !(s->report->guess <= QUIET)))
    s->border(s, &quasi->inverse, quasi->done == 0 || quasi->fresh, change, image);
  memcpy(step, image, (size_t)s->n * sizeof *step);
  correct_increment(s);
  s->report->iterations++;
}

/* R + D v - f and R as the equation has them for d. */
static void conclude(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  const double weight = s->weight;
  const double *kick = view->kick, *d = view->unknown, *load = view->load, *v = view->velocity;
  double *restrict total = view->total, *restrict force = view->force;
  const int32_t rank = s->state->rank;
  for (int32_t i = s->first; i < rank; i++) {
    total[i] = (kick[i] - d[i]) / weight;
    force[i] = total[i] + load[i] - thrum_rest_damping(s->model, s->state, i) * v[i];
  }
}

/* A residual beside the step, or beside what is rounding if that is more. */
static double beside(const thrum_solver *s, double norm, double step) {
  const double wanted = goal(s, step);
  return wanted > 0.0 ? s->state->tolerance * norm / wanted : 0.0;
}

/* Where the solve stands at this evaluation. */
static void observe(const thrum_solver *s, const thrum_quasi *quasi, double norm, double step) {
  s->report->reached = beside(s, norm, step);
  if (quasi->done == 0)
    s->report->guess = s->report->reached;
}

/* Is the residual of the increment just corrected sure to be small enough? */
static bool sure(const thrum_solver *s, double contraction, double norm, double step) {
  // D of the tangent form is known where it was evaluated only; where v is much more than d/h, as
  // for a small beta_N, what (5) says of R + D v - f would be rounding
  if (s->tangent || !(s->rate * s->state->dt <= RATE_MOST) ||
      !(MARGIN * contraction * norm <= goal(s, step)))
    return false;
  // a correction that is large beside the residual meets a soft direction, where H may err more
  const double *direction = s->view->direction + s->first;
  return sqrt(thrum_sum_of(s->n, direction, direction, s->view->scale + s->first)) <= FAR * norm;
}

thrum_quasi_next thrum_quasi_take(const thrum_solver *s, thrum_quasi *quasi) {
  const double norm = thrum_solve_assess(s), step = thrum_solve_norm(s);
  if (!isfinite(norm))
    return THRUM_QUASI_STUCK;
  observe(s, quasi, norm, step);
  const bool second = quasi->done > 0;
  if (thrum_solve_accept(s, norm, step)) {
    s->report->verified = true;
    return THRUM_QUASI_DONE;
  }
  if (quasi->done == s->state->iterations_max || (second && quasi->fresh && norm > quasi->before))
    return THRUM_QUASI_STUCK;
  const double contraction = norm / quasi->before;
  const bool late = second && slow(s, contraction, norm, goal(s, step));
  quasi->fresh = late || (quasi->ahead && !second);
  s->report->slow = s->report->slow || (late && !quasi->ahead);
  if (quasi->fresh && !refresh(s, quasi))
    return THRUM_QUASI_STUCK;
  quasi->assembled = false;
  correct(s, quasi, second && !quasi->fresh && quasi->before > TEACHING * step);
  quasi->before = norm;
  quasi->done++;
  thrum_solve_place(s);
  if (second && !quasi->fresh && sure(s, contraction, norm, step)) {
    s->report->residual = step > 0.0 ? MARGIN * contraction * norm / step : 0.0;
    conclude(s);
    s->report->verified = false;
    return THRUM_QUASI_DONE;
  }
  return THRUM_QUASI_EVALUATE;
}
