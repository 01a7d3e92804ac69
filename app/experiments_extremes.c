/* `thrum experiments --extremes`: bodies, loads and steps far outside the usual, and one body in
 * many units. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app/experiments.h"
#include "config/progress.h"
#include "io/json.h"
#include "validation/experiments/extremes.h"
#include "validation/experiments/tables.h"

static void print_json(const experiments_request *request, const experiment_extremes *extremes,
                       bool flagged) {
  cJSON *object = experiments_json(request, flagged);
  cJSON *runs = cJSON_AddArrayToObject(object, "runs");

  // one object for each run, with the columns of extremes.csv
  for (int64_t n = 0; n < extremes->count; n++) {
    const experiment_extreme_body *body = extremes->cases[n].body;
    const experiment_extreme_result *result = &extremes->results[n];
    cJSON *item = cJSON_CreateObject();
    cJSON_AddStringToObject(item, "subject", experiment_subject_names[body->extreme->subject]);
    cJSON_AddStringToObject(item, "case", body->extreme->name);
    cJSON_AddStringToObject(item, "integrator",
                            experiment_integrator_names[extremes->cases[n].integrator]);
    cJSON_AddStringToObject(item, "outcome",
                            experiment_extreme_outcome(&extremes->cases[n], result));
    cJSON_AddStringToObject(item, "reason", result->status < 0 ? result->stop.message : "");
    json_number(item, "dt", body->dt);
    json_number(item, "steps", (double)result->report.steps);
    json_number(item, "us_per_step", result->us_per_step);
    json_number(item, "mean_iterations",
                (double)result->report.iterations / (double)result->report.steps);
    json_number(item, "work_j", result->work);
    json_number(item, "energy_error", result->energy_error);
    json_number(item, "energy_end", result->energy_end);
    json_number(item, "peak_amplitude", result->peak_amplitude);
    experiments_json_levels(item, &result->report);
    cJSON_AddItemToArray(runs, item);
  }

  // and one for each comparison of units
  cJSON *units = cJSON_AddArrayToObject(object, "units");
  for (int64_t n = 0; n < extremes->unit_count; n++) {
    const experiment_unit_result *result = &extremes->unit_results[n];
    cJSON *item = cJSON_CreateObject();
    cJSON_AddStringToObject(item, "units", extremes->units[n].units->name);
    cJSON_AddStringToObject(item, "case", extremes->units[n].extreme->name);
    cJSON_AddStringToObject(item, "integrator",
                            experiment_integrator_names[extremes->units[n].integrator]);
    json_number(item, "difference", result->difference);
    json_number(item, "iterations", (double)result->iterations);
    json_number(item, "iterations_si", (double)result->iterations_si);
    cJSON_AddBoolToObject(item, "same_levels", result->same_levels);
    cJSON_AddItemToArray(units, item);
  }
  json_print(object);
}

static void print_table(const experiment_extremes *extremes) {
  printf("%-10s %-34s %-8s %-10s %9s %9s %6s\n", "subject", "case", "method", "outcome", "error",
         "bend", "iter.");

  // a refused body has a reason in place of numbers
  for (int64_t n = 0; n < extremes->count; n++) {
    const experiment_extreme_body *body = extremes->cases[n].body;
    const experiment_extreme_result *result = &extremes->results[n];
    printf("%-10s %-34s %-8s %-10s", experiment_subject_names[body->extreme->subject],
           body->extreme->name, experiment_integrator_names[extremes->cases[n].integrator],
           experiment_extreme_outcome(&extremes->cases[n], result));
    if (body->status >= 0 && isfinite(result->energy_error)) {
      printf(" %9.1e", result->energy_error);
    } else if (body->status >= 0) {
      printf(" %9s", "-");
    }
    if (body->status >= 0)
      printf(" %8.1f%% %6.2f", 100 * result->peak_amplitude,
             (double)result->report.iterations / (double)result->report.steps);
    printf("%s%s\n", result->status < 0 ? " " : "", result->status < 0 ? result->stop.message : "");
  }
  for (int64_t n = 0; n < extremes->unit_count; n++)
    printf("%-10s %-34s %-8s differs by %.1e\n", "units", extremes->units[n].units->name,
           experiment_integrator_names[extremes->units[n].integrator],
           extremes->unit_results[n].difference);
}

static thrum_status write_files(const experiments_request *request,
                                const experiment_extremes *extremes, thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(experiments_open(request, "extremes.csv", &writer, error));
  experiment_extremes_csv(writer.stream, extremes);
  THRUM_TRY(thrum_file_writer_commit(&writer, error));

  THRUM_TRY(experiments_open(request, "units.csv", &writer, error));
  experiment_units_csv(writer.stream, extremes);
  THRUM_TRY(thrum_file_writer_commit(&writer, error));
  return experiments_page(request, "extremes", error);
}

static bool show(void *context, const char *stage, double fraction) {
  config_progress_update(context, stage, fraction);
  return true;
}

thrum_status experiments_extremes(const experiments_request *request, bool *flagged,
                                  thrum_error *error) {
  config_progress progress = config_progress_make(request->quiet);
  experiment_extremes extremes = {
      .steps = request->steps,
      .threads = (int)request->threads,
      .progress = show,
      .progress_context = &progress,
  };
  memcpy(extremes.subjects, request->subjects, sizeof extremes.subjects);
  memcpy(extremes.integrators, request->integrators, sizeof extremes.integrators);
  thrum_status status = experiment_extremes_run(&extremes, error);
  if (status < 0) {
    config_progress_abandon(&progress);
    goto cleanup;
  }

  config_progress_done(&progress);
  *flagged = experiment_extremes_flagged(&extremes);
  status = write_files(request, &extremes, error);
  if (status >= 0 && request->json)
    print_json(request, &extremes, *flagged);
  else if (status >= 0)
    print_table(&extremes);

cleanup:
  experiment_extremes_free(&extremes);
  return status;
}
