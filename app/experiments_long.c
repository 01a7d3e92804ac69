/* `thrum experiments --long`: the long runs, their tables and figures.
 * SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

#include "app/experiments.h"
#include "config/message.h"
#include "config/progress.h"
#include "io/file.h"
#include "io/json.h"

#define TABLE "long.csv"
#define WINDOWS "long_windows.csv"

/* What the tasks share. The cases go by model, amplitude, integrator, the last fastest. */
typedef struct long_work {
  const experiments_request *request;
  const experiments_bodies *bodies;
  experiment_long_case *cases;
  experiment_long_result *results;
  int64_t integrators;
  int64_t count;
  atomic_bool *known; /* a case that is done, by this run or an earlier one */
  config_progress progress;
} long_work;

/* The impulse of one body and amplitude, for all of its integrators. */
static thrum_status find_impulse(void *context, int64_t index, thrum_error *error) {
  long_work *work = context;
  experiment_long_case *cases = work->cases + index * work->integrators;
  bool needed = false;
  for (int64_t n = 0; n < work->integrators; n++)
    needed = needed || !atomic_load(&work->known[index * work->integrators + n]);
  if (!needed)
    return THRUM_OK;
  double impulse = 0, reached = 0;
  const thrum_status status =
      experiment_impulse(cases->body, cases->amplitude, cases->dt, &impulse, &reached, error);
  for (int64_t n = 0; n < work->integrators && status >= 0; n++) {
    if (atomic_load(&work->known[index * work->integrators + n]))
      continue;
    cases[n].impulse = impulse;
    cases[n].reached = reached;
  }
  return status;
}

static thrum_status run_case(void *context, int64_t index, thrum_error *error) {
  long_work *work = context;
  if (atomic_load(&work->known[index]))
    return THRUM_OK;
  const thrum_status status =
      experiment_long_run(&work->cases[index], &work->results[index], error);
  atomic_store(&work->known[index], status >= 0);
  return status;
}

static int64_t plan(const experiments_request *request, const experiments_bodies *bodies,
                    experiment_long_case *cases) {
  int64_t count = 0;
  for (int64_t b = 0; b < bodies->count; b++) {
    for (int64_t a = 0; a < request->amplitude_count; a++) {
      for (int i = 0; i < EXPERIMENT_INTEGRATOR_COUNT; i++) {
        if (!request->integrators[i])
          continue;
        cases[count++] = (experiment_long_case){
            .body = &bodies->bodies[b],
            .integrator = (experiment_integrator)i,
            .amplitude = request->amplitudes[a],
            .dt = request->dt,
            .steps = request->steps,
        };
      }
    }
  }
  return count;
}

static void print_json(const long_work *work, int64_t count, bool flagged) {
  cJSON *object = experiments_json(work->request, flagged);
  cJSON *runs = cJSON_AddArrayToObject(object, "runs");
  for (int64_t n = 0; n < count; n++) {
    const experiment_long_case *run = &work->cases[n];
    const experiment_long_result *result = &work->results[n];
    cJSON *item = cJSON_CreateObject();
    json_string(item, "model", run->body->name);
    cJSON_AddStringToObject(item, "integrator", experiment_integrator_names[run->integrator]);
    json_number(item, "amplitude", run->amplitude);
    json_number(item, "reached", run->reached);
    cJSON_AddStringToObject(item, "status", experiment_long_status(result));
    json_number(item, "steps", (double)result->report.steps);
    json_number(item, "dt", run->dt);
    json_number(item, "us_per_step", result->us_per_step);
    json_number(item, "energy_j", result->energy);
    json_number(item, "windows", (double)result->window_count);
    json_number(item, "total_change", result->total_change);
    json_number(item, "total_worst", result->total_worst);
    json_number(item, "high_change", result->high_change);
    json_number(item, "high_slope_per_s", result->high_slope);
    json_number(item, "high_slope_error_per_s", result->high_slope_error);
    json_number(item, "high_slope_error_correlated_per_s", result->high_slope_error_correlated);
    cJSON_AddBoolToObject(item, "high_steady", experiment_long_steady(result));
    experiments_json_levels(item, &result->report);
    cJSON_AddItemToArray(runs, item);
  }
  json_print(object);
}

static void print_table(const long_work *work, int64_t count) {
  printf("%-8s %-8s %5s %9s %9s %10s %10s %9s %9s  %s\n", "model", "method", "swing", "steps",
         "us/step", "energy", "worst", "high", "slope/se", "status");
  for (int64_t n = 0; n < count; n++) {
    const experiment_long_case *run = &work->cases[n];
    const experiment_long_result *result = &work->results[n];
    printf("%-8s %-8s %4.0f%% %9" PRId64 " %9.2f %10.1e %10.1e %9.1e %9.1f  %s\n", run->body->name,
           experiment_integrator_names[run->integrator], 100 * run->amplitude, result->report.steps,
           result->us_per_step, result->total_change, result->total_worst, result->high_change,
           result->high_slope / result->high_slope_error_correlated,
           experiment_long_status(result));
  }
}

/* Marks what the tables in DIR hold already; without them nothing is known. */
static void resume(long_work *work, int64_t count) {
  char path[CLI_MODEL_PATH_MAX];
  void *table = NULL, *windows = NULL;
  size_t size = 0;
  snprintf(path, sizeof path, "%s/%s", work->request->output, TABLE);
  if (thrum_file_read(path, &table, &size, NULL) < 0)
    return;
  snprintf(path, sizeof path, "%s/%s", work->request->output, WINDOWS);
  if (thrum_file_read(path, &windows, &size, NULL) >= 0) {
    for (int64_t n = 0; n < count; n++)
      atomic_init(&work->known[n],
                  experiment_long_read(table, windows, &work->cases[n], &work->results[n]));
  }
  free(table);
  free(windows);
}

/* The tables of what is done so far. */
static thrum_status write_tables(const long_work *work, int64_t count, thrum_error *error) {
  experiment_long_case *cases = calloc((size_t)count + 1, sizeof *cases);
  experiment_long_result *results = calloc((size_t)count + 1, sizeof *results);
  thrum_status status = THRUM_OK;
  int64_t done = 0;
  if (cases == NULL || results == NULL) {
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory");
  } else {
    // shallow copies
    for (int64_t n = 0; n < count; n++) {
      if (!atomic_load(&work->known[n]))
        continue;
      cases[done] = work->cases[n];
      results[done++] = work->results[n];
    }
    experiment_text text = {0};
    experiment_long_csv(&text, cases, results, done);
    status = experiments_write(work->request, TABLE, &text, error);
    experiment_windows_csv(&text, cases, results, done);
    if (status >= 0)
      status = experiments_write(work->request, WINDOWS, &text, error);
    free(text.bytes);
  }
  free(cases);
  free(results);
  return status;
}

/* After each case: what is done is kept, should somebody stop the program. */
static bool keep(void *context, double fraction) {
  long_work *work = context;
  thrum_error error = {0};
  experiments_progress(&work->progress, fraction);
  if (write_tables(work, work->count, &error) < 0)
    config_warn("%s", error.message);
  return true;
}

static thrum_status write_report(const long_work *work, int64_t count, thrum_error *error) {
  experiment_text text = {0};
  const experiment_place place = experiments_place(work->request);
  experiment_long_report(&text, work->cases, work->results, count, &place);
  return experiments_write(work->request, "long.html", &text, error);
}

static thrum_status run_all(long_work *work, int64_t count, thrum_error *error) {
  const experiments_request *request = work->request;
  work->progress = config_progress_make(request->quiet);
  work->count = count;
  experiment_pool pool = {
      .threads = (int)request->threads,
      .count = count / work->integrators,
      .task = find_impulse,
      .context = work,
  };
  thrum_status status = experiment_pool_run(&pool, error);
  pool.count = count;
  pool.task = run_case;
  pool.progress = keep;
  pool.progress_context = work;
  if (status >= 0)
    status = experiment_pool_run(&pool, error);
  if (status >= 0) {
    config_progress_done(&work->progress);
  } else {
    config_progress_abandon(&work->progress);
  }
  return status;
}

thrum_status experiments_long(const experiments_request *request, const experiments_bodies *bodies,
                              bool *flagged, thrum_error *error) {
  long_work work = {.request = request, .bodies = bodies};
  const size_t room =
      (size_t)(bodies->count * request->amplitude_count * EXPERIMENT_INTEGRATOR_COUNT + 1);
  work.cases = calloc(room, sizeof *work.cases);
  work.results = calloc(room, sizeof *work.results);
  work.known = calloc(room, sizeof *work.known);
  for (int i = 0; i < EXPERIMENT_INTEGRATOR_COUNT; i++)
    work.integrators += request->integrators[i];
  thrum_status status = THRUM_OK;
  int64_t count = 0;
  if (work.cases == NULL || work.results == NULL || work.known == NULL) {
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory");
  } else {
    count = plan(request, bodies, work.cases);
    if (request->resume)
      resume(&work, count);
    status = run_all(&work, count, error);
  }
  for (int64_t n = 0; status >= 0 && n < count; n++)
    *flagged = *flagged || work.results[n].status < 0 || work.results[n].lost;
  if (status >= 0)
    status = write_tables(&work, count, error);
  if (status >= 0)
    status = write_report(&work, count, error);
  if (status >= 0 && request->json) {
    print_json(&work, count, *flagged);
  } else if (status >= 0) {
    print_table(&work, count);
  }
  for (int64_t n = 0; n < count; n++)
    experiment_long_result_free(&work.results[n]);
  free(work.cases);
  free(work.results);
  free(work.known);
  return status;
}
