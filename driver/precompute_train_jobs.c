/* precompute --train in independent jobs. What can be split are the full-order runs, which take
 * most of the time: each is a job, and is kept in the folder of --keep-runs. What follows them is
 * one basis after the other, each from the errors of the one before, and is done by --collect.
 * SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <stdio.h>
#include <unistd.h>

#include "driver/full_motion_kept.h"
#include "driver/job_list.h"
#include "driver/precompute_train.h"
#include "io/json.h"
#include "io/paths.h"

/* The calls of the list share this; the model is needed for all but the names. */
typedef struct train_jobs {
  const precompute_request *request;
  const thrum_model *model;
  config_progress *bar;
  train_outcome *outcome; /* its runs */
} train_jobs;

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

static job_list list_of(train_jobs *all) {
  return (job_list){.command = "precompute",
                    .folder = all->request->keep_runs,
                    .count = all->request->train_count + all->request->test_count,
                    .context = all,
                    .name = name_job,
                    .stamp = stamp_job,
                    .run = run_job,
                    .take = take_job};
}

thrum_status precompute_train_print(const precompute_request *request, char *const *argv,
                                    thrum_error *error) {
  train_jobs all = {.request = request};
  const job_list list = list_of(&all);
  return job_list_print(&list, argv, error);
}

thrum_status precompute_train_job(const precompute_task *task, thrum_error *error) {
  const precompute_request *request = task->request;
  train_outcome outcome = {0};
  thrum_precomputed made = {0};
  thrum_status status = precompute_train_list(request, &outcome, error);
  THRUM_THEN(status, precompute_train_first(task, &made, error));
  train_jobs all = {request, &made.model, &task->progress->bar, &outcome};
  const job_list list = list_of(&all);
  THRUM_THEN(status, job_list_run(&list, request->jobs.number, request->json, error));
  thrum_precomputed_free(&made);
  precompute_train_free(&outcome);
  return status;
}

thrum_status precompute_train_complete(const precompute_request *request, const thrum_model *model,
                                       train_outcome *outcome, thrum_error *error) {
  train_jobs all = {request, model, NULL, outcome};
  const job_list list = list_of(&all);
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
