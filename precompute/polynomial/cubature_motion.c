/* Motion by cubature points beside motion by all points of the mesh, see cubature_motion.h.
 *
 * The error of a force says little of the error of a motion: where points are stiffer than the body
 * along one shape, its vibration gets out of step. So both models are stepped: q by the points, q'
 * by all points of the mesh, which in these coordinates is exact, for two periods of the lowest
 * mode. The error is the rms of q - q' over that of q', in the norm of the mass, over all steps.
 *
 * A motion begins with a velocity, or at rest under a load that stays. Either is that of the lowest
 * coordinates, of which the linear body would have q_i = c_i at most, c_i ~ 1 / w_i with
 * alternating signs, scaled so that its furthest vertex then goes as far as a share of the range.
 *
 * Cost: 4 motions of 120 steps by each model; a force of the whole takes the time of all points.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/polynomial/cubature_motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/pi.h"
#include "core/base/vec3.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "thrum/polynomial.h"
#include "thrum/state.h"

enum { LOWEST = 3, STEPS = 120, PERIODS = 2 };

/* Shares of the range: of the motions within it, and of those beyond. */
static const double within = 0.75, beyond = 1.5;

/* A motion of both models. */
typedef struct motion {
  double reach; /* m, of the furthest vertex of the linear body */
  bool loaded;  /* by a load from rest; or it begins with a velocity */
} motion;

typedef struct pair {
  thrum_model points, whole; /* packed copies */
  double *shape;             /* rank: c_i of a furthest vertex at 1 m */
  double *q, *exact, *start; /* rank each */
  double dt;
  double seconds; /* of the processor, of all steps of the points */
  int64_t steps;
} pair;

/* c_i, such that the furthest vertex of the linear body goes as far as 1 m. */
static void fill_shape(const thrum_model *model, double *shape) {
  const int64_t r = model->rank, lowest = r < LOWEST ? r : LOWEST;
  double furthest = 0;
  memset(shape, 0, sizeof *shape * (size_t)r);
  for (int64_t i = 0; i < lowest; i++)
    shape[i] = (i % 2 == 0 ? 1 : -1) / sqrt(model->omega2[i]);

  for (int64_t v = 0; v < model->vertex_count; v++) {
    double square = 0;
    for (int64_t row = 3 * v; row < 3 * v + 3; row++) {
      double u = 0;
      for (int64_t i = 0; i < lowest; i++)
        u += model->basis[row * r + i] * shape[i];
      square += u * u;
    }
    furthest = fmax(furthest, sqrt(square));
  }
  for (int64_t i = 0; i < lowest && furthest > 0; i++)
    shape[i] /= furthest;
}

/* A state of a model at the start of a motion. */
static thrum_status begin(const thrum_model *model, const pair *p, const motion *of,
                          double *scratch, thrum_state **state, thrum_error *error) {
  const int64_t r = model->rank;
  thrum_state_def def = thrum_default_state_def();
  def.dt = p->dt;
  THRUM_TRY(thrum_state_create(model, &def, state, error));

  // a load that stays moves a linear body twice as far as it would rest
  for (int64_t i = 0; i < r; i++)
    scratch[i] =
        of->reach * p->shape[i] * (of->loaded ? 0.5 * model->omega2[i] : sqrt(model->omega2[i]));
  return of->loaded ? thrum_state_set_force(model, *state, scratch, error)
                    : thrum_state_set(model, *state, NULL, scratch, error);
}

/* The relative error of one motion; 1 where the points alone cannot be stepped, NaN where the whole
 * body cannot. */
static thrum_status measure(pair *p, const motion *of, double *relative, thrum_error *error) {
  const int64_t r = p->whole.rank;
  thrum_state *state = NULL, *exact = NULL;
  double off = 0, size = 0;
  thrum_status status = begin(&p->points, p, of, p->start, &state, error);
  THRUM_THEN(status, begin(&p->whole, p, of, p->start, &exact, error));

  // steps that fail are an answer, and no failure of the precompute
  bool stepped = status >= 0, followed = true;
  for (int n = 0; n < STEPS && stepped; n++) {
    stepped = thrum_step(&p->whole, exact, NULL) >= 0 &&
              thrum_state_get(&p->whole, exact, p->exact, NULL, NULL) >= 0;
    const double began = clock_thread_seconds();
    followed = followed && thrum_step(&p->points, state, NULL) >= 0 &&
               thrum_state_get(&p->points, state, p->q, NULL, NULL) >= 0;
    p->seconds += clock_thread_seconds() - began;
    p->steps++;
    for (int64_t i = 0; i < r && stepped; i++) {
      const double d = followed ? p->q[i] - p->exact[i] : p->exact[i];
      off += d * d;
      size += p->exact[i] * p->exact[i];
    }
  }
  thrum_state_destroy(state);
  thrum_state_destroy(exact);
  *relative = stepped && size > 0 ? sqrt(off / size) : NAN;
  return status;
}

/* The model with the gradients of its points packed, in memory of the scope. */
static void pack(thrum_scope *memory, thrum_model *model) {
  const size_t size = thrum_model_pack_size(model);
  void *packed = thrum_scope_allocate_aligned(memory, size);
  if (memory->status == THRUM_OK)
    memory->status = thrum_model_pack(model, packed, size, memory->error);
}

/* The worst of two motions that go so far, from a velocity and under a load. */
static thrum_status measure_both(pair *p, double reach, double *worst, thrum_error *error) {
  double relative[2];
  for (int n = 0; n < 2; n++) {
    const motion of = {.reach = reach, .loaded = n == 1};
    THRUM_TRY(measure(p, &of, &relative[n], error));
  }
  *worst = isnan(relative[0]) || isnan(relative[1]) ? NAN : fmax(relative[0], relative[1]);
  return THRUM_OK;
}

thrum_status thrum_cubature_motion(const thrum_fem *fem, const thrum_cubature_def *def,
                                   const thrum_model *model, thrum_cubature_figures *figures,
                                   thrum_error *error) {
  const int64_t all = fem->tet_count * fem->point_count, r = model->rank;
  figures->motion_error = figures->motion_error_beyond = figures->step_seconds = NAN;
  if (fem->ranks || 9 * all * r > THRUM_MOTION_NUMBERS_MOST || !(model->omega2[0] > 0))
    return THRUM_OK;

  // the same model of all points, each with the weight that the mesh gives it
  pair p = {.points = *model, .whole = *model};
  thrum_scope memory = thrum_scope_begin("the motion by cubature points", error);
  int64_t *places = thrum_scope_allocate(&memory, all, sizeof *places);
  p.shape = thrum_scope_allocate(&memory, 4 * r, sizeof(double));
  for (int64_t n = 0; n < all && memory.status == THRUM_OK; n++)
    places[n] = n;
  thrum_status status = memory.status;
  p.whole.point_region = NULL;
  p.whole.point_weights = p.whole.point_moduli = p.whole.point_gradients = NULL;
  THRUM_THEN(status, thrum_cubature_fill(fem, all, places, fem->weight, &p.whole, error));

  if (status >= 0) {
    pack(&memory, &p.points);
    pack(&memory, &p.whole);
    status = memory.status;
  }
  if (status >= 0) {
    p.q = p.shape + r;
    p.exact = p.q + r;
    p.start = p.exact + r;
    p.dt = PERIODS * THRUM_TWO_PI / sqrt(model->omega2[0]) / STEPS;
    fill_shape(model, p.shape);
    const double reach = def->range * thrum_box3_diagonal(model->vertices, model->vertex_count);
    status = measure_both(&p, within * reach, &figures->motion_error, error);
    THRUM_THEN(status, measure_both(&p, beyond * reach, &figures->motion_error_beyond, error));
    figures->step_seconds = p.steps > 0 ? p.seconds / (double)p.steps : NAN;
  }

  // these alone are not the model's
  free((void *)(uintptr_t)p.whole.point_region);
  free((void *)(uintptr_t)p.whole.point_weights);
  free((void *)(uintptr_t)p.whole.point_moduli);
  free((void *)(uintptr_t)p.whole.point_gradients);
  thrum_scope_free(&memory);
  return status;
}
