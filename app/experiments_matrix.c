/* `thrum experiments`: the matrix of bodies, loads, dampings and integrators.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/experiments.h"
#include "config/progress.h"
#include "io/json.h"
#include "validation/experiments/run_outcome.h"
#include "validation/experiments/tables.h"

static void print_json(const experiments_request *request, const experiment_run *runs,
                       int64_t count, bool flagged) {
  cJSON *object = experiments_json(request, flagged);
  json_number(object, "dt", request->dt);
  cJSON *list = cJSON_AddArrayToObject(object, "runs");

  // one object for each run, with the columns of runs.csv
  for (int64_t n = 0; n < count; n++) {
    const experiment_run *run = &runs[n];
    cJSON *item = cJSON_CreateObject();
    json_string(item, "model", run->body->name);
    cJSON_AddStringToObject(item, "load", experiment_load_names[run->load]);
    json_number(item, "force_n", run->force);
    json_number(item, "damping", run->alpha);
    cJSON_AddStringToObject(item, "integrator", experiment_integrator_names[run->integrator]);
    cJSON_AddStringToObject(item, "status", experiment_status_name(run->status));
    json_number(item, "simulated_s", run->simulated);
    json_number(item, "us_per_step", run->us_per_step);
    json_number(item, "mean_iterations", run->mean_iterations);
    json_number(item, "energy_peak_j", run->energy_peak);
    json_number(item, "energy_end_j", run->energy_end);
    json_number(item, "high_end_j", run->high_end);
    json_number(item, "energy_change", run->energy_change);
    json_number(item, "peak_amplitude", run->peak_amplitude);
    json_number(item, "explicit_modes", run->report.explicit_modes);
    json_number(item, "implicit_modes", run->report.implicit_modes);
    experiments_json_levels(item, &run->report);
    cJSON_AddItemToArray(list, item);
  }
  json_print(object);
}

static void print_table(const experiment_run *runs, int64_t count) {
  printf("%-8s %-8s %5s %-8s %8s %8s %6s %6s %10s  %s\n", "model", "load", "damp.", "method",
         "time [s]", "us/step", "iter.", "bend", "end [J]", "status");
  for (int64_t n = 0; n < count; n++) {
    const experiment_run *run = &runs[n];
    printf("%-8s %-8s %5g %-8s %8.3f %8.2f %6.2f %5.1f%% %10.3g  %s\n", run->body->name,
           experiment_load_names[run->load], run->alpha,
           experiment_integrator_names[run->integrator], run->simulated, run->us_per_step,
           run->mean_iterations, 100 * run->peak_amplitude, run->energy_end,
           experiment_status_name(run->status));
  }
}

static thrum_status write_files(const experiments_request *request, const experiment_run *runs,
                                int64_t count, thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(experiments_open(request, "runs.csv", &writer, error));
  experiment_matrix_csv(writer.stream, runs, count);
  THRUM_TRY(thrum_file_writer_commit(&writer, error));

  THRUM_TRY(experiments_open(request, "curves.csv", &writer, error));
  experiment_curves_csv(writer.stream, runs, count);
  THRUM_TRY(thrum_file_writer_commit(&writer, error));
  return experiments_page(request, "runs", error);
}

thrum_status experiments_matrix(const experiments_request *request,
                                const experiments_bodies *bodies, bool *flagged,
                                thrum_error *error) {
  config_progress progress = config_progress_make(request->quiet);
  experiment_matrix matrix = {
      .bodies = bodies->bodies,
      .body_count = bodies->count,
      .dt = request->dt,
      .steps = request->steps,
      .threads = (int)request->threads,
      .progress = experiments_progress,
      .progress_context = &progress,
  };
  memcpy(matrix.loads, request->loads, sizeof matrix.loads);
  memcpy(matrix.integrators, request->integrators, sizeof matrix.integrators);
  const int64_t count = experiment_matrix_count(&matrix);
  experiment_run *runs = calloc((size_t)count + 1, sizeof *runs);
  if (runs == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory");

  // the files are written before anything is printed, so that a full disk is the last word
  thrum_status status = experiment_matrix_run(&matrix, runs, error);
  if (status >= 0) {
    config_progress_done(&progress);
    status = write_files(request, runs, count, error);
  } else {
    config_progress_abandon(&progress);
  }

  for (int64_t n = 0; status >= 0 && n < count; n++)
    *flagged = *flagged || runs[n].status < 0;
  if (status >= 0 && request->json) {
    print_json(request, runs, count, *flagged);
  } else if (status >= 0) {
    print_table(runs, count);
  }
  experiment_runs_free(runs, count);
  return status;
}
