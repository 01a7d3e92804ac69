/* precompute --train: a basis that also shows what the full order does under loads.
 *
 * Half of the rank, and at least the linear modes, is the usual basis. The full order is run under
 * each load; what that half cannot show of its motion becomes the other half. The error on the
 * loads of the training and on others, which were in none, says what it is worth.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_PRECOMPUTE_TRAIN_H
#define THRUM_DRIVER_MAKE_PRECOMPUTE_TRAIN_H

#include "driver/make/precompute_progress.h"
#include "driver/make/train_case.h"
#include "driver/spec/job_list.h"

/* One case, its full-order run, and the error of the model in it. */
typedef struct train_run {
  const char *text;
  bool test;
  train_case c; /* owned; its forces only while it is run */
  double *u;    /* its samples, in those of the outcome */
  double error; /* rms of the displacement against the full order [1]; NaN: the run was lost */
} train_run;

/* The outcome; a zeroed one has no runs. */
typedef struct train_outcome {
  train_run *runs; /* owned: those of the training, then those of the test */
  int64_t run_count, train_count;
  double *samples; /* run_count x FULL_MOTION_SNAPSHOTS x 3 vertex_count: displacements at equally
                      spaced times; owned */
  double *fields;  /* field_count x 3 vertex_count: shapes for the basis; owned */
  int64_t field_count;
  bool missed;                 /* the error that was wanted is not reached */
  double seconds, cpu_seconds; /* all that it took beside the stages of the model that is kept */
  double peak_mb;              /* most memory of the process until its end [2^20 bytes] */
} train_outcome;

/* Runs the full order of the mesh in all cases of the request, makes a basis that shows what it
 * does, and steps it in all of them; with no training the basis is the usual one, and only judged.
 * Where the request has an error, modes, derivatives and shapes grow until no load errs by more, up
 * to its rank_max; the best is kept. The progress of the task shows the runs as well.
 * precompute_train_free frees the outcome, whatever came back. */
thrum_status precompute_train(const precompute_task *task, train_outcome *outcome,
                              thrum_precomputed *result, thrum_error *error);

/* The same in parts, for samples that are there already: the model of the usual part of the basis
 * that the options ask for (`usual` of the rank; 0: half, and at least the modes), and what that
 * leaves of `samples` (runs x FULL_MOTION_SNAPSHOTS x 3 vertex_count), which `options` get, with
 * the rank that it leaves them, and *fields holds; the caller frees it. */
thrum_status precompute_train_base(const thrum_mesh *mesh, const uint8_t *fixed,
                                   const thrum_precompute_options *options, int64_t usual,
                                   thrum_precomputed *base, thrum_error *error);
thrum_status precompute_train_shapes(const thrum_model *base, const double *samples, int64_t runs,
                                     thrum_precompute_options *options, double **fields,
                                     thrum_error *error);

/* The parts of a training that is split into jobs, one for each run: the list of the runs, the
 * model that they are filled with (starts by modes are those of its basis), a run with its script,
 * and the run itself, which is kept where the request says; its samples go to run->u, NULL:
 * nowhere. */
thrum_status precompute_train_list(const precompute_request *request, train_outcome *outcome,
                                   thrum_error *error);
thrum_status precompute_train_first(const precompute_task *task, thrum_precomputed *made,
                                    thrum_error *error);
/* A case on the unreduced body. */
full_motion_script train_run_script(const precompute_request *request, const train_case *c);
thrum_status train_run_fill(const precompute_request *request, const thrum_model *model,
                            train_run *run, full_motion_script *script, thrum_error *error);
thrum_status train_run_make(const precompute_request *request, const thrum_model *model,
                            config_progress *bar, train_run *run, thrum_error *error);

/* The jobs of a training are its runs; the model is needed for all but their names. */
typedef struct train_jobs {
  const precompute_request *request;
  const thrum_model *model;
  config_progress *bar;
  train_outcome *outcome; /* its runs */
} train_jobs;
job_list precompute_train_jobs(train_jobs *all);

/* Prints the jobs of a training, or does one of them. argv is that of the command. */
thrum_status precompute_train_print(const precompute_request *request, char *const *argv,
                                    thrum_error *error);
thrum_status precompute_train_job(const precompute_task *task, thrum_error *error);
/* Refuses a training that lacks runs, and names their jobs. */
thrum_status precompute_train_complete(const precompute_request *request, const thrum_model *model,
                                       train_outcome *outcome, thrum_error *error);

/* Bytes that a training of the request takes beside the precompute of a mesh of so many vertices:
 * its snapshots, and their decomposition; 0 without one. */
double precompute_train_bytes(const precompute_request *request, int64_t vertex_count);

void precompute_train_free(train_outcome *outcome);

/* The largest error of the runs of the training, or of the test; NaN: there is none, or one was
 * lost. */
double precompute_train_error(const train_outcome *outcome, bool test);

#endif
