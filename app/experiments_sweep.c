/* `thrum experiments --sweep`: the time steps, their table and figures.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#include "app/experiments.h"
#include "config/progress.h"
#include "io/json.h"

#define IMPULSE_DT 0.003 /* at which the impulse is found */

static const double steps_of_sweep[] = {
    EXPERIMENTS_SHORTEST, 3e-4, 1e-3, 3e-3, 5e-3, 0.01, 0.02, 0.05};
enum { SWEEP_COUNT = sizeof steps_of_sweep / sizeof steps_of_sweep[0] };

/* What the tasks share. The cases go by model, time step, integrator, the last fastest. */
typedef struct sweep_work {
  experiment_sweep_case *cases;
  experiment_sweep_result *results;
} sweep_work;

static thrum_status run_case(void *context, int64_t index, thrum_error *error) {
  sweep_work *work = context;
  return experiment_sweep_run(&work->cases[index], &work->results[index], error);
}

static thrum_status plan(const experiments_request *request, const experiments_bodies *bodies,
                         experiment_sweep_case *cases, int64_t *count, thrum_error *error) {
  *count = 0;
  for (int64_t b = 0; b < bodies->count; b++) {
    double impulse = 0, reached = 0;
    const thrum_status status = experiment_impulse(&bodies->bodies[b], request->amplitudes[0],
                                                   IMPULSE_DT, &impulse, &reached, error);
    if (status < 0)
      return status;
    for (int k = 0; k < SWEEP_COUNT; k++) {
      for (int i = 0; i < EXPERIMENT_INTEGRATOR_COUNT; i++) {
        if (!request->integrators[i])
          continue;
        const int64_t steps = thrum_step_count(request->time, steps_of_sweep[k]);
        cases[(*count)++] = (experiment_sweep_case){
            .body = &bodies->bodies[b],
            .integrator = (experiment_integrator)i,
            .impulse = impulse,
            .dt = steps_of_sweep[k],
            .steps = steps < 1 ? 1 : steps,
        };
      }
    }
  }
  return THRUM_OK;
}

static void print_json(const experiments_request *request, const sweep_work *work, int64_t count,
                       bool flagged) {
  cJSON *object = experiments_json(request, flagged);
  cJSON *runs = cJSON_AddArrayToObject(object, "runs");
  for (int64_t n = 0; n < count; n++) {
    const experiment_sweep_case *run = &work->cases[n];
    const experiment_sweep_result *result = &work->results[n];
    cJSON *item = cJSON_CreateObject();
    json_string(item, "model", run->body->name);
    cJSON_AddStringToObject(item, "integrator", experiment_integrator_names[run->integrator]);
    json_number(item, "dt", run->dt);
    cJSON_AddStringToObject(item, "status", experiment_sweep_status(result));
    json_number(item, "simulated_s", result->simulated);
    json_number(item, "us_per_step", result->us_per_step);
    json_number(item, "mean_iterations",
                (double)result->report.iterations / (double)result->report.steps);
    json_number(item, "energy_j", result->energy);
    json_number(item, "energy_error", result->energy_error);
    json_number(item, "energy_change", result->energy_change);
    json_number(item, "peak_amplitude", result->peak_amplitude);
    experiments_json_levels(item, &result->report);
    cJSON_AddItemToArray(runs, item);
  }
  json_print(object);
}

static void print_table(const sweep_work *work, int64_t count) {
  printf("%-8s %-8s %7s %8s %8s %6s %10s %10s  %s\n", "model", "method", "dt [s]", "time [s]",
         "us/step", "iter.", "error", "change", "status");
  for (int64_t n = 0; n < count; n++) {
    const experiment_sweep_case *run = &work->cases[n];
    const experiment_sweep_result *result = &work->results[n];
    printf("%-8s %-8s %7g %8.3f %8.2f %6.2f", run->body->name,
           experiment_integrator_names[run->integrator], run->dt, result->simulated,
           result->us_per_step, (double)result->report.iterations / (double)result->report.steps);
    // of a lost run the size of its error says nothing
    if (result->lost) {
      printf(" %10s %10s", "-", "-");
    } else {
      printf(" %10.1e %10.1e", result->energy_error, result->energy_change);
    }
    printf("  %s\n", experiment_sweep_status(result));
  }
}

static thrum_status run_all(const experiments_request *request, sweep_work *work, int64_t count,
                            thrum_error *error) {
  config_progress progress = config_progress_make(request->quiet);
  const experiment_pool pool = {
      .threads = (int)request->threads,
      .count = count,
      .task = run_case,
      .progress = experiments_progress,
      .context = work,
      .progress_context = &progress,
  };
  const thrum_status status = experiment_pool_run(&pool, error);
  if (status >= 0) {
    config_progress_done(&progress);
  } else {
    config_progress_abandon(&progress);
  }
  return status;
}

thrum_status experiments_sweep(const experiments_request *request, const experiments_bodies *bodies,
                               bool *flagged, thrum_error *error) {
  const size_t room = (size_t)bodies->count * SWEEP_COUNT * EXPERIMENT_INTEGRATOR_COUNT + 1;
  sweep_work work = {.cases = calloc(room, sizeof *work.cases),
                     .results = calloc(room, sizeof *work.results)};
  thrum_status status = THRUM_OK;
  int64_t count = 0;
  if (work.cases == NULL || work.results == NULL) {
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory");
  } else {
    status = plan(request, bodies, work.cases, &count, error);
  }
  if (status >= 0)
    status = run_all(request, &work, count, error);
  for (int64_t n = 0; status >= 0 && n < count; n++)
    // newmark may lose its energy, for that is what it does; the others may not
    *flagged = *flagged || work.results[n].status < 0 ||
               (work.results[n].lost && work.cases[n].integrator != EXPERIMENT_newmark);
  if (status >= 0) {
    experiment_text text = {0};
    experiment_sweep_csv(&text, work.cases, work.results, count);
    status = experiments_write(request, "sweep.csv", &text, error);
    if (status >= 0) {
      const experiment_place place = experiments_place(request);
      experiment_sweep_report(&text, work.cases, work.results, count, &place);
      status = experiments_write(request, "sweep.html", &text, error);
    }
  }
  if (status >= 0 && request->json) {
    print_json(request, &work, count, *flagged);
  } else if (status >= 0) {
    print_table(&work, count);
  }
  free(work.cases);
  free(work.results);
  return status;
}
