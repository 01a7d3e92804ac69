/* Touch modes that follow loads at rest, see touch_follow.h. With X the shapes less what U shows of
 * them in K, the small problem (X^T M X) v = mu (X^T K X) v gives T = X v / sqrt(mu), of unit mass
 * each and diagonal in K, with omega^2 = 1 / mu. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/touch_follow.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "platform/threads.h"
#include "precompute/basis/eigen.h"
#include "precompute/fem/lapack_status.h"
#include "precompute/model/model_fill.h"
#include "precompute/model/model_statics.h"
#include "thrum/polynomial.h"

#define PASSES 2 /* of the projection, as one leaves rounding of what it takes */

typedef struct work {
  const thrum_model_fem *body;
  const thrum_model *model;
  int64_t n, count;
  double *shapes;      /* n x count: X, then T */
  double *images;      /* n x count: K X or M X; then X v */
  double *rows;        /* n x rank, row-major: U on the free components */
  double *shown;       /* rank x count */
  double *mass, *form; /* count x count: X^T M X, X^T K X */
  double *values;      /* count: mu, then omega^2 */
  thrum_scope memory;
} work;

static thrum_status work_allocate(work *w, thrum_error *error) {
  const int64_t rank = w->model->rank;
  w->memory = thrum_scope_begin("the touch modes", error);
  w->shapes = thrum_scope_allocate(&w->memory, w->n * w->count, sizeof(double));
  w->images = thrum_scope_allocate(&w->memory, w->n * w->count, sizeof(double));
  w->rows = thrum_scope_allocate(&w->memory, w->n * rank, sizeof(double));
  w->shown = thrum_scope_allocate(&w->memory, rank * w->count, sizeof(double));
  w->mass = thrum_scope_allocate(&w->memory, w->count * w->count, sizeof(double));
  w->form = thrum_scope_allocate(&w->memory, w->count * w->count, sizeof(double));
  w->values = thrum_scope_allocate(&w->memory, w->count, sizeof(double));
  return w->memory.status;
}

/* X less U W^-1 U^T K X. */
static void project(const work *w) {
  const int n = (int)w->n, count = (int)w->count, rank = (int)w->model->rank;
  for (int pass = 0; pass < PASSES; pass++) {
    thrum_sparse_product(&w->body->stiffness, w->shapes, w->count, w->images);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, rank, count, n, 1, w->rows, rank,
                w->images, n, 0, w->shown, rank);
    for (int64_t c = 0; c < w->count; c++)
      for (int64_t i = 0; i < rank; i++)
        w->shown[c * rank + i] /= w->model->omega2[i];
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, n, count, rank, -1, w->rows, rank,
                w->shown, rank, 1, w->shapes, n);
  }
}

/* T in place of X, ascending. */
static thrum_status diagonalise(const work *w, thrum_error *error) {
  const int n = (int)w->n, count = (int)w->count;
  double *const forms[] = {w->mass, w->form};
  const thrum_sparse *const matrices[] = {&w->body->mass, &w->body->stiffness};
  for (int m = 0; m < 2; m++) {
    thrum_sparse_product(matrices[m], w->shapes, w->count, w->images);
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, count, count, n, 1, w->shapes, n,
                w->images, n, 0, forms[m], count);
  }

  // mu ascends, so omega^2 descends
  THRUM_TRY(thrum_lapack_status(LAPACKE_dsygv(LAPACK_COL_MAJOR, 1, 'V', 'U', count, w->mass, count,
                                              w->form, count, w->values),
                                THRUM_NOT_CONVERGED, "the touch modes depend on each other",
                                error));
  for (int64_t c = 0; c < w->count; c++)
    cblas_dgemv(CblasColMajor, CblasNoTrans, n, count, 1 / sqrt(w->values[w->count - 1 - c]),
                w->shapes, n, w->mass + (w->count - 1 - c) * w->count, 1, 0, w->images + c * w->n,
                1);
  memcpy(w->shapes, w->images, sizeof *w->shapes * (size_t)(w->n * w->count));
  for (int64_t c = 0; c < w->count; c++)
    w->form[c] = 1 / w->values[w->count - 1 - c];
  memcpy(w->values, w->form, sizeof *w->values * (size_t)w->count);
  return THRUM_OK;
}

static thrum_status make_shapes(work *w, const double *fields, thrum_error *error) {
  const thrum_fem *fem = &w->body->fem;
  const int64_t rank = w->model->rank;
  for (int64_t c = 0; c < w->count; c++)
    thrum_fem_gather(fem, fields + 3 * c * w->model->vertex_count, w->shapes + c * w->n);
  for (int64_t i = 0; i < w->n; i++)
    memcpy(w->rows + i * rank, w->model->basis + fem->component[i] * rank,
           sizeof *w->rows * (size_t)rank);
  project(w);
  THRUM_TRY(diagonalise(w, error));
  thrum_eigen_canonicalise_fem(fem, false, w->count, w->values, 1e-14 * w->values[w->count - 1],
                               w->shapes, 1, w->n);
  return THRUM_OK;
}

/* The arrays of both, side by side. */
static thrum_status join(const work *w, thrum_touch_followers *f, thrum_error *error) {
  const thrum_model *from = w->model;
  const int64_t rank = from->rank, all = rank + w->count, rows = 3 * from->vertex_count;
  const int64_t pairs = rank * (rank + 1) / 2;
  THRUM_TRY(thrum_reserve(&f->basis, rows * all, sizeof(double), "the touch modes", error));
  THRUM_TRY(thrum_reserve(&f->omega2, all, sizeof(double), "the touch modes", error));
  THRUM_TRY(thrum_reserve(&f->axis_mass, 3 * all, sizeof(double), "the touch modes", error));
  THRUM_TRY(
      thrum_reserve(&f->slave_map, w->count * pairs, sizeof(double), "the touch modes", error));

  // held components have no rows
  for (int64_t row = 0; row < rows; row++)
    memcpy(f->basis + row * all, from->basis + row * rank, sizeof *f->basis * (size_t)rank);
  for (int64_t i = 0; i < w->n; i++)
    for (int64_t c = 0; c < w->count; c++)
      f->basis[w->body->fem.component[i] * all + rank + c] = w->shapes[c * w->n + i];

  // touch modes have their stiffnesses behind those of the model
  memcpy(f->omega2, from->omega2, sizeof *f->omega2 * (size_t)rank);
  memcpy(f->omega2 + rank, w->values, sizeof *f->omega2 * (size_t)w->count);

  // the masters keep their polynomial, bit for bit
  f->count = w->count;
  f->model = *from;
  f->model.rank = all;
  f->model.basis = f->basis;
  f->model.omega2 = f->omega2;
  f->model.axis_mass = f->axis_mass;
  f->model.slave_map = f->slave_map;
  f->model.slave_count = w->count;
  f->model.slave_pairs = pairs;
  f->model.condensed_c3 = from->c3;
  f->model.condensed_c3_count = from->c3_count;
  f->model.condensed_c4 = from->c4;
  f->model.condensed_c4_count = from->c4_count;
  f->model.c3 = f->model.c4 = NULL;
  f->model.c3_count = f->model.c4_count = 0;
  return thrum_model_fill_axis_mass(&w->body->fem, w->body->kind, &f->model, error);
}

thrum_status thrum_touch_follow(const thrum_touch *touch, const thrum_model *model,
                                const double *fields, int64_t count,
                                thrum_touch_followers *followers, thrum_error *error) {
  const thrum_model_fem *body = &thrum_touch_statics(touch)->body;
  work w = {.body = body, .model = model, .n = body->fem.free_count, .count = count};
  thrum_touch_followers made = {0};

  // blocks of few columns are slower on several threads
  const thrum_threads before = thrum_threads_set(1);
  thrum_status status = work_allocate(&w, error);
  THRUM_THEN(status, make_shapes(&w, fields, error));
  THRUM_THEN(status, join(&w, &made, error));
  thrum_threads_restore(before);
  thrum_scope_free(&w.memory);
  if (status < 0)
    thrum_touch_followers_free(&made);
  else
    *followers = made;
  return status;
}

void thrum_touch_followers_free(thrum_touch_followers *followers) {
  free(followers->basis);
  free(followers->omega2);
  free(followers->axis_mass);
  free(followers->slave_map);
  *followers = (thrum_touch_followers){0};
}
