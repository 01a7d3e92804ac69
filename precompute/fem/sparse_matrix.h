/* Sparse symmetric matrices. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_SPARSE_MATRIX_H
#define THRUM_PRECOMPUTE_FEM_SPARSE_MATRIX_H

#include <stdint.h>

#include "precompute/fem/ranks.h"
#include "thrum/status.h"

/* A symmetric matrix by the columns of its lower triangle: rows ascending, the diagonal first. */
typedef struct thrum_sparse {
  int64_t size;             /* n */
  int64_t *begin;           /* n + 1: where each column starts in row and value */
  int64_t *row;             /* begin[n] */
  double *value;            /* begin[n] */
  const thrum_ranks *ranks; /* of whose matrix these are the terms; NULL: the whole matrix */
} thrum_sparse;

/* Allocates a matrix of n columns and `entries` stored entries, begin[0] = 0, the rest undefined.
 */
thrum_status thrum_sparse_create(int64_t size, int64_t entries, thrum_sparse *matrix,
                                 thrum_error *error);
void thrum_sparse_free(thrum_sparse *matrix); /* leaves it empty; an empty (zeroed) one is fine */

/* product = A x; both n x columns, column-major, not overlapping. */
void thrum_sparse_product(const thrum_sparse *matrix, const double *x, int64_t columns,
                          double *product);

/* The same with the same bits in memory of the caller's, n x THRUM_PRODUCT_WORK or NULL: for many
 * products, as the system takes and clears the pages of large arrays anew each time. */
#define THRUM_PRODUCT_WORK 16
void thrum_sparse_product_in(const thrum_sparse *matrix, const double *x, int64_t columns,
                             double *product, double *work);

/* Largest sum of absolute values of a row, work: n doubles. Of a part, where terms that cancel
 * between parts count twice, from above. */
double thrum_sparse_norm(const thrum_sparse *matrix, double *work);

#endif
