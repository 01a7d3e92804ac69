/* A multigrid in single precision for many right-hand sides at once, made of the grids that PETSc's
 * smoothed aggregation finds (Vanek, Mandel, Brezina 1996, doi:10.1007/BF02238511).
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_MULTIGRID_H
#define THRUM_MPI_MULTIGRID_H

#include <petscksp.h>

#include "mpi/block_rows.h"

typedef struct multigrid multigrid;

/* Takes the grids of a preconditioner of PETSc, PCGAMG that is set up, which may go afterwards.
 * scale: of each row of this process, 1 / sqrt(diagonal) of the finest matrix, by which it is
 * scaled from both sides. THRUM_UNSUPPORTED where the grids are not of the kind that is known. */
thrum_status multigrid_create(PC grids, const double *scale, multigrid **made, thrum_error *error);

/* One V-cycle: rough solutions of the scaled equations from residuals, both own rows x
 * BLOCK_COLUMNS, in memory of the multigrid until its next cycle. The residuals go in at
 * multigrid_right. */
float *multigrid_right(multigrid *grids);
thrum_status multigrid_cycle(multigrid *grids, const float **solution, thrum_error *error);

void multigrid_free(multigrid *grids); /* NULL is fine */

#endif
