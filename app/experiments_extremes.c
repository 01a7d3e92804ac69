/* `thrum experiments --extremes`: bodies, loads and steps far outside the usual, and one body in
 * many units. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/experiments.h"
#include "config/progress.h"
#include "io/json.h"

/* What the tasks share. The cases go by body, integrator, the last fastest; so do the units. */
typedef struct extremes_work {
  experiment_extreme_body *bodies;
  int64_t body_count;
  experiment_extreme_case *cases;
  experiment_extreme_result *results;
  int64_t count;
  experiment_unit_case *units;
  experiment_unit_result *unit_results;
  int64_t unit_count;
  config_progress progress;
} extremes_work;

static thrum_status run_case(void *context, int64_t index, thrum_error *error) {
  extremes_work *work = context;
  return experiment_extreme_run(&work->cases[index], &work->results[index], error);
}

static thrum_status allocate(extremes_work *work, thrum_error *error) {
  const size_t bodies = (size_t)experiment_extreme_count(),
               cases = bodies * EXPERIMENT_INTEGRATOR_COUNT;
  const size_t units =
      (size_t)experiment_unit_count() * EXPERIMENT_UNIT_EXTREMES * EXPERIMENT_INTEGRATOR_COUNT;
  work->bodies = calloc(bodies, sizeof *work->bodies);
  work->cases = calloc(cases, sizeof *work->cases);
  work->results = calloc(cases, sizeof *work->results);
  work->units = calloc(units, sizeof *work->units);
  work->unit_results = calloc(units, sizeof *work->unit_results);
  if (work->bodies == NULL || work->cases == NULL || work->results == NULL || work->units == NULL ||
      work->unit_results == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory");
  return THRUM_OK;
}

static void release(extremes_work *work) {
  for (int64_t n = 0; n < work->body_count; n++)
    experiment_extreme_free(&work->bodies[n]);
  free(work->bodies);
  free(work->cases);
  free(work->results);
  free(work->units);
  free(work->unit_results);
}

/* The bodies asked for, one after the other, and a case for each and each integrator. */
static thrum_status make_bodies(const experiments_request *request, extremes_work *work,
                                thrum_error *error) {
  const int64_t all = experiment_extreme_count();
  for (int64_t n = 0; n < all; n++) {
    const experiment_extreme *extreme = &experiment_extremes[n];
    config_progress_update(&work->progress, "bodies", (double)n / (double)all);
    if (!request->subjects[extreme->subject])
      continue;
    experiment_extreme_body *body = &work->bodies[work->body_count];
    const thrum_status status = experiment_extreme_make(extreme, body, error);
    if (status < 0)
      return status;
    work->body_count++;
    const int64_t share = extreme->steps_share > 0 ? extreme->steps_share : 1;
    const int64_t steps = request->steps / share > 1 ? request->steps / share : 2;
    for (int i = 0; i < EXPERIMENT_INTEGRATOR_COUNT; i++) {
      if (request->integrators[i])
        work->cases[work->count++] =
            (experiment_extreme_case){body, (experiment_integrator)i, steps};
    }
  }
  return THRUM_OK;
}

/* The units, one after the other: each makes its bodies. */
static thrum_status run_units(const experiments_request *request, extremes_work *work,
                              thrum_error *error) {
  for (int e = 0; e < EXPERIMENT_UNIT_EXTREMES; e++) {
    const experiment_extreme *extreme = &experiment_unit_extremes[e];
    if (!request->subjects[extreme->subject])
      continue;
    for (int64_t u = 1; u < experiment_unit_count(); u++) {
      for (int i = 0; i < EXPERIMENT_INTEGRATOR_COUNT; i++) {
        if (request->integrators[i])
          work->units[work->unit_count++] = (experiment_unit_case){
              extreme, &experiment_unit_systems[u], (experiment_integrator)i,
              // beyond some hundred steps the motion itself magnifies the last digit
              request->steps < EXPERIMENTS_UNIT_STEPS ? request->steps : EXPERIMENTS_UNIT_STEPS};
      }
    }
  }
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < work->unit_count && status >= 0; n++) {
    config_progress_update(&work->progress, "units", (double)n / (double)work->unit_count);
    status = experiment_units_run(&work->units[n], &work->unit_results[n], error);
  }
  return status;
}

static thrum_status run_all(const experiments_request *request, extremes_work *work,
                            thrum_error *error) {
  thrum_status status = make_bodies(request, work, error);
  const experiment_pool pool = {
      .threads = (int)request->threads,
      .count = work->count,
      .task = run_case,
      .progress = experiments_progress,
      .context = work,
      .progress_context = &work->progress,
  };
  if (status >= 0)
    status = experiment_pool_run(&pool, error);
  if (status >= 0)
    status = run_units(request, work, error);
  if (status >= 0) {
    config_progress_done(&work->progress);
  } else {
    config_progress_abandon(&work->progress);
  }
  return status;
}

static void print_json(const experiments_request *request, const extremes_work *work,
                       bool flagged) {
  cJSON *object = experiments_json(request, flagged);
  cJSON *runs = cJSON_AddArrayToObject(object, "runs");
  for (int64_t n = 0; n < work->count; n++) {
    const experiment_extreme_body *body = work->cases[n].body;
    const experiment_extreme_result *result = &work->results[n];
    cJSON *item = cJSON_CreateObject();
    cJSON_AddStringToObject(item, "subject", experiment_subject_names[body->extreme->subject]);
    cJSON_AddStringToObject(item, "case", body->extreme->name);
    cJSON_AddStringToObject(item, "integrator",
                            experiment_integrator_names[work->cases[n].integrator]);
    cJSON_AddStringToObject(item, "outcome", experiment_extreme_outcome(&work->cases[n], result));
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
  cJSON *units = cJSON_AddArrayToObject(object, "units");
  for (int64_t n = 0; n < work->unit_count; n++) {
    const experiment_unit_result *result = &work->unit_results[n];
    cJSON *item = cJSON_CreateObject();
    cJSON_AddStringToObject(item, "units", work->units[n].units->name);
    cJSON_AddStringToObject(item, "case", work->units[n].extreme->name);
    cJSON_AddStringToObject(item, "integrator",
                            experiment_integrator_names[work->units[n].integrator]);
    json_number(item, "difference", result->difference);
    json_number(item, "iterations", (double)result->iterations);
    json_number(item, "iterations_si", (double)result->iterations_si);
    cJSON_AddBoolToObject(item, "same_levels", result->same_levels);
    cJSON_AddItemToArray(units, item);
  }
  json_print(object);
}

static void print_table(const extremes_work *work) {
  printf("%-10s %-34s %-8s %-10s %9s %9s %6s\n", "subject", "case", "method", "outcome", "error",
         "bend", "iter.");
  for (int64_t n = 0; n < work->count; n++) {
    const experiment_extreme_body *body = work->cases[n].body;
    const experiment_extreme_result *result = &work->results[n];
    printf("%-10s %-34s %-8s %-10s", experiment_subject_names[body->extreme->subject],
           body->extreme->name, experiment_integrator_names[work->cases[n].integrator],
           experiment_extreme_outcome(&work->cases[n], result));
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
  for (int64_t n = 0; n < work->unit_count; n++)
    printf("%-10s %-34s %-8s differs by %.1e\n", "units", work->units[n].units->name,
           experiment_integrator_names[work->units[n].integrator],
           work->unit_results[n].difference);
}

static thrum_status write_files(const experiments_request *request, const extremes_work *work,
                                thrum_error *error) {
  experiment_text text = {0};
  experiment_extremes_csv(&text, work->cases, work->results, work->count);
  thrum_status status = experiments_write(request, "extremes.csv", &text, error);
  if (status < 0)
    return status;
  experiment_units_csv(&text, work->units, work->unit_results, work->unit_count);
  status = experiments_write(request, "units.csv", &text, error);
  if (status < 0)
    return status;
  const experiment_place place = experiments_place(request);
  experiment_extremes_report(&text, work->cases, work->results, work->count, work->units,
                             work->unit_results, work->unit_count, &place);
  return experiments_write(request, "extremes.html", &text, error);
}

thrum_status experiments_extremes(const experiments_request *request, bool *flagged,
                                  thrum_error *error) {
  extremes_work work = {.progress = config_progress_make(request->quiet)};
  thrum_status status = allocate(&work, error);
  if (status >= 0)
    status = run_all(request, &work, error);
  // newmark may lose its energy, for that is what it does; the others may not
  for (int64_t n = 0; status >= 0 && n < work.count; n++) {
    const char *outcome = experiment_extreme_outcome(&work.cases[n], &work.results[n]);
    const bool bad = strcmp(outcome, "stopped") == 0 || strcmp(outcome, "lost") == 0;
    *flagged = *flagged || strcmp(outcome, "not_finite") == 0 ||
               (bad && work.cases[n].integrator != EXPERIMENT_newmark);
  }
  if (status >= 0)
    status = write_files(request, &work, error);
  if (status >= 0 && request->json) {
    print_json(request, &work, *flagged);
  } else if (status >= 0) {
    print_table(&work);
  }
  release(&work);
  return status;
}
