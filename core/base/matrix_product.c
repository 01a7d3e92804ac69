/* Products with a matrix and its transpose; see matrix_product.h.
 *
 * Plain C. The order of every sum is fixed, so the result does not depend on compiler,
 * optimisation or vector width.
 * Cost: every function reads its matrix once; 2 operations per entry.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/base/matrix_product.h"

#include <stddef.h>

#include "core/base/lane_sums.h"

/* b += s a */
static void axpy(int64_t count, double s, const double *restrict a, double *restrict b) {
  for (int64_t c = 0; c < count; c++)
    b[c] += s * a[c];
}

void thrum_matrix_product(int64_t rows, int64_t columns, const double *matrix, const double *x,
                          double *y) {
  for (int64_t i = 0; i < rows; i++)
    y[i] += thrum_sum_of(columns, matrix + i * columns, x, NULL);
}

void thrum_matrix_product_transposed(int64_t rows, int64_t columns, const double *restrict matrix,
                                     const double *restrict x, double *restrict y) {
  int64_t i = 0;

  // four rows at a time, added in ascending order, so that y is loaded and stored less often
  for (; i + 4 <= rows; i += 4) {
    const double *b0 = matrix + i * columns, *b1 = b0 + columns, *b2 = b1 + columns,
                 *b3 = b2 + columns;
    double x0 = x[i], x1 = x[i + 1], x2 = x[i + 2], x3 = x[i + 3];
    for (int64_t c = 0; c < columns; c++)
      y[c] = (((y[c] + x0 * b0[c]) + x1 * b1[c]) + x2 * b2[c]) + x3 * b3[c];
  }

  // the rows that are left
  for (; i < rows; i++)
    axpy(columns, x[i], matrix + i * columns, y);
}
