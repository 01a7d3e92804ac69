/* `thrum experiments --linear`: how far linear modal analysis can be believed, and what the cubic
 * and quartic terms cost. SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#include "app/experiments.h"
#include "config/progress.h"
#include "io/json.h"

/* What the tasks share. */
typedef struct linear_work {
  const experiment_body *bodies;
  experiment_linear_result *results;
} linear_work;

static thrum_status run_body(void *context, int64_t index, thrum_error *error) {
  linear_work *work = context;
  return experiment_linear_run(&work->bodies[index], &work->results[index], error);
}

static void add_curve(cJSON *item, const char *key, const experiment_linear_curve *curve) {
  static const char *const names[EXPERIMENT_LINEAR_LEVELS] = {"deflection_at_5_percent",
                                                              "deflection_at_20_percent"};
  cJSON *object = cJSON_AddObjectToObject(item, key);
  for (int level = 0; level < EXPERIMENT_LINEAR_LEVELS; level++)
    json_number(object, names[level], curve->at[level].amplitude);
}

static void print_json(const experiments_request *request, const experiments_bodies *bodies,
                       const experiment_linear_result *results) {
  cJSON *object = experiments_json(request, false);
  cJSON *runs = cJSON_AddArrayToObject(object, "runs");
  for (int64_t n = 0; n < bodies->count; n++) {
    const experiment_linear_result *result = &results[n];
    cJSON *item = cJSON_CreateObject();
    json_string(item, "model", bodies->bodies[n].name);
    json_number(item, "rank", (double)bodies->models[n]->rank);
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

static void print_table(const experiments_bodies *bodies, const experiment_linear_result *results) {
  printf("%-8s %4s %35s %26s\n", "", "", "deflection [% of the length] at", "");
  printf("%-8s %4s %17s %17s %26s\n", "", "", "rest, error", "motion, error", "time [us]");
  printf("%-8s %4s %8s %8s %8s %8s %8s %8s %8s\n", "model", "rank", "5 %", "20 %", "5 %", "20 %",
         "force", "imexv", "linear");
  for (int64_t n = 0; n < bodies->count; n++) {
    const experiment_linear_result *result = &results[n];
    printf("%-8s %4lld", bodies->bodies[n].name, (long long)bodies->models[n]->rank);
    for (int level = 0; level < EXPERIMENT_LINEAR_LEVELS; level++)
      print_share(result->statics.at[level].amplitude);
    for (int level = 0; level < EXPERIMENT_LINEAR_LEVELS; level++)
      print_share(result->dynamics.at[level].amplitude);
    printf(" %8.2f %8.2f %8.3f\n", result->force_us, result->step_us, result->linear_us);
  }
}

static thrum_status write_files(const experiments_request *request,
                                const experiments_bodies *bodies,
                                const experiment_linear_result *results, thrum_error *error) {
  const experiment_place place = experiments_place(request);
  experiment_text text = {0};
  experiment_linear_csv(&text, bodies->bodies, results, bodies->count);
  thrum_status status = experiments_write(request, "linear.csv", &text, error);
  if (status < 0)
    return status;
  experiment_linear_curves_csv(&text, bodies->bodies, results, bodies->count);
  status = experiments_write(request, "linear_curves.csv", &text, error);
  if (status < 0)
    return status;
  experiment_linear_report(&text, bodies->bodies, results, bodies->count, &place);
  return experiments_write(request, "linear.html", &text, error);
}

thrum_status experiments_linear(const experiments_request *request,
                                const experiments_bodies *bodies, thrum_error *error) {
  experiment_linear_result *results = calloc((size_t)bodies->count, sizeof *results);
  if (results == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory");
  linear_work work = {bodies->bodies, results};
  config_progress progress = config_progress_make(request->quiet);
  const experiment_pool pool = {.threads = (int)request->threads,
                                .count = bodies->count,
                                .task = run_body,
                                .progress = experiments_progress,
                                .context = &work,
                                .progress_context = &progress};
  thrum_status status = experiment_pool_run(&pool, error);
  if (status >= 0)
    config_progress_done(&progress);
  else
    config_progress_abandon(&progress);
  if (status >= 0)
    status = write_files(request, bodies, results, error);
  if (status >= 0 && request->json)
    print_json(request, bodies, results);
  else if (status >= 0)
    print_table(bodies, results);
  free(results);
  return status;
}
