/* Orthonormal columns in the mass inner product, by BLAS-3 throughout: rounds of a pivoted Cholesky
 * that picks a well-conditioned subset of what is left, Cholesky-QR twice on that subset (Yamamoto
 * et al. 2015, ETNA 44), and block Gram-Schmidt twice on the rest. A round resolves what lies
 * within 1e-3 of the columns' own norms, so three or four reach any usable tolerance with
 * orthonormality at rounding, which one Gram matrix cannot. O(n count^2).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/orthonormal.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/lapack_status.h"

#define ROUNDS_MAX 40
#define PIVOT_MIN 1e-6 /* of a unit column's squared norm: picked columns stay well conditioned */

void thrum_mass_gram(const thrum_sparse *mass, const double *left, int64_t a, const double *right,
                     int64_t b, double *gram, double *work) {
  const int64_t n = mass->size;
  for (int64_t first = 0; first < b; first += THRUM_SOLVE_BLOCK) {
    const int64_t width = b - first < THRUM_SOLVE_BLOCK ? b - first : THRUM_SOLVE_BLOCK;
    thrum_sparse_product_in(mass, right + first * n, width, work, work + THRUM_SOLVE_BLOCK * n);
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, (int)a, (int)width, (int)n, 1, left,
                (int)n, work, (int)n, 0, gram + first * a, (int)a);
  }
  thrum_ranks_sum(mass->ranks, gram, a * b);
}

void thrum_mass_project(const thrum_sparse *mass, const double *q, int64_t done, double *x,
                        int64_t count, double *gram, double *work) {
  const int n = (int)mass->size;
  if (done == 0 || count == 0)
    return;
  thrum_mass_gram(mass, q, done, x, count, gram, work);
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, (int)count, (int)done, -1, q, n, gram,
              (int)done, 1, x, n);
}

// pivoted Cholesky of the Gram matrix brought to unit diagonal; order gets the picked columns
// first, and *picked their number
static thrum_status pick(double *gram, int64_t count, double tolerance, int32_t *order,
                         int64_t *picked, thrum_error *error) {
  double *scale = gram + count * count;
  for (int64_t i = 0; i < count; i++) {
    const double square = gram[i + i * count];
    scale[i] = square > tolerance * tolerance ? 1 / sqrt(square) : 0;
  }
  for (int64_t j = 0; j < count; j++)
    for (int64_t i = 0; i < count; i++)
      gram[i + j * count] *= scale[i] * scale[j];

  // above 0 it says that not all columns were picked, which is what it is asked
  int32_t number = 0;
  const int info = LAPACKE_dpstrf(LAPACK_COL_MAJOR, 'U', (int)count, gram, (int)count, order,
                                  &number, PIVOT_MIN);
  if (info < 0)
    return thrum_lapack_status(info, THRUM_NOT_CONVERGED, "the columns could not be ordered",
                               error);
  *picked = number;
  return THRUM_OK;
}

static void swap_columns(double *x, int64_t n, int64_t a, int64_t b) {
  if (a != b)
    cblas_dswap((int)n, x + a * n, 1, x + b * n, 1);
}

/* How the columns that were given are made of the orthonormal ones; NULL members: not asked for. */
typedef struct triangle {
  int64_t count;   /* of columns, and of rows */
  double *entries; /* count x count, column-major */
  int32_t *which;  /* count: the column that was given of each column here */
} triangle;

// brings the picked columns of x, behind `done` others, to its front
static void bring_front(double *x, int64_t n, int64_t done, int64_t picked, int32_t *order,
                        int64_t count, const triangle *r) {
  for (int64_t i = 0; i < picked; i++) {
    const int64_t from = order[i] - 1;
    swap_columns(x, n, i, from);
    if (r->entries != NULL) {
      const int32_t turned = r->which[done + i];
      r->which[done + i] = r->which[done + from];
      r->which[done + from] = turned;
      swap_columns(r->entries, r->count, done + i, done + from);
    }
    // what stood at i stands now where the picked one was
    for (int64_t j = i + 1; j < count; j++)
      if (order[j] - 1 == i)
        order[j] = order[i];
  }
}

// what a projection took from `count` columns behind `done` orthonormal ones
static void note_projection(const triangle *r, int64_t done, int64_t count, const double *gram) {
  for (int64_t c = 0; c < count && r->entries != NULL; c++)
    cblas_daxpy((int)done, 1, gram + c * done, 1, r->entries + (done + c) * r->count, 1);
}

// Cholesky-QR of `picked` columns x behind `done` orthonormal ones, twice
static thrum_status factor_front(const thrum_sparse *mass, double *q, int64_t done, int64_t picked,
                                 const triangle *r, double *gram, double *work,
                                 thrum_error *error) {
  const int n = (int)mass->size, p = (int)picked, all = (int)r->count;
  double *x = q + done * mass->size;
  double *above = r->entries ? r->entries + done * r->count : NULL;
  double *block = r->entries ? above + done : NULL;
  for (int64_t c = 0; c < picked && block != NULL; c++)
    block[c * r->count + c] = 1;

  // the columns were x = x' block + q above; x' becomes y R + q gram
  for (int pass = 0; pass < 2; pass++) {
    thrum_mass_project(mass, q, done, x, picked, gram, work);
    if (block != NULL && done > 0)
      cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, (int)done, p, p, 1, gram, (int)done,
                  block, all, 1, above, all);
    thrum_mass_gram(mass, x, picked, x, picked, gram, work);
    THRUM_TRY(thrum_lapack_status(LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'U', p, gram, p), THRUM_SINGULAR,
                                  "the basis could not be orthonormalised", error));
    cblas_dtrsm(CblasColMajor, CblasRight, CblasUpper, CblasNoTrans, CblasNonUnit, n, p, 1, gram, p,
                x, n);
    if (block != NULL)
      cblas_dtrmm(CblasColMajor, CblasLeft, CblasUpper, CblasNoTrans, CblasNonUnit, p, p, 1, gram,
                  p, block, all);
  }
  return THRUM_OK;
}

static thrum_status orthonormalise(const thrum_sparse *mass, int64_t count, double *x,
                                   double tolerance, int64_t *rank, const triangle *r, double *work,
                                   thrum_error *error) {
  const int64_t n = mass->size;
  thrum_scope memory = thrum_scope_begin("the basis", error);
  double *gram = thrum_scope_allocate(&memory, count * (count + 1), sizeof *gram);
  int32_t *order = thrum_scope_allocate(&memory, count, sizeof *order);
  thrum_status status = memory.status;

  // rounds, as the columns picked in one may be all that is accurate
  int64_t done = 0;
  for (int round = 0; round < ROUNDS_MAX && done < count && status >= 0; round++) {
    double *rest = x + done * n;
    const int64_t left = count - done;

    // orthogonal to the columns that are done; twice, as once leaves rounding
    for (int pass = 0; pass < 2 && done > 0; pass++) {
      thrum_mass_project(mass, x, done, rest, left, gram, work);
      note_projection(r, done, left, gram);
    }

    // pivots of the Gram matrix say which columns are independent enough
    thrum_mass_gram(mass, rest, left, rest, left, gram, work);
    int64_t picked = 0;
    status = pick(gram, left, tolerance, order, &picked, error);
    if (status < 0 || picked == 0)
      break;

    // those come to the front and become orthonormal by a Cholesky factor
    bring_front(rest, n, done, picked, order, left, r);
    status = factor_front(mass, x, done, picked, r, gram, work, error);
    done += picked;
  }

  thrum_scope_free(&memory);
  if (status >= 0)
    *rank = done;
  return status;
}

thrum_status thrum_mass_orthonormalise(const thrum_sparse *mass, int64_t count, double *x,
                                       double tolerance, int64_t *rank, double *work,
                                       thrum_error *error) {
  const triangle none = {0};
  return orthonormalise(mass, count, x, tolerance, rank, &none, work, error);
}

thrum_status thrum_mass_factor(const thrum_sparse *mass, int64_t count, double *x, double tolerance,
                               int64_t *rank, double *entries, int32_t *which, double *work,
                               thrum_error *error) {
  const triangle r = {count, entries, which};
  memset(entries, 0, sizeof *entries * (size_t)(count * count));
  for (int64_t c = 0; c < count; c++)
    which[c] = (int32_t)c;
  return orthonormalise(mass, count, x, tolerance, rank, &r, work, error);
}
