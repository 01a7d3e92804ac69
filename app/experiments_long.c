/* `thrum experiments --long`: the long runs.
 * SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/experiments.h"
#include "config/message.h"
#include "config/progress.h"
#include "io/file.h"
#include "io/json.h"
#include "validation/experiments/long_run.h"
#include "validation/experiments/tables.h"

#define TABLE "long.csv"
#define WINDOWS "long_windows.csv"

/* A request with its runs, for the progress that writes the tables. */
typedef struct long_work {
  const experiments_request *request;
  experiment_long runs;
  config_progress progress;
} long_work;

static void print_json(const experiments_request *request, const experiment_long *runs,
                       bool flagged) {
  cJSON *object = experiments_json(request, flagged);
  cJSON *list = cJSON_AddArrayToObject(object, "runs");

  // one object for each run, with the columns of long.csv
  for (int64_t n = 0; n < runs->count; n++) {
    const experiment_long_case *run = &runs->cases[n];
    const experiment_long_result *result = &runs->results[n];
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
    cJSON_AddItemToArray(list, item);
  }
  json_print(object);
}

static void print_table(const experiment_long *runs) {
  printf("%-8s %-8s %5s %9s %9s %10s %10s %9s %9s  %s\n", "model", "method", "swing", "steps",
         "us/step", "energy", "worst", "high", "slope/se", "status");
  for (int64_t n = 0; n < runs->count; n++) {
    const experiment_long_case *run = &runs->cases[n];
    const experiment_long_result *result = &runs->results[n];
    printf("%-8s %-8s %4.0f%% %9" PRId64 " %9.2f %10.1e %10.1e %9.1e %9.1f  %s\n", run->body->name,
           experiment_integrator_names[run->integrator], 100 * run->amplitude, result->report.steps,
           result->us_per_step, result->total_change, result->total_worst, result->high_change,
           result->high_slope / result->high_slope_error_correlated,
           experiment_long_status(result));
  }
}

/* Marks the runs that the tables in the folder hold already as done; without tables there are none.
 */
static void resume(long_work *work) {
  char path[NAMED_MODEL_PATH_MAX];
  void *table = NULL, *windows = NULL;
  size_t size = 0;
  snprintf(path, sizeof path, "%s/%s", work->request->output, TABLE);
  if (thrum_file_read(path, &table, &size, NULL) < 0)
    return;

  snprintf(path, sizeof path, "%s/%s", work->request->output, WINDOWS);
  if (thrum_file_read(path, &windows, &size, NULL) >= 0)
    experiment_tables_read_long(table, windows, &work->runs);
  free(table);
  free(windows);
}

/* The tables of the runs that are done. */
static thrum_status write_tables(const long_work *work, thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(experiments_open(work->request, TABLE, &writer, error));
  experiment_long_csv(writer.stream, &work->runs);
  THRUM_TRY(thrum_file_writer_commit(&writer, error));

  THRUM_TRY(experiments_open(work->request, WINDOWS, &writer, error));
  experiment_windows_csv(writer.stream, &work->runs);
  return thrum_file_writer_commit(&writer, error);
}

/* After each run: the tables keep what is done, should the program be stopped. */
static bool keep(void *context, double fraction) {
  long_work *work = context;
  thrum_error error = {0};
  experiments_progress(&work->progress, fraction);
  if (write_tables(work, &error) < 0)
    config_warn("%s", error.message);
  return true;
}

thrum_status experiments_long(const experiments_request *request, const experiments_bodies *bodies,
                              bool *flagged, thrum_error *error) {
  long_work work = {.request = request, .progress = config_progress_make(request->quiet)};
  experiment_long *runs = &work.runs;
  *runs = (experiment_long){
      .bodies = bodies->bodies,
      .body_count = bodies->count,
      .amplitudes = request->amplitudes,
      .amplitude_count = request->amplitude_count,
      .dt = request->dt,
      .steps = request->steps,
      .threads = (int)request->threads,
      .progress = keep,
      .progress_context = &work,
  };
  memcpy(runs->integrators, request->integrators, sizeof runs->integrators);
  thrum_status status = experiment_long_plan(runs, error);
  if (status < 0)
    goto cleanup;

  // what an earlier call has done is not run again
  if (request->resume)
    resume(&work);
  status = experiment_long_run(runs, error);
  if (status < 0) {
    config_progress_abandon(&work.progress);
    goto cleanup;
  }

  config_progress_done(&work.progress);
  *flagged = experiment_long_flagged(runs);
  status = write_tables(&work, error);
  if (status >= 0)
    status = experiments_page(request, "long", error);
  if (status >= 0 && request->json)
    print_json(request, runs, *flagged);
  else if (status >= 0)
    print_table(runs);

cleanup:
  experiment_long_free(runs);
  return status;
}
