/* Bases trained on motion. SPDX-License-Identifier: Apache-2.0 */
#include "driver/precompute_train.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/progress.h"
#include "driver/load_spec.h"
#include "platform/allocate.h"
#include "platform/threads.h"
#include "precompute/full/full.h"
#include "precompute/model/snapshots.h"

#define TRAIN_DT 0.003 /* of the full order and of the runs that are measured against it [s] */

/* One load on the unreduced body and the steps that it is run for. */
typedef struct course {
  load_spec load;
  double *forces; /* 3 vertex_count, at full strength */
  int64_t steps;
} course;

static thrum_status course_open(const precompute_request *request, const thrum_model *model,
                                const char *text, course *c, thrum_error *error) {
  *c = (course){.steps = thrum_step_count(request->train_time, TRAIN_DT)};
  THRUM_TRY(load_spec_parse(text, &c->load, error));
  c->forces = thrum_allocate(3 * model->vertex_count, sizeof *c->forces, "a load", error);
  if (c->forces == NULL)
    return THRUM_OUT_OF_MEMORY;
  memset(c->forces, 0, 3 * (size_t)model->vertex_count * sizeof *c->forces);
  return load_spec_fill(model, &c->load, c->forces, error);
}

/* The sample that the step `k` ends at; -1: none. */
static int64_t sample_at(const course *c, int64_t k) {
  const int64_t sample = (k + 1) * TRAIN_SAMPLES / c->steps;
  return sample > k * TRAIN_SAMPLES / c->steps ? sample - 1 : -1;
}

/* The full order under one load, its samples into run->u. */
static thrum_status run_full(const thrum_model *model, const course *c, const char *label,
                             config_progress *progress, train_run *run, thrum_error *error) {
  const int64_t all = 3 * model->vertex_count;
  thrum_full_def def = thrum_default_full_def();
  thrum_full *full = NULL;
  def.dt = TRAIN_DT;
  double *forces = thrum_allocate(all, sizeof *forces, "the training", error);
  thrum_status status = forces ? THRUM_OK : THRUM_OUT_OF_MEMORY;
  THRUM_THEN(status, thrum_full_create(model, NULL, &def, &full, error));

  // displacements at equally spaced steps; a step fills all samples that it passes
  int64_t next = 0;
  for (int64_t k = 0; k < c->steps && status >= 0; k++) {
    const double mean = thrum_load_mean(&c->load.course, k, TRAIN_DT);
    for (int64_t i = 0; i < all; i++)
      forces[i] = mean * c->forces[i];
    status = thrum_full_set_force(full, forces, error);
    THRUM_THEN(status, thrum_full_step(full, error));
    for (const int64_t sample = sample_at(c, k); status >= 0 && next <= sample; next++)
      thrum_full_get(full, run->u + next * all, NULL);
    config_progress_update(progress, label, (double)(k + 1) / (double)c->steps);
  }

  thrum_full_free(full);
  free(forces);
  return status;
}

static thrum_status run_all(const precompute_request *request, const thrum_model *model,
                            train_outcome *outcome, thrum_error *error) {
  const int64_t each = TRAIN_SAMPLES * 3 * model->vertex_count;
  outcome->samples =
      thrum_allocate(outcome->run_count * each, sizeof *outcome->samples, "the training", error);
  if (outcome->samples == NULL)
    return THRUM_OUT_OF_MEMORY;

  // the full order under one load after the other
  config_progress progress = config_progress_make(request->quiet);
  const thrum_threads before = thrum_threads_set(request->options.threads);
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < outcome->run_count && status >= 0; n++) {
    train_run *run = &outcome->runs[n];
    course c = {.forces = NULL};
    char label[64];
    snprintf(label, sizeof label, "%s %.40s", run->test ? "test" : "training", run->text);
    status = course_open(request, model, run->text, &c, error);
    run->u = outcome->samples + n * each;
    THRUM_THEN(status, run_full(model, &c, label, &progress, run, error));
    free(c.forces);
  }
  thrum_threads_restore(before);
  config_progress_end(&progress, status >= 0);
  return status;
}

static thrum_status list_runs(const precompute_request *request, train_outcome *outcome,
                              thrum_error *error) {
  const int64_t count = request->train_count + request->test_count;
  outcome->runs = calloc((size_t)count, sizeof *outcome->runs);
  if (outcome->runs == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the training");
  for (int64_t n = 0; n < request->train_count; n++)
    outcome->runs[outcome->run_count++] = (train_run){.text = request->train[n], .error = NAN};
  for (int64_t n = 0; n < request->test_count; n++)
    outcome->runs[outcome->run_count++] =
        (train_run){.text = request->tests[n], .test = true, .error = NAN};
  outcome->train_count = request->train_count;
  return THRUM_OK;
}

/* The shapes of what the basis of `model` leaves of the runs of the training. */
static thrum_status find_shapes(const thrum_model *model, int64_t count, train_outcome *outcome,
                                thrum_error *error) {
  thrum_model_fem body = {0};
  outcome->fields = thrum_allocate(3 * model->vertex_count * count, sizeof *outcome->fields,
                                   "the training", error);
  thrum_status status = outcome->fields ? THRUM_OK : THRUM_OUT_OF_MEMORY;
  THRUM_THEN(status, thrum_model_fem_create(model, &body, error));

  // the runs of the training come first
  THRUM_THEN(status, thrum_snapshot_shapes(model, &body, outcome->samples, outcome->train_count,
                                           TRAIN_SAMPLES, count, outcome->fields,
                                           &outcome->field_count, error));
  thrum_model_fem_free(&body);
  return status;
}

thrum_status precompute_train(const precompute_request *request, const thrum_mesh *mesh,
                              const uint8_t *fixed, thrum_precompute_options *options,
                              train_outcome *outcome, thrum_error *error) {
  // the part of the rank that is made as without a training
  const int64_t rank = options->rank > 0 ? options->rank : 2 * options->modes;
  const int64_t usual = options->modes > rank / 2 ? options->modes : rank / 2;
  if (usual >= rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--train: rank %lld leaves nothing beside %lld modes; raise --rank",
                           (long long)rank, (long long)options->modes);

  thrum_precompute_options first = *options;
  thrum_precomputed base = {0};
  first.rank = usual;
  first.keep_modes = false;
  thrum_status status = list_runs(request, outcome, error);
  THRUM_THEN(status, thrum_precompute(mesh, fixed, &first, &base, error));
  if (status >= 0 && base.rigid_count > 0)
    status = thrum_error_set(error, THRUM_UNSUPPORTED,
                             "--train: nothing is held, and a free body moves away as a whole");
  THRUM_THEN(status, run_all(request, &base.model, outcome, error));
  THRUM_THEN(status, find_shapes(&base.model, rank - usual, outcome, error));
  if (status >= 0 && outcome->field_count == 0)
    status = thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "--train: the loads move nothing that the basis does not show "
                             "already; do they act within --train-time?");
  thrum_precomputed_free(&base);

  options->trained = outcome->fields;
  options->trained_count = outcome->field_count;
  options->rank = usual + outcome->field_count;
  return status;
}

/* --- judging -----------------------------------------------------------------------------------
 */

/* a = U^T M u, and |u|^2. */
static double project(const thrum_model *model, const thrum_model_fem *body, const double *u,
                      double *work, double *a) {
  const int64_t n = body->fem.free_count, rank = model->rank;
  double *free_ones = work, *product = work + n, square = 0;
  thrum_fem_gather(&body->fem, u, free_ones);
  thrum_sparse_product(&body->mass, free_ones, 1, product);
  memset(a, 0, (size_t)rank * sizeof *a);
  for (int64_t f = 0; f < n; f++) {
    const double *row = model->basis + body->fem.component[f] * rank;
    square += free_ones[f] * product[f];
    for (int64_t i = 0; i < rank; i++)
      a[i] += row[i] * product[f];
  }
  return square;
}

/* The model under one load, against the samples of the full order (design 14). */
static thrum_status judge_run(const thrum_model *model, const thrum_model_fem *body,
                              const course *c, double *work, train_run *run, thrum_error *error) {
  double reduced[THRUM_RANK_MAX], force[THRUM_RANK_MAX], q[THRUM_RANK_MAX], a[THRUM_RANK_MAX];
  const int64_t all = 3 * model->vertex_count, rank = model->rank;
  thrum_state_def def = thrum_default_state_def();
  thrum_state *state = NULL;
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  def.dt = TRAIN_DT;
  def.frequency_matched = 0; // as the full order, so that the errors in time are the same
  THRUM_TRY(load_spec_reduce(model, &c->load, reduced, error));
  THRUM_TRY(thrum_state_create(model, &def, &state, error));

  double off = 0, size = 0;
  int64_t next = 0;
  thrum_status status = THRUM_OK;
  for (int64_t k = 0; k < c->steps && status >= 0; k++) {
    const double mean = thrum_load_mean(&c->load.course, k, TRAIN_DT);
    for (int64_t i = 0; i < rank; i++)
      force[i] = mean * reduced[i];
    status = thrum_state_set_force(model, state, force, error);
    THRUM_THEN(status, thrum_step(model, state, error));
    THRUM_THEN(status, thrum_state_get(model, state, q, NULL, error));

    // |U q - u|^2 = |u|^2 - 2 q U^T M u + |q|^2
    for (const int64_t sample = sample_at(c, k); status >= 0 && next <= sample; next++) {
      const double square = project(model, body, run->u + next * all, work, a);
      off += square;
      size += square;
      for (int64_t i = 0; i < rank; i++)
        off += q[i] * q[i] - 2 * q[i] * a[i];
    }
  }
  thrum_state_destroy(state);

  // a run that was lost has no error, which is told apart from a small one
  run->error = status >= 0 && size > 0 ? sqrt(fmax(off, 0) / size) : NAN;
  return status == THRUM_NOT_CONVERGED || status == THRUM_NOT_FINITE ? THRUM_OK : status;
}

thrum_status precompute_train_judge(const precompute_request *request, const thrum_model *model,
                                    train_outcome *outcome, thrum_error *error) {
  thrum_model_fem body = {0};
  THRUM_TRY(thrum_model_fem_create(model, &body, error));
  double *work = thrum_allocate(2 * body.fem.free_count, sizeof *work, "the training", error);
  thrum_status status = work ? THRUM_OK : THRUM_OUT_OF_MEMORY;
  for (int64_t n = 0; n < outcome->run_count && status >= 0; n++) {
    course c = {.forces = NULL};
    status = course_open(request, model, outcome->runs[n].text, &c, error);
    THRUM_THEN(status, judge_run(model, &body, &c, work, &outcome->runs[n], error));
    free(c.forces);
  }
  free(work);
  thrum_model_fem_free(&body);
  return status;
}

double precompute_train_error(const train_outcome *outcome, bool test) {
  double worst = NAN;
  for (int64_t n = 0; n < outcome->run_count; n++) {
    const train_run *run = &outcome->runs[n];
    if (run->test == test && (isnan(run->error) || !(run->error <= worst)))
      worst = run->error;
    if (run->test == test && isnan(run->error))
      return NAN;
  }
  return worst;
}

void precompute_train_free(train_outcome *outcome) {
  free(outcome->samples);
  free(outcome->runs);
  free(outcome->fields);
  *outcome = (train_outcome){0};
}
