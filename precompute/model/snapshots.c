/* Proper orthogonal decomposition in the norm of the stiffness, by the method of snapshots: with
 * the columns W = (u - U U^T M u) / |run|, the eigenvectors a of W^T K W with the largest
 * eigenvalues l give the shapes W a / sqrt(l).
 *
 * The norm is that of the energy and not of the mass, because a motion goes wrong by its phase:
 * what a body would do to relax is small and makes it softer, and a basis without it swings too
 * fast. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/snapshots.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>

#include "platform/allocate.h"
#include "precompute/basis/orthonormal.h"
#include "precompute/fem/lapack_status.h"

#define NOTHING 1e-12 /* of a run's energy: what a shape below this shows is rounding */

typedef struct pod {
  const thrum_model *model;
  const thrum_model_fem *body;
  int64_t n, columns;
  double *w;     /* n x columns, column-major */
  double *basis; /* n x rank, column-major */
  double *gram;  /* columns x columns, and room for columns x rank */
  double *values;
  double *work; /* n x THRUM_GRAM_WORK */
  thrum_scope memory;
} pod;

static thrum_status pod_allocate(pod *p, thrum_error *error) {
  const int64_t rank = p->model->rank, wide = p->columns > rank ? p->columns : rank;
  p->memory = thrum_scope_begin("the snapshots", error);
  p->w = thrum_scope_allocate(&p->memory, p->n * p->columns, sizeof *p->w);
  p->basis = thrum_scope_allocate(&p->memory, p->n * rank, sizeof *p->basis);
  p->gram = thrum_scope_allocate(&p->memory, wide * p->columns, sizeof *p->gram);
  p->values = thrum_scope_allocate(&p->memory, p->columns, sizeof *p->values);
  p->work = thrum_scope_allocate(&p->memory, p->n * THRUM_GRAM_WORK, sizeof *p->work);
  return p->memory.status;
}

/* The snapshots on the free components, each run of unit size. */
static void fill_columns(pod *p, const double *snapshots, int64_t runs, int64_t each) {
  const int64_t all = 3 * p->model->vertex_count;
  for (int64_t r = 0; r < runs; r++) {
    double *first = p->w + r * each * p->n, size = 0;
    for (int64_t s = 0; s < each; s++) {
      double *column = first + s * p->n, square = 0;
      thrum_fem_gather(&p->body->fem, snapshots + (r * each + s) * all, column);
      thrum_mass_gram(&p->body->stiffness, column, 1, column, 1, &square, p->work);
      size += square;
    }

    // column by column: a whole run may have more components than BLAS can count
    for (int64_t s = 0; s < each; s++)
      cblas_dscal((int)p->n, size > 0 ? 1 / sqrt(size) : 0, first + s * p->n, 1);
  }
}

/* w -= U U^T M w, twice, so that rounding leaves nothing of the basis either. */
static void remove_basis(pod *p) {
  const int n = (int)p->n, columns = (int)p->columns, rank = (int)p->model->rank;
  for (int64_t i = 0; i < rank; i++)
    for (int64_t f = 0; f < n; f++)
      p->basis[i * n + f] = p->model->basis[p->body->fem.component[f] * rank + i];
  for (int pass = 0; pass < 2; pass++) {
    thrum_mass_gram(&p->body->mass, p->basis, rank, p->w, columns, p->gram, p->work);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, columns, rank, -1, p->basis, n,
                p->gram, rank, 1, p->w, n);
  }
}

static thrum_status decompose(pod *p, int64_t runs, int64_t count, double *fields, int64_t *found,
                              thrum_error *error) {
  const int64_t all = 3 * p->model->vertex_count, columns = p->columns;
  thrum_mass_gram(&p->body->stiffness, p->w, columns, p->w, columns, p->gram, p->work);
  THRUM_TRY(thrum_lapack_status(
      LAPACKE_dsyev(LAPACK_COL_MAJOR, 'V', 'U', (int)columns, p->gram, (int)columns, p->values),
      THRUM_NOT_CONVERGED, "the decomposition of the snapshots did not converge", error));

  // the largest come last
  *found = 0;
  while (*found < count && *found < columns &&
         p->values[columns - 1 - *found] > NOTHING * (double)runs) {
    const int64_t at = columns - 1 - *found;
    cblas_dgemv(CblasColMajor, CblasNoTrans, (int)p->n, (int)columns, 1 / sqrt(p->values[at]), p->w,
                (int)p->n, p->gram + at * columns, 1, 0, p->work, 1);
    thrum_fem_scatter(&p->body->fem, p->work, fields + *found * all);
    ++*found;
  }
  return THRUM_OK;
}

thrum_status thrum_snapshot_shapes(const thrum_model *model, const thrum_model_fem *body,
                                   const double *snapshots, int64_t runs, int64_t each,
                                   int64_t count, double *fields, int64_t *found,
                                   thrum_error *error) {
  pod p = {.model = model, .body = body, .n = body->fem.free_count, .columns = runs * each};
  thrum_status status = pod_allocate(&p, error);
  if (status >= 0) {
    fill_columns(&p, snapshots, runs, each);
    remove_basis(&p);
    status = decompose(&p, runs, count, fields, found, error);
  }
  thrum_scope_free(&p.memory);
  return status;
}
