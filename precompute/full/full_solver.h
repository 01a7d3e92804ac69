/* Which solver takes the linear systems of the full order, and which points its forces.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FULL_FULL_SOLVER_H
#define THRUM_PRECOMPUTE_FULL_FULL_SOLVER_H

#include "thrum/status.h"

typedef enum thrum_full_solver {
  THRUM_FULL_CHOLESKY = 0, /* sparse Cholesky */
  THRUM_FULL_CG = 1        /* conjugate gradients, symmetric Gauss-Seidel as preconditioner */
} thrum_full_solver;

typedef enum thrum_full_quadrature {
  THRUM_FULL_EXACT = 0, /* the rule that is exact for the energy of straight tetrahedra */
  THRUM_FULL_FOUR = 1   /* four points in a ten-node tetrahedron, as other programs take */
} thrum_full_quadrature;

struct thrum_sparse;

/* A solver that several processes share, in the place of Cholesky. `system` is what plan gave;
 * compute takes the matrix as it is now and fails with THRUM_SINGULAR where it is not positive
 * definite; x = A^-1 b, n each. */
typedef struct thrum_full_shared {
  void *context;
  thrum_status (*plan)(void *context, const struct thrum_sparse *matrix, void **system,
                       thrum_error *error);
  thrum_status (*compute)(void *system, const struct thrum_sparse *matrix, thrum_error *error);
  thrum_status (*solve)(void *system, const double *b, double *x, thrum_error *error);
  void (*end)(void *system);
} thrum_full_shared;

#endif
