/* Curves of periodic motions by arc length; see thrum/response.h, docs/mathematics/21.
 *
 * From a point the curve is followed in its direction, with the bend that it had between the last
 * two, to a plane across it, where Newton's method finds the next one (corrector.c). The step grows
 * while that is easy and shrinks where the direction turns. Between two points special_points.c
 * finds what happened. Source: Keller 1977, Numerical solution of bifurcation and nonlinear
 * eigenvalue problems.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "thrum/response.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/def.h"
#include "core/base/finite.h"
#include "core/base/pi.h"
#include "response/special_points.h"
#include "thrum/condensed_model.h"
#include "thrum/polynomial.h"

#define STABILITY_STEPS_LEAST 48
#define STABILITY_STEPS_EACH 6 /* for each harmonic */
#define STEP_FIRST 0.1         /* of the longest */
#define STEP_LEAST 1e-9        /* of the longest: where it is shorter the curve is lost */
#define STEP_CUT 1e-2          /* of the one before: a direction that leads nowhere is found anew */
#define GROW 1.5
#define EASY 4            /* iterations of a point after which the step may grow */
#define TURN_MOST 0.95    /* product of two directions: a sharper turn asks for a shorter step */
#define AWAY_MOST 0.2     /* of a step: a point further from its guess may be of another curve */
#define CLOSED_LEAST 8    /* points of a closed curve at least */
#define RAMP 32           /* steps of the load where the first point is not found at once */
#define SMALL 1e-3        /* share of nonlinear forces in the first motion of a backbone */
#define SIZE_FIRST 100.0  /* by which its first motion is too small to measure steps by */
#define LEAP_LEAST 0.002  /* of the longest: a shorter step leaps over no gap */
#define BRANCH_LEAST 0.1  /* of the longest step: the first away from a branch point */
#define BESIDE_LEAST 1e-6 /* of a step from a special point that is not found itself, */
#define BESIDE_MOST 1e-2  /* and the most */
#define SMALL_TRIALS 200  /* at finding it */

typedef struct curve {
  const thrum_response_def *def;
  thrum_balance balance;
  thrum_corrector corrector;
  thrum_floquet floquet;
  thrum_place first, mark, now, next, at;
  double *first_tangent, *mark_tangent, *normal, *tangent, *before, *tangent_at; /* directions */
  double *coefficients, *kept; /* for visits: all blocks, multipliers */
  double *unit;                /* rank of the shape */
  double step, step_before, arc;
  int32_t unstable;
  int sign;          /* of the determinant at the present point */
  int32_t crossings; /* branch points so far */
  int32_t marked;    /* points behind the first one at which the mark was set; 0: it is not */
  int32_t begun;     /* points before the curve's first, of the other one at a branch point */
  bool crossed;      /* the last piece has come to the branch point that was asked for */
  bool given;        /* the first point was */
  bool (*visit)(void *context, const thrum_response_point *point);
  void *context;
  thrum_response_report report;
} curve;

void thrum_response_def_init(thrum_response_def *def, size_t size) {
  const thrum_response_def defaults = {.cookie = sizeof defaults,
                                       .harmonics = 5,
                                       .mode = -1,
                                       .amplitude = INFINITY,
                                       .step = 0.05,
                                       .points = 2000,
                                       .tolerance = 1e-12,
                                       .stability = 1,
                                       .inertia = 1,
                                       .periods = 1};
  thrum_def_fill(def, size, &defaults, sizeof defaults);
}

const char *thrum_response_kind_name(thrum_response_kind kind) {
  switch (kind) {
#define X(name, value, text)                                                                       \
  case THRUM_RESPONSE_##name:                                                                      \
    return text;
    THRUM_RESPONSE_KIND_LIST(X)
#undef X
  }
  return NULL;
}

const char *thrum_response_end_name(thrum_response_end end) {
  switch (end) {
#define X(name, value, text)                                                                       \
  case THRUM_RESPONSE_END_##name:                                                                  \
    return text;
    THRUM_RESPONSE_END_LIST(X)
#undef X
  }
  return NULL;
}

/* --- checks ----------------------------------------------------------------------------------- */

static thrum_status check_frequencies(const thrum_response_def *def, thrum_error *error) {
  const double most = THRUM_RESPONSE_MOST;
  if (!(def->from > 1 / most && def->from < most && def->to > 1 / most && def->to < most))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "from %g to %g rad/s: both are above 0 and finite; at no frequency "
                           "there is no period",
                           def->from, def->to);
  if (def->from == def->to)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "from and to are both %g rad/s",
                           def->from);
  return THRUM_OK;
}

static thrum_status check_numbers(const thrum_response_def *def, const thrum_model *model,
                                  thrum_error *error) {
  if (def->harmonics < 1 || def->harmonics > THRUM_RESPONSE_HARMONICS_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "harmonics is %d, not 1 to %d",
                           (int)def->harmonics, THRUM_RESPONSE_HARMONICS_MAX);
  if (def->mode < -1 || def->mode >= model->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "mode is %lld; the model has modes 0 to %lld", (long long)def->mode,
                           (long long)model->rank - 1);
  THRUM_TRY(check_frequencies(def, error));
  if (!(def->amplitude > 0))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "amplitude is %g, not above 0",
                           def->amplitude);
  if (!(def->step > 0 && def->step <= 1))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "step is %g, not in (0, 1]", def->step);
  if (def->points < 2)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "points is %d, not 2 or more",
                           (int)def->points);
  if (!(def->tolerance > 0 && def->tolerance <= 1e-3))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "tolerance is %g, not in (0, 1e-3]",
                           def->tolerance);
  if (def->periods < 1 || def->periods > def->harmonics || (def->mode >= 0 && def->periods > 1))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "periods is %d, not 1 to the number of harmonics; a backbone has 1",
                           (int)def->periods);
  if (def->stability_steps < 0 || def->stability_steps > 1000000)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "stability_steps is %d, not 0 to 1000000",
                           (int)def->stability_steps);
  return THRUM_OK;
}

static thrum_status check_arrays(const thrum_response_def *def, const thrum_model *model,
                                 thrum_error *error) {
  const double *const loads[] = {def->load_mean, def->load_cosine, def->load_sine};
  const int64_t rank = thrum_condensed_shape_model(model)->rank;
  for (int n = 0; n < 3; n++)
    if (loads[n] != NULL && !thrum_all_within(loads[n], rank, THRUM_RESPONSE_MOST))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "a load has a number that is not finite or too large");
  for (int64_t i = 0; def->damping != NULL && i < model->rank; i++)
    if (!(def->damping[i] >= 0 && def->damping[i] < THRUM_RESPONSE_MOST))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "damping of coordinate %lld is %g 1/s, not a finite number of 0 or "
                             "more",
                             (long long)i + 1, def->damping[i]);
  const int64_t slaves = rank - model->rank;
  for (int64_t i = 0; def->slave_damping != NULL && i < slaves; i++)
    if (!(def->slave_damping[i] >= 0 && def->slave_damping[i] < THRUM_RESPONSE_MOST))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "damping of slave %lld is %g 1/s, not a finite number of 0 or more",
                             (long long)i + 1, def->slave_damping[i]);
  if (def->mode < 0 && def->load_cosine == NULL && def->load_sine == NULL)
    return thrum_error_set(error, THRUM_MISSING, "a forced curve needs a load that swings");
  if (def->mode >= 0 &&
      (def->load_mean != NULL || def->load_cosine != NULL || def->load_sine != NULL))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "a backbone is free: it has no load");
  return THRUM_OK;
}

static thrum_status check(const thrum_model *model, const thrum_response_def *def,
                          thrum_error *error) {
  if (model == NULL || model->omega2 == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "model or def is NULL");
  if (def == NULL)
    return thrum_error_set(error, THRUM_UNINITIALISED_DEF,
                           "make the def with thrum_default_response_def");
  if (model->rank < 1 || model->rank > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model's rank is %lld, not 1 to %d",
                           (long long)model->rank, THRUM_RANK_MAX);
  if (model->point_count == 0 && (model->c3 == NULL || model->c4 == NULL))
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no polynomial; one that was precomputed condensed is to "
                           "be condensed first");
  if (model->levels != NULL)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a body under the levels of actuators has no curve here");
  THRUM_TRY(check_numbers(def, model, error));
  return check_arrays(def, model, error);
}

/* --- memory ----------------------------------------------------------------------------------- */

/* Takes room for all arrays. */
static void lay(curve *c, const thrum_model *model, const thrum_response_def *def,
                thrum_room *room) {
  const int64_t h = def->harmonics, r = model->rank;
  const int64_t shape_rank = thrum_condensed_shape_model(model)->rank;
  const bool even = def->mode >= 0;
  c->def = def;
  c->balance = (thrum_balance){.model = model,
                               .damping = even ? NULL : def->damping,
                               .rank = r,
                               .harmonics = h,
                               .periods = def->periods,
                               .blocks = even ? h + 1 : 2 * h + 1,
                               .samples = (4 * h + 1) * (model->point_count > 0 ? 2 : 1)};
  c->balance.unknowns = c->balance.blocks * r;
  if (def->inertia != 0 && model->follow != NULL)
    c->balance.slaves = (thrum_slave_inertia){
        .count = shape_rank - r, .rank = r, .damping = even ? NULL : def->slave_damping};
  thrum_balance_lay(&c->balance, shape_rank != r && !even, room);
  c->corrector = (thrum_corrector){.balance = &c->balance, .tolerance = def->tolerance};
  thrum_corrector_lay(&c->corrector, room);

  // stability
  const int64_t steps = STABILITY_STEPS_EACH * h;
  c->floquet = (thrum_floquet){.balance = &c->balance, .steps_least = def->stability_steps};
  if (def->stability_steps == 0)
    c->floquet.steps_least = steps > STABILITY_STEPS_LEAST ? steps : STABILITY_STEPS_LEAST;
  if (def->stability != 0)
    thrum_floquet_lay(&c->floquet, room);

  // places and directions
  double **const arrays[] = {&c->first.x, &c->mark.x, &c->mark_tangent,  &c->now.x,
                             &c->next.x,  &c->at.x,   &c->first_tangent, &c->normal,
                             &c->tangent, &c->before, &c->tangent_at};
  for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
    *arrays[i] = thrum_room_take(room, c->balance.unknowns + 1);
  c->coefficients = thrum_room_take(room, (2 * h + 1) * r);
  c->kept = thrum_room_take(room, 4 * r);
  c->unit = thrum_room_take(room, shape_rank);
}

static size_t head_bytes(void) {
  return (sizeof(curve) + 63) / 64 * 64;
}

thrum_status thrum_response_size(const thrum_model *model, const thrum_response_def *def,
                                 size_t *size, thrum_error *error) {
  thrum_response_def whole = thrum_default_response_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  THRUM_TRY(check(model, def, error));
  if (size == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  curve counted = {0};
  thrum_room room = {NULL, 0};
  lay(&counted, model, def, &room);
  *size = head_bytes() + (size_t)room.used * sizeof(double);
  return THRUM_OK;
}

/* --- loads ------------------------------------------------------------------------------------ */

/* The load in the coordinates that are stepped, and what of it grows with them. */
static void reduce_loads(curve *c) {
  thrum_balance *b = &c->balance;
  const thrum_model *model = b->model;
  const double *const loads[LOAD_PARTS] = {c->def->load_mean, c->def->load_cosine,
                                           c->def->load_sine};
  const int64_t r = b->rank;
  for (int part = 0; part < LOAD_PARTS; part++) {
    double *load = b->load + part * r;
    if (loads[part] == NULL)
      continue;
    memset(c->unit, 0, (size_t)r * sizeof *c->unit);
    thrum_condensed_load(model, c->unit, loads[part], load);

    // it is linear in the coordinates: a unit of each gives a column
    for (int64_t j = 0; b->pull != NULL && j < r; j++) {
      double *column = c->tangent;
      c->unit[j] = 1;
      thrum_condensed_load(model, c->unit, loads[part], column);
      c->unit[j] = 0;
      for (int64_t i = 0; i < r; i++)
        b->pull[(part * r + j) * r + i] = column[i] - load[i];
      for (int64_t i = 0; i < r; i++)
        b->pulls[part] = b->pulls[part] || column[i] != load[i];
    }
  }
}

static void scale_loads(thrum_balance *b, double by) {
  for (int64_t i = 0; i < LOAD_PARTS * b->rank; i++)
    b->load[i] *= by;
  for (int64_t i = 0; b->pull != NULL && i < LOAD_PARTS * b->rank * b->rank; i++)
    b->pull[i] *= by;
}

/* --- visits ----------------------------------------------------------------------------------- */

/* Work of the load over a period: its product with the velocities at the samples, which is exact.
 */
static double work_of_load(curve *c, const thrum_place *place) {
  thrum_balance *b = &c->balance;
  const int64_t r = b->rank, n = b->samples;
  double work = 0;
  for (int64_t s = 0; s < n; s++) {
    // the load is what is taken from no force
    double *load = c->unit;
    memset(load, 0, (size_t)r * sizeof *load);
    thrum_balance_subtract_load(b, s, b->q + s * r, load);
    for (int64_t block = 1; block < b->blocks; block++) {
      const int64_t k = thrum_block_harmonic(b, block);
      const double rate =
          (double)k * (thrum_block_sine(b, block) ? b->cosines[k * n + s] : -b->sines[k * n + s]);
      for (int64_t i = 0; i < r; i++)
        work -= load[i] * rate * place->x[block * r + i];
    }
  }
  return THRUM_TWO_PI / (double)n * work;
}

/* Energies and works of the motion at `place`. */
static void measure(curve *c, const thrum_place *place, thrum_response_point *point) {
  thrum_balance *b = &c->balance;
  const int64_t r = b->rank, h = b->harmonics;
  double all = 0, tail = 0;
  point->residual = thrum_corrector_residual(&c->corrector, place);
  for (int64_t block = 1; block < b->blocks; block++) {
    const int64_t harmonic = thrum_block_harmonic(b, block);
    const double k = (double)harmonic, *x = place->x + block * r;
    for (int64_t i = 0; i < r; i++) {
      const double square = k * k * x[i] * x[i];
      all += square;
      tail += h > 2 && harmonic > h - 2 ? square : 0;
      if (b->damping != NULL)
        point->dissipated += THRUM_PI * place->omega * square * b->damping[i];
    }
  }
  point->dissipated += THRUM_TWO_PI / place->omega * b->loss;
  point->energy = b->energy + 0.25 * place->omega * place->omega * all;
  point->tail = all > 0 ? tail / all : 0;
  if (b->blocks > h + 1)
    point->work = work_of_load(c, place);
}

/* Shows a point to the caller; false where the caller wants no more. */
static bool show(curve *c, const thrum_place *place, double arc, thrum_response_kind kind,
                 int32_t unstable, const double *multipliers) {
  const thrum_balance *b = &c->balance;
  thrum_response_point point = {.omega = place->omega,
                                .coefficients = c->coefficients,
                                .arc = arc,
                                .multipliers = multipliers,
                                .unstable = unstable,
                                .iterations = c->corrector.last_iterations,
                                .kind = kind};
  measure(c, place, &point);
  memset(c->coefficients, 0, (size_t)((2 * b->harmonics + 1) * b->rank) * sizeof(double));
  memcpy(c->coefficients, place->x, (size_t)b->unknowns * sizeof(double));

  // what the report says of all points
  thrum_response_report *report = &c->report;
  const double larger = fmax(fabs(point.work), point.dissipated);
  report->points++;
  report->folds += kind == THRUM_RESPONSE_FOLD;
  report->special += kind != THRUM_RESPONSE_REGULAR;
  report->tail = fmax(report->tail, point.tail);
  if (larger > 0 && (b->damping != NULL || b->slaves.damping != NULL))
    report->balance = fmax(report->balance, fabs(point.work - point.dissipated) / larger);
  return c->visit == NULL || c->visit(c->context, &point);
}

/* Unstable multipliers of a place, which are then in the floquet; -1: not looked at, or not found.
 */
static int32_t look_at_stability(curve *c, const thrum_place *place) {
  if (c->def->stability == 0 || !thrum_floquet_solve(&c->floquet, place))
    return -1;
  return thrum_floquet_unstable(&c->floquet);
}

/* --- the first point -------------------------------------------------------------------------- */

static double length_of(int64_t n, const double *x) {
  return sqrt(thrum_direction_product(n, x, x));
}

/* The linear answer to the load. */
static void answer_linearly(const thrum_balance *b, double omega, double *x) {
  const int64_t r = b->rank, h = b->harmonics, k = b->periods;
  omega *= (double)k;
  memset(x, 0, (size_t)b->unknowns * sizeof *x);
  for (int64_t i = 0; i < r; i++) {
    const double stiffness = b->model->omega2[i] - omega * omega;
    const double damping = b->damping != NULL ? omega * b->damping[i] : 0;
    const double square = stiffness * stiffness + damping * damping;
    const double cosine = b->load[LOAD_COSINE * r + i], sine = b->load[LOAD_SINE * r + i];
    if (b->model->omega2[i] > 0)
      x[i] = b->load[LOAD_MEAN * r + i] / b->model->omega2[i];
    if (square > 0) {
      x[k * r + i] = (stiffness * cosine - damping * sine) / square;
      x[(h + k) * r + i] = (stiffness * sine + damping * cosine) / square;
    }
  }
}

/* Solves at the frequency `from`; the guess is in c->now. */
static bool solve_first(curve *c) {
  thrum_balance *b = &c->balance;
  const thrum_place anchor = {c->now.x, c->def->from};
  c->now.omega = c->def->from;
  c->corrector.size = fmax(c->corrector.size, length_of(b->unknowns, c->now.x));
  memset(c->normal, 0, (size_t)b->unknowns * sizeof *c->normal);
  c->normal[b->unknowns] = c->def->to > c->def->from ? 1 : -1;
  return thrum_corrector_solve(&c->corrector, c->normal, &anchor, 0, &c->now);
}

static thrum_status begin_forced(curve *c, const double *start, thrum_error *error) {
  thrum_balance *b = &c->balance;
  reduce_loads(c);
  answer_linearly(b, c->def->from, c->now.x);
  if (!(length_of(b->unknowns - b->rank, c->now.x + b->rank) > 0))
    return thrum_error_set(error, THRUM_MISSING,
                           "the load that swings moves nothing: no coordinate feels it");
  if (start != NULL)
    memcpy(c->now.x, start, (size_t)b->unknowns * sizeof *start);
  if (solve_first(c))
    return THRUM_OK;

  // in small steps of the load, from none
  bool found = start == NULL;
  c->corrector.size = 0;
  for (int n = 1; n <= RAMP && found; n++) {
    scale_loads(b, n == 1 ? 1.0 / RAMP : (double)n / (n - 1));
    if (n == 1)
      answer_linearly(b, c->def->from, c->now.x);
    found = solve_first(c);
  }
  const double hertz = c->def->from * c->def->periods / THRUM_TWO_PI;
  if (!found && start != NULL)
    return thrum_error_set(error, THRUM_NOT_CONVERGED,
                           "no periodic motion was found near the start that was given, at %.6g "
                           "Hz: begin at its frequency",
                           hertz);
  return found ? THRUM_OK
               : thrum_error_set(error, THRUM_NOT_CONVERGED,
                                 "no periodic motion was found at %.6g Hz, where the curve begins: "
                                 "begin further from the resonance, or with less load",
                                 hertz);
}

/* Share of nonlinear forces where the mode is displaced by `amplitude`: each over its frequency. */
static double nonlinear_share(curve *c, double amplitude) {
  thrum_balance *b = &c->balance;
  const double *omega2 = b->model->omega2;
  const int64_t mode = c->def->mode;
  double *q = c->before, *force = c->tangent, sum = 0;
  memset(q, 0, (size_t)b->rank * sizeof *q);
  q[mode] = amplitude;
  thrum_internal_force(b->model, q, force, b->work);
  for (int64_t i = 0; i < b->rank; i++) {
    const double part = force[i] - (i == mode ? omega2[i] * amplitude : 0);
    sum += omega2[i] > 0 ? part * part / omega2[i] : 0;
  }
  return sqrt(sum / omega2[mode]) / amplitude;
}

/* The first motion of a backbone is so small that it is next to linear. */
static thrum_status begin_backbone(curve *c, thrum_error *error) {
  thrum_balance *b = &c->balance;
  const int64_t mode = c->def->mode, n = b->unknowns;
  double amplitude = 1;
  if (!(b->model->omega2[mode] > 0))
    return thrum_error_set(error, THRUM_BAD_VALUE, "mode %lld has no stiffness",
                           (long long)mode + 1);
  for (int trial = 0; trial < SMALL_TRIALS; trial++) {
    const double share = nonlinear_share(c, amplitude);
    if (share > 0.5 * SMALL && share < SMALL)
      break;
    amplitude *= isfinite(share) ? fmin(fmax(0.75 * SMALL / share, 0.1), 10) : 0.1;
    if (!(amplitude < THRUM_RESPONSE_MOST && amplitude > 1 / THRUM_RESPONSE_MOST))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "mode %lld has no nonlinear force: its frequency is the same at "
                             "every amplitude",
                             (long long)mode + 1);
  }

  // the amplitude is held, the frequency is found
  amplitude = fmin(amplitude, 0.5 * c->def->amplitude);
  c->corrector.size = SIZE_FIRST * amplitude;
  memset(c->now.x, 0, (size_t)n * sizeof *c->now.x);
  c->now.x[b->rank + mode] = amplitude;
  c->now.omega = sqrt(b->model->omega2[mode]);
  memset(c->normal, 0, (size_t)(n + 1) * sizeof *c->normal);
  c->normal[b->rank + mode] = 1;
  const thrum_place anchor = {c->next.x, c->now.omega};
  memcpy(c->next.x, c->now.x, (size_t)n * sizeof *c->now.x);
  return thrum_corrector_solve(&c->corrector, c->normal, &anchor, 0, &c->now)
             ? THRUM_OK
             : thrum_error_set(error, THRUM_NOT_CONVERGED,
                               "no small motion in mode %lld was found: another mode may have "
                               "the same frequency",
                               (long long)mode + 1);
}

/* --- along the curve -------------------------------------------------------------------------- */

/* The unknowns are measured by the largest solution so far: directions follow. */
static void measure_anew(curve *c) {
  const int64_t n = c->balance.unknowns;
  const double length = length_of(n, c->now.x);
  if (length <= c->corrector.size)
    return;
  for (int64_t i = 0; i < n; i++) {
    c->normal[i] *= c->corrector.size / length;
    c->before[i] *= c->corrector.size / length;
    c->first_tangent[i] *= c->corrector.size / length;
  }
  for (int64_t i = 0; i < n && c->marked > 0; i++)
    c->mark_tangent[i] *= c->corrector.size / length;
  c->corrector.size = length;
  thrum_direction_normalise(n + 1, c->normal);
  thrum_direction_normalise(n + 1, c->before);
  thrum_direction_normalise(n + 1, c->first_tangent);
  if (c->marked > 0)
    thrum_direction_normalise(n + 1, c->mark_tangent);
}

/* The next point one step ahead, in c->next with its direction in c->tangent. */
static bool advance(curve *c) {
  const int64_t n = c->balance.unknowns;
  const double step = c->step;
  const double bend = c->step_before > 0 ? 0.5 * step * step / c->step_before : 0;
  for (int64_t i = 0; i < n; i++)
    c->next.x[i] = c->now.x[i] +
                   c->corrector.size * (step * c->normal[i] + bend * (c->normal[i] - c->before[i]));
  c->next.omega = c->now.omega +
                  c->corrector.width * (step * c->normal[n] + bend * (c->normal[n] - c->before[n]));
  if (!(c->next.omega > 0))
    return false;
  memcpy(c->at.x, c->next.x, (size_t)n * sizeof *c->at.x);
  c->at.omega = c->next.omega;
  if (!thrum_corrector_solve(&c->corrector, c->normal, &c->now, step, &c->next))
    return false;

  // far from the guess, or turned too far: another curve, or too long a step
  double away = (c->next.omega - c->at.omega) / c->corrector.width;
  away *= away;
  for (int64_t i = 0; i < n; i++) {
    const double part = (c->next.x[i] - c->at.x[i]) / c->corrector.size;
    away += part * part;
  }
  if (away > AWAY_MOST * AWAY_MOST * step * step)
    return false;
  thrum_corrector_tangent(&c->corrector, c->tangent);
  return thrum_direction_product(n + 1, c->normal, c->tangent) > TURN_MOST;
}

/* Moves c->next back to the frequency or the amplitude at which the curve ends: the component
 * `index` of the unknowns (all of them: the frequency) becomes `value`. */
static bool cut(curve *c, int64_t index, double value) {
  const int64_t n = c->balance.unknowns;
  const double from = index == n ? c->now.omega : c->now.x[index];
  const double to = index == n ? c->next.omega : c->next.x[index];
  const double share = (value - from) / (to - from);
  for (int64_t i = 0; i < n; i++)
    c->next.x[i] = c->now.x[i] + share * (c->next.x[i] - c->now.x[i]);
  c->next.omega = c->now.omega + share * (c->next.omega - c->now.omega);

  // the plane is that of the component
  double *plane = c->tangent_at;
  memset(plane, 0, (size_t)(n + 1) * sizeof *plane);
  plane[index] = to > from ? 1 : -1;
  memcpy(c->at.x, c->next.x, (size_t)n * sizeof *c->at.x);
  c->at.omega = c->next.omega;
  if (index == n)
    c->at.omega = value;
  else
    c->at.x[index] = value;
  if (!thrum_corrector_solve(&c->corrector, plane, &c->at, 0, &c->next))
    return false;
  thrum_corrector_tangent(&c->corrector, c->tangent);
  if (thrum_direction_product(n + 1, c->normal, c->tangent) < 0)
    for (int64_t i = 0; i <= n; i++)
      c->tangent[i] = -c->tangent[i];
  return true;
}

/* Whether the curve ends with c->next, which is then moved to the end; *lost: it was not found
 * there, and c->next is no motion. */
static bool ends(curve *c, bool *lost) {
  const thrum_response_def *def = c->def;
  const int64_t n = c->balance.unknowns;

  // a first point that was given may be of a curve to both sides of it: as far there as here
  const double behind = c->given ? def->from * def->from / def->to : def->from;
  const double low = fmin(behind, def->to), high = fmax(behind, def->to);
  const double omega = c->next.omega;
  if (def->mode >= 0) {
    const int64_t index = c->balance.rank + def->mode;
    if (fabs(c->next.x[index]) > def->amplitude) {
      *lost = !cut(c, index, copysign(def->amplitude, c->next.x[index]));
      c->report.end = THRUM_RESPONSE_END_AMPLITUDE;
      return true;
    }
  }
  const bool above = omega > high && c->now.omega <= high;
  const bool below = omega < low && c->now.omega >= low;
  if (!above && !below)
    return false;

  const double bound = above ? high : low;
  *lost = !cut(c, n, bound);
  c->report.end =
      def->mode < 0 && bound == behind ? THRUM_RESPONSE_END_LEFT : THRUM_RESPONSE_END_ARRIVED;
  return true;
}

/* Whether the piece that was made passes `place` in the direction there. */
static bool passes(const curve *c, const thrum_place *place, const double *tangent) {
  const int64_t n = c->balance.unknowns;
  double away = 0, along = 0;
  if (thrum_direction_product(n + 1, c->tangent, tangent) < TURN_MOST)
    return false;
  for (int64_t i = 0; i <= n; i++) {
    const double part = i < n ? (place->x[i] - c->now.x[i]) / c->corrector.size
                              : (place->omega - c->now.omega) / c->corrector.width;
    away += part * part;
    along += part * c->normal[i];
  }
  return along > 0 && along <= c->step && away < 1.2 * along * along;
}

/* Whether the curve is back at its first point, or at a mark on the way: a curve may come to
 * another that is closed. A mark is set where twice as many points are behind the last one. */
static bool closes(curve *c) {
  const int64_t n = c->balance.unknowns, behind = c->report.points - c->begun;
  if (behind >= CLOSED_LEAST && passes(c, &c->first, c->first_tangent))
    return true;
  if (c->marked > 0 && behind >= c->marked + CLOSED_LEAST && passes(c, &c->mark, c->mark_tangent))
    return true;
  if (behind >= 2 * c->marked + CLOSED_LEAST) {
    c->marked = (int32_t)behind;
    c->mark.omega = c->now.omega;
    memcpy(c->mark.x, c->now.x, (size_t)n * sizeof *c->mark.x);
    memcpy(c->mark_tangent, c->normal, (size_t)(n + 1) * sizeof *c->mark_tangent);
  }
  return false;
}

/* Finds the direction at c->next anew where it, or a parabola along the piece, says that the curve
 * has turned back: that of factors nearby may be from either side of a sharp fold. */
static void look_for_turn(curve *c, double step) {
  const int64_t n = c->balance.unknowns;
  const double before = c->normal[n];
  const double ahead = 2 * (c->next.omega - c->now.omega) / (c->corrector.width * step) - before;
  if (ahead * before < 0 || c->tangent[n] * before < 0)
    thrum_corrector_tangent_at(&c->corrector, c->normal, &c->next, c->tangent);
}

/* The motion at a special point, or next to it: where curves cross Newton's method may find none.
 */
static bool find_special(thrum_piece *piece, double position) {
  if (thrum_piece_at(piece, position))
    return true;
  for (double beside = BESIDE_LEAST; beside < BESIDE_MOST; beside *= 10)
    for (int side = -1; side <= 1; side += 2)
      if (thrum_piece_at(piece, position + side * beside))
        return true;
  return false;
}

/* The step to c->next along the normal. */
static double step_to_next(const curve *c) {
  const int64_t n = c->balance.unknowns;
  double step = c->normal[n] * (c->next.omega - c->now.omega) / c->corrector.width;
  for (int64_t i = 0; i < n; i++)
    step += c->normal[i] * (c->next.x[i] - c->now.x[i]) / c->corrector.size;
  return step;
}

/* Whether the step may have leapt to the same motion some periods of the load later. Where such
 * motions come near each other they turn back, and a long step goes straight on to another. */
static bool may_leap(const curve *c) {
  const int64_t n = c->balance.unknowns;
  return c->def->periods > 1 && c->normal[n] * c->tangent[n] < 0 &&
         c->step > LEAP_LEAST * c->def->step;
}

/* Shows what is between c->now and c->next, and then that, or ends at the branch point that was
 * asked for, in c->at; false where the caller wants no more. */
static bool show_piece(curve *c) {
  thrum_balance *b = &c->balance;
  const int32_t iterations = c->corrector.last_iterations;
  const double step = step_to_next(c);
  const int sign = thrum_corrector_sign(&c->corrector);
  const int32_t unstable = look_at_stability(c, &c->next);
  if (unstable >= 0)
    memcpy(c->kept, c->floquet.values, (size_t)(4 * b->rank) * sizeof *c->kept);

  // special points in between, in their order
  double positions[THRUM_SPECIAL_MAX];
  thrum_response_kind kinds[THRUM_SPECIAL_MAX];
  thrum_piece piece = {.corrector = &c->corrector,
                       .floquet = c->def->stability != 0 ? &c->floquet : NULL,
                       .normal = c->normal,
                       .tangent = c->tangent,
                       .begin = c->now,
                       .end = c->next,
                       .step = step,
                       .behind = c->arc / step,
                       .unstable_begin = c->unstable,
                       .unstable_end = unstable,
                       .sign_begin = c->sign,
                       .sign_end = sign,
                       .at = c->at,
                       .tangent_at = c->tangent_at};
  const int32_t count = thrum_piece_specials(&piece, positions, kinds);
  c->sign = piece.sign_end;
  for (int32_t k = 0; k < count; k++) {
    if (!find_special(&piece, positions[k]))
      continue;
    const int32_t there = look_at_stability(c, &piece.at);
    if (!show(c, &piece.at, c->arc + positions[k] * step, kinds[k], there,
              there >= 0 ? c->floquet.values : NULL))
      return false;
    if (kinds[k] != THRUM_RESPONSE_BRANCH)
      continue;

    // the direction of factors nearby may be that before the crossing
    if (++c->crossings != llabs(c->def->branch)) {
      thrum_corrector_tangent_at(&c->corrector, c->normal, &c->next, c->tangent);
    } else {
      c->at.omega = piece.at.omega;
      c->arc += positions[k] * step;
      c->crossed = true;
      return true;
    }
  }

  // and the point itself
  c->arc += step;
  c->unstable = unstable;
  c->corrector.last_iterations = iterations;
  return show(c, &c->next, c->arc, THRUM_RESPONSE_REGULAR, unstable,
              unstable >= 0 ? c->kept : NULL);
}

/* c->next becomes c->now. */
static void move_on(curve *c) {
  const int64_t n = c->balance.unknowns;
  const thrum_place place = c->now;
  c->now = c->next;
  c->next = place;
  memcpy(c->before, c->normal, (size_t)(n + 1) * sizeof *c->before);
  memcpy(c->normal, c->tangent, (size_t)(n + 1) * sizeof *c->normal);
  c->step_before = c->step;
}

/* The curve begins at c->now in its direction. */
static void begin_here(curve *c) {
  const int64_t n = c->balance.unknowns;
  memcpy(c->first_tangent, c->normal, (size_t)(n + 1) * sizeof *c->normal);
  memcpy(c->first.x, c->now.x, (size_t)n * sizeof *c->first.x);
  c->first.omega = c->now.omega;
  memset(c->before, 0, (size_t)(n + 1) * sizeof *c->before);
  c->before[n] = 1;
  c->step_before = 0;
  c->marked = 0;
  c->sign = thrum_corrector_sign(&c->corrector);
}

/* The direction at c->now by factors of its own: those of its last iteration may be of a place that
 * is far for what resonates sharply. */
static void turn_anew(curve *c) {
  const size_t size = (size_t)(c->balance.unknowns + 1) * sizeof *c->normal;
  if (!thrum_corrector_tangent_at(&c->corrector, c->normal, &c->now, c->tangent))
    return;
  memcpy(c->normal, c->tangent, size);
  c->step_before = 0;
}

/* Goes over to the other curve through the branch point in c->at: along the direction that stands
 * on that of the curve and that the equations do not hold, to a plane across it (Keller 1977).
 * False where no motion is found there; *wanted: whether the caller wants more. */
static bool take_branch(curve *c, bool *wanted) {
  const int64_t n = c->balance.unknowns;
  double *across = c->before;
  if (!thrum_corrector_tangent_at(&c->corrector, c->normal, &c->at, c->tangent_at))
    return false;
  thrum_corrector_null(&c->corrector, across);
  for (int64_t i = 0; i <= n && c->def->branch < 0; i++)
    across[i] = -across[i];

  // the nearest place where both curves are apart
  bool found = false;
  for (double step = BRANCH_LEAST * c->def->step; !found && step <= c->def->step; step *= 2) {
    for (int64_t i = 0; i < n; i++)
      c->next.x[i] = c->at.x[i] + step * c->corrector.size * across[i];
    c->next.omega = c->at.omega + step * c->corrector.width * across[n];
    found =
        c->next.omega > 0 && thrum_corrector_solve(&c->corrector, across, &c->at, step, &c->next);
    c->step = step;
  }
  if (!found)
    return false;

  // the curve goes on from there, away from the crossing
  for (int64_t i = 0; i < n; i++)
    c->normal[i] = (c->next.x[i] - c->at.x[i]) / c->corrector.size;
  c->normal[n] = (c->next.omega - c->at.omega) / c->corrector.width;
  thrum_direction_normalise(n + 1, c->normal);
  if (!thrum_corrector_tangent_at(&c->corrector, c->normal, &c->next, c->tangent))
    return false;
  c->arc += c->step;
  c->begun = c->report.points;
  c->unstable = look_at_stability(c, &c->next);
  *wanted = show(c, &c->next, c->arc, THRUM_RESPONSE_REGULAR, c->unstable,
                 c->unstable >= 0 ? c->floquet.values : NULL);
  move_on(c);
  begin_here(c);
  return true;
}

static void follow(curve *c) {
  const double longest = c->def->step;
  c->step = STEP_FIRST * longest;
  while (c->report.points < c->def->points) {
    measure_anew(c);
    bool lost = !advance(c);
    const int32_t iterations = c->corrector.last_iterations;
    const bool last = !lost && ends(c, &lost);
    if (lost) {
      c->step *= 0.5;
      if (c->step_before > 0 && c->step < STEP_CUT * c->step_before)
        turn_anew(c);
      if (c->step < STEP_LEAST * longest) {
        c->report.end = THRUM_RESPONSE_END_LOST;
        return;
      }
      continue;
    }
    look_for_turn(c, step_to_next(c));
    if (!last && may_leap(c)) {
      c->step *= 0.5;
      continue;
    }
    const bool closed = closes(c);
    bool wanted = show_piece(c);
    if (c->crossed) {
      c->crossed = false;
      if (wanted && take_branch(c, &wanted) && wanted)
        continue;
      c->report.end = wanted ? THRUM_RESPONSE_END_LOST : THRUM_RESPONSE_END_STOPPED;
      return;
    }
    if (!wanted) {
      c->report.end = THRUM_RESPONSE_END_STOPPED;
      return;
    }
    if (closed)
      c->report.end = THRUM_RESPONSE_END_CLOSED;
    if (last || closed)
      return;
    move_on(c);
    if (iterations <= EASY)
      c->step = fmin(GROW * c->step, longest);
  }
  c->report.end = THRUM_RESPONSE_END_POINTS;
}

thrum_status thrum_response(const thrum_model *model, const thrum_response_def *def,
                            const double *start, void *workspace, size_t workspace_size,
                            bool (*visit)(void *context, const thrum_response_point *point),
                            void *context, thrum_response_report *report, thrum_error *error) {
  thrum_response_def whole = thrum_default_response_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  size_t size = 0;
  THRUM_TRY(thrum_response_size(model, def, &size, error));
  if (report == NULL || workspace == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "report or workspace is NULL");
  if ((uintptr_t)workspace % 64 != 0)
    return thrum_error_set(error, THRUM_MISALIGNED, "the workspace is not aligned to 64");
  if (workspace_size < size)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                           "the workspace has %zu bytes, and %zu are needed", workspace_size, size);
  if (start != NULL &&
      !thrum_all_within(start, (2 * def->harmonics + 1) * model->rank, THRUM_RESPONSE_MOST))
    return thrum_error_set(error, THRUM_BAD_VALUE, "start has a number that is not finite");

  // the head of the workspace holds what is known of the curve
  curve *c = workspace;
  *c = (curve){0};
  thrum_room room = {(double *)(void *)((char *)workspace + head_bytes()), 0};
  lay(c, model, def, &room);
  thrum_balance_fill(&c->balance);
  if (c->balance.slaves.count > 0)
    thrum_slave_inertia_fill(&c->balance.slaves, model);
  c->visit = visit;
  c->context = context;
  c->given = start != NULL;
  c->corrector.width = fabs(def->to - def->from);
  THRUM_TRY(def->mode < 0 ? begin_forced(c, start, error) : begin_backbone(c, error));

  // the direction of the first point, by factors there
  const int64_t n = c->balance.unknowns;
  if (!thrum_corrector_tangent_at(&c->corrector, c->normal, &c->now, c->tangent))
    return thrum_error_set(error, THRUM_NOT_CONVERGED,
                           "the first point is singular: begin at another frequency");
  memcpy(c->normal, c->tangent, (size_t)(n + 1) * sizeof *c->normal);
  begin_here(c);
  c->unstable = look_at_stability(c, &c->now);
  if (!show(c, &c->now, 0, THRUM_RESPONSE_REGULAR, c->unstable,
            c->unstable >= 0 ? c->floquet.values : NULL))
    c->report.end = THRUM_RESPONSE_END_STOPPED;
  else
    follow(c);

  c->report.iterations = c->corrector.iterations;
  c->report.factorisations = c->corrector.factorisations;
  *report = c->report;
  return THRUM_OK;
}

void thrum_response_at(int64_t rank, int32_t harmonics, double omega, double phase,
                       const double *coefficients, double *q, double *p) {
  for (int64_t i = 0; i < rank; i++) {
    if (q != NULL)
      q[i] = coefficients[i];
    if (p != NULL)
      p[i] = 0;
  }
  for (int32_t k = 1; k <= harmonics; k++) {
    const double *a = coefficients + k * rank, *b = coefficients + (harmonics + k) * rank;
    const double c = cos(k * phase), s = sin(k * phase), rate = k * omega;
    for (int64_t i = 0; q != NULL && i < rank; i++)
      q[i] += a[i] * c + b[i] * s;
    for (int64_t i = 0; p != NULL && i < rank; i++)
      p[i] += rate * (b[i] * c - a[i] * s);
  }
}
