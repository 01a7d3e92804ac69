/* Local response modes over the surface, chosen by coverage, see touch.h.
 *
 * With the unit forces F (three a place) and the compliances C = F^T K^-1 F a basis U that is
 * diagonal in K leaves R = C - (F^T U) W^-1 (U^T F), W = diag(omega^2): K-orthogonal, so the give
 * that a place lacks is the trace of its block of R. The shape K^-1 F a, less what U shows of it,
 * takes R a a^T R / (a^T R a) from R. So everything but a solve a shape happens in R.
 *
 * Each shape is the largest of a proper orthogonal decomposition of what the answers lack, every
 * place weighed by a power of what it lacks, so that the worst decide: the greedy choice over a
 * training set of reduced bases (P. Benner, S. Gugercin, K. Willcox 2015, doi:10.1137/130932715).
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/touch.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "platform/allocate.h"
#include "platform/threads.h"
#include "precompute/model/model_statics.h"
#include "precompute/model/touch_places.h"
#include "runtime/material/jacobi.h"

#define PLACES 480       /* that shapes are made for: the whole surface where it has no more */
#define JUDGES 96        /* places between these, which only judge */
#define PATCH 0.05       /* radius of a patch, of the body's diagonal */
#define STIFF 0.01       /* of the give of the softest place */
#define WORST_DECIDE 4.0 /* power of what a place lacks in its weight */
#define TURNS 40         /* of the power method, whose result need not be exact */
#define NOTHING 1e-12    /* of the largest of the first shape: what a shape adds is rounding */

struct thrum_touch {
  thrum_model_statics statics;
  thrum_touch_places places;
  int64_t forces;     /* three a place */
  double *compliance; /* forces x forces, symmetric */
  double *rest;       /* the same less what the basis shows */
  double *give;       /* a place: trace of its block */
  double *follows;    /* a place: share of it that the basis shows */
  thrum_scope memory;
};

/* --- forces and compliances --------------------------------------------------------------------
 */

/* Adds to f, on the free components, `size` of the unit force `force`. */
static void add_force(const thrum_touch *t, int64_t force, double size, double *f) {
  const thrum_touch_places *p = &t->places;
  for (int64_t e = p->begin[force / 3]; e < p->begin[force / 3 + 1]; e++)
    f[t->statics.body.fem.dof[3 * p->vertex[e] + force % 3]] += size * p->share[e];
}

/* How far the displacements x, on the free components, move a patch along a unit force. */
static double moved(const thrum_touch *t, int64_t force, const double *x) {
  const thrum_touch_places *p = &t->places;
  double sum = 0;
  for (int64_t e = p->begin[force / 3]; e < p->begin[force / 3 + 1]; e++)
    sum += p->share[e] * x[t->statics.body.fem.dof[3 * p->vertex[e] + force % 3]];
  return sum;
}

/* C, a block of forces at a time, so that no answers are kept. */
static thrum_status fill_compliance(thrum_touch *t, thrum_error *error) {
  const int64_t n = t->statics.body.fem.free_count;
  double *block = NULL;
  THRUM_TRY(thrum_reserve(&block, n * THRUM_SOLVE_BLOCK, sizeof *block, "the answers", error));

  // C_ij is what force j moves the place of force i by
  thrum_status status = THRUM_OK;
  for (int64_t first = 0; first < t->forces && status >= 0; first += THRUM_SOLVE_BLOCK) {
    const int64_t left = t->forces - first;
    const int64_t count = left < THRUM_SOLVE_BLOCK ? left : THRUM_SOLVE_BLOCK;
    memset(block, 0, sizeof *block * (size_t)(n * count));
    for (int64_t c = 0; c < count; c++)
      add_force(t, first + c, 1, block + c * n);
    status = thrum_factor_solve(t->statics.factor, block, count, block, error);
    for (int64_t c = 0; c < count && status >= 0; c++)
      for (int64_t i = 0; i < t->forces; i++)
        t->compliance[(first + c) * t->forces + i] = moved(t, i, block + c * n);
  }
  free(block);
  return status;
}

/* The trace of a place's block of a matrix of all forces. */
static double trace_of(const thrum_touch *t, const double *matrix, int64_t place) {
  double sum = 0;
  for (int64_t i = 3 * place; i < 3 * place + 3; i++)
    sum += matrix[i * t->forces + i];
  return sum;
}

static thrum_status fill_places(thrum_touch *t, const thrum_model *model, thrum_error *error) {
  const double radius = PATCH * thrum_box3_diagonal(model->vertices, model->vertex_count);
  THRUM_TRY(thrum_touch_places_create(&t->statics.body.mesh, &t->statics.body.fem, PLACES + JUDGES,
                                      radius, &t->places, error));

  // three unit forces a place; the matrices are of all pairs of them
  t->forces = 3 * t->places.count;
  t->memory = thrum_scope_begin("the places", error);
  t->compliance = thrum_scope_allocate(&t->memory, t->forces * t->forces, sizeof *t->compliance);
  t->rest = thrum_scope_allocate(&t->memory, t->forces * t->forces, sizeof *t->rest);
  t->give = thrum_scope_allocate(&t->memory, t->places.count, sizeof *t->give);
  t->follows = thrum_scope_allocate(&t->memory, t->places.count, sizeof *t->follows);
  THRUM_TRY(t->memory.status);

  THRUM_TRY(fill_compliance(t, error));
  for (int64_t place = 0; place < t->places.count; place++)
    t->give[place] = trace_of(t, t->compliance, place);
  return THRUM_OK;
}

thrum_status thrum_touch_create(const thrum_model *model, thrum_touch **touch, thrum_error *error) {
  if (model->basis == NULL)
    return thrum_error_set(error, THRUM_MISSING, "the model has no basis to follow a pull by");
  thrum_touch *made = NULL;
  THRUM_TRY(thrum_reserve(&made, 1, sizeof *made, "the places", error));

  // blocks of few columns are slower on several threads
  thrum_status status = thrum_model_statics_create(model, &made->statics, error);
  const thrum_threads before = thrum_threads_set(1);
  THRUM_THEN(status, fill_places(made, model, error));
  thrum_threads_restore(before);
  if (status < 0)
    thrum_touch_free(made);
  else
    *touch = made;
  return status;
}

void thrum_touch_free(thrum_touch *touch) {
  if (touch == NULL)
    return;
  thrum_model_statics_free(&touch->statics);
  thrum_touch_places_free(&touch->places);
  thrum_scope_free(&touch->memory);
  free(touch);
}

const thrum_model_statics *thrum_touch_statics(const thrum_touch *touch) {
  return &touch->statics;
}

/* --- judging -----------------------------------------------------------------------------------
 */

/* A place's block of a symmetric matrix of all forces, of which the upper triangle is there. */
static void copy_block(const thrum_touch *t, const double *matrix, int64_t place, double into[9]) {
  for (int row = 0; row < 3; row++)
    for (int column = row; column < 3; column++)
      into[3 * row + column] = into[3 * column + row] =
          matrix[(3 * place + column) * t->forces + 3 * place + row];
}

/* The least share by which a place is followed in one direction. Among the principal directions of
 * its compliance that give at least `stiff` it lacks the largest eigenvalue of R, scaled by the
 * roots of the gives. */
static double follows_least(const thrum_touch *t, int64_t place, double stiff) {
  double give[9], lacks[9], axes[9], scaled[9] = {0}, unused[9];
  copy_block(t, t->compliance, place, give);
  copy_block(t, t->rest, place, lacks);
  thrum_jacobi(3, give, axes);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      if (give[4 * a] < stiff || give[4 * b] < stiff)
        continue;
      for (int n = 0; n < 9; n++)
        scaled[3 * a + b] += axes[n / 3 * 3 + a] * lacks[n] * axes[n % 3 * 3 + b];
      scaled[3 * a + b] /= sqrt(give[4 * a] * give[4 * b]);
    }
  thrum_jacobi(3, scaled, unused);
  return 1 - fmax(scaled[0], fmax(scaled[4], scaled[8]));
}

/* Finds in which direction of all judged places the model follows least. */
static void judge_directions(const thrum_touch *t, thrum_touch_coverage *coverage) {
  double softest = 0;
  for (int64_t place = 0; place < t->places.count; place++)
    softest = fmax(softest, t->give[place]);
  coverage->direction = INFINITY;
  for (int64_t place = 0; place < t->places.count; place++) {
    if (t->give[place] < STIFF * softest)
      continue;
    const double least = follows_least(t, place, STIFF * softest / 3);
    if (least >= coverage->direction)
      continue;
    coverage->direction = least;
    coverage->direction_vertex = t->places.middle[place];
  }
}

/* Finds from R how well each place is followed. */
static void judge(thrum_touch *t, thrum_touch_coverage *coverage) {
  double softest = 0;
  for (int64_t place = 0; place < t->places.count; place++)
    softest = fmax(softest, t->give[place]);

  // stiff places count as followed, so that nothing is spent on them
  *coverage = (thrum_touch_coverage){.worst = INFINITY};
  for (int64_t place = 0; place < t->places.count; place++) {
    t->follows[place] = 1;
    if (t->give[place] < STIFF * softest) {
      coverage->stiff++;
      continue;
    }

    // the basis lacks the share of the give that R still has
    const double follows = 1 - trace_of(t, t->rest, place) / t->give[place];
    t->follows[place] = follows;
    coverage->mean += follows;
    coverage->places++;
    if (follows >= coverage->worst)
      continue;
    coverage->worst = follows;
    coverage->vertex = t->places.middle[place];
  }
  coverage->mean /= (double)coverage->places;
}

/* R = C less what the basis of the model shows, a coordinate at a time. */
static void remove_basis(thrum_touch *t, const thrum_model *model) {
  const thrum_touch_places *p = &t->places;
  memcpy(t->rest, t->compliance, sizeof *t->rest * (size_t)(t->forces * t->forces));
  for (int64_t i = 0; i < model->rank; i++) {
    double work[3 * (PLACES + JUDGES)] = {0};
    for (int64_t f = 0; f < t->forces; f++)
      for (int64_t e = p->begin[f / 3]; e < p->begin[f / 3 + 1]; e++)
        work[f] += p->share[e] * model->basis[(3 * p->vertex[e] + f % 3) * model->rank + i];
    cblas_dsyr(CblasColMajor, CblasUpper, (int)t->forces, -1 / model->omega2[i], work, 1, t->rest,
               (int)t->forces);
  }
}

void thrum_touch_measure(thrum_touch *touch, const thrum_model *model,
                         thrum_touch_coverage *coverage) {
  const thrum_threads before = thrum_threads_set(1);
  remove_basis(touch, model);
  judge(touch, coverage);
  judge_directions(touch, coverage);
  thrum_threads_restore(before);
}

void thrum_touch_spread(const thrum_touch *touch, const double *points, int64_t count,
                        double *follows) {
  const thrum_touch_places *p = &touch->places;
  for (int64_t n = 0; n < count; n++) {
    double nearest = INFINITY, between[3];
    for (int64_t place = 0; place < p->count; place++) {
      thrum_subtract3(points + 3 * n,
                      touch->statics.body.fem.vertices + 3 * (int64_t)p->middle[place], between);
      const double away = thrum_dot3(between, between);
      if (away >= nearest)
        continue;
      nearest = away;
      follows[n] = touch->follows[place];
    }
  }
}

/* --- choosing ----------------------------------------------------------------------------------
 */

/* Memory of the choice. */
typedef struct choice {
  double *weight; /* forces: by which each counts; 0 where it is not chosen from */
  double *vector; /* forces: the combination a */
  double *answer; /* forces: R a */
  double *field;  /* free components */
  double first;   /* what the first shape showed, weighed */
} choice;

/* The power of what each place lacks, beside the worst. The last places, which lie between the
 * others, are left out, so that they judge what they had no part in. */
static void weigh(const thrum_touch *t, choice *c) {
  const int64_t part = t->places.count < PLACES ? t->places.count : PLACES;
  double worst = 0;
  for (int64_t place = 0; place < part; place++)
    worst = fmax(worst, 1 - t->follows[place]);

  // relative to the give, as what is followed is a share of it
  for (int64_t f = 0; f < 3 * part; f++) {
    const double lacks = fmax(0, 1 - t->follows[f / 3]);
    c->weight[f] = pow(lacks / worst, WORST_DECIDE / 2) / sqrt(t->give[f / 3]);
  }
}

/* a: the combination of forces whose answers lack the most, by weight, from all of them by the
 * power method. False: that is rounding. */
static bool choose(const thrum_touch *t, choice *c) {
  const int n = (int)t->forces;
  double size = 0;
  weigh(t, c);
  for (int64_t f = 0; f < t->forces; f++)
    c->vector[f] = c->weight[f];

  // a, and what it lacks in place of a, in turn; both are weighed
  for (int turn = 0; turn < TURNS; turn++) {
    cblas_dsymv(CblasColMajor, CblasUpper, n, 1, t->rest, n, c->vector, 1, 0, c->answer, 1);
    for (int64_t f = 0; f < t->forces; f++)
      c->answer[f] *= c->weight[f];
    size = cblas_dnrm2(n, c->answer, 1);
    for (int64_t f = 0; f < t->forces && size > 0; f++)
      c->vector[f] = c->weight[f] * c->answer[f] / size;
  }
  c->first = fmax(c->first, size);
  return size > NOTHING * c->first;
}

/* Takes from R what the shape K^-1 F a shows, and makes its field. */
static thrum_status take_shape(thrum_touch *t, choice *c, double *field, thrum_error *error) {
  const int n = (int)t->forces;
  cblas_dsymv(CblasColMajor, CblasUpper, n, 1, t->rest, n, c->vector, 1, 0, c->answer, 1);
  const double energy = cblas_ddot(n, c->vector, 1, c->answer, 1);
  cblas_dsyr(CblasColMajor, CblasUpper, n, -1 / energy, c->answer, 1, t->rest, n);

  // the answer of the body to that combination
  memset(c->field, 0, sizeof *c->field * (size_t)t->statics.body.fem.free_count);
  for (int64_t f = 0; f < t->forces; f++)
    if (c->vector[f] != 0)
      add_force(t, f, c->vector[f], c->field);
  THRUM_TRY(thrum_factor_solve(t->statics.factor, c->field, 1, c->field, error));
  thrum_fem_scatter(&t->statics.body.fem, c->field, field);
  return THRUM_OK;
}

thrum_status thrum_touch_shapes(thrum_touch *touch, const thrum_model *model, double share,
                                int64_t most, double *fields, int64_t *found, thrum_error *error) {
  thrum_scope memory = thrum_scope_begin("the touch modes", error);
  choice c = {0};
  c.weight = thrum_scope_allocate(&memory, touch->forces, sizeof *c.weight);
  c.vector = thrum_scope_allocate(&memory, touch->forces, sizeof *c.vector);
  c.answer = thrum_scope_allocate(&memory, touch->forces, sizeof *c.answer);
  c.field = thrum_scope_allocate(&memory, touch->statics.body.fem.free_count, sizeof *c.field);
  thrum_status status = memory.status;

  // one shape after the other, until the worst of all places is followed
  thrum_touch_coverage coverage;
  thrum_touch_measure(touch, model, &coverage);
  const thrum_threads before = thrum_threads_set(1);
  *found = 0;
  while (status >= 0 && *found < most && coverage.worst < share && choose(touch, &c)) {
    status = take_shape(touch, &c, fields + *found * 3 * model->vertex_count, error);
    *found += status >= 0;
    judge(touch, &coverage);
  }
  thrum_threads_restore(before);
  thrum_scope_free(&memory);
  return status;
}
