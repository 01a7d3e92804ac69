/* Sparse symmetric matrices and their Cholesky factors: the one interface to CHOLMOD. Nothing else
 * of Thrum sees the solver, so another one can take its place here.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_SPARSE_H
#define THRUM_PRECOMPUTE_FEM_SPARSE_H

#include <stdint.h>

#include "thrum/status.h"

/* A symmetric matrix by the columns of its lower triangle: rows ascending, the diagonal first. */
typedef struct thrum_sparse {
  int64_t size;   /* n */
  int64_t *begin; /* n + 1: where each column starts in row and value */
  int64_t *row;   /* begin[n] */
  double *value;  /* begin[n] */
} thrum_sparse;

/* Allocates a matrix of n columns and `entries` stored entries, begin[0] = 0, the rest undefined.
 */
thrum_status thrum_sparse_create(int64_t size, int64_t entries, thrum_sparse *matrix,
                                 thrum_error *error);
void thrum_sparse_free(thrum_sparse *matrix); /* leaves it empty; an empty (zeroed) one is fine */

/* product = A x; both n x columns, column-major, not overlapping. */
void thrum_sparse_product(const thrum_sparse *matrix, const double *x, int64_t columns,
                          double *product);

/* Largest sum of absolute values of a row, work: n doubles. */
double thrum_sparse_norm(const thrum_sparse *matrix, double *work);

/* A supernodal Cholesky factor L L^T = P A P^T, P by METIS nested dissection. One thread at a time.
 */
typedef struct thrum_factor thrum_factor;

/* THRUM_SINGULAR when A is not positive definite. The matrix is only read and may go. */
thrum_status thrum_factor_create(const thrum_sparse *matrix, thrum_factor **factor,
                                 thrum_error *error);

/* The same in two steps. plan: ordering and pattern of L, which costs a small part; flops and
 * nonzeros are known afterwards. compute: the numbers, of the same matrix. */
thrum_status thrum_factor_plan(const thrum_sparse *matrix, thrum_factor **factor,
                               thrum_error *error);
thrum_status thrum_factor_compute(const thrum_sparse *matrix, thrum_factor *factor,
                                  thrum_error *error);

/* From now on solve keeps to the complement of `count` vectors Z: it takes b - dual (Z^T b) for b
 * and gives x - Z (dual^T x) for x, dual = M Z, both n x count, column-major. They must stay while
 * the factor is used. */
void thrum_factor_deflate(thrum_factor *factor, int64_t count, const double *vectors,
                          const double *dual);
int64_t thrum_factor_deflated(const thrum_factor *factor); /* count, 0 before */

/* solution = A^-1 right; both n x columns, column-major; may be the same array. Blocks of about
 * THRUM_SOLVE_BLOCK columns cost a sixth a column of what one alone costs. */
#define THRUM_SOLVE_BLOCK 32
thrum_status thrum_factor_solve(thrum_factor *factor, const double *right, int64_t columns,
                                double *solution, thrum_error *error);

int64_t thrum_factor_nonzeros(const thrum_factor *factor); /* of L, stored zeros included */
/* Count the operations of the factorisation, by CHOLMOD, and of all solves so far, four a nonzero
 * and column. */
double thrum_factor_flops(const thrum_factor *factor);
double thrum_factor_solve_flops(const thrum_factor *factor);
/* Bytes that the planned factor will take, and that its computation takes besides a copy of A. */
double thrum_factor_bytes(const thrum_factor *factor);
double thrum_factor_work_bytes(const thrum_factor *factor);
void thrum_factor_free(thrum_factor *factor); /* NULL is fine */

#endif
