/* The full-order runs of a training: each by itself, as jobs, and whether all are there.
 * SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "config/progress.h"
#include "driver/make/full_motion_kept.h"
#include "driver/make/precompute_train.h"
#include "io/json.h"
#include "io/paths.h"
#include "platform/allocate.h"
#include "platform/threads.h"

thrum_status precompute_train_list(const precompute_request *request, train_outcome *outcome,
                                   thrum_error *error) {
  const int64_t count = request->train_count + request->test_count;
  THRUM_TRY(thrum_reserve(&outcome->runs, count, sizeof *outcome->runs, "the training", error));
  for (int64_t n = 0; n < request->train_count; n++)
    outcome->runs[outcome->run_count++] = (train_run){.text = request->train[n], .error = NAN};
  for (int64_t n = 0; n < request->test_count; n++)
    outcome->runs[outcome->run_count++] =
        (train_run){.text = request->tests[n], .test = true, .error = NAN};
  outcome->train_count = request->train_count;
  return THRUM_OK;
}

void precompute_train_free(train_outcome *outcome) {
  for (int64_t n = 0; n < outcome->run_count; n++)
    train_case_free(&outcome->runs[n].c);
  free(outcome->samples);
  free(outcome->runs);
  free(outcome->fields);
  *outcome = (train_outcome){0};
}

/* --- a run ------------------------------------------------------------------------------------ */

full_motion_script train_run_script(const precompute_request *request, const train_case *c) {
  full_motion_script script = train_case_script(c);
  script.damping_alpha = request->train_damping[0];
  script.damping_beta = request->train_damping[1];
  script.time = request->train_time;
  if (!isinf(request->options.cubature_yield))
    script.yield = request->options.cubature_yield;
  return script;
}

/* Where samples go, and the bar that shows the run. */
typedef struct taker {
  train_run *run;
  int64_t all;
  config_progress *progress;
  const char *label;
} taker;

static void take(void *context, int64_t index, const double *u, const double *v, double energy) {
  const taker *t = context;
  (void)v;
  (void)energy;
  if (t->run->u != NULL)
    memcpy(t->run->u + index * t->all, u, (size_t)t->all * sizeof *u);
}

static bool show(void *context, double fraction) {
  const taker *t = context;
  config_progress_update(t->progress, t->label, fraction);
  return true;
}

thrum_status train_run_fill(const precompute_request *request, const thrum_model *model,
                            train_run *run, full_motion_script *script, thrum_error *error) {
  THRUM_TRY(train_case_parse(run->text, &run->c, error));
  THRUM_TRY(train_case_fill(model, run->test ? "test" : "train", &run->c, error));
  *script = train_run_script(request, &run->c);
  return THRUM_OK;
}

thrum_status train_run_make(const precompute_request *request, const thrum_model *model,
                            config_progress *bar, train_run *run, thrum_error *error) {
  char label[64];
  full_motion_script script;
  snprintf(label, sizeof label, "%s %.40s", run->test ? "test" : "training", run->text);
  THRUM_TRY(train_run_fill(request, model, run, &script, error));
  taker t = {run, 3 * model->vertex_count, bar, label};
  const full_motion_observer observer = {FULL_MOTION_SNAPSHOTS, take, &t, show, &t};

  // also of a run that is kept and has no steps to show
  config_progress_update(bar, label, 0);
  const thrum_threads before = thrum_threads_set(request->options.threads);
  const thrum_status status =
      full_motion_kept(request->keep_runs, model, (int)request->options.mass, &script,
                       request->train_dt, &observer, NULL, error);
  thrum_threads_restore(before);
  free(run->c.forces);
  run->c.forces = NULL;
  return status;
}

/* --- jobs ------------------------------------------------------------------------------------- */

static void name_job(void *context, int64_t job, char name[JOB_NAME_MAX]) {
  const train_jobs *all = context;
  const int64_t trained = all->request->train_count;
  snprintf(name, JOB_NAME_MAX, job < trained ? "training-%" PRId64 : "test-%" PRId64,
           job < trained ? job + 1 : job - trained + 1);
}

/* The file that the run is kept in. */
static thrum_status find_file(const train_jobs *all, int64_t job, char path[FULL_MOTION_PATH_MAX],
                              thrum_error *error) {
  const precompute_request *request = all->request;
  train_run *run = &all->outcome->runs[job];
  full_motion_script script;
  thrum_status status = train_run_fill(request, all->model, run, &script, error);
  THRUM_THEN(status,
             full_motion_kept_path(request->keep_runs, all->model, (int)request->options.mass,
                                   &script, request->train_dt, FULL_MOTION_SNAPSHOTS, path, error));
  train_case_free(&run->c);
  return status;
}

/* The name of that file says of which body, loads, times and program the run is. */
static thrum_status stamp_job(void *context, int64_t job, cJSON *stamp, thrum_error *error) {
  const train_jobs *all = context;
  char path[FULL_MOTION_PATH_MAX];
  THRUM_TRY(find_file(all, job, path, error));
  json_string(stamp, "load", all->outcome->runs[job].text);
  json_string(stamp, "run", path_basename(path));
  return THRUM_OK;
}

static thrum_status run_job(void *context, int64_t job, cJSON *result, thrum_error *error) {
  const train_jobs *all = context;
  cJSON_AddBoolToObject(result, "kept", true);
  return train_run_make(all->request, all->model, all->bar, &all->outcome->runs[job], error);
}

static thrum_status take_job(void *context, int64_t job, cJSON *result, thrum_error *error) {
  const train_jobs *all = context;
  char path[FULL_MOTION_PATH_MAX];
  (void)result;
  THRUM_TRY(find_file(all, job, path, error));
  if (access(path, R_OK) == 0)
    return THRUM_OK;
  return thrum_error_set(
      error, THRUM_MISSING,
      "%.300s: is gone; delete the folder jobs beside it, and run the jobs again", path);
}

job_list precompute_train_jobs(train_jobs *all) {
  return (job_list){.command = "precompute",
                    .folder = all->request->keep_runs,
                    .count = all->request->train_count + all->request->test_count,
                    .context = all,
                    .name = name_job,
                    .stamp = stamp_job,
                    .run = run_job,
                    .take = take_job};
}

thrum_status precompute_train_complete(const precompute_request *request, const thrum_model *model,
                                       train_outcome *outcome, thrum_error *error) {
  train_jobs all = {request, model, NULL, outcome};
  const job_list list = precompute_train_jobs(&all);
  cJSON *missing = cJSON_CreateArray();
  thrum_status status = job_list_collect(&list, missing, error);

  // a model of a part of its training would be another model
  char text[JOB_MISSING_MAX];
  if (status >= 0 && cJSON_GetArraySize(missing) > 0)
    status = thrum_error_set(error, THRUM_MISSING, "the training is not whole: %.350s",
                             job_list_missing(&list, missing, text));
  cJSON_Delete(missing);
  return status;
}
