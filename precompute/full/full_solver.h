/* Which solver takes the linear systems of the full order. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FULL_FULL_SOLVER_H
#define THRUM_PRECOMPUTE_FULL_FULL_SOLVER_H

typedef enum thrum_full_solver {
  THRUM_FULL_CHOLESKY = 0, /* sparse Cholesky */
  THRUM_FULL_CG = 1        /* conjugate gradients, symmetric Gauss-Seidel as preconditioner */
} thrum_full_solver;

#endif
