/* Plans and runs all extremes: the bodies, their runs over threads, then the systems of units.
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "platform/thread_pool.h"
#include "validation/experiments/extremes.h"

#define UNIT_STEPS 400 /* beyond some hundred steps the motion itself magnifies the last digit */

static bool pass_progress(const experiment_extremes *extremes, const char *stage, double fraction) {
  return extremes->progress == NULL ||
         extremes->progress(extremes->progress_context, stage, fraction);
}

static bool pass_run_progress(void *context, double fraction) {
  return pass_progress(context, "experiments", fraction);
}

static thrum_status allocate(experiment_extremes *x, thrum_error *error) {
  const int64_t bodies = experiment_extreme_count();
  const int64_t cases = bodies * EXPERIMENT_SCHEME_COUNT;
  const int64_t units =
      experiment_unit_count() * EXPERIMENT_UNIT_EXTREMES * EXPERIMENT_SCHEME_COUNT;
  x->body_count = x->count = x->unit_count = 0;
  x->memory = thrum_scope_begin("the runs", error);
  x->bodies = thrum_scope_allocate(&x->memory, bodies, sizeof *x->bodies);
  x->cases = thrum_scope_allocate(&x->memory, cases, sizeof *x->cases);
  x->results = thrum_scope_allocate(&x->memory, cases, sizeof *x->results);
  x->units = thrum_scope_allocate(&x->memory, units, sizeof *x->units);
  x->unit_results = thrum_scope_allocate(&x->memory, units, sizeof *x->unit_results);
  return x->memory.status;
}

/* The bodies asked for, one after the other, and a case for each with each scheme. */
static thrum_status make_bodies(experiment_extremes *x, thrum_error *error) {
  const int64_t all = experiment_extreme_count();
  for (int64_t n = 0; n < all; n++) {
    const experiment_extreme *extreme = &experiment_extreme_list[n];
    if (!x->subjects[extreme->subject])
      continue;
    if (!pass_progress(x, "bodies", (double)n / (double)all))
      return thrum_error_set(error, THRUM_INTERRUPTED, "stopped");

    experiment_extreme_body *body = &x->bodies[x->body_count];
    THRUM_TRY(experiment_extreme_make(extreme, body, error));
    x->body_count++;

    // a large rank takes fewer steps, but at least one with the load and one without
    const int64_t share = extreme->steps_share > 0 ? extreme->steps_share : 1;
    const int64_t steps = x->steps / share > 1 ? x->steps / share : 2;
    for (int i = 0; i < EXPERIMENT_SCHEME_COUNT; i++)
      if (x->schemes[i])
        x->cases[x->count++] = (experiment_extreme_case){body, (experiment_scheme)i, steps};
  }
  return THRUM_OK;
}

static void plan_units(experiment_extremes *x) {
  const int64_t steps = x->steps < UNIT_STEPS ? x->steps : UNIT_STEPS;
  for (int e = 0; e < EXPERIMENT_UNIT_EXTREMES; e++) {
    const experiment_extreme *extreme = &experiment_unit_extremes[e];
    if (!x->subjects[extreme->subject])
      continue;

    // system 0 is SI, with which the others are compared; a scheme that may stop has no such runs
    for (int64_t u = 1; u < experiment_unit_count(); u++) {
      for (int i = 0; i < EXPERIMENT_SCHEME_COUNT; i++) {
        if (x->schemes[i] && experiment_scheme_keeps((experiment_scheme)i))
          x->units[x->unit_count++] = (experiment_unit_case){extreme, &experiment_unit_systems[u],
                                                             (experiment_scheme)i, steps};
      }
    }
  }
}

/* The systems of units, one after the other, since each makes its bodies. */
static thrum_status run_units(experiment_extremes *x, thrum_error *error) {
  plan_units(x);
  for (int64_t n = 0; n < x->unit_count; n++) {
    if (!pass_progress(x, "units", (double)n / (double)x->unit_count))
      return thrum_error_set(error, THRUM_INTERRUPTED, "stopped");
    THRUM_TRY(experiment_units_run(&x->units[n], &x->unit_results[n], error));
  }
  return THRUM_OK;
}

static thrum_status run_index(void *context, int64_t index, thrum_error *error) {
  experiment_extremes *x = context;
  return experiment_extreme_run(&x->cases[index], &x->results[index], error);
}

thrum_status experiment_extremes_run(experiment_extremes *x, thrum_error *error) {
  THRUM_TRY(allocate(x, error));
  THRUM_TRY(make_bodies(x, error));
  const thrum_thread_pool pool = {
      .threads = x->threads,
      .count = x->count,
      .task = run_index,
      .progress = pass_run_progress,
      .context = x,
      .progress_context = x,
  };
  THRUM_TRY(thrum_thread_pool_run(&pool, error));
  return run_units(x, error);
}

void experiment_extremes_free(experiment_extremes *x) {
  for (int64_t n = 0; n < x->body_count; n++)
    experiment_extreme_free(&x->bodies[n]);
  thrum_scope_free(&x->memory);
}

bool experiment_extremes_flagged(const experiment_extremes *x) {
  bool flagged = false;
  for (int64_t n = 0; n < x->count; n++) {
    const char *outcome = experiment_extreme_outcome(&x->cases[n], &x->results[n]);
    const bool bad = strcmp(outcome, "stopped") == 0 || strcmp(outcome, "lost") == 0;
    flagged = flagged || strcmp(outcome, "not_finite") == 0 ||
              (bad && experiment_scheme_keeps(x->cases[n].scheme));
  }
  return flagged;
}
