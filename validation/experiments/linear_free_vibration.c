/* See validation/experiments/linear_free_vibration.h. At rest: thrum_equilibrium against f_i /
 * omega_i^2. In motion: one period of the lowest mode after an impulse, both with the integrator
 * that conserves energy and its step, so that its own error in time is common to both.
 * SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/linear_free_vibration.h"

#include <math.h>

#include "core/base/pi.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "platform/thread_pool.h"
#include "thrum/equilibrium.h"
#include "thrum/polynomial.h"

#define FIRST 1e-3 /* amplitude that the first load would give a linear body */
#define LAST 3.0   /* and the last; what bends it less than this is not looked for */
#define BISECTIONS 12
#define STEPS 400 /* of a period of the lowest mode */
#define AMPLITUDE 0.05
#define BATCHES 7
#define BATCH_SECONDS 0.02

const double experiment_linear_levels[EXPERIMENT_LINEAR_LEVELS] = {0.05, 0.2};

/* The two models of a search. `linear` is the body without its cubic and quartic terms. */
typedef struct search {
  const experiment_body *body;
  thrum_model linear;
  double *zeros;
  void *workspace; /* of thrum_equilibrium */
  size_t workspace_size;
  thrum_scope memory; /* of these two */
} search;

static thrum_status search_make(const experiment_body *body, search *s, thrum_error *error) {
  const thrum_model *model = body->model;
  search made = {.body = body, .linear = *model};
  THRUM_TRY(thrum_equilibrium_size(model, &made.workspace_size, error));
  const int64_t cubic = thrum_c3_count(model->rank), quartic = thrum_c4_count(model->rank);
  made.memory = thrum_scope_begin(body->name, error);
  made.zeros = thrum_scope_allocate(&made.memory, cubic + quartic, sizeof *made.zeros);
  made.workspace = thrum_scope_allocate_aligned(&made.memory, made.workspace_size);

  // the linear model is the same one with coefficients of zero
  made.linear.c3 = made.zeros;
  made.linear.c4 = made.zeros;
  made.linear.c3_count = cubic;
  made.linear.c4_count = quartic;
  made.linear.point_weights = made.linear.point_moduli = made.linear.point_gradients = NULL;
  made.linear.point_training = NULL;
  made.linear.point_count = 0;
  // what is packed is still the nonlinear one
  made.linear.packed = NULL;
  made.linear.packed_single = NULL;
  *s = made;
  return made.memory.status;
}

static double difference(int64_t rank, const double *a, const double *b) {
  double sum = 0;
  for (int64_t i = 0; i < rank; i++)
    sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

static double square(int64_t rank, const double *a) {
  double sum = 0;
  for (int64_t i = 0; i < rank; i++)
    sum += a[i] * a[i];
  return sum;
}

/* At rest under `load` N. A load that cannot be followed has no point. */
static bool rest(const search *s, double load, experiment_linear_point *point) {
  const thrum_model *model = s->body->model;
  const thrum_equilibrium_def def = thrum_default_equilibrium_def();
  thrum_equilibrium_report report;
  double force[THRUM_RANK_MAX], q[THRUM_RANK_MAX] = {0}, straight[THRUM_RANK_MAX];

  // the linear answer is one division for each mode
  for (int64_t i = 0; i < model->rank; i++) {
    force[i] = load * s->body->push[i];
    straight[i] = force[i] / model->omega2[i];
  }

  // a jump means that another branch was reached: no point of this curve
  if (thrum_equilibrium(model, &def, force, q, s->workspace, s->workspace_size, &report, NULL) <
          0 ||
      report.jumps > 0)
    return false;

  point->load = load;
  point->amplitude = experiment_body_amplitude(s->body, q);
  point->error = sqrt(difference(model->rank, straight, q) / square(model->rank, q));
  return true;
}

/* One of two states side by side. */
static thrum_status start(const search *s, const thrum_model *model, double impulse,
                          thrum_state **state, thrum_error *error) {
  thrum_state_def def = thrum_default_state_def();
  double p[THRUM_RANK_MAX];
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  def.dt = THRUM_TWO_PI / sqrt(model->omega2[0]) / STEPS;
  for (int64_t i = 0; i < model->rank; i++)
    p[i] = impulse * s->body->push[i];
  thrum_status status = thrum_state_create(model, &def, state, error);
  return status < 0 ? status : thrum_state_set(model, *state, NULL, p, error);
}

/* A period after an impulse of `load` N s. */
static bool swing(const search *s, double load, experiment_linear_point *point) {
  const thrum_model *models[2] = {s->body->model, &s->linear};
  const int64_t rank = models[0]->rank;
  double q[2][THRUM_RANK_MAX], wrong = 0, whole = 0, peak = 0;
  thrum_state *state[2] = {NULL, NULL};
  bool done = start(s, models[0], load, &state[0], NULL) >= 0 &&
              start(s, models[1], load, &state[1], NULL) >= 0;

  // both models step side by side; the sums are over the whole period
  for (int k = 0; k < STEPS && done; k++) {
    for (int n = 0; n < 2 && done; n++)
      done = thrum_step(models[n], state[n], NULL) >= 0 &&
             thrum_state_get(models[n], state[n], q[n], NULL, NULL) >= 0;
    if (!done)
      break;
    wrong += difference(rank, q[1], q[0]);
    whole += square(rank, q[0]);
    peak = fmax(peak, experiment_body_amplitude(s->body, q[0]));
  }

  thrum_state_destroy(state[0]);
  thrum_state_destroy(state[1]);
  *point = (experiment_linear_point){load, peak, sqrt(wrong / whole)};
  return done;
}

typedef bool probe(const search *s, double load, experiment_linear_point *point);

/* The point where the error passes `level`, between a load below it and one above. */
static experiment_linear_point bisect(const search *s, probe *look, double low, double high,
                                      double level) {
  experiment_linear_point point = {NAN, NAN, NAN};
  for (int k = 0; k < BISECTIONS; k++) {
    experiment_linear_point trial;
    const double load = sqrt(low * high);
    if (!look(s, load, &trial))
      break;
    point = trial;
    if (trial.error < level)
      low = load;
    else
      high = load;
  }
  return point;
}

/* Loads in a geometric row; `unit` gives a linear body the amplitude 1. Ends at the last load that
 * can be followed, or once the last level is passed by far. */
static void trace(const search *s, probe *look, double unit, experiment_linear_curve *curve) {
  const double ratio = pow(LAST / FIRST, 1.0 / (EXPERIMENT_LINEAR_POINTS - 1));
  curve->count = 0;
  for (int level = 0; level < EXPERIMENT_LINEAR_LEVELS; level++)
    curve->at[level] = (experiment_linear_point){NAN, NAN, NAN};

  // each load is some 40 % larger than the one before
  for (int n = 0; n < EXPERIMENT_LINEAR_POINTS; n++) {
    experiment_linear_point *point = &curve->points[n];
    if (!look(s, unit * FIRST * pow(ratio, n), point))
      break;
    curve->count++;

    // a level that was passed between two points is found by bisection
    for (int level = 0; level < EXPERIMENT_LINEAR_LEVELS && n > 0; level++)
      if (isnan(curve->at[level].error) && point[-1].error < experiment_linear_levels[level] &&
          point->error >= experiment_linear_levels[level])
        curve->at[level] =
            bisect(s, look, point[-1].load, point->load, experiment_linear_levels[level]);
    if (point->error > 1)
      break;
  }
}

/* A step of undamped linear modes under a constant load, exact: what a linear program would do. */
static void linear_step(int64_t rank, const double *table, const double *shift, double *q,
                        double *p) {
  for (int64_t i = 0; i < rank; i++) {
    const double x = q[i] - shift[i], v = p[i];
    q[i] = shift[i] + table[3 * i] * x + table[3 * i + 1] * v;
    p[i] = table[3 * i] * v - table[3 * i + 2] * x;
  }
}

/* The data of the three timed calls. */
typedef struct timed {
  const thrum_model *model;
  thrum_state *state;
  double *q, *p, *work;
  double table[3 * THRUM_RANK_MAX], shift[THRUM_RANK_MAX];
  double sink;
} timed;

static void time_force(timed *t) {
  double force[THRUM_RANK_MAX];
  t->sink += thrum_internal_force(t->model, t->q, force, t->work) + force[0];
}

static void time_step(timed *t) {
  t->sink += (double)thrum_step(t->model, t->state, NULL);
}

static void time_linear(timed *t) {
  linear_step(t->model->rank, t->table, t->shift, t->q, t->p);
}

/* Least processor time of a call over batches [us]. */
static double least_us(void (*call)(timed *t), timed *t) {
  double least = INFINITY;
  int64_t calls = 16;
  for (int batch = 0; batch < BATCHES;) {
    const double began = clock_thread_seconds();
    for (int64_t n = 0; n < calls; n++)
      call(t);
    const double seconds = clock_thread_seconds() - began;

    // a batch must be long against the resolution of the clock
    if (seconds < BATCH_SECONDS) {
      calls *= 2;
      continue;
    }
    least = fmin(least, 1e6 * seconds / (double)calls);
    batch++;
  }
  return least;
}

/* All three at a swing of AMPLITUDE. */
static thrum_status time_all(const experiment_body *body, experiment_linear_result *result,
                             thrum_error *error) {
  const thrum_model *model = body->model;
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_IMEXV;
  const int64_t rank = model->rank;

  // one allocation has q, p and the work of the polynomial
  thrum_scope memory = thrum_scope_begin(body->name, error);
  timed *t = thrum_scope_allocate(&memory, 1, sizeof *t);
  double *numbers =
      thrum_scope_allocate(&memory, 2 * rank + (int64_t)thrum_work_count(model), sizeof *numbers);
  double energy, impulse = 0, reached = 0;
  thrum_status status = memory.status;
  THRUM_THEN(status, experiment_impulse(body, AMPLITUDE, def.dt, &impulse, &reached, error));
  THRUM_THEN(status, thrum_state_create(model, &def, &t->state, error));
  THRUM_THEN(status, experiment_kick(body, impulse, t->state, &energy, error));

  // the exact step of linear modes is a rotation of each (omega q, p)
  if (status >= 0) {
    t->model = model;
    t->q = numbers;
    t->p = numbers + rank;
    t->work = numbers + 2 * rank;
    for (int64_t i = 0; i < rank; i++) {
      const double omega = sqrt(model->omega2[i]);
      t->table[3 * i] = cos(omega * def.dt);
      t->table[3 * i + 1] = sin(omega * def.dt) / omega;
      t->table[3 * i + 2] = sin(omega * def.dt) * omega;
      t->p[i] = impulse * body->push[i];
    }

    // one after the other, as each warms the caches for itself
    result->step_us = least_us(time_step, t);
    result->linear_us = least_us(time_linear, t);
    result->force_us = least_us(time_force, t);
  }
  if (t != NULL)
    thrum_state_destroy(t->state);
  thrum_scope_free(&memory);
  return status < 0 ? status : THRUM_OK;
}

thrum_status experiment_linear_compare(const experiment_body *body,
                                       experiment_linear_result *result, thrum_error *error) {
  search s = {0};
  if (!(body->model->omega2[0] > 0))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%.100s: a mode has no stiffness, so there is no linear answer at rest",
                           body->name);
  thrum_status status = search_make(body, &s, error);

  // the unit load and the unit impulse give a linear body an amplitude of its own length
  experiment_linear_result made = {0};
  if (status >= 0) {
    trace(&s, rest, body->length / body->compliance, &made.statics);
    trace(&s, swing, body->length / (body->compliance * sqrt(body->model->omega2[0])),
          &made.dynamics);
  }
  thrum_scope_free(&s.memory);
  THRUM_THEN(status, time_all(body, &made, error));
  if (status >= 0)
    *result = made;
  return status;
}

static thrum_status compare_index(void *context, int64_t index, thrum_error *error) {
  experiment_linear *linear = context;
  return experiment_linear_compare(&linear->bodies[index], &linear->results[index], error);
}

thrum_status experiment_linear_run(experiment_linear *linear, thrum_error *error) {
  THRUM_TRY(thrum_reserve(&linear->results, (size_t)linear->body_count + 1, sizeof *linear->results,
                          "the results", error));
  const thrum_thread_pool pool = {.threads = linear->threads,
                                  .count = linear->body_count,
                                  .task = compare_index,
                                  .progress = linear->progress,
                                  .context = linear,
                                  .progress_context = linear->progress_context};
  return thrum_thread_pool_run(&pool, error);
}
