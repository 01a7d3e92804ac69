/* One equilibrium: R(q) = factor f by Newton, two ways (design 12).
 *
 * Near: J d = g with J = T, steps shortened until |g| falls; it finds what is near, be it stable or
 * not, which is how a path is followed past the point where it becomes unstable.
 * Down: g is the gradient of the total energy Pi = V - factor f q, whose minima are the stable
 * equilibria; T is shifted by 3/2 of its least eigenvalue where that is negative, so that every
 * direction leads downhill, and a search along it ends in a minimum (Nocedal & Wright 2006,
 * Numerical Optimization, doi:10.1007/978-0-387-40065-5, chapter 3).
 * Where steps stay short because the minimum lies along a curved valley, as that of a slender body
 * which bends far without stretching, a few full steps are taken during which the energy may rise
 * (the watchdog of Chamberlain, Powell, Lemarechal & Pedersen 1982, doi:10.1007/BFb0120945).
 * Norms are of energy: |g| = sqrt(sum g_i^2 / omega_i^2), |q| = sqrt(sum omega_i^2 q_i^2), so that
 * no mode is judged in another's units. Cost: a tangent and r^3 to 3 r^3 operations an iteration.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "core/linear_algebra/dense.h"
#include "core/linear_algebra/symmetric.h"
#include "runtime/actuation/acting.h"
#include "runtime/statics/equilibrium_private.h"

#define ROUNDING                                                                                   \
  (256.0 * DBL_EPSILON) /* relative to the largest |q|: no residual falls below it                 \
                         */
#define STALLED                                                                                    \
  1e-7             /* residual relative to the load that will do where rounding stops the descent */
#define SHORT 0.25 /* lengths of a line search below this are short */
#define SHORT_MOST 8       /* so many in a row lead to a leap */
#define LEAP_STEPS 6       /* full steps within which the energy must fall below where it was */
#define NEAR_ITERATIONS 20 /* a step that needs more is too long */
#define LENGTHS_MAX 60     /* lengths of a line search */
#define PROMISED 1e-4      /* share of the fall that the slope promises (Armijo) */
#define NORM_FALL                                                                                  \
  0.1 /* share of a length by which the residual falls, where the energy says nothing */
#define NOISE 1e-12 /* of the energy, which is a difference of larger terms */
#define PUSH 1e-3   /* of the largest amplitude: off an unstable equilibrium */

void thrum_search_act(thrum_search *s, double factor) {
  for (int64_t k = 0; s->actors && k < s->model->actuator_count; k++)
    s->levels[k] = factor * s->actors[k];
  if (s->actors)
    thrum_acting_sum(s->model, s->levels);
}

void thrum_search_load(thrum_search *s, const double *q, double *load) {
  memcpy(load, s->load, (size_t)s->n * sizeof *load);
  if (!s->actors)
    return;

  // energies are linear in the levels, so that a difference is a derivative
  double before[THRUM_ACTUATORS_MAX], force[THRUM_RANK_MAX];
  memcpy(before, s->levels, (size_t)s->model->actuator_count * sizeof *before);
  for (int n = 0; n < 2; n++) {
    memset(force, 0, (size_t)s->n * sizeof *force);
    thrum_search_act(s, n);
    thrum_passes.act(s->kernel, s->model, q, force, NULL, 0.0);
    for (int32_t i = 0; i < s->n; i++)
      load[i] += n == 0 ? force[i] : -force[i];
  }
  memcpy(s->levels, before, (size_t)s->model->actuator_count * sizeof *before);
  thrum_acting_sum(s->model, s->levels);
}

/* Residual and energies of s->trial under factor times the load. */
static thrum_search_measure assess(thrum_search *s, double factor) {
  thrum_search_measure found;
  thrum_search_act(s, factor);
  found.energy = thrum_internal_force_by(s->kernel, s->model, s->trial, s->force, s->work);

  // r = R(q) - factor f - base, and the work of both loads
  double sum = 0.0, worked = 0.0;
  for (int32_t i = 0; i < s->n; i++) {
    s->residual[i] = s->force[i] - factor * s->load[i];
    worked += factor * s->load[i] * s->trial[i];
    if (s->def->base) {
      s->residual[i] -= s->def->base[i];
      worked += s->def->base[i] * s->trial[i];
    }
    sum += s->residual[i] * s->residual[i] / s->scale[i];
  }

  found.norm = sqrt(sum);
  found.merit = found.energy - worked;
  if (s->actors)
    found.energy -= thrum_passes.act(s->kernel, s->model, s->trial, NULL, NULL, 0.0);
  return found;
}

double thrum_search_length(const thrum_search *s, const double *x, const double *y) {
  double sum = 0.0;
  for (int32_t i = 0; i < s->n; i++) {
    const double d = y ? x[i] - y[i] : x[i];
    sum += s->scale[i] * d * d;
  }
  return sqrt(sum);
}

/* Residual that counts as none. */
static double target(const thrum_search *s, double factor) {
  return s->def->tolerance * factor * s->load_norm + ROUNDING * s->amplitude;
}

static bool factorise(thrum_search *s, double shift) {
  const size_t n = (size_t)s->n;
  memcpy(s->factors, s->tangent, n * n * sizeof *s->factors);
  for (size_t i = 0; i < n; i++)
    s->factors[i * n + i] += shift;
  s->report->factorisations++;
  return thrum_dense_factor(s->factors, s->n, (int32_t *)(void *)s->pivots);
}

static void solve(const thrum_search *s, double *x) {
  thrum_dense_solve(s->factors, s->n, (const int32_t *)(const void *)s->pivots, x);
}

bool thrum_search_rate(thrum_search *s, const double *q, double *rate) {
  thrum_tangent_stiffness_by(s->kernel, s->model, q, s->tangent, s->work);
  if (!factorise(s, 0.0))
    return false;
  thrum_search_load(s, q, rate);
  solve(s, rate);
  double sum = 0.0;
  for (int32_t i = 0; i < s->n; i++)
    sum += rate[i] * rate[i];
  return isfinite(sum);
}

double thrum_search_least(thrum_search *s, const double *q, bool vector) {
  const size_t n = (size_t)s->n;
  thrum_tangent_stiffness_by(s->kernel, s->model, q, s->tangent, s->work);
  memcpy(s->factors, s->tangent, n * n * sizeof *s->factors);
  const double least = thrum_symmetric_least(s->factors, s->n, s->spare);
  if (vector)
    thrum_symmetric_vector(s->tangent, s->n, least, s->factors, (int32_t *)(void *)s->pivots,
                           s->soft);
  return least;
}

/* s->trial = s->origin - length * s->direction */
static void place(thrum_search *s, double length) {
  for (int32_t i = 0; i < s->n; i++)
    s->trial[i] = s->origin[i] - length * s->direction[i];
}

/* Line search: goes along the direction by 1 and then shorter. With slope > 0 the merit must fall,
 * else the residual. False, and back where it was, when neither does. */
static bool shorten(thrum_search *s, double factor, double slope, thrum_search_measure *here,
                    double *taken) {
  memcpy(s->origin, s->trial, (size_t)s->n * sizeof *s->origin);

  // the energy is a difference of terms as large as those of the displacement
  const double size = thrum_search_length(s, s->origin, NULL);
  const double noise = NOISE * fabs(here->merit) + 16.0 * DBL_EPSILON * size * size;
  double length = 1.0;
  for (int k = 0; k < LENGTHS_MAX; k++) {
    place(s, length);
    const thrum_search_measure there = assess(s, factor);

    // enough is a fixed share of what the slope promises
    const bool fell =
        slope > 0.0 ? there.merit < here->merit - PROMISED * length * slope ||
                          (there.norm < 0.5 * here->norm && there.merit <= here->merit + noise)
                    : there.norm < (1.0 - NORM_FALL * length) * here->norm;
    if (isfinite(there.norm) && isfinite(there.merit) &&
        (fell || there.norm <= target(s, factor))) {
      *here = there;
      *taken = length;
      return true;
    }

    // far outside, where the quartic terms dominate, halving would take too long
    length *= there.norm < 8.0 * here->norm ? 0.5 : 0.0625;
  }

  // no length helps: back to the start
  place(s, 0.0);
  *here = assess(s, factor);
  return false;
}

bool thrum_search_near(thrum_search *s, double factor, thrum_search_measure *found) {
  *found = assess(s, factor);
  for (int32_t j = 0; found->norm > target(s, factor); j++) {
    if (j == NEAR_ITERATIONS || !isfinite(found->norm))
      return false;

    // a full Newton step, shortened where the residual does not fall
    thrum_tangent_stiffness_by(s->kernel, s->model, s->trial, s->tangent, s->work);
    if (!factorise(s, 0.0))
      return false;
    memcpy(s->direction, s->residual, (size_t)s->n * sizeof *s->direction);
    solve(s, s->direction);
    s->report->iterations++;
    double length = 0.0;
    if (!shorten(s, factor, 0.0, found, &length))
      return found->norm <= STALLED * factor * s->load_norm;
  }
  return isfinite(found->norm);
}

/* Finds the least eigenvalue of T at the trial and a direction downhill; returns its slope, > 0. */
static double descend(thrum_search *s, double *least) {
  *least = thrum_search_least(s, s->trial, false);
  const double shift = *least < 0.0 ? -1.5 * *least : 0.0;
  if (!isfinite(*least) || !factorise(s, shift))
    return 0.0;

  // T, made positive definite by a shift where it is not, turns the residual into a descent
  memcpy(s->direction, s->residual, (size_t)s->n * sizeof *s->direction);
  solve(s, s->direction);
  double slope = 0.0;
  for (int32_t i = 0; i < s->n; i++)
    slope += s->direction[i] * s->residual[i];
  return slope;
}

/* Leaves a saddle along the soft direction to the side where the total energy is lower. */
static void push_off(thrum_search *s, double factor) {
  thrum_search_least(s, s->trial, true);
  const double size = thrum_search_length(s, s->soft, NULL);
  const double push = size > 0.0 ? PUSH * s->amplitude / size : 0.0;

  // both sides are tried
  memcpy(s->origin, s->trial, (size_t)s->n * sizeof *s->origin);
  memcpy(s->direction, s->soft, (size_t)s->n * sizeof *s->direction);
  place(s, push);
  const double back = assess(s, factor).merit;
  place(s, -push);
  if (back < assess(s, factor).merit)
    place(s, push);
}

/* Full steps of Newton until the energy is lower than here by a share of what the first slope
 * promises; false, and back where it was, when it is not after LEAP_STEPS. The candidate is free
 * while a search goes down. */
static bool leap(thrum_search *s, double factor, double slope, thrum_search_measure *here) {
  const size_t vector = (size_t)s->n * sizeof *s->trial;
  const double enough = here->merit - PROMISED * slope;
  memcpy(s->candidate, s->trial, vector);

  double least = 0.0;
  for (int k = 0; k < LEAP_STEPS && isfinite(slope) && slope > 0.0; k++) {
    memcpy(s->origin, s->trial, vector);
    place(s, 1.0);
    const thrum_search_measure there = assess(s, factor);
    if (!isfinite(there.norm) || !isfinite(there.merit))
      break;
    if (there.merit < enough) {
      *here = there;
      return true;
    }
    slope = descend(s, &least);
    s->report->iterations++;
  }

  // the direction is that of where the search was
  memcpy(s->trial, s->candidate, vector);
  *here = assess(s, factor);
  descend(s, &least);
  return false;
}

bool thrum_search_down(thrum_search *s, double factor, thrum_search_measure *found) {
  *found = assess(s, factor);
  int short_steps = 0;
  for (int32_t j = 0; j <= s->def->iterations_max && isfinite(found->norm); j++) {
    if (found->norm <= target(s, factor)) {
      if (thrum_search_least(s, s->trial, false) >= -THRUM_STATIC_ROUNDING * s->scale[s->n - 1])
        return true;
      push_off(s, factor);
      *found = assess(s, factor);
      continue;
    }

    // Newton with descent: the total energy falls in every iteration
    double least = 0.0;
    const double slope = descend(s, &least);
    s->report->iterations++;
    if (short_steps >= SHORT_MOST && leap(s, factor, slope, found))
      continue;
    double length = 0.0;
    if (!isfinite(slope) || !(slope > 0.0) || !shorten(s, factor, slope, found, &length))
      return least >= 0.0 && found->norm <= STALLED * factor * s->load_norm;

    // a leap that came to nothing waits for as many short steps again
    short_steps = short_steps >= SHORT_MOST || length >= SHORT ? 0 : short_steps + 1;
  }
  return false;
}
