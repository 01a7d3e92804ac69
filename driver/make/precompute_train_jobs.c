/* precompute --train in independent jobs. What can be split are the full-order runs, which take
 * most of the time: each is a job, and is kept in the folder of --keep-runs. What follows them is
 * one basis after the other, each from the errors of the one before, and is done by --collect.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/precompute_train.h"

thrum_status precompute_train_print(const precompute_request *request, char *const *argv,
                                    thrum_error *error) {
  train_jobs all = {.request = request};
  const job_list list = precompute_train_jobs(&all);
  return job_list_print(&list, argv, error);
}

thrum_status precompute_train_job(const precompute_task *task, thrum_error *error) {
  const precompute_request *request = task->request;
  train_outcome outcome = {0};
  thrum_precomputed made = {0};
  thrum_status status = precompute_train_list(request, &outcome, error);
  THRUM_THEN(status, precompute_train_first(task, &made, error));
  train_jobs all = {request, &made.model, &task->progress->bar, &outcome};
  const job_list list = precompute_train_jobs(&all);
  THRUM_THEN(status, job_list_run(&list, request->jobs.number, request->json, error));
  thrum_precomputed_free(&made);
  precompute_train_free(&outcome);
  return status;
}
