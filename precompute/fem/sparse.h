/* Cholesky factors of sparse symmetric matrices: the one interface to CHOLMOD. Nothing else
 * of Thrum sees the solver, so another one can take its place here.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_SPARSE_H
#define THRUM_PRECOMPUTE_FEM_SPARSE_H

#include <stdbool.h>

#include "precompute/fem/sparse_matrix.h"

/* A supernodal Cholesky factor L L^T = P A P^T, P by METIS nested dissection. One thread at a time.
 */
typedef struct thrum_factor thrum_factor;

/* THRUM_SINGULAR when A is not positive definite. The matrix is only read and may go. */
thrum_status thrum_factor_create(const thrum_sparse *matrix, thrum_factor **factor,
                                 thrum_error *error);

/* The solver of all processes that share a body (thrum_ranks, which must stay) in place of a
 * factor: solves take terms and give displacements, of the `size` free components of this part.
 * `ranks` is prepared. */
thrum_status thrum_factor_share(const thrum_ranks *ranks, int64_t size, thrum_factor **factor,
                                thrum_error *error);

/* The same in two steps. plan: ordering and pattern of L, which costs a small part; flops and
 * nonzeros are known afterwards. compute: the numbers, of the same matrix. */
thrum_status thrum_factor_plan(const thrum_sparse *matrix, thrum_factor **factor,
                               thrum_error *error);
thrum_status thrum_factor_compute(const thrum_sparse *matrix, thrum_factor *factor,
                                  thrum_error *error);

/* Numbers in a factor from which on single precision is worth its additional passes: 1.2 GB in
 * double. Smaller bodies keep the bits of double precision. */
#define THRUM_SINGLE_NONZEROS 150000000

/* Between plan and compute: the numbers will be computed in single precision, and solves are
 * refined by conjugate gradients with `matrix` until they are as good as those of double precision.
 * The matrix must stay while the factor is used; its null space may be deflated where the one that
 * is factorised is the matrix with springs. NULL: back to double precision, as after a failed
 * compute.
 */
void thrum_factor_set_single(thrum_factor *factor, const thrum_sparse *matrix);
bool thrum_factor_is_single(const thrum_factor *factor);

/* From now on solve keeps to the complement of `count` vectors Z: it takes b - dual (Z^T b) for b
 * and gives x - Z (dual^T x) for x, dual = M Z, both n x count, column-major. They must stay while
 * the factor is used. */
void thrum_factor_deflate(thrum_factor *factor, int64_t count, const double *vectors,
                          const double *dual);
int64_t thrum_factor_deflated(const thrum_factor *factor);      /* count, 0 before */
const double *thrum_factor_vectors(const thrum_factor *factor); /* Z, NULL before */

/* solution = A^-1 right; both n x columns, column-major; may be the same array. Blocks of about
 * THRUM_SOLVE_BLOCK columns cost a sixth a column of what one alone costs. */
#define THRUM_SOLVE_BLOCK 32
thrum_status thrum_factor_solve(thrum_factor *factor, const double *right, int64_t columns,
                                double *solution, thrum_error *error);

/* The same as one pass through the factor gives it: of a factor in single precision about six
 * digits less the condition, else the same. */
thrum_status thrum_factor_solve_roughly(thrum_factor *factor, const double *right, int64_t columns,
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
