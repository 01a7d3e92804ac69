/* The stability number of imexv, and the explicit set that follows from it (design 4; stability.h).
 *
 * The number is h sqrt(rho), h the longest step lately (step_length.h) and rho the spectral radius
 * of the stiffness treated explicitly: T_EE(q) in the thesis split and the position form, T(q) -
 * diag_I(omega^2) in the quadratic split; stable below 2. It comes from power iterations, one every
 * few steps and one a step near the limit, started from the last iterate. Above NUMBER_HIGH the
 * highest explicit modes become implicit (the quadratic split becomes the thesis split). All return
 * after a long quiet time, which doubles with each change. Cost: a product T v a sample.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/guard/stability.h"

#include <math.h>
#include <string.h>

#include "core/polynomial/polynomial_private.h"
#include "core/schemes/mode_split.h"
#include "core/step/scheme_change.h"

#define NUMBER_HIGH 1.6 /* above it modes leave the explicit set, */
#define NUMBER_GOOD                                                                                \
  1.4 /* until the number is below this, below which a quiet time brings all back */
#define RATE_FADES 0.75 /* what a sample leaves of the rate at which the number has moved */

/* view->direction = v/|v| of the first n modes. v all zero: starts with weight on the highest. */
static void normalise(const thrum_state *state, thrum_state_view *view, int32_t n, double *v) {
  double norm = 0.0;
  for (int32_t i = 0; i < n; i++)
    norm += v[i] * v[i];
  if (!(norm > 0.0))
    for (int32_t i = 0; i < n; i++)
      v[i] = 1.0 / (double)(n - i);

  norm = 0.0;
  for (int32_t i = 0; i < n; i++)
    norm += v[i] * v[i];
  for (int32_t i = 0; i < state->rank; i++)
    view->direction[i] = i < n ? v[i] / sqrt(norm) : 0.0;
}

static void multiply(const thrum_model *model, thrum_state_view *view, int32_t n) {
  thrum_tangent_product_part(view->kernel, model, n, view->q, view->direction, view->product,
                             view->work);
}

/* Ends a power iteration on the first n modes, from T times the direction in view->product: the
 * next iterate into v. Returns |A v| for |v| = 1, a lower bound of the spectral radius. */
static double finish_iteration(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, int32_t n, double *v) {
  if (state->scheme == THRUM_SCHEME_QUADRATIC)
    for (int32_t i = state->split; i < n; i++)
      view->product[i] -= model->omega2[i] * view->direction[i];

  double norm = 0.0;
  for (int32_t i = 0; i < n; i++)
    norm += view->product[i] * view->product[i];
  norm = sqrt(norm);
  for (int32_t i = 0; i < n; i++)
    v[i] = norm > 0.0 && isfinite(norm) ? view->product[i] / norm : 0.0;
  return norm;
}

static double iterate(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                      int32_t n, double *v) {
  normalise(state, view, n, v);
  multiply(model, view, n);
  return finish_iteration(model, state, view, n, v);
}

static double number_of(const thrum_state *state, double radius) {
  return fmin(state->split_dt * sqrt(radius), THRUM_MONITOR_MOST);
}

void thrum_stability_direct(const thrum_state *state, thrum_state_view *view) {
  const size_t vector = (size_t)state->rank * sizeof(double);
  memcpy(view->power_explicit_next, view->power_explicit, vector);
  memcpy(view->power_whole_next, view->power_whole, vector);
  view->power_sampled = true;
  normalise(state, view, thrum_monitored_modes(state), view->power_explicit_next);
}

void thrum_stability_multiply(const thrum_model *model, const thrum_state *state,
                              thrum_state_view *view) {
  const int32_t n = thrum_monitored_modes(state);
  if (n > 0)
    multiply(model, view, n);
}

/* The highest explicit modes become implicit until the rest is stable with a margin. */
static thrum_status shrink(const thrum_model *model, thrum_state *state, thrum_state_view *view) {
  int32_t split = state->split;
  thrum_state lower = *state;
  lower.scheme = (int32_t)thrum_solving_scheme(state);

  // the quadratic split first gives way to the thesis split of the same modes
  bool fewer = state->scheme != THRUM_SCHEME_QUADRATIC;
  for (double number = NUMBER_HIGH; number >= NUMBER_GOOD && split > 0; fewer = true) {
    split -= fewer ? 1 : 0;
    memset(view->power_explicit_next, 0, (size_t)state->rank * sizeof *view->power_explicit_next);

    // from a new start a few iterations are enough for a margin of this size
    number = 0.0;
    for (int k = 0; k < 8 && split > 0; k++)
      number = number_of(state, iterate(model, &lower, view, split, view->power_explicit_next));
  }

  // each change alters the discrete energy, so that modes return later after each
  if (state->scheme == THRUM_SCHEME_QUADRATIC)
    state->report.scheme_switches++;
  else
    state->report.split_changes++;
  const int64_t changes = state->report.split_changes < 10 ? state->report.split_changes : 10;
  state->monitor.quiet_peak = 0.0;
  state->monitor.quiet_end = state->report.steps + ((int64_t)THRUM_QUIET_STEPS << changes);
  return thrum_scheme_change(model, state, view, thrum_solving_scheme(state), split);
}

/* Looks whether all explicit modes of the def, `whole`, can return. */
static thrum_status look_for_return(const thrum_model *model, thrum_state *state,
                                    thrum_state_view *view, int32_t whole) {
  thrum_stability_monitor *monitor = &state->monitor;
  const double number =
      number_of(state, iterate(model, state, view, whole, view->power_whole_next));
  monitor->quiet_peak = fmax(monitor->quiet_peak, number);
  if (state->report.steps < monitor->quiet_end)
    return THRUM_OK;

  // the quiet time is over: it counts from here again
  const bool quiet = monitor->quiet_peak < NUMBER_GOOD;
  monitor->quiet_peak = 0.0;
  monitor->quiet_end = state->report.steps + THRUM_QUIET_STEPS;
  if (!quiet)
    return THRUM_OK;
  state->report.split_changes++;
  memset(view->power_explicit_next, 0, (size_t)state->rank * sizeof(double));
  return thrum_scheme_change(model, state, view, thrum_solving_scheme(state), whole);
}

/* Enters a sample of the stability number, and how fast it has moved since the last one: it rests
 * where a swing turns and moves again, so that rate fades only slowly. */
static void enter_number(thrum_state *state, double number) {
  thrum_stability_monitor *m = &state->monitor;
  const double before = state->report.stability_number_last;
  const double steps = (double)(state->report.steps - m->sample_step);
  m->number_rate *= RATE_FADES;
  if (m->sample_step >= 0 && steps > 0.0 &&
      !(fabs(number - before) <= m->number_rate * before * steps))
    m->number_rate = before > 0.0 ? fmin(fabs(number - before) / (before * steps), 1.0) : 1.0;
  m->sample_step = state->report.steps;
  state->report.stability_number_last = number;
}

thrum_status thrum_stability_sample(const thrum_model *model, thrum_state *state,
                                    thrum_state_view *view) {
  thrum_state_report *report = &state->report;
  const int32_t whole = thrum_mode_split(model, state), n = thrum_monitored_modes(state);
  if (n > 0) {
    const double radius = finish_iteration(model, state, view, n, view->power_explicit_next);
    enter_number(state, number_of(state, radius));
    report->stability_number_peak =
        fmax(report->stability_number_peak, report->stability_number_last);
    if (!(report->stability_number_last <= NUMBER_HIGH))
      return shrink(model, state, view);
  }

  // fewer samples are enough to see a quiet time
  if (state->scheme == THRUM_SCHEME_QUADRATIC || state->split == whole ||
      report->steps % THRUM_SAMPLE_STEPS != 0)
    return THRUM_OK;
  return look_for_return(model, state, view, whole);
}
