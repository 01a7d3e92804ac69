/* Sparse Cholesky factors in single precision: half the memory and less than half the time of one
 * in double precision. Where conjugate gradients take it as preconditioner their solutions are
 * those of double precision. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_SINGLE_FACTOR_H
#define THRUM_PRECOMPUTE_FEM_SINGLE_FACTOR_H

#include <stdint.h>

#include "precompute/fem/sparse_matrix.h"

/* The pattern of L by supernodes, neighbouring columns with the same rows below them; the maker of
 * the plan owns the arrays, and they must stay while the factor is used. */
typedef struct thrum_supernodes {
  int64_t size;         /* n */
  int64_t count;        /* of supernodes */
  const int64_t *first; /* count + 1: first column of each */
  const int64_t *begin; /* count + 1: where the rows of each start in row */
  const int64_t *row;   /* begin[count]: ascending in each, its own columns first */
  const int64_t *order; /* n: row order[i] of A is row i of P A P^T */
} thrum_supernodes;

typedef struct thrum_single_factor thrum_single_factor;

/* Numbers that the factor will store. */
int64_t thrum_single_factor_entries(const thrum_supernodes *pattern);

/* Factorises S A S = L L^T, with S = diag(A)^-1/2 so that no number leaves the range of single
 * precision. THRUM_SINGULAR where a pivot is not positive, which rounding does to matrices of a
 * condition above about 1e7 that are positive definite. The matrix is only read and may go. */
thrum_status thrum_single_factor_create(const thrum_supernodes *pattern, const thrum_sparse *matrix,
                                        thrum_single_factor **factor, thrum_error *error);

/* solution = S (L L^T)^-1 S right, to about 1e-6 of the condition; both n x columns, column-major,
 * may be the same array. */
thrum_status thrum_single_factor_solve(thrum_single_factor *factor, const double *right,
                                       int64_t columns, double *solution, thrum_error *error);

void thrum_single_factor_free(thrum_single_factor *factor); /* NULL is fine */

#endif
