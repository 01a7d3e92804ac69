/* Conjugate gradients for blocks of right-hand sides, with a multigrid in single precision.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_BLOCK_GRADIENTS_H
#define THRUM_MPI_BLOCK_GRADIENTS_H

#include <petscksp.h>

#include "mpi/block_rows.h"

typedef struct block_gradients block_gradients;

/* Takes the matrix and the grids of PETSc's preconditioner, which may both go afterwards.
 * THRUM_UNSUPPORTED where they are not of the kind that is known. */
thrum_status block_gradients_create(Mat matrix, PC grids, block_gradients **made,
                                    thrum_error *error);

/* Solves for up to BLOCK_COLUMNS columns, in place: own rows x BLOCK_COLUMNS, columns that are zero
 * stay zero. It ends when r . A r, A the multigrid, has fallen by the square of the tolerance: the
 * error then is that share of the solution in the norm of the matrix. Called by all. */
thrum_status block_gradients_solve(block_gradients *s, double *columns, double tolerance,
                                   thrum_error *error);

/* Steps of all solves, and how many columns they took along. */
typedef struct block_gradients_counts {
  double columns, steps;
} block_gradients_counts;
block_gradients_counts block_gradients_counted(const block_gradients *s);

void block_gradients_free(block_gradients *s); /* NULL is fine */

#endif
