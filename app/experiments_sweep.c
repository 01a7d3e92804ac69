/* `thrum experiments --sweep`: the sweep over time steps.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "app/experiments.h"
#include "config/progress.h"
#include "io/json.h"
#include "validation/experiments/sweep.h"
#include "validation/experiments/tables.h"

static void print_json(const experiments_request *request, const experiment_sweep *sweep,
                       bool flagged) {
  cJSON *object = experiments_json(request, flagged);
  cJSON *runs = cJSON_AddArrayToObject(object, "runs");

  // one object for each run, with the columns of sweep.csv
  for (int64_t n = 0; n < sweep->count; n++) {
    const experiment_sweep_case *run = &sweep->cases[n];
    const experiment_sweep_result *result = &sweep->results[n];
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

static void print_table(const experiment_sweep *sweep) {
  printf("%-8s %-8s %7s %8s %8s %6s %10s %10s  %s\n", "model", "method", "dt [s]", "time [s]",
         "us/step", "iter.", "error", "change", "status");
  for (int64_t n = 0; n < sweep->count; n++) {
    const experiment_sweep_case *run = &sweep->cases[n];
    const experiment_sweep_result *result = &sweep->results[n];
    printf("%-8s %-8s %7g %8.3f %8.2f %6.2f", run->body->name,
           experiment_integrator_names[run->integrator], run->dt, result->simulated,
           result->us_per_step, (double)result->report.iterations / (double)result->report.steps);

    // the size of the error of a lost run says nothing
    if (result->lost) {
      printf(" %10s %10s", "-", "-");
    } else {
      printf(" %10.1e %10.1e", result->energy_error, result->energy_change);
    }
    printf("  %s\n", experiment_sweep_status(result));
  }
}

static thrum_status write_files(const experiments_request *request, const experiment_sweep *sweep,
                                thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(experiments_open(request, "sweep.csv", &writer, error));
  experiment_sweep_csv(writer.stream, sweep);
  THRUM_TRY(thrum_file_writer_commit(&writer, error));
  return experiments_page(request, "sweep", error);
}

thrum_status experiments_sweep(const experiments_request *request, const experiments_bodies *bodies,
                               bool *flagged, thrum_error *error) {
  config_progress progress = config_progress_make(request->quiet);
  experiment_sweep sweep = {
      .bodies = bodies->bodies,
      .body_count = bodies->count,
      .amplitude = request->amplitudes[0],
      .time = request->time,
      .threads = (int)request->threads,
      .progress = experiments_progress,
      .progress_context = &progress,
  };
  memcpy(sweep.integrators, request->integrators, sizeof sweep.integrators);
  thrum_status status = experiment_sweep_run(&sweep, error);
  if (status < 0) {
    config_progress_abandon(&progress);
    goto cleanup;
  }

  config_progress_done(&progress);
  *flagged = experiment_sweep_flagged(&sweep);
  status = write_files(request, &sweep, error);
  if (status >= 0 && request->json)
    print_json(request, &sweep, *flagged);
  else if (status >= 0)
    print_table(&sweep);

cleanup:
  experiment_sweep_free(&sweep);
  return status;
}
