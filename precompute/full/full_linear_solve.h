/* One linear system of the full-order body, by either solver; see full_linear_solve.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FULL_FULL_LINEAR_SOLVE_H
#define THRUM_PRECOMPUTE_FULL_FULL_LINEAR_SOLVE_H

#include <stdbool.h>

#include "precompute/fem/sparse.h"
#include "precompute/full/full_solver.h"

typedef struct full_linear {
  thrum_full_solver solver;
  const thrum_sparse *matrix; /* borrowed; its values may change before each prepare */
  thrum_factor *factor;       /* Cholesky, but for that of several processes: */
  const thrum_full_shared *shared;
  void *system;
  double *work; /* conjugate gradients: 4 n */
  double tolerance;
  bool ready; /* prepared, and good for solve */
  int64_t factorisations, iterations;
} full_linear;

/* Plans for this pattern, with Cholesky in the processes of `shared`, NULL: in this one.
 * full_linear_free is fine on a zeroed one. */
thrum_status full_linear_make(thrum_full_solver solver, const thrum_full_shared *shared,
                              double tolerance, const thrum_sparse *matrix, full_linear *linear,
                              thrum_error *error);
void full_linear_free(full_linear *linear);

/* Takes the matrix as it is now. THRUM_SINGULAR when it is found not to be positive definite, which
 * conjugate gradients find in solve only. */
thrum_status full_linear_prepare(full_linear *linear, thrum_error *error);

/* x = A^-1 b, n each, not overlapping. */
thrum_status full_linear_solve(full_linear *linear, const double *b, double *x, thrum_error *error);

#endif
