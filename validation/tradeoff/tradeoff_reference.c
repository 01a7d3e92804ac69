/* The full order, sampled. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver/make/full_motion_kept.h"
#include "platform/allocate.h"
#include "precompute/basis/order_find.h"
#include "validation/tradeoff/tradeoff_private.h"

/* The context of take(): where samples go, and room for the free components of a field. */
typedef struct taker {
  tradeoff_reference *reference;
  double *free_ones; /* n: the components that may move, of a field of all */
  int64_t all;
} taker;

static double dot(const double *x, const double *y, int64_t n) {
  double sum = 0;
  for (int64_t i = 0; i < n; i++)
    sum += x[i] * y[i];
  return sum;
}

static void take(void *context, int64_t index, const double *u, const double *v, double energy) {
  const taker *t = context;
  tradeoff_reference *r = t->reference;

  // how far cubature points are to be right
  for (int64_t c = 0; c < t->all; c += 3)
    r->reach = fmax(r->reach, sqrt(dot(u + c, u + c, 3)));

  // what bases are trained on, twice as often as errors are measured
  if (r->u != NULL)
    memcpy(r->u + index * t->all, u, (size_t)t->all * sizeof *u);
  if (index % 2 == 0)
    return;
  const int64_t sample = index / 2;
  double *mass_u = r->mass_u + sample * r->n, *mass_v = r->mass_v + sample * r->n;

  // M u and |u|^2, then M v and |v|^2
  thrum_fem_gather(&r->body.fem, u, t->free_ones);
  thrum_sparse_product(&r->body.mass, t->free_ones, 1, mass_u);
  r->u_square[sample] = dot(t->free_ones, mass_u, r->n);
  thrum_fem_gather(&r->body.fem, v, t->free_ones);
  thrum_sparse_product(&r->body.mass, t->free_ones, 1, mass_v);
  r->v_square[sample] = dot(t->free_ones, mass_v, r->n);
  r->energy[sample] = energy;
}

static thrum_status allocate(tradeoff_reference *made, int64_t all, bool keep, taker *t,
                             thrum_error *error) {
  static const char what[] = "the samples of the full order";
  THRUM_TRY(thrum_reserve(&made->mass_u, 2 * TRADEOFF_SAMPLES * made->n, sizeof *made->mass_u, what,
                          error));
  THRUM_TRY(thrum_reserve(&t->free_ones, made->n, sizeof *t->free_ones, what, error));
  if (keep)
    THRUM_TRY(thrum_reserve(&made->u, FULL_MOTION_SNAPSHOTS * all, sizeof *made->u, what, error));
  made->mass_v = made->mass_u + TRADEOFF_SAMPLES * made->n;
  return THRUM_OK;
}

thrum_status tradeoff_reference_make(const tradeoff_problem *problem,
                                     const full_motion_script *script, const char *stage, bool keep,
                                     tradeoff_reference *reference, thrum_error *error) {
  const int64_t all = 3 * problem->model->vertex_count;
  tradeoff_reference made = {0};
  taker t = {.reference = &made, .all = all};
  tradeoff_stage shown = {problem, stage};
  const full_motion_observer observer = {FULL_MOTION_SNAPSHOTS, take, &t, tradeoff_show, &shown};
  thrum_status status = thrum_model_fem_create(problem->model, &made.body, error);
  made.n = made.body.fem.free_count;

  // samples are kept times the mass, as errors are measured in its norm
  THRUM_THEN(status, allocate(&made, all, keep, &t, error));
  THRUM_THEN(status,
             full_motion_kept(problem->keep_runs, problem->model, (int)made.body.kind, script,
                              problem->full_dt, &observer, &made.us_per_step, error));
  free(t.free_ones);
  if (status < 0)
    tradeoff_reference_free(&made);
  else
    *reference = made;
  return status;
}

thrum_status tradeoff_mesh_error(const tradeoff_reference *reference, double *found,
                                 thrum_error *error) {
  double errors[THRUM_ORDER_MODES_MAX];
  int64_t count = THRUM_ORDER_ERRORS_MAX;
  *found = NAN;
  if (reference->body.fem.rule != NULL)
    return THRUM_OK;
  THRUM_TRY(thrum_order_find(&reference->body.mesh, &reference->body.fem, INFINITY, &count, errors,
                             error));
  for (int64_t i = 0; i < count; i++)
    *found = fmax(*found, errors[i]);
  return THRUM_OK;
}

void tradeoff_reference_free(tradeoff_reference *reference) {
  thrum_model_fem_free(&reference->body);
  free(reference->mass_u);
  free(reference->u);
  *reference = (tradeoff_reference){0};
}
