/* Solutions of double precision from a factor in single precision. SPDX-License-Identifier:
 * Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_REFINED_SOLVE_H
#define THRUM_PRECOMPUTE_FEM_REFINED_SOLVE_H

#include "precompute/fem/single_factor.h"

/* solution = A^-1 right, both n x columns, column-major; may be the same array. *solved rises by
 * the columns that went through the factor. THRUM_NOT_CONVERGED where the factor is no use. */
thrum_status thrum_refined_solve(const thrum_sparse *matrix, thrum_single_factor *factor,
                                 const double *right, int64_t columns, double *solution,
                                 int64_t *solved, thrum_error *error);

#endif
