/* A curve of periodic motions: the request becomes a def of thrum/response.h, and its points become
 * rows with what is seen of them. SPDX-License-Identifier: Apache-2.0 */
#include "driver/response/response_curve.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "config/progress.h"
#include "core/base/pi.h"
#include "core/base/vec3.h"
#include "driver/model/model_cut.h"
#include "driver/model/model_meta.h"
#include "driver/response/response_orbit.h"
#include "io/npy_file.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "platform/stop_request.h"
#include "thrum/thrum.h"

#define MASTERS_MOST 8    /* that are stepped where the request leaves it open */
#define HARMONICS_FIRST 5 /* tried where it leaves those open, */
#define HARMONICS_MORE 4  /* and so many more each time, */
#define TAIL_MOST 1e-6    /* while the last two have more of the kinetic energy */
#define TAIL_HELPED 0.5   /* of the least share so far: a curve without an end that leaves more */
#define TRIES_IN_VAIN 2   /* such curves, after which that of the least share is taken */
#define PHASES_LEAST 64   /* at which the largest displacement is looked for, */
#define PHASES_EACH 8     /* and so many for each harmonic */
#define ROOM_FIRST 256
#define FORCED_FROM 0.8 /* of the first frequency */
#define FORCED_TO 1.2
#define FREE_FROM 0.5
#define FREE_TO 2.0
#define AMPLITUDE_SHORT                                                                            \
  1e-3                     /* so little may a backbone end below --amplitude, and it is not above */
#define AMPLITUDE_PASSES 6 /* at finding the bound */
#define PAIR_NEAR                                                                                  \
  0.05                  /* of a ratio of frequencies: two modes so near to 1, 2 or 3 are one form  \
                         */
#define FORM_PASSES 4   /* of finding the amplitude at which a normal form is found */
#define FORM_SHARE 0.1  /* of the frequency that its first coefficient makes there */
#define FORM_APART 0.01 /* of the frequency: orders so far apart are no longer good */
#define FORM_HALVINGS 60

/* --- the model -------------------------------------------------------------------------------- */

/* Masters where the request leaves it open: the modes whose derivatives are all there. */
static int64_t masters_by_model(const thrum_model *model) {
  if (thrum_model_masters(model) > 0 || model->point_count > 0)
    return thrum_model_masters(model);
  cJSON *meta = model_meta_parse(model);
  const cJSON *modes = model_meta_find(meta, "options", "modes");
  int64_t masters = cJSON_IsNumber(modes) ? (int64_t)modes->valuedouble : 0;
  cJSON_Delete(meta);
  if (masters > MASTERS_MOST)
    masters = MASTERS_MOST;
  return masters > 0 && model->rank >= masters + masters * (masters + 1) / 2 ? masters : 0;
}

static thrum_status make_model(response_curve *c, thrum_error *error) {
  const thrum_model *loaded = c->loaded;
  int64_t masters = c->request->condense;
  if (masters < 0)
    masters = masters_by_model(loaded);
  if (masters == 0 && thrum_model_masters(loaded) > 0)
    return thrum_error_set(error, THRUM_MISSING,
                           "--condense none: the model was precomputed condensed to %lld "
                           "coordinates, and has no polynomial of all %lld",
                           (long long)thrum_model_masters(loaded), (long long)loaded->rank);
  if (masters == loaded->rank)
    masters = 0;
  THRUM_TRY(model_condense_to(loaded, masters, &c->memory, &c->stepped, error));
  c->shape = thrum_condensed_shape_model(c->stepped);
  if (c->request->mode > c->stepped->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--mode %lld: the model has %lld coordinates that move",
                           (long long)c->request->mode, (long long)c->stepped->rank);
  return THRUM_OK;
}

/* --- what is looked at ------------------------------------------------------------------------ */

/* The vertex that moves furthest in the mode, or in the first. */
static thrum_status furthest_vertex(response_curve *c, thrum_error *error) {
  double *q = NULL, length = 0;
  int64_t vertex = 0;
  if (c->shape->basis == NULL)
    return THRUM_OK;
  THRUM_TRY(thrum_reserve(&q, 2 * c->shape->rank, sizeof *q, "the mode", error));
  q[c->request->mode > 0 ? c->request->mode - 1 : 0] = 1;
  thrum_status status = thrum_basis_extents(c->shape, q + c->shape->rank, error);
  THRUM_THEN(status,
             thrum_displacement_peak(c->shape, q + c->shape->rank, q, &length, &vertex, error));
  free(q);
  snprintf(c->vertex, sizeof c->vertex, "vertex=%lld", (long long)vertex + 1);
  return status;
}

/* The displacement of each target under a unit of each coordinate. */
static thrum_status see_targets(response_curve *c, const load_target *targets, thrum_error *error) {
  const int64_t rank = c->shape->rank;
  double *q = NULL;
  THRUM_TRY(
      thrum_reserve(&c->seen, 3 * c->target_count * rank, sizeof *c->seen, "the targets", error));
  THRUM_TRY(thrum_reserve(&q, rank, sizeof *q, "the targets", error));
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < c->target_count && status >= 0; n++) {
    load_vertices at = {0};
    status = config_error_in(error, load_target_find(c->shape, &targets[n], &at, error), "%s",
                             n < c->request->target_given ? "--at" : "--load");
    for (int64_t i = 0; i < rank && status >= 0; i++) {
      double mean[3] = {0, 0, 0};
      q[i] = 1;
      status = thrum_displacement_mean(c->shape, at.list, at.count, q, mean, error);
      q[i] = 0;
      for (int axis = 0; axis < 3; axis++)
        c->seen[(3 * n + axis) * rank + i] = mean[axis];
    }
    load_vertices_free(&at);
  }
  free(q);
  return status;
}

/* What follows is a square of what moves: c->follow has what units and pairs of units make of it.
 */
static thrum_status find_following(response_curve *c, thrum_error *error) {
  const int64_t moving = c->stepped->rank, rank = c->shape->rank, following = rank - moving;
  if (c->shape == c->stepped)
    return THRUM_OK;
  c->pairs = moving * (moving + 1) / 2;
  THRUM_TRY(
      thrum_reserve(&c->follow, c->pairs * following, sizeof *c->follow, "what follows", error));
  double *row = c->follow;
  for (int64_t i = 0; i < moving; i++)
    for (int64_t j = i; j < moving; j++, row += following) {
      double x[THRUM_RANK_MAX] = {0}, q[THRUM_RANK_MAX];
      x[i] = x[j] = 1;
      thrum_condensed_shape(c->stepped, x, NULL, q);
      memcpy(row, q + moving, (size_t)following * sizeof *row);

      // without the squares of both
      for (int64_t unit = i; i != j && unit <= j; unit += j - i) {
        memset(x, 0, sizeof x);
        x[unit] = 1;
        thrum_condensed_shape(c->stepped, x, NULL, q);
        for (int64_t h = 0; h < following; h++)
          row[h] -= q[moving + h];
      }
    }
  return THRUM_OK;
}

/* Numbers of a line of c->sight. */
static int64_t sight_of(const response_curve *c) {
  return c->stepped->rank + c->pairs + 3;
}

/* What is seen of each coordinate that moves, of each pair and of the parts of the load. */
static thrum_status find_sight(response_curve *c, thrum_error *error) {
  const int64_t moving = c->stepped->rank, rank = c->shape->rank, following = rank - moving;
  const int64_t width = sight_of(c);
  THRUM_TRY(thrum_reserve(&c->sight, 3 * c->target_count * width, sizeof *c->sight, "the targets",
                          error));
  for (int64_t line = 0; line < 3 * c->target_count; line++) {
    const double *seen = c->seen + line * rank;
    double *sight = c->sight + line * width;
    memcpy(sight, seen, (size_t)moving * sizeof *sight);
    for (int64_t n = 0; n < c->pairs; n++)
      for (int64_t h = 0; h < following; h++)
        sight[moving + n] += seen[moving + h] * c->follow[n * following + h];
    for (int part = 0; part < 3; part++)
      for (int64_t h = moving; h < rank; h++)
        sight[moving + c->pairs + part] += seen[h] * c->loads[part][h] / c->shape->omega2[h];
  }
  return THRUM_OK;
}

static thrum_status choose_targets(response_curve *c, thrum_error *error) {
  const response_request *request = c->request;
  c->at = request->at;
  c->target_count = request->target_count;
  if (request->target_count > 0)
    return see_targets(c, request->targets, error);

  // where nothing is named the mode says what is worth a look
  static const char *names[1];
  load_target target = {0};
  THRUM_TRY(furthest_vertex(c, error));
  if (c->vertex[0] == 0)
    return THRUM_OK;
  THRUM_TRY(load_target_parse(c->vertex, "--at", &target, error));
  names[0] = c->vertex;
  c->at = names;
  c->target_count = 1;
  return see_targets(c, &target, error);
}

/* --- opening ---------------------------------------------------------------------------------- */

static thrum_status make_loads(response_curve *c, thrum_error *error) {
  const response_request *request = c->request;
  const int64_t rank = c->shape->rank;
  THRUM_TRY(thrum_reserve(&c->loads[0], 4 * rank, sizeof **c->loads, "the loads", error));
  c->loads[1] = c->loads[0] + rank;
  c->loads[2] = c->loads[1] + rank;
  bool any = request->load_count == 0;
  for (int64_t n = 0; n < request->load_count; n++) {
    const response_load *load = &request->loads[n];
    double *reduced = c->loads[2] + rank;
    bool idle = true;
    THRUM_TRY(
        response_load_add(c->shape, load, c->loads[0], c->loads[1], c->loads[2], reduced, error));
    for (int64_t i = 0; i < rank; i++)
      idle = idle && reduced[i] == 0;
    idle = idle || (load->base && c->shape->rigid != NULL);
    any = any || (load->swings && !idle);
    if (idle && n + 1 == request->load_count && !any)
      return thrum_error_set(error, THRUM_MISSING,
                             "%s '%.200s' moves nothing: it is zero, all of its vertices are held, "
                             "or nothing holds the body",
                             load->base ? "--base-motion" : "--load", load->text);
    if (idle)
      config_warn("%s '%s' moves nothing: it is zero, or all of its vertices are held",
                  load->base ? "--base-motion" : "--load", load->text);
  }

  // a free body has no coordinates for what moves it as a whole
  if (c->shape->rigid != NULL && request->load_count > 0)
    config_warn("nothing holds the body: what of the loads moves it as a whole has no effect");
  return THRUM_OK;
}

thrum_status response_curve_open(const response_request *request, const thrum_model *loaded,
                                 response_curve *curve, thrum_error *error) {
  *curve = (response_curve){.request = request, .loaded = loaded};
  THRUM_TRY(make_model(curve, error));
  THRUM_TRY(choose_targets(curve, error));
  THRUM_TRY(make_loads(curve, error));
  THRUM_TRY(find_following(curve, error));
  THRUM_TRY(find_sight(curve, error));
  THRUM_TRY(
      thrum_reserve(&curve->rates, curve->shape->rank, sizeof *curve->rates, "the damping", error));
  damping_spec_rates(&request->damping, curve->shape->omega2, curve->shape->rank,
                     model_meta_modes(curve->shape), curve->rates);

  // the range, by the mode where it is not given
  const int64_t mode = request->mode > 0 ? request->mode - 1 : 0;
  const double hertz = sqrt(curve->stepped->omega2[mode]) / THRUM_TWO_PI;
  const bool is_free = request->mode > 0;
  curve->from = request->from > 0 ? request->from : (is_free ? FREE_FROM : FORCED_FROM) * hertz;
  curve->to = request->to > 0 ? request->to : (is_free ? FREE_TO : FORCED_TO) * hertz;
  if (!is_free && !damping_spec_given(&request->damping))
    config_warn("nothing damps the body from %.4g to %.4g Hz: the resonance has no end, and the "
                "curve follows it out of the range; give --damping-ratio or --q",
                curve->from, curve->to);
  return THRUM_OK;
}

static void drop_rows(response_curve *c) {
  free(c->rows);
  free(c->coefficients);
  free(c->harmonic);
  free(c->peak);
  c->rows = NULL;
  c->coefficients = c->harmonic = c->peak = NULL;
  c->count = c->room = 0;
}

void response_curve_close(response_curve *curve) {
  drop_rows(curve);
  free(curve->memory);
  free(curve->rates);
  free(curve->loads[0]);
  free(curve->seen);
  free(curve->follow);
  free(curve->sight);
  free(curve->waves);
  *curve = (response_curve){0};
}

/* --- rows ------------------------------------------------------------------------------------- */

/* Numbers of a row in each of its arrays. */
static int64_t coefficients_of(const response_curve *c) {
  return (2 * c->harmonics + 1) * c->stepped->rank;
}
static int64_t harmonics_of(const response_curve *c) {
  return c->target_count * 3 * (2 * c->harmonics + 1);
}

static thrum_status grow(void **array, int64_t room, int64_t numbers, size_t size,
                         thrum_error *error) {
  void *grown = realloc(*array, (size_t)(room * numbers + 1) * size);
  if (grown == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %lld points of the curve",
                           (long long)room);
  *array = grown;
  return THRUM_OK;
}

static thrum_status make_room(response_curve *c) {
  if (c->count < c->room)
    return THRUM_OK;
  const int64_t room = c->room > 0 ? 2 * c->room : ROOM_FIRST;
  void *rows = c->rows, *coefficients = c->coefficients, *harmonic = c->harmonic, *peak = c->peak;
  thrum_status status = grow(&rows, room, 1, sizeof *c->rows, &c->failure);
  THRUM_THEN(status, grow(&coefficients, room, coefficients_of(c), sizeof(double), &c->failure));
  THRUM_THEN(status, grow(&harmonic, room, harmonics_of(c), sizeof(double), &c->failure));
  THRUM_THEN(status, grow(&peak, room, c->target_count, sizeof(double), &c->failure));
  c->rows = rows;
  c->coefficients = coefficients;
  c->harmonic = harmonic;
  c->peak = peak;
  if (status >= 0)
    c->room = room;
  return status;
}

/* Numbers of a sample of the waves: cosine and sine of k times its phase, for all k up to 2 H. */
static int64_t wave_width(const response_curve *c) {
  return 2 * (2 * c->harmonics + 1);
}

/* Samples that tell what is quadratic in the motion. */
static int64_t samples_of(const response_curve *c) {
  return 4 * c->harmonics + 1;
}

static int64_t phases_of(const response_curve *c) {
  const int64_t phases = PHASES_EACH * c->harmonics;
  return phases > PHASES_LEAST ? phases : PHASES_LEAST;
}

/* The waves at those samples and at the phases, and room for the series of all targets. */
static thrum_status make_waves(response_curve *c, thrum_error *error) {
  const int64_t n = samples_of(c), phases = phases_of(c), width = wave_width(c);
  THRUM_TRY(thrum_reserve(&c->waves, (n + phases + 3 * c->target_count + c->shape->rank) * width,
                          sizeof *c->waves, "the phases", error));
  for (int64_t s = 0; s < n + phases; s++)
    for (int64_t k = 0; k < width / 2; k++) {
      const double share =
          s < n ? (double)(k * s % n) / (double)n : (double)(k * (s - n) % phases) / (double)phases;
      c->waves[s * width + 2 * k] = cos(THRUM_TWO_PI * share);
      c->waves[s * width + 2 * k + 1] = sin(THRUM_TWO_PI * share);
    }
  c->series = c->waves + (n + phases) * width;
  c->moving = c->series + 3 * c->target_count * width;
  return THRUM_OK;
}

/* The coordinates that move at a sample, and their products. */
static void moving_at(const response_curve *c, const double *coefficients, const double *wave,
                      double *x) {
  const int64_t r = c->stepped->rank, h = c->harmonics;
  memcpy(x, coefficients, (size_t)r * sizeof *x);
  for (int64_t k = 1; k <= h; k++)
    for (int64_t i = 0; i < r; i++)
      x[i] +=
          wave[2 * k] * coefficients[k * r + i] + wave[2 * k + 1] * coefficients[(h + k) * r + i];
  double *product = x + r;
  for (int64_t i = 0; i < r && c->pairs > 0; i++)
    for (int64_t j = i; j < r; j++)
      *product++ = x[i] * x[j];
}

/* The parts of the load at a sample. */
static void load_at(const response_curve *c, const double *wave, double parts[3]) {
  const double *swing = wave + 2 * c->request->periods;
  parts[0] = 1;
  parts[1] = swing[0];
  parts[2] = swing[1];
}

/* The coordinates of the shape at a sample, where x has what moves and its products. */
static void shape_at(const response_curve *c, const double *x, const double *wave, double *q) {
  const int64_t r = c->stepped->rank, rank = c->shape->rank;
  double parts[3];
  load_at(c, wave, parts);
  memcpy(q, x, (size_t)r * sizeof *q);
  for (int64_t i = r; i < rank; i++) {
    q[i] = 0;
    for (int part = 0; part < 3; part++)
      q[i] += parts[part] * c->loads[part][i] / c->shape->omega2[i];
  }
  for (int64_t n = 0; n < c->pairs; n++)
    for (int64_t h = 0; h < rank - r; h++)
      q[r + h] += x[r + n] * c->follow[n * (rank - r) + h];
}

/* The largest length of a displacement over a period, of the series of x, y and z. */
static double longest(const response_curve *c, const double *series) {
  const int64_t width = wave_width(c), phases = phases_of(c);
  double most = 0;
  for (int64_t s = 0; s < phases; s++) {
    const double *wave = c->waves + (samples_of(c) + s) * width;
    double square = 0;
    for (int axis = 0; axis < 3; axis++) {
      double u = 0;
      for (int64_t e = 0; e < width; e++)
        u += series[axis * width + e] * wave[e];
      square += u * u;
    }
    most = fmax(most, square);
  }
  return sqrt(most);
}

/* What is seen at the targets: the largest displacement over a period, and its harmonics. It is
 * quadratic in what moves, so 2 H harmonics are all. */
static void see(response_curve *c, const thrum_response_point *point) {
  const int64_t h = c->harmonics, n = samples_of(c), width = wave_width(c), numbers = sight_of(c);
  const int64_t seen = 3 * c->target_count;
  memset(c->series, 0, (size_t)(seen * width) * sizeof *c->series);
  for (int64_t s = 0; s < n; s++) {
    const double *wave = c->waves + s * width;
    moving_at(c, point->coefficients, wave, c->moving);
    load_at(c, wave, c->moving + numbers - 3);
    for (int64_t line = 0; line < seen; line++) {
      double u = 0;
      for (int64_t i = 0; i < numbers; i++)
        u += c->sight[line * numbers + i] * c->moving[i];
      for (int64_t e = 0; e < width; e++)
        c->series[line * width + e] += (e < 2 ? 1 : 2) * u * wave[e] / (double)n;
    }
  }

  // the harmonics of the motion, mean, cosines and sines
  double *harmonic = c->harmonic + c->count * harmonics_of(c);
  for (int64_t line = 0; line < seen; line++, harmonic += 2 * h + 1)
    for (int64_t k = 0; k <= h; k++) {
      harmonic[k] = c->series[line * width + 2 * k];
      if (k > 0)
        harmonic[h + k] = c->series[line * width + 2 * k + 1];
    }
  for (int64_t target = 0; target < c->target_count; target++)
    c->peak[c->count * c->target_count + target] = longest(c, c->series + 3 * target * width);
}

static bool keep_row(void *context, const thrum_response_point *point) {
  response_curve *c = context;
  if (make_room(c) < 0)
    return false;
  response_row *row = &c->rows[c->count];
  *row = (response_row){.point = *point, .multiplier = {NAN, NAN}};
  if (point->multipliers != NULL)
    memcpy(row->multiplier, point->multipliers, sizeof row->multiplier);
  row->point.multipliers = row->point.coefficients = NULL;
  row->point.omega *= (double)c->request->periods;
  memcpy(c->coefficients + c->count * coefficients_of(c), point->coefficients,
         (size_t)coefficients_of(c) * sizeof(double));
  see(c, point);
  c->count++;
  return !thrum_stop_requested();
}

double response_curve_amplitude(const response_curve *curve, int64_t row, int64_t target, int axis,
                                int64_t k, double *phase) {
  const int64_t count = 2 * curve->harmonics + 1;
  const double *of = curve->harmonic + row * harmonics_of(curve) + (3 * target + axis) * count;
  const double cosine = of[k], sine = of[curve->harmonics + k];
  *phase = atan2(cosine, sine);
  return hypot(cosine, sine);
}

void response_curve_shape(const response_curve *curve, int64_t row, double *out) {
  const int64_t rank = curve->shape->rank, n = samples_of(curve), most = 2 * curve->harmonics;
  double q[THRUM_RANK_MAX];
  memset(out, 0, (size_t)((2 * most + 1) * rank) * sizeof *out);
  for (int64_t s = 0; s < n; s++) {
    const double *wave = curve->waves + s * wave_width(curve);
    moving_at(curve, curve->coefficients + row * coefficients_of(curve), wave, curve->moving);
    shape_at(curve, curve->moving, wave, q);
    for (int64_t block = 0; block <= 2 * most; block++) {
      const int64_t k = block <= most ? block : block - most;
      const double share = (k > 0 ? 2 : 1) * wave[2 * k + (block > most)] / (double)n;
      for (int64_t i = 0; i < rank; i++)
        out[block * rank + i] += share * q[i];
    }
  }
}

void response_curve_state(const response_curve *curve, int64_t row, double *q, double *p) {
  const double *coefficients = curve->coefficients + row * coefficients_of(curve);
  double x[THRUM_RANK_MAX], v[THRUM_RANK_MAX];

  // a run begins without the static answer of the slaves, which it adds by itself
  thrum_response_at(curve->stepped->rank, (int32_t)curve->harmonics,
                    curve->rows[row].point.omega / (double)curve->request->periods, 0, coefficients,
                    x, v);
  thrum_condensed_shape(curve->stepped, x, NULL, q);
  thrum_condensed_velocity(curve->stepped, x, v, p);
}

/* --- finding ---------------------------------------------------------------------------------- */

static thrum_response_def def_of(const response_curve *c, bool stability) {
  const response_request *request = c->request;
  thrum_response_def def = thrum_default_response_def();
  def.harmonics = (int32_t)c->harmonics;
  def.mode = request->mode - 1;
  def.from = THRUM_TWO_PI * c->from / (double)request->periods;
  def.to = THRUM_TWO_PI * c->to / (double)request->periods;
  def.periods = (int32_t)request->periods;
  def.branch = (int32_t)(request->other_side ? -request->branch : request->branch);
  def.step = request->step;
  def.points = (int32_t)request->points_max;
  def.tolerance = request->tolerance;
  def.stability = stability;
  def.stability_steps = (int32_t)request->stability_steps;
  def.inertia = request->followers;
  if (request->mode > 0)
    return def;
  def.damping = damping_spec_given(&request->damping) ? c->rates : NULL;
  if (def.damping != NULL && c->shape != c->stepped)
    def.slave_damping = c->rates + c->stepped->rank;
  def.load_mean = c->loads[0];
  def.load_cosine = c->loads[1];
  def.load_sine = c->loads[2];
  return def;
}

/* The coordinate of the mode at which its furthest vertex alone is displaced by --amplitude, or by
 * the longest side of the body, beyond which no backbone means anything. */
static thrum_status bound_amplitude(const response_curve *c, thrum_response_def *def,
                                    thrum_error *error) {
  const thrum_model *shape = c->shape;
  const bool given = isfinite(c->request->amplitude);
  if (def->mode < 0 || (!given && (shape->basis == NULL || shape->vertices == NULL)))
    return THRUM_OK;
  double q[THRUM_RANK_MAX] = {0}, amplitude = c->request->amplitude;
  if (!given)
    amplitude = thrum_box3_longest(shape->vertices, shape->vertex_count);
  THRUM_TRY(
      config_error_in(error, thrum_mode_add(shape, def->mode, amplitude, q, error), "--amplitude"));
  def->amplitude = fabs(q[def->mode]);
  return THRUM_OK;
}

/* The bound at which the largest displacement of the first target is --amplitude, by what the last
 * motion has with the bound so far; NaN where that will do, which is a little below. */
static double better_amplitude(const response_curve *c, double bound) {
  const double wanted = c->request->amplitude * (1 - 0.5 * AMPLITUDE_SHORT);
  if (c->report.end != THRUM_RESPONSE_END_AMPLITUDE || c->target_count == 0 || !isfinite(wanted))
    return NAN;
  const double found = c->peak[(c->count - 1) * c->target_count];
  if (found <= c->request->amplitude && found >= c->request->amplitude * (1 - AMPLITUDE_SHORT))
    return NAN;
  return bound * wanted / found;
}

/* The coefficients near the motion that --start-from names; *start stays NULL without it. */
static thrum_status find_start(const response_curve *c, double **start, thrum_error *error) {
  const char *path = c->request->start_from;
  double *state = NULL;
  int64_t rows = 0, columns = 0;
  if (path == NULL)
    return THRUM_OK;
  THRUM_TRY(thrum_npy_read_f8(path, &state, &rows, &columns, error));
  thrum_status status = THRUM_OK;
  if (rows != 2 || columns != c->shape->rank)
    status = thrum_error_set(error, THRUM_BAD_SHAPE,
                             "--start-from %.200s: a state has 2 rows of %lld numbers, not %lld of "
                             "%lld",
                             path, (long long)c->shape->rank, (long long)rows, (long long)columns);
  const double *const loads[3] = {c->loads[0], c->loads[1], c->loads[2]};
  const response_orbit orbit = {c->shape, c->rates, loads, THRUM_TWO_PI * c->from,
                                c->request->periods};
  THRUM_THEN(status, thrum_reserve(start, coefficients_of(c), sizeof **start, "the start", error));
  THRUM_THEN(status, response_orbit_coefficients(&orbit, state, state + columns, c->stepped->rank,
                                                 c->harmonics, *start, error));
  free(state);
  return status;
}

static thrum_status follow(response_curve *c, bool stability, thrum_error *error) {
  thrum_response_def def = def_of(c, stability);
  void *workspace = NULL;
  size_t size = 0;
  double *start = NULL;
  THRUM_TRY(bound_amplitude(c, &def, error));
  THRUM_TRY(make_waves(c, error));
  THRUM_TRY(thrum_response_size(c->stepped, &def, &size, error));
  thrum_status status = find_start(c, &start, error);
  THRUM_THEN(status, thrum_reserve_aligned(&workspace, size, "the curve", error));
  const double began = clock_seconds();

  // the bound of a backbone is mended by what its last motion has
  for (int pass = 0; pass < AMPLITUDE_PASSES && status >= 0; pass++) {
    drop_rows(c);
    status =
        thrum_response(c->stepped, &def, start, workspace, size, keep_row, c, &c->report, error);
    const double better = status >= 0 ? better_amplitude(c, def.amplitude) : NAN;
    if (isnan(better))
      break;
    def.amplitude = better;
  }
  c->seconds += clock_seconds() - began;
  free(workspace);
  free(start);
  if (status >= 0 && c->failure.status < 0 && error != NULL)
    *error = c->failure;
  return status >= 0 && c->failure.status < 0 ? c->failure.status : status;
}

/* Follows once more. A pass that is stopped short of the one before it leaves that one's rows. */
static thrum_status follow_again(response_curve *c, int64_t harmonics_before, bool stability,
                                 thrum_error *error) {
  response_curve kept = *c;
  c->rows = NULL;
  c->coefficients = c->harmonic = c->peak = c->waves = NULL;
  c->count = c->room = 0;
  const thrum_status status = follow(c, stability, error);
  response_curve *dropped = &kept;
  if (status >= 0 && c->report.end == THRUM_RESPONSE_END_STOPPED && c->count < kept.count) {
    const response_curve cut = *c;
    *c = kept;
    c->seconds = cut.seconds;
    c->report.end = THRUM_RESPONSE_END_STOPPED;
    c->harmonics = harmonics_before;
    kept = cut;
  }
  drop_rows(dropped);
  free(dropped->waves);
  return status;
}

/* The linear mode whose frequency is nearest to 1, 2 or 3 times that of the backbone's, or to a
 * part of it; *ratio stays 0 where none is near. */
static void find_partner(const response_curve *c, int64_t modes[2], int32_t *ratio) {
  const double *omega2 = c->loaded->omega2;
  const int64_t own = c->request->mode - 1, count = model_meta_modes(c->loaded);
  double nearest = PAIR_NEAR;
  for (int64_t other = 0; other < count; other++) {
    const bool above = omega2[other] > omega2[own];
    const double between = sqrt(omega2[above ? other : own] / omega2[above ? own : other]);
    const double whole = round(between), away = fabs(between / whole - 1);
    if (other == own || whole > 3 || away >= nearest)
      continue;
    nearest = away;
    *ratio = (int32_t)whole;
    modes[0] = above ? own : other;
    modes[1] = above ? other : own;
  }
}

/* By how much of its frequency the terms of two orders turn either mode faster at the most, where
 * both furthest vertices are displaced by `amplitude`. each: such displacements by z = 1/2. */
static double pair_apart(const response_curve *c, int32_t order, double amplitude,
                         const double each[2]) {
  const double z[2] = {0.5 * amplitude * each[0], 0.5 * amplitude * each[1]};
  double apart[2] = {0, 0};
  for (int32_t n = 0; n < c->pair.count; n++) {
    const thrum_normal_form_term *term = &c->pair.terms[n];
    const int32_t *p = term->powers, of = p[0] + p[1] + p[2] + p[3];
    if (of == order || of == order - 1)
      apart[term->of] += fabs(term->coefficient) * pow(z[0], p[0] + p[1]) * pow(z[1], p[2] + p[3]) /
                         (z[term->of] * c->pair.omega[term->of]);
  }
  return fmax(apart[0], apart[1]);
}

/* The form of the mode and its partner, to the highest order in which no third mode is in resonance
 * with them, and how far its orders agree. */
static void find_pair(response_curve *c, double scale, void *workspace, size_t size) {
  find_partner(c, c->pair_modes, &c->pair_ratio);
  for (int32_t order = THRUM_NORMAL_FORM_ORDER; order >= 3 && c->pair_ratio > 0; order -= 2) {
    c->pair_order = order;
    if (thrum_normal_form_pair_find(c->loaded, c->pair_modes, c->pair_ratio, order, scale,
                                    workspace, size, &c->pair, NULL) >= 0)
      break;
  }
  double each[2] = {0, 0};
  bool seen = c->pair.count > 0;
  for (int j = 0; j < 2 && seen; j++) {
    double q[THRUM_RANK_MAX] = {0};
    seen = thrum_mode_add(c->shape, c->pair_modes[j], 1, q, NULL) >= 0;
    each[j] = fabs(q[c->pair_modes[j]]);
  }

  // what is apart grows with the amplitude, so halving finds it
  for (int n = 0; n < 2; n++) {
    const int32_t order = 5 + 2 * n;
    double low = 0, high = 1;
    c->pair_amplitudes[n] = NAN;
    if (!seen || order > c->pair_order || !(pair_apart(c, order, 1, each) > 0))
      continue;
    while (pair_apart(c, order, high, each) < FORM_APART)
      high *= 2;
    for (int step = 0; step < FORM_HALVINGS; step++) {
      const double middle = 0.5 * (low + high);
      *(pair_apart(c, order, middle, each) < FORM_APART ? &low : &high) = middle;
    }
    c->pair_amplitudes[n] = high;
  }
}

/* The normal form of the mode in all coordinates, and that with its partner, where the model has
 * one. A first one says at which amplitude its orders are of one size, which is where the next is
 * found. */
static thrum_status find_form(response_curve *c, thrum_error *error) {
  const thrum_model *model = c->loaded;
  const int64_t mode = c->request->mode - 1;
  size_t size = 0;
  void *workspace = NULL;
  double q[THRUM_RANK_MAX] = {0}, scale = 1;
  if (mode < 0 || thrum_normal_form_size(model, mode, &size, NULL) < 0)
    return THRUM_OK;
  THRUM_TRY(thrum_reserve_aligned(&workspace, size, "the normal form", error));
  for (int pass = 0; pass < FORM_PASSES; pass++) {
    if (thrum_normal_form_find(model, mode, scale, workspace, size, &c->form, NULL) < 0)
      break;
    const double first = fabs(c->form.coefficients[0]);
    scale = first > 0 ? sqrt(FORM_SHARE * c->form.omega / first) : scale;
  }
  find_pair(c, scale, workspace, size);
  free(workspace);

  // one order alone makes a hundredth of the frequency there
  const bool seen = c->form.omega > 0 && thrum_mode_add(c->shape, mode, 1, q, NULL) >= 0;
  for (int n = 0; n < 2; n++) {
    const double next = fabs(c->form.coefficients[n + 1]);
    c->form_amplitudes[n] = NAN;
    if (seen && next > 0)
      c->form_amplitudes[n] =
          2 * pow(FORM_APART * c->form.omega / next, 1.0 / (4 + 2 * n)) / fabs(q[mode]);
  }
  return THRUM_OK;
}

thrum_status response_curve_find(response_curve *curve, thrum_error *error) {
  const response_request *request = curve->request;
  config_progress progress = config_progress_make(request->quiet);
  const bool open = request->harmonics == 0;
  const int64_t more = HARMONICS_MORE * request->periods;
  thrum_status status = find_form(curve, error);
  const int64_t first = HARMONICS_FIRST * request->periods;
  const int64_t most = THRUM_RESPONSE_HARMONICS_MAX;
  curve->harmonics = !open ? request->harmonics : first < most ? first : most;
  int64_t before = curve->harmonics;

  // more harmonics while the last of them matter, which is looked for without stability; curves
  // that do not come to an end take the longer the more there are, and are given up where they do
  // not help
  int64_t best = curve->harmonics;
  double least = INFINITY;
  int in_vain = 0;
  for (bool enough = !open; !enough && status >= 0;) {
    char label[40];
    snprintf(label, sizeof label, "curve, %d harmonics", (int)curve->harmonics);
    config_progress_update(&progress, label, 0);
    status = follow_again(curve, before, false, error);
    before = curve->harmonics;
    in_vain +=
        curve->report.end == THRUM_RESPONSE_END_POINTS && curve->report.tail > TAIL_HELPED * least;
    if (curve->report.tail < least) {
      best = curve->harmonics;
      least = curve->report.tail;
    }
    enough = thrum_stop_requested() || curve->report.tail <= TAIL_MOST ||
             in_vain == TRIES_IN_VAIN || curve->harmonics + more > THRUM_RESPONSE_HARMONICS_MAX;
    curve->harmonics = !enough                    ? curve->harmonics + more
                       : in_vain == TRIES_IN_VAIN ? best
                                                  : curve->harmonics;
    config_progress_end(&progress, status >= 0);
  }
  if (status >= 0 && (!open || request->stability)) {
    config_progress_update(&progress, request->stability ? "curve and stability" : "curve", 0);
    status = follow_again(curve, before, request->stability, error);
    config_progress_end(&progress, status >= 0);
  }
  return status;
}
