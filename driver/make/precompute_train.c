/* Bases trained on motion. SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/precompute_train.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/progress.h"
#include "driver/make/full_motion_kept.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "platform/memory_limit.h"
#include "platform/threads.h"
#include "precompute/model/snapshots.h"
#include "precompute/options_check.h"

#define GROWTH_LEAST 5 /* coordinates that a part of the basis grows by */

double precompute_train_bytes(const precompute_request *request, int64_t vertex_count) {
  // all runs stay, and those of the training are decomposed in a copy with its products
  const double field = 24 * (double)vertex_count, train = (double)request->train_count,
               runs = train + (double)request->test_count;
  const double columns = train * FULL_MOTION_SNAPSHOTS;
  return field * (runs + train) * FULL_MOTION_SNAPSHOTS + 8 * columns * columns;
}

/* A training that does not fit into the memory is refused before anything is run. */
static thrum_status check_memory(const precompute_request *request, int64_t vertex_count,
                                 thrum_error *error) {
  const char *whose = "of the limit given";
  const double limit = request->options.memory_limit, held = thrum_memory_resident();
  const double bytes = precompute_train_bytes(request, vertex_count);
  const double left = limit > 0 ? fmax(0, limit - held) : thrum_memory_available(&whose);
  if (bytes <= left)
    return THRUM_OK;
  return thrum_error_set(
      error, THRUM_OUT_OF_MEMORY,
      "--train and --test: the snapshots take about %.0f MB, and %.0f MB %s are left: "
      "give fewer loads at a time, or a coarser mesh",
      bytes / 1048576, left / 1048576, whose);
}

static thrum_status run_all(const precompute_request *request, const thrum_model *model,
                            config_progress *bar, train_outcome *outcome, thrum_error *error) {
  const int64_t each = FULL_MOTION_SNAPSHOTS * 3 * model->vertex_count;
  if (request->jobs.collect)
    THRUM_TRY(precompute_train_complete(request, model, outcome, error));
  THRUM_TRY(thrum_reserve(&outcome->samples, outcome->run_count * each, sizeof *outcome->samples,
                          "the training", error));

  // the full order under one load after the other
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < outcome->run_count && status >= 0; n++) {
    outcome->runs[n].u = outcome->samples + n * each;
    status = train_run_make(request, model, bar, &outcome->runs[n], error);
  }
  return status;
}

thrum_status precompute_train_base(const thrum_mesh *mesh, const uint8_t *fixed,
                                   const thrum_precompute_options *options, int64_t usual,
                                   thrum_precomputed *base, thrum_error *error) {
  // the part of the rank that is made as without a training, of modes and handles at least
  const int64_t rank = thrum_options_complete(options).rank, half = usual > 0 ? usual : rank / 2;
  const int64_t shapes = thrum_options_shapes(options), k = options->modes;
  const int64_t most = k * (k + 3) / 2 + 2 * (shapes - k);
  thrum_precompute_options first = *options;
  first.rank = shapes > half ? shapes : half;

  // few modes have few derivatives
  first.rank = first.rank < most ? first.rank : most;
  first.keep_modes = false;

  // only the shapes of this first model are used, so its points are not refined; with this law the
  // coefficients of a condensed model are made sooner than points
  first.cubature_refine = 0;
  if (first.cubature && first.law == THRUM_LAW_STVK) {
    first.cubature = false;
    first.condensed = true;
  }
  if (first.rank >= rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--train: rank %lld leaves nothing beside %lld modes%s; raise --rank",
                           (long long)rank, (long long)shapes,
                           options->handle_count > 0 ? " and handles" : "");
  return thrum_precompute(mesh, fixed, &first, base, error);
}

thrum_status precompute_train_shapes(const thrum_model *base, const double *samples, int64_t runs,
                                     thrum_precompute_options *options, double **fields,
                                     thrum_error *error) {
  const int64_t rank = thrum_options_complete(options).rank;
  const int64_t count = rank - base->rank;
  thrum_model_fem body = {0};
  int64_t found = 0;
  thrum_status status =
      thrum_reserve(fields, 3 * base->vertex_count * count, sizeof **fields, "the training", error);
  THRUM_THEN(status, thrum_model_fem_create(base, &body, error));
  THRUM_THEN(status, thrum_snapshot_shapes(base, &body, samples, runs, FULL_MOTION_SNAPSHOTS, count,
                                           *fields, &found, error));
  thrum_model_fem_free(&body);
  if (status >= 0 && found == 0)
    status = thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "--train: the loads move nothing that the basis does not show "
                             "already; do they act within --train-time?");

  // the rank falls where fewer shapes show all of the motion
  options->trained = *fields;
  options->trained_count = found;
  options->rank = base->rank + found;
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

/* The sums over the samples of a run that is judged. */
typedef struct judge {
  const thrum_model *model;
  const thrum_model_fem *body;
  const train_run *run;
  double *work;     /* 2 free components */
  double off, size; /* |U q - u|^2 and |u|^2, summed */
} judge;

static void judge_sample(void *context, int64_t index, double share, const double *q) {
  judge *j = context;
  double a[THRUM_RANK_MAX];
  (void)share;
  const double square =
      project(j->model, j->body, j->run->u + index * 3 * j->model->vertex_count, j->work, a);

  // |U q - u|^2 = |u|^2 - 2 q U^T M u + |q|^2
  j->off += square;
  j->size += square;
  for (int64_t i = 0; i < j->model->rank; i++)
    j->off += q[i] * q[i] - 2 * q[i] * a[i];
}

/* The model in one case, against the samples of the full order (design 14). */
static thrum_status judge_run(const thrum_model *model, const thrum_model_fem *body,
                              const precompute_request *request, double *work, train_run *run,
                              thrum_error *error) {
  double force[THRUM_RANK_MAX];
  double from[2 * THRUM_RANK_MAX] = {0}, to[2 * THRUM_RANK_MAX], between[2 * THRUM_RANK_MAX];
  const int64_t rank = model->rank;
  const train_case *c = &run->c;
  const full_motion_script script = train_run_script(request, c);
  judge j = {model, body, run, work, 0, 0};
  thrum_state_def def = thrum_default_state_def();
  thrum_state *state = NULL;
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  def.dt = request->train_dt;
  def.damping_alpha = request->train_damping[0];
  def.damping_beta = request->train_damping[1];
  def.plastic.yield = request->options.cubature_yield;
  def.frequency_matched = 0; // as the full order, so that the errors in time are the same
  double *directions = NULL;
  thrum_status status =
      thrum_reserve(&directions, (c->count + 1) * rank, sizeof *directions, "a load", error);
  THRUM_THEN(status, train_case_reduce(model, c, directions, error));
  THRUM_THEN(status, thrum_state_create(model, &def, &state, error));
  THRUM_THEN(status, full_motion_reduced_start(model, body, &script, from, error));
  THRUM_THEN(status, thrum_state_set(model, state, from, NULL, error));

  const int64_t steps = thrum_step_count(request->train_time, def.dt);
  for (int64_t k = 0; k < steps && status >= 0; k++) {
    thrum_load_sum(c->courses, directions, c->count, rank, k, def.dt, force);
    status = full_motion_reduced_base(model, &script, k, def.dt, force, error);
    THRUM_THEN(status, thrum_state_set_force(model, state, force, error));
    THRUM_THEN(status, thrum_step(model, state, error));
    THRUM_THEN(status, thrum_state_get(model, state, to, to + rank, error));
    if (status >= 0)
      full_motion_between(request->train_time, FULL_MOTION_SNAPSHOTS, (double)k * def.dt, def.dt,
                          rank, from, to, judge_sample, &j, between);
    memcpy(from, to, sizeof from);
  }
  thrum_state_destroy(state);
  free(directions);

  // a run that was lost has no error, which is told apart from a small one
  run->error = status >= 0 && j.size > 0 ? sqrt(fmax(j.off, 0) / j.size) : NAN;
  return status == THRUM_NOT_CONVERGED || status == THRUM_NOT_FINITE ? THRUM_OK : status;
}

/* Steps the model in all cases, and fills the errors. */
static thrum_status judge_all(const precompute_request *request, const thrum_model *model,
                              config_progress *bar, train_outcome *outcome, thrum_error *error) {
  thrum_model_fem body = {0};
  THRUM_TRY(thrum_model_fem_create(model, &body, error));
  double *work = NULL;
  thrum_status status =
      thrum_reserve(&work, 2 * body.fem.free_count, sizeof *work, "the training", error);
  for (int64_t n = 0; n < outcome->run_count && status >= 0; n++) {
    config_progress_update(bar, "errors under the loads", (double)n / (double)outcome->run_count);
    status = judge_run(model, &body, request, work, &outcome->runs[n], error);
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

/* --- shares ------------------------------------------------------------------------------------
 */

/* q = psi^T M u of the modes (k x n) at one snapshot; returns |u|^2. `work`: 2 n. */
static double mode_coordinates(const thrum_model_fem *body, const double *modes, int64_t k,
                               const double *u, double *work, double *q) {
  const int64_t n = body->fem.free_count;
  double *x = work, *product = work + n, square = 0;
  thrum_fem_gather(&body->fem, u, x);
  thrum_sparse_product(&body->mass, x, 1, product);
  for (int64_t f = 0; f < n; f++)
    square += x[f] * product[f];

  for (int64_t i = 0; i < k; i++) {
    q[i] = 0;
    for (int64_t f = 0; f < n; f++)
      q[i] += modes[i * n + f] * product[f];
  }
  return square;
}

/* Adds one run's shares: of mode i the root mean square of q_i, of its derivative by j that of the
 * q_i q_j that moves it, half of it for i = j; relative to the run's displacement. */
static void add_shares(const double *q, int64_t k, double size, double *shares) {
  int64_t next = k;
  for (int64_t i = 0; i < k; i++) {
    // the mode's own coordinate
    double square = 0;
    for (int64_t s = 0; s < FULL_MOTION_SNAPSHOTS; s++)
      square += q[s * k + i] * q[s * k + i];
    shares[i] += sqrt(square / size);

    // the shares of the mode's derivatives by itself and the modes after it
    for (int64_t j = i; j < k; j++) {
      double pair = 0;
      for (int64_t s = 0; s < FULL_MOTION_SNAPSHOTS; s++) {
        const double product = q[s * k + i] * q[s * k + j];
        pair += product * product;
      }
      shares[next++] += (i == j ? 0.5 : 1) * sqrt(pair / size);
    }
  }
}

/* The shares of modes and derivatives in the runs of the training, which the caller frees. */
static thrum_status find_shares(const precompute_task *task,
                                const thrum_precompute_options *options,
                                const train_outcome *outcome, double **shares, thrum_error *error) {
  const int64_t k = options->modes, each = FULL_MOTION_SNAPSHOTS;
  const int64_t all = 3 * task->mesh->vertex_count;
  thrum_precompute_options asked = *options;
  thrum_precomputed made = {0};
  thrum_model_fem body = {0};
  asked.rank = k;
  asked.handle_count = 0;
  asked.keep_modes = true;
  THRUM_TRY(thrum_precompute(task->mesh, task->fixed, &asked, &made, error));
  thrum_status status = thrum_model_fem_create(&made.model, &body, error);

  // modes on the free components, room for one field, and the coordinates of one run
  const int64_t n = body.fem.free_count, count = k + k * (k + 1) / 2;
  double *modes = NULL;
  THRUM_THEN(status,
             thrum_reserve(&modes, n * (k + 2) + each * k, sizeof *modes, "the training", error));
  THRUM_THEN(status, thrum_reserve(shares, count, sizeof **shares, "the training", error));
  for (int64_t i = 0; i < k && status >= 0; i++)
    thrum_fem_gather(&body.fem, made.mode_vectors + i * all, modes + i * n);

  for (int64_t r = 0; r < outcome->train_count && status >= 0; r++) {
    double *work = modes + n * k, *q = work + 2 * n, size = 0;
    for (int64_t s = 0; s < each; s++)
      size += mode_coordinates(&body, modes, k, outcome->samples + (r * each + s) * all, work,
                               q + s * k);
    if (size > 0)
      add_shares(q, k, size, *shares);
  }
  free(modes);
  thrum_model_fem_free(&body);
  thrum_precomputed_free(&made);
  return status;
}

/* --- making ------------------------------------------------------------------------------------
 */

/* The parts of a basis: modes, the rank of them and their derivatives, the rank of all. */
typedef struct trial {
  int64_t modes, usual, rank; /* usual 0: half of the rank */
} trial;

static thrum_status check_held(const thrum_precomputed *made, const char *option,
                               thrum_error *error) {
  if (made->rigid_count == 0)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "%s: nothing is held, and a free body moves away as a whole", option);
}

/* The usual part of a trial. Before anything is run, the memory of the limit must hold the model
 * and the training beside it. */
static thrum_status make_base(const precompute_task *task, const thrum_precompute_options *asked,
                              int64_t usual, bool begins, thrum_precomputed *base,
                              thrum_error *error) {
  thrum_precompute_options first = *asked;
  thrum_error detail = {0};
  const double bytes = precompute_train_bytes(task->request, task->mesh->vertex_count);
  if (begins && first.memory_limit > 0)
    first.memory_limit -= bytes;
  if (begins)
    THRUM_TRY(check_memory(task->request, task->mesh->vertex_count, error));
  const thrum_status status =
      precompute_train_base(task->mesh, task->fixed, &first, usual, base, &detail);
  if (status < 0)
    return begins && status == THRUM_OUT_OF_MEMORY
               ? thrum_error_set(error, status, "beside the %.0f MB of --train: %.300s",
                                 bytes / 1048576, detail.message)
               : thrum_error_set(error, status, "%s", detail.message);
  return check_held(base, "--train", error);
}

/* The usual model, of which a body that is held alone can be tested. */
static thrum_status make_usual(const precompute_task *task, thrum_precomputed *result,
                               thrum_error *error) {
  THRUM_TRY(check_memory(task->request, task->mesh->vertex_count, error));
  THRUM_TRY(thrum_precompute(task->mesh, task->fixed, &task->options, result, error));
  return check_held(result, "--test", error);
}

thrum_status precompute_train_first(const precompute_task *task, thrum_precomputed *made,
                                    thrum_error *error) {
  return task->request->train_count > 0 ? make_base(task, &task->options, 0, true, made, error)
                                        : make_usual(task, made, error);
}

/* The model of a trial with its errors; the full order is run where it was not before. */
static thrum_status make_trial(const precompute_task *task, const trial *t, train_outcome *outcome,
                               thrum_precomputed *result, thrum_error *error) {
  const precompute_request *request = task->request;
  precompute_progress *progress = task->progress;
  thrum_precompute_options asked = task->options;
  thrum_precomputed base = {0};
  asked.modes = t->modes;
  asked.rank = t->rank;

  const bool begins = outcome->samples == NULL;
  progress->basis = "untrained: ";
  thrum_status status = make_base(task, &asked, t->usual, begins, &base, error);
  if (begins)
    THRUM_THEN(status, run_all(request, &base.model, &progress->bar, outcome, error));

  // modes and derivatives by what they do in the training, now that it is known
  double *shares = NULL;
  if (request->by_share) {
    THRUM_THEN(status, find_shares(task, &asked, outcome, &shares, error));
    asked.shares = shares;
    thrum_precomputed_free(&base);
    THRUM_THEN(status,
               precompute_train_base(task->mesh, task->fixed, &asked, t->usual, &base, error));
  }

  // the runs of the training come first among the samples
  free(outcome->fields);
  outcome->fields = NULL;
  THRUM_THEN(status, precompute_train_shapes(&base.model, outcome->samples, outcome->train_count,
                                             &asked, &outcome->fields, error));
  outcome->field_count = asked.trained_count;
  thrum_precomputed_free(&base);
  progress->basis = "trained: ";
  THRUM_THEN(status, thrum_precompute(task->mesh, task->fixed, &asked, result, error));
  THRUM_THEN(status, judge_all(request, &result->model, &progress->bar, outcome, error));
  free(shares);
  return status;
}

/* The usual model, under the tests. */
static thrum_status make_untrained(const precompute_task *task, train_outcome *outcome,
                                   thrum_precomputed *result, thrum_error *error) {
  config_progress *bar = &task->progress->bar;
  THRUM_TRY(make_usual(task, result, error));
  THRUM_TRY(run_all(task->request, &result->model, bar, outcome, error));
  return judge_all(task->request, &result->model, bar, outcome, error);
}

/* The larger of both errors; infinite where a run is lost. */
static double worst_of(const train_outcome *outcome) {
  double worst = 0;
  for (int64_t n = 0; n < outcome->run_count; n++)
    worst = isnan(outcome->runs[n].error) ? INFINITY : fmax(worst, outcome->runs[n].error);
  return worst;
}

static int64_t half_more(int64_t count) {
  return count + (count / 2 > GROWTH_LEAST ? count / 2 : GROWTH_LEAST);
}

/* The trial after one of this rank, `shapes` of it trained. What errs under the loads of the
 * training needs more of their shapes, what errs under others more modes and derivatives. False:
 * the rank may not grow any more. */
static bool grow(const precompute_request *request, const train_outcome *outcome, int64_t rank,
                 trial *t) {
  if (rank >= request->rank_max)
    return false;
  int64_t shapes = outcome->field_count, usual = rank - shapes;
  const double wanted = request->error;
  if (!(precompute_train_error(outcome, false) <= wanted))
    shapes = half_more(shapes);
  if (outcome->run_count > outcome->train_count &&
      !(precompute_train_error(outcome, true) <= wanted))
    usual = half_more(usual);

  // the last one takes what the limit leaves it
  if (usual + shapes > request->rank_max) {
    usual = usual * request->rank_max / (usual + shapes);
    shapes = request->rank_max - usual;
  }
  t->usual = usual;
  t->rank = usual + shapes;
  t->modes = t->modes > usual / 2 ? t->modes : usual / 2;
  return true;
}

/* A line for each trial of --error. */
static void tell(const precompute_request *request, const trial *t, const train_outcome *outcome,
                 int64_t rank) {
  if (request->quiet)
    return;
  fprintf(stderr, "thrum: rank %lld of %lld modes, %lld of it trained: %.3g %% in training",
          (long long)rank, (long long)t->modes, (long long)outcome->field_count,
          100 * precompute_train_error(outcome, false));
  if (outcome->run_count > outcome->train_count)
    fprintf(stderr, ", %.3g %% in tests", 100 * precompute_train_error(outcome, true));
  fputc('\n', stderr);
}

/* The best model so far: itself, and the errors of its runs. */
typedef struct best {
  thrum_precomputed result;
  double worst;
  double *errors; /* run_count */
  int64_t field_count;
} best;

/* Keeps the better of two; `found` is empty then. */
static void keep(best *b, thrum_precomputed *found, const train_outcome *outcome) {
  const double worst = worst_of(outcome);
  const bool better = b->result.model.rank == 0 || worst < b->worst;
  if (better) {
    thrum_precomputed_free(&b->result);
    b->result = *found;
    *found = (thrum_precomputed){0};
    b->worst = worst;
    b->field_count = outcome->field_count;
    for (int64_t n = 0; n < outcome->run_count; n++)
      b->errors[n] = outcome->runs[n].error;
  }
  thrum_precomputed_free(found);
}

/* One trial, and where an error is wanted more of them until one has it. */
static thrum_status make_trials(const precompute_task *task, train_outcome *outcome, best *b,
                                thrum_error *error) {
  const precompute_request *request = task->request;
  const bool wanted = !isnan(request->error);
  trial t = {.modes = task->options.modes, .rank = thrum_options_complete(&task->options).rank};
  for (bool first = true;; first = false) {
    thrum_precomputed found = {0};
    thrum_error detail = {0};
    const thrum_status status = outcome->train_count > 0
                                    ? make_trial(task, &t, outcome, &found, &detail)
                                    : make_untrained(task, outcome, &found, &detail);
    config_progress_end(&task->progress->bar, status >= 0);

    // where the mesh has no more modes, what was there before counts
    if (status < 0) {
      thrum_precomputed_free(&found);
      if (!first && status == THRUM_INVALID_ARGUMENT)
        return THRUM_OK;
      *error = detail;
      return status;
    }

    const int64_t rank = found.model.rank;
    if (wanted)
      tell(request, &t, outcome, rank);
    keep(b, &found, outcome);
    if (!wanted || b->worst <= request->error || !grow(request, outcome, rank, &t))
      return THRUM_OK;
  }
}

thrum_status precompute_train(const precompute_task *task, train_outcome *outcome,
                              thrum_precomputed *result, thrum_error *error) {
  const double began = clock_seconds(), worked = clock_process_seconds();
  best b = {.worst = INFINITY};
  thrum_status status = precompute_train_list(task->request, outcome, error);
  THRUM_THEN(status, thrum_reserve(&b.errors, (size_t)outcome->run_count + 1, sizeof *b.errors,
                                   "the training", error));
  THRUM_THEN(status, make_trials(task, outcome, &b, error));

  // the outcome is that of the model that is kept
  for (int64_t n = 0; n < outcome->run_count && status >= 0; n++)
    outcome->runs[n].error = b.errors[n];
  outcome->field_count = b.field_count;
  outcome->missed = status >= 0 && b.worst > task->request->error;

  // what it took beside the stages of that model
  outcome->seconds = clock_seconds() - began;
  outcome->cpu_seconds = clock_process_seconds() - worked;
  outcome->peak_mb = clock_peak_mb();
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++) {
    outcome->seconds -= b.result.seconds[stage];
    outcome->cpu_seconds -= b.result.cpu_seconds[stage];
  }
  free(b.errors);
  if (status < 0)
    thrum_precomputed_free(&b.result);
  else
    *result = b.result;
  return status;
}
