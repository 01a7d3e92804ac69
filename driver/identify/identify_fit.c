/* A fit by Levenberg's and Marquardt's method: each iteration makes the run and, for each
 * parameter, its change to first order (thrum_tape_push_forward), so that the Jacobian is exact.
 * The run is read off between its steps by cubic Hermite interpolation.
 *
 * A frequency that is a little off is out of step after many periods, and the sum of squares has
 * many minima. So the fit begins with the first two periods, and takes in twice as many each time.
 *
 * Cost: an iteration takes as many passes as there are parameters, and one more. Sources: Levenberg
 * 1944, doi:10.1090/qam/10666; Marquardt 1963, doi:10.1137/0111030.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/identify/identify_fit.h"

#include <lapacke.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "config/progress.h"
#include "core/base/lame.h"
#include "core/base/pi.h"
#include "driver/model/model_meta.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "thrum/thrum.h"

#define PERIOD_STEPS 1000.0 /* of the first mode */
#define STEPS_MOST 1000000
#define PERIODS_FIRST 2.0 /* in the first window */
#define RATIO_FIRST 0.01  /* damping ratio from which a fit begins */
#define TOLERANCE 1e-9    /* of the steps: derivatives agree with runs to about that */
#define DAMP_FIRST 1e-3   /* Marquardt's lambda */
#define DAMP_LEAST 1e-9
#define DAMP_MOST 1e12   /* beyond, no step lowers the sum */
#define STEP_MOST 1.0    /* of a logarithm */
#define STEP_LEAST 1e-6  /* of a logarithm, at which the fit has converged */
#define GAIN_LEAST 1e-8  /* of the sum, likewise; */
#define GAIN_WINDOW 1e-2 /* in a window that is not the last */
#define STEP_STUCK                                                                                 \
  1e-3              /* of a logarithm: a fit that finds nothing lower on so long a step is stuck */
#define SMALL 1e-14 /* of a diagonal, below which a parameter does not show */
#define POOR_FROM 0.5 /* of the motion: where more is left the fit explains nothing */
#define LAGS_MOST 100 /* rows between two that are compared, */
#define LAGS_SHARE 4  /* and at most one in so many of all */
#define REPEATED_LEAST                                                                             \
  4.0 /* deviations of a correlation of noise, below which what is left may be noise */
#define MISSED_SHARE 0.5 /* repeated: most of what is left is no noise, */
#define MISSED_FROM 0.01 /* and so much of the motion */

/* --- what is fitted --------------------------------------------------------------------------- */

/* The x from which a fit begins. */
static double x_of(const identify_parameter *p) {
  switch (p->kind) {
  case IDENTIFY_POISSON:
    return log((1 + p->first) / (0.5 - p->first));
  case IDENTIFY_RATIO:
  case IDENTIFY_ALPHA:
  case IDENTIFY_BETA:
    return log(p->first);
  case IDENTIFY_YOUNG:
  case IDENTIFY_DENSITY:
  case IDENTIFY_START_Q:
  case IDENTIFY_START_P:
    break;
  }
  return 0;
}

/* The number that x stands for. */
static double value_of(const identify_parameter *p, double x) {
  switch (p->kind) {
  case IDENTIFY_YOUNG:
  case IDENTIFY_DENSITY:
    return p->first * exp(x);
  case IDENTIFY_POISSON:
    return 0.5 - 1.5 / (1 + exp(x));
  case IDENTIFY_RATIO:
  case IDENTIFY_ALPHA:
  case IDENTIFY_BETA:
    return exp(x);
  case IDENTIFY_START_Q:
  case IDENTIFY_START_P:
    break;
  }
  return p->first + x;
}

/* How that changes with x. */
static double slope_of(const identify_parameter *p, double value) {
  if (p->kind == IDENTIFY_POISSON)
    return (1 + value) * (0.5 - value) / 1.5;
  return p->kind < IDENTIFY_START_Q ? value : 1;
}

static identify_parameter *add(identify_fit *f, identify_kind kind, int64_t index, const char *unit,
                               double first) {
  identify_parameter *p = &f->parameters[f->count];
  *p = (identify_parameter){.kind = kind, .index = index, .unit = unit, .first = first};
  f->x[f->count++] = x_of(p);
  return p;
}

/* One number of the material of each region: column `member` of model->material. */
static void add_material(identify_fit *f, identify_kind kind, int member, const char *name,
                         const char *unit) {
  cJSON *meta = model_meta_parse(f->model);
  for (int64_t g = 0; g < f->shares.count; g++) {
    const double *material = f->shares.model.material;
    identify_parameter *p =
        add(f, kind, g, f->model->material ? unit : "", material[3 * g + member]);
    const char *region = model_meta_region(meta, g);
    if (f->shares.count > 1 && region != NULL)
      snprintf(p->name, sizeof p->name, "%s of %.80s", name, region);
    else if (f->shares.count > 1)
      snprintf(p->name, sizeof p->name, "%s of region %lld", name, (long long)g + 1);
    else
      snprintf(p->name, sizeof p->name, "%s", name);
  }
  cJSON_Delete(meta);
}

static void add_damping(identify_fit *f) {
  const identify_request *request = f->request;
  const double omega = sqrt(f->model->omega2[0]);
  for (int64_t n = 0; n < request->ratio_count && request->ratio; n++) {
    const double given = damping_spec_ratio(&request->damping, n);
    identify_parameter *p = add(f, IDENTIFY_RATIO, n, "", given > 0 ? given : RATIO_FIRST);
    if (request->ratio_count == 1)
      snprintf(p->name, sizeof p->name, "damping ratio");
    else
      snprintf(p->name, sizeof p->name, "damping ratio of mode %lld%s", (long long)n + 1,
               n + 1 == request->ratio_count ? " and beyond" : "");
  }
  const double alpha = request->damping.alpha, beta = request->damping.beta;
  if (request->alpha)
    snprintf(add(f, IDENTIFY_ALPHA, 0, "1/s", alpha > 0 ? alpha : 2 * RATIO_FIRST * omega)->name,
             sizeof f->parameters->name, "alpha");
  if (request->beta)
    snprintf(add(f, IDENTIFY_BETA, 0, "s", beta > 0 ? beta : 2 * RATIO_FIRST / omega)->name,
             sizeof f->parameters->name, "beta");
}

static thrum_status choose_parameters(identify_fit *f, thrum_error *error) {
  const identify_request *request = f->request;
  const int64_t modes =
      request->start_modes < f->model->rank ? request->start_modes : f->model->rank;
  const int64_t most = 3 * f->shares.count + request->ratio_count + 2 + 2 * modes;
  THRUM_TRY(thrum_reserve(&f->parameters, most, sizeof *f->parameters, "the parameters", error));
  THRUM_TRY(thrum_reserve(&f->x, 2 * most, sizeof *f->x, "the parameters", error));
  f->best_x = f->x + most;
  f->best = INFINITY;
  if (request->ratio && request->ratio_count > f->model->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "--ratios %lld: the model has %lld modes",
                           (long long)request->ratio_count, (long long)f->model->rank);
  if (request->young)
    add_material(f, IDENTIFY_YOUNG, 0, "E", "Pa");
  if (request->poisson)
    add_material(f, IDENTIFY_POISSON, 1, "nu", "");
  if (request->density)
    add_material(f, IDENTIFY_DENSITY, 2, "density", "kg/m^3");
  add_damping(f);
  for (int64_t i = 0; i < 2 * modes && request->start; i++) {
    const bool speed = i >= modes;
    const int64_t mode = speed ? i - modes : i;
    identify_parameter *p = add(f, speed ? IDENTIFY_START_P : IDENTIFY_START_Q, mode,
                                speed ? "kg^1/2 m/s" : "kg^1/2 m", speed ? f->p[mode] : f->q[mode]);
    snprintf(p->name, sizeof p->name, "start %s%lld", speed ? "p" : "q", (long long)mode + 1);
  }
  return THRUM_OK;
}

/* --- opening ---------------------------------------------------------------------------------- */

/* The displacement of each column under a unit of each coordinate. */
static thrum_status see_columns(identify_fit *f, thrum_error *error) {
  const int64_t r = f->model->rank;
  double *q = NULL;
  THRUM_TRY(thrum_reserve(&q, r, sizeof *q, "the targets", error));
  thrum_status status = THRUM_OK;
  for (int64_t c = 0; c < f->recording.column_count && status >= 0; c++) {
    const recording_column *column = &f->recording.columns[c];
    load_vertices at = {0};
    status = config_error_in(error, load_target_find(f->model, &column->target, &at, error), "%s",
                             f->request->recording_path);
    for (int64_t i = 0; i < r && status >= 0; i++) {
      double mean[3] = {0, 0, 0};
      q[i] = 1;
      status = thrum_displacement_mean(f->model, at.list, at.count, q, mean, error);
      q[i] = 0;
      f->seen[c * r + i] = mean[column->axis];
    }
    load_vertices_free(&at);
  }
  free(q);
  return status;
}

/* Rows that are periods apart do not show the motion between them: most often their times are in
 * another unit. */
static thrum_status check_times(const identify_fit *f, thrum_error *error) {
  const recording *rec = &f->recording;
  const double period = THRUM_TWO_PI / sqrt(f->model->omega2[0]);
  const double apart = (rec->times[rec->rows - 1] - rec->times[0]) / (double)(rec->rows - 1);
  if (apart > period)
    return thrum_error_set(
        error, THRUM_BAD_VALUE,
        "%.300s: its rows are %.3g s apart, and the first mode swings in %.3g s: "
        "are the times in seconds?",
        f->request->recording_path, apart, period);
  return THRUM_OK;
}

static thrum_status choose_steps(identify_fit *f, thrum_error *error) {
  const recording *rec = &f->recording;
  THRUM_TRY(check_times(f, error));
  double dt = f->request->dt;
  if (dt == 0) {
    dt = THRUM_TWO_PI / sqrt(f->model->omega2[0]) / PERIOD_STEPS;
    for (int64_t n = 1; n < rec->rows; n++)
      dt = fmin(dt, rec->times[n] - rec->times[n - 1]);
  }
  const double steps = ceil(rec->times[rec->rows - 1] / dt);
  if (!(steps >= 1 && steps <= STEPS_MOST))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the recording takes %g steps of %g s, not 1 to %d: give a longer --dt",
                           steps, dt, STEPS_MOST);
  f->dt = dt;
  f->steps = (int64_t)steps;
  return THRUM_OK;
}

/* Memory of the fit: the change of a run, q and p of each step; the Jacobian, rows x columns x
 * count; the residual; the normal equations, count x count, twice, and four vectors. */
static thrum_status reserve(identify_fit *f, thrum_error *error) {
  const int64_t r = f->model->rank, seen = f->recording.rows * f->recording.column_count;
  const int64_t n = f->count;
  THRUM_TRY(thrum_reserve(&f->change, 2 * (f->steps + 1) * r, sizeof *f->change, "the fit", error));
  THRUM_TRY(thrum_reserve(&f->jacobian, seen * n, sizeof *f->jacobian, "the fit", error));
  THRUM_TRY(thrum_reserve(&f->residual, seen, sizeof *f->residual, "the fit", error));
  THRUM_TRY(thrum_reserve(&f->fitted, seen, sizeof *f->fitted, "the fit", error));
  THRUM_TRY(thrum_reserve(&f->normal, 2 * n * n + 4 * n, sizeof *f->normal, "the fit", error));
  thrum_tape_def def = thrum_default_tape_def();
  def.steps = f->steps;
  return thrum_tape_create(f->model, &def, &f->tape, error);
}

thrum_status identify_fit_open(const identify_request *request, const thrum_model *model,
                               identify_fit *fit, thrum_error *error) {
  *fit = (identify_fit){.request = request, .model = model};
  if (model->basis == NULL || model->omega2[0] <= 0)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no basis to see the targets by, or nothing holds it");
  THRUM_TRY(recording_read(request->recording_path, &fit->recording, error));
  if (!request->start && request->start_count == 0)
    return thrum_error_set(error, THRUM_MISSING,
                           "the body starts at rest: give its --start, or fit it with --parameters "
                           "...,start");
  THRUM_TRY(region_shares_open(model, request->poisson || request->density, &fit->shares, error));

  // what is seen, and the start
  fit->modes = model_meta_modes(model);
  const int64_t r = model->rank;
  THRUM_TRY(thrum_reserve(&fit->seen, fit->recording.column_count * r, sizeof *fit->seen,
                          "the targets", error));
  THRUM_TRY(see_columns(fit, error));
  THRUM_TRY(thrum_reserve(&fit->q, 2 * r, sizeof *fit->q, "the start", error));
  fit->p = fit->q + r;
  THRUM_TRY(start_specs_make(model, request->starts, request->start_count, fit->q, fit->p, error));
  THRUM_TRY(choose_parameters(fit, error));
  THRUM_TRY(choose_steps(fit, error));

  const int64_t seen = fit->recording.rows * fit->recording.column_count;
  if (seen <= fit->count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld numbers are recorded, too few for %lld parameters",
                           (long long)seen, (long long)fit->count);
  for (int64_t n = 0; n < seen; n++)
    fit->motion += fit->recording.values[n] * fit->recording.values[n] / (double)seen;
  fit->motion = sqrt(fit->motion);
  if (!(fit->motion > 0))
    return thrum_error_set(error, THRUM_BAD_VALUE, "%.300s: nothing moves, all displacements are 0",
                           request->recording_path);
  return reserve(fit, error);
}

void identify_fit_close(identify_fit *fit) {
  recording_free(&fit->recording);
  region_shares_close(&fit->shares);
  double *const blocks[] = {fit->seen,   fit->q,        fit->x,        fit->fitted,
                            fit->change, fit->jacobian, fit->residual, fit->normal};
  for (size_t n = 0; n < sizeof blocks / sizeof blocks[0]; n++)
    free(blocks[n]);
  free(fit->parameters);
  thrum_tape_destroy(fit->tape);
  memset(fit, 0, sizeof *fit);
}

/* --- a run ------------------------------------------------------------------------------------ */

/* The body of a trial, and what steps it. */
typedef struct trial {
  region_body body;
  double *material, *values;     /* 3 a region: E, nu and density; lambda, mu and density */
  double ratios[THRUM_RANK_MAX]; /* of the modes */
  double damping[THRUM_RANK_MAX];
  int64_t damped_as[THRUM_RANK_MAX];           /* the mode whose rate each coordinate has */
  double q[THRUM_RANK_MAX], p[THRUM_RANK_MAX]; /* the start, in the coordinates of the model */
  double alpha, beta;
  double *seen; /* columns x rank, in the coordinates of the body */
} trial;

static void read_parameters(const identify_fit *f, const double *x, trial *t) {
  const int64_t r = f->model->rank;
  const damping_spec *damping = &f->request->damping;
  memcpy(t->material, f->shares.model.material, (size_t)(3 * f->shares.count) * sizeof(double));
  for (int64_t i = 0; i < r; i++) {
    t->ratios[i] = damping_spec_ratio(damping, i);
    t->q[i] = f->q[i];
    t->p[i] = f->p[i];
  }
  t->alpha = damping->alpha;
  t->beta = damping->beta;

  for (int64_t n = 0; n < f->count; n++) {
    const identify_parameter *p = &f->parameters[n];
    const double value = value_of(p, x[n]);
    if (p->kind == IDENTIFY_YOUNG)
      t->material[3 * p->index] = value;
    else if (p->kind == IDENTIFY_POISSON)
      t->material[3 * p->index + 1] = value;
    else if (p->kind == IDENTIFY_DENSITY)
      t->material[3 * p->index + 2] = value;
    else if (p->kind == IDENTIFY_ALPHA)
      t->alpha = value;
    else if (p->kind == IDENTIFY_BETA)
      t->beta = value;
    else if (p->kind == IDENTIFY_START_Q)
      t->q[p->index] = value;
    else if (p->kind == IDENTIFY_START_P)
      t->p[p->index] = value;
    else
      for (int64_t i = p->index; i < r; i++)
        t->ratios[i] = value;
  }
}

/* to = turn^T from: what is seen, in the coordinates of the body. */
static void see_from_body(const region_body *body, const double *from, double *to) {
  const int64_t r = body->model.rank;
  for (int64_t j = 0; j < r; j++) {
    to[j] = 0;
    for (int64_t i = 0; i < r; i++)
      to[j] += body->turn[i * r + j] * from[i];
  }
}

/* to = back from: a motion, in the coordinates of the body. */
static void into_body(const region_body *body, const double *from, double *to) {
  const int64_t r = body->model.rank;
  for (int64_t i = 0; i < r; i++) {
    to[i] = 0;
    for (int64_t j = 0; j < r; j++)
      to[i] += body->back[i * r + j] * from[j];
  }
}

/* lambda, mu and density by E, nu and density. A body that is not split into lambda and mu has all
 * of its energy in mu. */
static void put_values_of(const identify_fit *f, trial *t) {
  for (int64_t g = 0; g < f->shares.count; g++) {
    const double *m = t->material + 3 * g;
    const thrum_lame lame = thrum_lame_of(m[0], m[1]);
    t->values[3 * g] = lame.lambda;
    t->values[3 * g + 1] = lame.mu;
    t->values[3 * g + 2] = m[2];
  }
}

static void trial_free(trial *t) {
  region_body_free(&t->body);
  free(t->material);
  free(t->seen);
}

static thrum_status trial_make(const identify_fit *f, const double *x, trial *t,
                               thrum_error *error) {
  const int64_t r = f->model->rank, columns = f->recording.column_count;
  THRUM_TRY(thrum_reserve(&t->material, 6 * f->shares.count, sizeof *t->material, "a run", error));
  t->values = t->material + 3 * f->shares.count;
  read_parameters(f, x, t);
  put_values_of(f, t);
  THRUM_TRY(region_body_make(&f->shares, t->values, &t->body, error));
  THRUM_TRY(thrum_reserve(&t->seen, columns * r, sizeof *t->seen, "a run", error));
  for (int64_t c = 0; c < columns; c++)
    see_from_body(&t->body, f->seen + c * r, t->seen + c * r);

  // what is no mode has the least rate of the modes
  const double *omega2 = t->body.model.omega2;
  const int64_t least = damping_spec_least(t->ratios, omega2, f->modes);
  for (int64_t i = 0; i < r; i++) {
    t->damped_as[i] = i < f->modes ? i : least;
    t->damping[i] = 2 * t->ratios[t->damped_as[i]] * sqrt(omega2[t->damped_as[i]]);
  }
  t->body.model.damping = t->damping;
  return THRUM_OK;
}

/* Steps that the first `rows` rows of the recording need. */
static int64_t steps_for(const identify_fit *f, int64_t rows) {
  const int64_t steps = (int64_t)ceil(f->recording.times[rows - 1] / f->dt);
  return steps < 1 ? 1 : steps < f->steps ? steps : f->steps;
}

static thrum_status trial_run(identify_fit *f, const trial *t, int64_t rows, thrum_error *error) {
  const thrum_model *model = &t->body.model;
  double q[THRUM_RANK_MAX], p[THRUM_RANK_MAX];
  thrum_state_def def = thrum_default_state_def();
  def.dt = f->dt;
  def.tolerance = TOLERANCE;
  def.damping_alpha = t->alpha;
  def.damping_beta = t->beta;
  thrum_state *state = NULL;
  THRUM_TRY(thrum_state_create(model, &def, &state, error));
  into_body(&t->body, t->q, q);
  into_body(&t->body, t->p, p);
  thrum_status status = thrum_tape_start(model, f->tape, state, q, p, error);
  THRUM_THEN(status, thrum_tape_run(model, f->tape, state, NULL, steps_for(f, rows), NULL, error));
  thrum_state_destroy(state);
  f->runs++;
  return status;
}

/* What is seen of q and p of all steps, at the rows: to[(row x columns + column) x stride]. */
static void observe(const identify_fit *f, const trial *t, int64_t rows, const double *q,
                    const double *p, int64_t stride, double *to) {
  const int64_t r = f->model->rank, columns = f->recording.column_count;
  const int64_t last = thrum_tape_steps(f->tape) - 1;
  const double h = f->dt;
  for (int64_t row = 0; row < rows; row++) {
    int64_t k = (int64_t)(f->recording.times[row] / h);
    k = k < last ? k : last;
    const double s = f->recording.times[row] / h - (double)k, o = 1 - s;
    const double a = o * o * (1 + 2 * s), b = s * s * (3 - 2 * s);
    const double va = h * s * o * o, vb = -h * s * s * o;
    for (int64_t c = 0; c < columns; c++) {
      const double *seen = t->seen + c * r;
      double sum = 0;
      for (int64_t i = 0; i < r; i++) {
        const int64_t at = k * r + i, next = at + r;
        sum += seen[i] * (a * q[at] + va * p[at] + b * q[next] + vb * p[next]);
      }
      to[(row * columns + c) * stride] = sum;
    }
  }
}

/* The residual of the first `rows` rows; *squares: the sum of its squares, infinite where the run
 * fails. A run without memory says nothing of its parameters, and ends the fit. */
static thrum_status residual_of(identify_fit *f, const trial *t, int64_t rows, double *residual,
                                double *squares, thrum_error *error) {
  const thrum_status status = trial_run(f, t, rows, error);
  *squares = INFINITY;
  if (status < 0)
    return status == THRUM_OUT_OF_MEMORY ? status : THRUM_OK;
  observe(f, t, rows, thrum_tape_q(f->tape), thrum_tape_p(f->tape), 1, residual);
  double sum = 0;
  for (int64_t n = 0; n < rows * f->recording.column_count; n++) {
    residual[n] -= f->recording.values[n];
    sum += residual[n] * residual[n];
  }
  if (isfinite(sum))
    *squares = sum;
  return THRUM_OK;
}

/* --- derivatives ------------------------------------------------------------------------------ */

/* How lambda, mu and density of a region change with one number of its material, and D of each mode
 * with them: a ratio goes with the frequency. */
static void put_material_direction(const identify_fit *f, const trial *t,
                                   const identify_parameter *p, double by, thrum_tape_gradient *d) {
  const double *m = t->material + 3 * p->index;
  const int64_t r = t->body.model.rank;
  if (p->kind == IDENTIFY_DENSITY) {
    d->part[0] = by;
  } else {
    const thrum_lame change = p->kind == IDENTIFY_YOUNG ? thrum_lame_of(by, m[1])
                                                        : thrum_lame_by_poisson(by * m[0], m[1]);
    d->part[0] = change.lambda;
    d->part[1] = change.mu;
  }
  d->parts = t->body.parts + 3 * p->index + (p->kind == IDENTIFY_DENSITY ? 2 : 0);
  d->part_count = p->kind == IDENTIFY_DENSITY ? 1 : 2;
  if (f->shares.whole) {
    d->part[0] = d->part[1];
    d->parts++;
    d->part_count = 1;
  }
  for (int64_t i = 0; i < r; i++) {
    const int64_t mode = t->damped_as[i];
    double change = 0;
    for (int64_t n = 0; n < d->part_count; n++)
      change += d->part[n] * d->parts[n].linear[mode * r + mode];
    d->damping[i] = t->ratios[mode] * change / sqrt(t->body.model.omega2[mode]);
  }
}

/* The direction of x_n; q, p, damping (rank each) and part (two) are zero before. */
static void put_direction(const identify_fit *f, const trial *t, const double *x, int64_t n,
                          thrum_tape_gradient *d) {
  const identify_parameter *p = &f->parameters[n];
  const int64_t r = f->model->rank;
  const double value = value_of(p, x[n]), *omega2 = t->body.model.omega2;
  if (p->kind <= IDENTIFY_POISSON)
    put_material_direction(f, t, p, slope_of(p, value), d);
  else if (p->kind == IDENTIFY_ALPHA)
    d->alpha = value;
  else if (p->kind == IDENTIFY_BETA)
    d->beta = value;
  for (int64_t i = 0; i < r && p->kind >= IDENTIFY_START_Q; i++)
    (p->kind == IDENTIFY_START_Q ? d->q : d->p)[i] = t->body.back[i * r + p->index];
  for (int64_t i = 0; i < r && p->kind == IDENTIFY_RATIO; i++) {
    const int64_t mode = t->damped_as[i];
    const bool beyond = mode > p->index && p->index + 1 == f->request->ratio_count;
    d->damping[i] = mode == p->index || beyond ? 2 * value * sqrt(omega2[mode]) : 0;
  }
}

static thrum_status put_jacobian(identify_fit *f, const trial *t, const double *x, int64_t rows,
                                 thrum_error *error) {
  const int64_t r = f->model->rank;
  double *change_p = f->change + (f->steps + 1) * r;
  for (int64_t n = 0; n < f->count; n++) {
    double q[THRUM_RANK_MAX] = {0}, p[THRUM_RANK_MAX] = {0}, damping[THRUM_RANK_MAX] = {0};
    double part[2] = {0};
    thrum_tape_gradient direction = {.q = q, .p = p, .damping = damping, .part = part};
    put_direction(f, t, x, n, &direction);
    THRUM_TRY(
        thrum_tape_push_forward(&t->body.model, f->tape, &direction, f->change, change_p, error));
    observe(f, t, rows, f->change, change_p, f->count, f->jacobian + n);
  }
  return THRUM_OK;
}

/* --- least squares ---------------------------------------------------------------------------- */

/* J^T J and J^T r over the first `seen` numbers. */
static void put_normal(const identify_fit *f, int64_t seen, double *matrix, double *slope) {
  const int64_t n = f->count;
  memset(matrix, 0, (size_t)(n * n) * sizeof *matrix);
  memset(slope, 0, (size_t)n * sizeof *slope);
  for (int64_t k = 0; k < seen; k++) {
    const double *row = f->jacobian + k * n;
    for (int64_t i = 0; i < n; i++) {
      slope[i] += row[i] * f->residual[k];
      for (int64_t j = 0; j <= i; j++)
        matrix[i * n + j] += row[i] * row[j];
    }
  }
}

/* Cholesky's factor of the lower triangle, in place. False: not positive definite. */
static bool factor(double *matrix, int64_t n) {
  return LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'U', (int)n, matrix, (int)n) == 0;
}

static void solve(const double *factors, int64_t n, double *x) {
  LAPACKE_dpotrs(LAPACK_COL_MAJOR, 'U', (int)n, 1, factors, (int)n, x, (int)n);
}

/* Whether a column of the Jacobian is more than rounding: beside the motion, or that of a start
 * beside the largest of its kind. */
static bool shows(const identify_fit *f, const double *matrix, int64_t i, int64_t seen) {
  const int64_t n = f->count;
  const identify_kind kind = f->parameters[i].kind;
  double scale = kind < IDENTIFY_START_Q ? f->motion * f->motion * (double)seen : 0;
  for (int64_t k = 0; k < n && kind >= IDENTIFY_START_Q; k++)
    if (f->parameters[k].kind == kind)
      scale = fmax(scale, matrix[k * n + k]);
  return matrix[i * n + i] > SMALL * scale;
}

/* Factors of the matrix with Marquardt's damping, without what does not show. */
static bool factor_shown(const identify_fit *f, const double *matrix, double damping, int64_t seen,
                         double *work) {
  const int64_t n = f->count;
  memcpy(work, matrix, (size_t)(n * n) * sizeof *work);
  for (int64_t i = 0; i < n; i++) {
    const bool held = !shows(f, matrix, i, seen);
    work[i * n + i] = held ? 1 : work[i * n + i] * (1 + damping);
    for (int64_t j = 0; j < n && held; j++) {
      if (j < i)
        work[i * n + j] = 0;
      else if (j > i)
        work[j * n + i] = 0;
    }
  }
  return factor(work, n);
}

/* The step of Marquardt's damping; false where there is none. Logarithms change by one at most. */
static bool put_step(const identify_fit *f, const double *matrix, const double *slope,
                     double damping, int64_t seen, double *work, double *step) {
  const int64_t n = f->count;
  if (!factor_shown(f, matrix, damping, seen, work))
    return false;
  for (int64_t i = 0; i < n; i++)
    step[i] = shows(f, matrix, i, seen) ? -slope[i] : 0;
  solve(work, n, step);
  for (int64_t i = 0; i < n; i++)
    if (f->parameters[i].kind < IDENTIFY_START_Q)
      step[i] = fmin(fmax(step[i], -STEP_MOST), STEP_MOST);
  return true;
}

/* A change of a parameter: of a logarithm, or of a start the motion that it makes. */
static double size_of_change(const identify_fit *f, const double *matrix, int64_t i, int64_t seen,
                             double change) {
  const double scale = f->parameters[i].kind < IDENTIFY_START_Q
                           ? 1
                           : sqrt(matrix[i * f->count + i] / (double)seen) / f->motion;
  return fabs(change) * scale;
}

static double largest_step(const identify_fit *f, const double *step, const double *matrix,
                           int64_t seen) {
  double most = 0;
  for (int64_t i = 0; i < f->count; i++)
    most = fmax(most, size_of_change(f, matrix, i, seen, step[i]));
  return most;
}

/* Tries steps, ever shorter, from the run that is on the tape until one lowers the sum, and takes
 * it. *end: there was none worth another; f->converged: as none was long. */
static thrum_status improve(identify_fit *f, int64_t rows, double *sum, double *damping, bool *end,
                            thrum_error *error) {
  const int64_t n = f->count, seen = rows * f->recording.column_count;
  double *matrix = f->normal, *work = matrix + n * n, *slope = work + n * n, *step = slope + n;
  double *x = step + n;
  put_normal(f, seen, matrix, slope);
  for (; *damping < DAMP_MOST; *damping *= 10) {
    if (!put_step(f, matrix, slope, *damping, seen, work, step))
      continue;
    for (int64_t i = 0; i < n; i++)
      x[i] = f->x[i] + step[i];
    trial t = {0};
    thrum_status status = trial_make(f, x, &t, error);
    double next = INFINITY;
    THRUM_THEN(status, residual_of(f, &t, rows, f->residual, &next, error));
    const bool lower = next < *sum;
    if (lower) {
      const double least = rows < f->recording.rows ? GAIN_WINDOW : GAIN_LEAST;
      const bool small = *sum - next < least * *sum;
      *end = f->converged = small || largest_step(f, step, matrix, seen) < STEP_LEAST;
      memcpy(f->x, x, (size_t)n * sizeof *x);
      status = put_jacobian(f, &t, x, rows, error);
      *sum = next;
      *damping = fmax(*damping / 10, DAMP_LEAST);
    }
    trial_free(&t);
    if (lower || status < 0)
      return status;

    // nothing is left to gain
    if (largest_step(f, step, matrix, seen) < STEP_LEAST)
      break;
  }
  *end = true;
  f->converged = put_step(f, matrix, slope, DAMP_LEAST, seen, work, step) &&
                 largest_step(f, step, matrix, seen) < STEP_STUCK;
  return THRUM_OK;
}

/* Residual and Jacobian at x. */
static thrum_status look(identify_fit *f, int64_t rows, bool keep, double *sum,
                         thrum_error *error) {
  trial t = {0};
  thrum_status status = trial_make(f, f->x, &t, error);
  THRUM_THEN(status, residual_of(f, &t, rows, f->residual, sum, error));
  if (status >= 0 && !isfinite(*sum))
    status = thrum_error_set(error, THRUM_NOT_CONVERGED,
                             "the run from which the fit begins fails: give a start and moduli "
                             "nearer to the recording, or a shorter --dt");
  THRUM_THEN(status, put_jacobian(f, &t, f->x, rows, error));
  if (status >= 0 && keep)
    observe(f, &t, rows, thrum_tape_q(f->tape), thrum_tape_p(f->tape), 1, f->fitted);
  trial_free(&t);
  return status;
}

/* The same, before which x is kept where it fits the whole recording better than any before. */
static thrum_status look_and_keep(identify_fit *f, int64_t rows, double *sum, thrum_error *error) {
  const thrum_status status = look(f, f->recording.rows, false, sum, error);
  if (status == THRUM_OUT_OF_MEMORY)
    return status;
  if (status >= 0 && *sum < f->best) {
    memcpy(f->best_x, f->x, (size_t)f->count * sizeof *f->x);
    f->best = *sum;
  }
  return rows < f->recording.rows || status < 0 ? look(f, rows, false, sum, error) : status;
}

/* Back to the best x where the fit went away from it. */
static void take_best(identify_fit *f, double sum) {
  if (sum <= f->best)
    return;
  memcpy(f->x, f->best_x, (size_t)f->count * sizeof *f->x);
  f->converged = false;
}

bool identify_fit_poor(const identify_fit *fit) {
  return !(fit->rms < POOR_FROM * fit->motion);
}

bool identify_fit_misses(const identify_fit *fit) {
  return fit->repeated > MISSED_SHARE && fit->rms * sqrt(fit->repeated) > MISSED_FROM * fit->motion;
}

double identify_fit_off(const identify_fit *fit, const identify_parameter *parameter) {
  const double seen = (double)(fit->recording.rows * fit->recording.column_count);
  return fit->repeated > 0 ? parameter->deviation * sqrt(seen * fit->repeated) : NAN;
}

/* Noise of one row says nothing of another: the largest correlation of what is left between rows
 * that are up to LAGS_MOST apart is the share that comes from the model. */
static double repeated_share(const identify_fit *f) {
  const int64_t columns = f->recording.column_count, rows = f->recording.rows;
  const int64_t lags = rows / LAGS_SHARE < LAGS_MOST ? rows / LAGS_SHARE : LAGS_MOST;
  double all = 0, most = 0;
  for (int64_t n = 0; n < rows * columns; n++)
    all += f->residual[n] * f->residual[n];
  for (int64_t lag = 1; lag <= lags; lag++) {
    double sum = 0;
    for (int64_t n = 0; n < (rows - lag) * columns; n++)
      sum += f->residual[n] * f->residual[n + lag * columns];
    most = fmax(most, sum / all);
  }
  return most > REPEATED_LEAST / sqrt((double)(rows * columns)) ? fmin(most, 1) : 0;
}

/* Values and their deviations, from the Jacobian of all rows. */
static void put_values(identify_fit *f, double sum) {
  const int64_t n = f->count, seen = f->recording.rows * f->recording.column_count;
  double *matrix = f->normal, *work = matrix + n * n, *slope = work + n * n, *column = slope + n;
  const double variance = sum / (double)(seen - n);
  put_normal(f, seen, matrix, slope);
  const bool definite = factor_shown(f, matrix, 0, seen, work) && !identify_fit_poor(f);
  for (int64_t i = 0; i < n; i++) {
    identify_parameter *p = &f->parameters[i];
    p->value = value_of(p, f->x[i]);
    p->deviation = p->doubt = INFINITY;
    if (!definite || !shows(f, matrix, i, seen))
      continue;
    memset(column, 0, (size_t)n * sizeof *column);
    column[i] = 1;
    solve(work, n, column);
    const double change = sqrt(variance * column[i]);
    p->deviation = change * slope_of(p, p->value);
    p->doubt = size_of_change(f, matrix, i, seen, change);
  }
}

thrum_status identify_fit_run(identify_fit *fit, thrum_error *error) {
  const recording *rec = &fit->recording;
  const double began = clock_seconds();
  config_progress progress = config_progress_make(fit->request->quiet);
  double window = PERIODS_FIRST * THRUM_TWO_PI / sqrt(fit->model->omega2[0]), sum = 0;
  int64_t rows = 0;
  while (rows < rec->rows) {
    // rows of this window, enough for the parameters
    for (; rows < rec->rows &&
           (rec->times[rows] <= window || rows * rec->column_count <= 2 * fit->count);)
      rows++;
    window *= 2;
    if (rows + rec->rows / 8 > rec->rows)
      rows = rec->rows;
    double damping = DAMP_FIRST;
    bool end = false;
    THRUM_TRY(look_and_keep(fit, rows, &sum, error));
    int64_t n = 0;
    char label[48];
    snprintf(label, sizeof label, "fit of the first %.4g s", rec->times[rows - 1]);
    thrum_status status = THRUM_OK;
    for (; n < fit->request->iterations && !end && status >= 0; n++) {
      config_progress_update(&progress, label, (double)n / (double)fit->request->iterations);
      status = improve(fit, rows, &sum, &damping, &end, error);
    }
    config_progress_end(&progress, status >= 0);
    THRUM_TRY(status);
    fit->iterations += n;
    fit->converged = fit->converged && end;
  }

  THRUM_TRY(look_and_keep(fit, rec->rows, &sum, error));
  take_best(fit, sum);
  THRUM_TRY(look(fit, rec->rows, true, &sum, error));
  fit->rms = sqrt(sum / (double)(rec->rows * rec->column_count));
  fit->repeated = repeated_share(fit);
  put_values(fit, sum);
  fit->seconds = clock_seconds() - began;
  return THRUM_OK;
}
