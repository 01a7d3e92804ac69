/* `thrum experiments --linear`: how far linear modal analysis can be believed, and what the cubic
 * and quartic terms cost. SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#include "app/experiments.h"
#include "config/progress.h"
#include "io/json.h"
#include "validation/experiments/linear_free_vibration.h"
#include "validation/experiments/tables.h"

static void add_curve(cJSON *item, const char *key, const experiment_linear_curve *curve) {
  static const char *const names[EXPERIMENT_LINEAR_LEVELS] = {"deflection_at_5_percent",
                                                              "deflection_at_20_percent"};
  cJSON *object = cJSON_AddObjectToObject(item, key);
  for (int level = 0; level < EXPERIMENT_LINEAR_LEVELS; level++)
    json_number(object, names[level], curve->at[level].amplitude);
}

static void print_json(const experiments_request *request, const experiment_linear *linear) {
  cJSON *object = experiments_json(request, false);
  cJSON *runs = cJSON_AddArrayToObject(object, "runs");

  // one object for each body
  for (int64_t n = 0; n < linear->body_count; n++) {
    const experiment_linear_result *result = &linear->results[n];
    cJSON *item = cJSON_CreateObject();
    json_string(item, "model", linear->bodies[n].name);
    json_number(item, "rank", (double)linear->bodies[n].model->rank);
    add_curve(item, "static", &result->statics);
    add_curve(item, "dynamic", &result->dynamics);
    json_number(item, "force_us", result->force_us);
    json_number(item, "step_us", result->step_us);
    json_number(item, "linear_step_us", result->linear_us);
    json_number(item, "nonlinear_us", result->step_us - result->linear_us);
    cJSON_AddItemToArray(runs, item);
  }
  json_print(object);
}

/* A share of the length in per cent, or a dash. */
static void print_share(double share) {
  if (share > 0)
    printf(" %8.2f", 100 * share);
  else
    printf(" %8s", "-");
}

static void print_table(const experiment_linear *linear) {
  printf("%-8s %4s %35s %26s\n", "", "", "deflection [% of the length] at", "");
  printf("%-8s %4s %17s %17s %26s\n", "", "", "rest, error", "motion, error", "time [us]");
  printf("%-8s %4s %8s %8s %8s %8s %8s %8s %8s\n", "model", "rank", "5 %", "20 %", "5 %", "20 %",
         "force", "imexv", "linear");

  // a deflection that no load reached is a dash
  for (int64_t n = 0; n < linear->body_count; n++) {
    const experiment_linear_result *result = &linear->results[n];
    printf("%-8s %4lld", linear->bodies[n].name, (long long)linear->bodies[n].model->rank);
    for (int level = 0; level < EXPERIMENT_LINEAR_LEVELS; level++)
      print_share(result->statics.at[level].amplitude);
    for (int level = 0; level < EXPERIMENT_LINEAR_LEVELS; level++)
      print_share(result->dynamics.at[level].amplitude);
    printf(" %8.2f %8.2f %8.3f\n", result->force_us, result->step_us, result->linear_us);
  }
}

static thrum_status write_files(const experiments_request *request, const experiment_linear *linear,
                                thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(experiments_open(request, "linear.csv", &writer, error));
  experiment_linear_csv(writer.stream, linear);
  THRUM_TRY(thrum_file_writer_commit(&writer, error));

  THRUM_TRY(experiments_open(request, "linear_curves.csv", &writer, error));
  experiment_linear_curves_csv(writer.stream, linear);
  THRUM_TRY(thrum_file_writer_commit(&writer, error));
  return experiments_page(request, "linear", error);
}

thrum_status experiments_linear(const experiments_request *request,
                                const experiments_bodies *bodies, thrum_error *error) {
  config_progress progress = config_progress_make(request->quiet);
  experiment_linear linear = {.bodies = bodies->bodies,
                              .body_count = bodies->count,
                              .threads = (int)request->threads,
                              .progress = experiments_progress,
                              .progress_context = &progress};
  thrum_status status = experiment_linear_run(&linear, error);
  if (status < 0) {
    config_progress_abandon(&progress);
    goto cleanup;
  }

  config_progress_done(&progress);
  status = write_files(request, &linear, error);
  if (status >= 0 && request->json)
    print_json(request, &linear);
  else if (status >= 0)
    print_table(&linear);

cleanup:
  free(linear.results);
  return status;
}
