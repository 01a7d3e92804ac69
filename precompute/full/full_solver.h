/* Which solver takes the linear systems of the full order, and which points its forces.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FULL_FULL_SOLVER_H
#define THRUM_PRECOMPUTE_FULL_FULL_SOLVER_H

typedef enum thrum_full_solver {
  THRUM_FULL_CHOLESKY = 0, /* sparse Cholesky */
  THRUM_FULL_CG = 1        /* conjugate gradients, symmetric Gauss-Seidel as preconditioner */
} thrum_full_solver;

typedef enum thrum_full_quadrature {
  THRUM_FULL_EXACT = 0, /* the rule that is exact for the energy of straight tetrahedra */
  THRUM_FULL_FOUR = 1   /* four points in a ten-node tetrahedron, as other programs take */
} thrum_full_quadrature;

#endif
