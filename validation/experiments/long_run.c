/* The long run: mean energies over windows of 35 s, their change and their trend.
 *
 * Energies are taken each few steps, from the synchronised momentum; the stride has no divisor in
 * common with the window, so the windows see the same phases of the step count.
 * SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/long_run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "platform/clock.h"
#include "validation/experiments/run_outcome.h"

#define SAMPLE_STRIDE 7

experiment_trend experiment_slope(const double *values, int64_t count, double spacing) {
  experiment_trend found = {NAN, NAN, NAN};
  if (count < 3)
    return found;
  const double n = (double)count, middle = 0.5 * (n - 1);
  double mean = 0, xy = 0, xx = 0, squares = 0, products = 0, before = 0;

  // least squares about the middle
  for (int64_t k = 0; k < count; k++)
    mean += values[k] / n;
  for (int64_t k = 0; k < count; k++) {
    const double x = ((double)k - middle) * spacing;
    xx += x * x;
    xy += x * (values[k] - mean);
  }
  found.slope = xy / xx;

  // residuals, and the products of neighbours for their correlation
  for (int64_t k = 0; k < count; k++) {
    const double x = ((double)k - middle) * spacing;
    const double residual = values[k] - mean - found.slope * x;
    squares += residual * residual;
    products += residual * before;
    before = residual;
  }
  found.error = sqrt(squares / (n - 2) / xx);
  // neighbours that differ more than chance lets them are no reason to be surer
  const double rho = squares > 0 ? fmax(products / squares, 0) : 0;
  const double effective = n * (1 - rho) / (1 + rho);
  found.error_correlated = effective > 2 ? sqrt(squares / (effective - 2) / xx) : INFINITY;
  return found;
}

bool experiment_long_steady(const experiment_long_result *result) {
  return isfinite(result->high_slope_error_correlated) &&
         fabs(result->high_slope) <= 2 * result->high_slope_error_correlated;
}

/* The figures that the windows give. */
static void conclude(double window_seconds, experiment_long_result *result) {
  const int64_t count = result->window_count;
  double mean = 0;
  result->total_change = result->high_change = result->total_worst = NAN;

  // changes are relative to the first window
  if (count >= 2) {
    const double total = result->total[0], high = result->high[0];
    result->total_change = (result->total[count - 1] - total) / total;
    result->high_change = (result->high[count - 1] - high) / high;
    result->total_worst = 0;
    for (int64_t k = 0; k < count; k++)
      result->total_worst = fmax(result->total_worst, fabs(result->total[k] - total) / total);
  }

  // the trend is relative to the mean of the high modes
  const experiment_trend trend = experiment_slope(result->high, count, window_seconds);
  for (int64_t k = 0; k < count; k++)
    mean += result->high[k] / (double)count;
  result->high_slope = trend.slope / mean;
  result->high_slope_error = trend.error / mean;
  result->high_slope_error_correlated = trend.error_correlated / mean;
}

/* Steps of one window; the mean energies of its samples, unless the run is lost in it. */
static thrum_status run_window(const experiment_long_case *run, thrum_state *state, int64_t steps,
                               double *seconds, double *total, double *high,
                               experiment_long_result *made) {
  const thrum_model *model = run->body->model;
  double sums[2] = {0, 0}, first = 0;
  int64_t samples = 0;
  for (int64_t step = 0; step < steps && !made->lost;) {
    const int64_t until = step + SAMPLE_STRIDE < steps ? step + SAMPLE_STRIDE : steps;
    thrum_energies energies;
    thrum_status status = THRUM_OK;
    const double began = clock_thread_seconds();
    for (; step < until && status >= 0; step++)
      status = thrum_step(model, state, &made->stop);
    *seconds += clock_thread_seconds() - began;
    THRUM_THEN(status, thrum_state_energies(model, state, &energies, &made->stop));
    if (status < 0)
      return status;

    // from the first on: the sum of thousands of equal numbers is rounded by more than they differ
    first = samples == 0 ? energies.total : first;
    sums[0] += energies.total - first;
    sums[1] += energies.high;
    samples++;
    made->lost = energies.total > EXPERIMENT_LOST * made->energy;
  }
  *total = first + sums[0] / (double)samples;
  *high = sums[1] / (double)samples;
  return THRUM_OK;
}

/* The windows of one case after its impulse, until its steps are done or it is lost. */
static thrum_status run_windows(const experiment_long_case *run, thrum_state *state, int64_t window,
                                experiment_long_result *made) {
  thrum_energies energies;
  THRUM_TRY(experiment_strike(run->body, run->impulse, run->dt, state, &made->stop));
  THRUM_TRY(thrum_state_energies(run->body->model, state, &energies, &made->stop));
  made->energy = energies.total;

  // whole windows first; what is left of the steps belongs to none
  double seconds = 0, rest[2];
  int64_t steps = run->steps - thrum_state_report_get(state).steps;
  thrum_status status = THRUM_OK;
  while (status >= 0 && steps >= window && !made->lost) {
    const int64_t k = made->window_count;
    status = run_window(run, state, window, &seconds, &made->total[k], &made->high[k], made);
    made->window_count += status >= 0 && !made->lost;
    steps -= window;
  }
  if (status >= 0 && steps > 0 && !made->lost)
    status = run_window(run, state, steps, &seconds, &rest[0], &rest[1], made);

  made->us_per_step = 1e6 * seconds / (double)thrum_state_report_get(state).steps;
  return status;
}

/* One case. Fails only for want of memory; a step that fails is in the result. */
static thrum_status run_case(const experiment_long_case *run, experiment_long_result *result,
                             thrum_error *error) {
  const int64_t window = thrum_step_count(EXPERIMENT_WINDOW_SECONDS, run->dt);
  const int64_t count = run->steps / window;
  experiment_long_result made = {0};
  thrum_state *state = NULL;
  const thrum_state_def def = experiment_scheme_def(run->scheme, run->dt);
  THRUM_TRY(thrum_state_create(run->body->model, &def, &state, error));

  // the two rows of means share one allocation
  made.total = calloc((size_t)(2 * count + 1), sizeof *made.total);
  if (made.total == NULL) {
    thrum_state_destroy(state);
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %lld windows",
                           (long long)count);
  }
  made.high = made.total + count;

  const thrum_status status = run_windows(run, state, window, &made);
  made.status = status < 0 ? status : THRUM_OK;
  made.report = thrum_state_report_get(state);
  conclude((double)window * run->dt, &made);
  thrum_state_destroy(state);
  *result = made;
  return THRUM_OK;
}

/* The impulse of one body and amplitude, for those of its schemes that are not done. */
static thrum_status find_impulse(void *context, int64_t index, thrum_error *error) {
  experiment_long *runs = context;
  const int64_t width = experiment_flag_count(runs->schemes, EXPERIMENT_SCHEME_COUNT);
  const int64_t first = index * width;
  experiment_long_case *cases = runs->cases + first;
  bool needed = false;
  for (int64_t n = 0; n < width; n++)
    needed = needed || !atomic_load(&runs->done[first + n]);
  if (!needed)
    return THRUM_OK;

  // the case of a run that is done says which impulse it had
  double impulse = 0, reached = 0;
  THRUM_TRY(
      experiment_impulse(cases->body, cases->amplitude, cases->dt, &impulse, &reached, error));
  for (int64_t n = 0; n < width; n++) {
    if (atomic_load(&runs->done[first + n]))
      continue;
    cases[n].impulse = impulse;
    cases[n].reached = reached;
  }
  return THRUM_OK;
}

static thrum_status run_index(void *context, int64_t index, thrum_error *error) {
  experiment_long *runs = context;
  if (atomic_load(&runs->done[index]))
    return THRUM_OK;
  THRUM_TRY(run_case(&runs->cases[index], &runs->results[index], error));
  atomic_store(&runs->done[index], true);
  return THRUM_OK;
}

thrum_status experiment_long_plan(experiment_long *runs, thrum_error *error) {
  const size_t room =
      (size_t)(runs->body_count * runs->amplitude_count * EXPERIMENT_SCHEME_COUNT + 1);
  runs->count = 0;
  THRUM_TRY(thrum_reserve(&runs->cases, room, sizeof *runs->cases, "the runs", error));
  THRUM_TRY(thrum_reserve(&runs->results, room, sizeof *runs->results, "the runs", error));
  THRUM_TRY(thrum_reserve(&runs->done, room, sizeof *runs->done, "the runs", error));

  // the schemes of one body and amplitude follow each other: they share their impulse
  for (int64_t b = 0; b < runs->body_count; b++) {
    for (int64_t a = 0; a < runs->amplitude_count; a++) {
      for (int i = 0; i < EXPERIMENT_SCHEME_COUNT; i++) {
        if (!runs->schemes[i])
          continue;
        runs->cases[runs->count++] = (experiment_long_case){
            .body = &runs->bodies[b],
            .scheme = (experiment_scheme)i,
            .amplitude = runs->amplitudes[a],
            .dt = runs->dt,
            .steps = runs->steps,
        };
      }
    }
  }
  return THRUM_OK;
}

thrum_status experiment_long_run(experiment_long *runs, thrum_error *error) {
  thrum_thread_pool pool = {
      .threads = runs->threads,
      .count = runs->body_count * runs->amplitude_count,
      .task = find_impulse,
      .context = runs,
  };
  THRUM_TRY(thrum_thread_pool_run(&pool, error));

  // the impulses take seconds, the runs hours: only these report their progress
  pool.count = runs->count;
  pool.task = run_index;
  pool.progress = runs->progress;
  pool.progress_context = runs->progress_context;
  return thrum_thread_pool_run(&pool, error);
}

bool experiment_long_flagged(const experiment_long *runs) {
  bool flagged = false;
  for (int64_t n = 0; n < runs->count; n++)
    flagged = flagged || ((runs->results[n].status < 0 || runs->results[n].lost) &&
                          experiment_scheme_keeps(runs->cases[n].scheme));
  return flagged;
}

void experiment_long_free(experiment_long *runs) {
  for (int64_t n = 0; n < runs->count; n++)
    experiment_long_result_free(&runs->results[n]);
  free(runs->cases);
  free(runs->results);
  free(runs->done);
}

void experiment_long_result_free(experiment_long_result *result) {
  free(result->total);
  memset(result, 0, sizeof *result);
}
