/* Sparse symmetric matrices as text that other programs read. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_PRECOMPUTE_FEM_MATRIX_MARKET_H
#define THRUM_PRECOMPUTE_FEM_MATRIX_MARKET_H

#include "precompute/fem/fem.h"

/* Writes the lower triangle in the Matrix Market format, coordinate real symmetric, 17 digits;
 * `about` is one line of comment. */
thrum_status thrum_matrix_market_write(const char *path, const thrum_sparse *matrix,
                                       const char *about, thrum_error *error);

/* Writes which component each row is: a line "vertex axis" a row, vertices from 1, axes x, y, z. */
thrum_status thrum_rows_write(const char *path, const thrum_fem *fem, thrum_error *error);

#endif
