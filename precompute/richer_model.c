/* A model with more directions than another one, of the same body.
 *
 * The corrections e that looks found are M-orthogonalised against U, and the eigenvectors of their
 * Gram matrix in M span them, the largest first. A load f adds what of it the basis does not feel:
 * K^-1 f, and from each direction w the next, K^-1 M w, as block Lanczos does: the lowest modes
 * that the load excites and the basis lacks are nearly in their span. The polynomial is made anew.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/richer_model.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/basis/orthonormal.h"
#include "precompute/model/solid_inertia.h"
#include "thrum/polynomial.h"

#define SMALLEST 1e-6 /* share of the largest direction's square that counts */
#define NEW 1e-7      /* share of a direction that has to be left outside of the others */

typedef struct maker {
  const thrum_model *model;
  const thrum_model_statics *statics;
  int64_t n, rank, count, most; /* count: of all columns so far, those of U included */
  double *columns;              /* n x (rank + most), M-orthonormal */
  double *x, *gram, *work;
  thrum_scope memory;
} maker;

/* x becomes one more column, less what the others have of it; false: nothing is left. */
static bool add_column(maker *m, double *x) {
  const thrum_sparse *mass = &m->statics->body.mass;
  double before, after;
  if (m->count == m->rank + m->most)
    return false;

  thrum_mass_gram(mass, x, 1, x, 1, &before, m->work);
  for (int pass = 0; pass < 2; pass++)
    thrum_mass_project(mass, m->columns, m->count, x, 1, m->gram, m->work);
  thrum_mass_gram(mass, x, 1, x, 1, &after, m->work);
  if (!(after > NEW * NEW * before))
    return false;

  double *to = m->columns + m->count++ * m->n;
  memcpy(to, x, (size_t)m->n * sizeof *x);
  cblas_dscal((int)m->n, 1 / sqrt(after), to, 1);
  return true;
}

/* The directions of the judge, by the eigenvectors of their Gram matrix. */
static thrum_status add_directions(maker *m, const double *directions, int64_t count, int64_t most,
                                   thrum_error *error) {
  double *copy = thrum_scope_allocate(&m->memory, m->n * count, sizeof(double));
  double *gram = thrum_scope_allocate(&m->memory, count * count + count, sizeof(double));
  double *values = gram + count * count;
  THRUM_TRY(m->memory.status);
  memcpy(copy, directions, (size_t)(m->n * count) * sizeof *copy);
  for (int64_t k = 0; k < count; k++)
    thrum_mass_project(&m->statics->body.mass, m->columns, m->count, copy + k * m->n, 1, m->gram,
                       m->work);
  thrum_mass_gram(&m->statics->body.mass, copy, count, copy, count, gram, m->work);
  if (LAPACKE_dsyev(LAPACK_COL_MAJOR, 'V', 'U', (int)count, gram, (int)count, values) != 0)
    return thrum_error_set(error, THRUM_NOT_CONVERGED, "the directions have no Gram matrix");

  // values ascend
  const double largest = values[count - 1];
  for (int64_t k = count - 1; k >= 0 && largest > 0 && values[k] > SMALLEST * largest; k--) {
    if (count - k > most)
      break;
    cblas_dgemv(CblasColMajor, CblasNoTrans, (int)m->n, (int)count, 1, copy, (int)m->n,
                gram + k * count, 1, 0, m->x, 1);
    add_column(m, m->x);
  }
  return THRUM_OK;
}

/* x -= M U (U^T x): what of a load the basis does not feel. */
static void take_off(maker *m, double *x) {
  const int n = (int)m->n, rank = (int)m->rank;
  double *sum = m->work, *product = m->work + n;
  cblas_dgemv(CblasColMajor, CblasTrans, n, rank, 1, m->columns, n, x, 1, 0, m->gram, 1);
  cblas_dgemv(CblasColMajor, CblasNoTrans, n, rank, 1, m->columns, n, m->gram, 1, 0, sum, 1);
  thrum_sparse_product(&m->statics->body.mass, sum, 1, product);
  cblas_daxpy(n, -1, product, 1, x, 1);
}

/* The first directions of the loads, then those that follow from each. */
static thrum_status add_loads(maker *m, const double *loads, int64_t count, thrum_error *error) {
  const thrum_fem *fem = &m->statics->body.fem;
  int64_t next = m->count;
  for (int64_t k = 0; k < count; k++) {
    thrum_fem_gather(fem, loads + k * 3 * fem->vertex_count, m->x);
    take_off(m, m->x);
    THRUM_TRY(thrum_factor_solve(m->statics->factor, m->x, 1, m->x, error));
    add_column(m, m->x);
  }
  for (; next < m->count; next++) {
    thrum_sparse_product(&m->statics->body.mass, m->columns + next * m->n, 1, m->x);
    THRUM_TRY(thrum_factor_solve(m->statics->factor, m->x, 1, m->x, error));
    add_column(m, m->x);
  }
  return THRUM_OK;
}

/* All columns on all components, row-major, as a precompute takes a basis. */
static void scatter(const maker *m, double *basis) {
  const thrum_fem *fem = &m->statics->body.fem;
  for (int64_t i = 0; i < m->n; i++)
    for (int64_t k = 0; k < m->count; k++)
      basis[fem->component[i] * m->count + k] = m->columns[k * m->n + i];
}

/* change = U'^T M U. */
static void relate(maker *m, thrum_richer_model *richer) {
  const thrum_fem *fem = &m->statics->body.fem;
  for (int64_t k = 0; k < m->count; k++) {
    for (int64_t i = 0; i < m->n; i++)
      m->x[i] = richer->model.basis[fem->component[i] * m->count + k];
    thrum_mass_gram(&m->statics->body.mass, m->columns, m->rank, m->x, 1,
                    richer->change + k * m->rank, m->work);
  }
}

static thrum_status make(maker *m, thrum_richer_model *richer, thrum_error *error) {
  const thrum_model *model = m->model;
  const thrum_model_fem *body = &m->statics->body;
  thrum_imported_basis imported = {.rows = 3 * model->vertex_count, .rank = m->count};
  imported.basis = thrum_scope_allocate(&m->memory, imported.rows * imported.rank, sizeof(double));
  THRUM_TRY(m->memory.status);
  scatter(m, imported.basis);

  thrum_precompute_options options = thrum_default_precompute_options();
  options.imported = &imported;
  options.mass = body->kind;
  THRUM_TRY(thrum_precompute(&body->mesh, model->fixed, &options, &richer->made, error));
  THRUM_TRY(
      thrum_reserve(&richer->change, m->count * m->rank, sizeof(double), "a richer model", error));

  // loads name groups
  richer->model = richer->made.model;
  richer->model.group_count = model->group_count;
  richer->model.group_names = model->group_names;
  richer->model.group_ends = model->group_ends;
  richer->model.group_name_bytes = model->group_name_bytes;
  richer->model.group_vertex_count = model->group_vertex_count;
  richer->model.group_vertices = model->group_vertices;
  relate(m, richer);

  // an unpacked model gives the same bits in many times the time
  const size_t size = thrum_model_pack_size(&richer->model);
  THRUM_TRY(thrum_reserve_aligned(&richer->packed, size, "a richer model", error));
  THRUM_TRY(thrum_model_pack(&richer->model, richer->packed, size, error));
  THRUM_TRY(thrum_solid_inertia(&richer->model, &richer->inertia, error));
  richer->model.inertia = richer->inertia;
  return THRUM_OK;
}

thrum_status thrum_richer_model_make(const thrum_model *model, const thrum_basis_judge *judge,
                                     const double *loads, int64_t count, int64_t most,
                                     thrum_richer_model *richer, thrum_error *error) {
  const double *directions = NULL;
  const int64_t looked = thrum_basis_judge_directions(judge, &directions);
  maker m = {.model = model, .statics = thrum_basis_judge_statics(judge), .rank = model->rank};
  m.n = m.statics->body.fem.free_count;
  m.most = most;
  m.memory = thrum_scope_begin("a richer model", error);
  m.columns = thrum_scope_allocate(&m.memory, m.n * (m.rank + most), sizeof(double));
  m.x = thrum_scope_allocate(&m.memory, m.n, sizeof(double));
  m.gram = thrum_scope_allocate(&m.memory, m.rank + most, sizeof(double));
  m.work = thrum_scope_allocate(&m.memory, m.n * THRUM_GRAM_WORK, sizeof(double));
  thrum_status status = m.memory.status;

  // the basis of the model comes first
  for (int64_t i = 0; status >= 0 && i < m.n; i++)
    for (int64_t k = 0; k < m.rank; k++)
      m.columns[k * m.n + i] = model->basis[m.statics->body.fem.component[i] * m.rank + k];
  m.count = m.rank;
  if (looked > 0)
    THRUM_THEN(status, add_directions(&m, directions, looked, count > 0 ? most / 2 : most, error));
  THRUM_THEN(status, add_loads(&m, loads, count, error));
  if (status >= 0 && m.count > m.rank)
    status = make(&m, richer, error);
  thrum_scope_free(&m.memory);
  return status;
}

void thrum_richer_model_free(thrum_richer_model *richer) {
  thrum_precomputed_free(&richer->made);
  free(richer->change);
  free(richer->packed);
  free(richer->inertia);
  *richer = (thrum_richer_model){0};
}
