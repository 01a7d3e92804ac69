/* Products with a rectangular matrix and its transpose, such as the basis U and the masses U^T M 1.
 * Private to the libraries.
 *
 * `matrix` is rows x columns, row-major and contiguous. A sum over columns runs in 8 lanes (lane =
 * column mod 8, ascending), added as ((0+4)+(2+6))+((1+5)+(3+7)); a sum over rows is ascending.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_MATRIX_PRODUCT_H
#define THRUM_CORE_BASE_MATRIX_PRODUCT_H

#include <stdint.h>

/* y += A x; x: columns, y: rows. */
void thrum_matrix_product(int64_t rows, int64_t columns, const double *matrix, const double *x,
                          double *y);

/* y += A^T x; x: rows, y: columns. */
void thrum_matrix_product_transposed(int64_t rows, int64_t columns, const double *matrix,
                                     const double *x, double *y);

#endif
