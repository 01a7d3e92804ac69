/* Rows of a matrix that processes share, in blocks of 3 x 3, for products with BLOCK_COLUMNS
 * columns at once: the matrix is read once for all of them, where PETSc reads it once for each.
 * Columns stand beside each other, so that an entry is x[row * BLOCK_COLUMNS + column].
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_BLOCK_ROWS_H
#define THRUM_MPI_BLOCK_ROWS_H

#include <petscmat.h>
#include <stdbool.h>

#include "thrum/status.h"

#define BLOCK_COLUMNS 16
#define BLOCK_NUMBERS (3 * BLOCK_COLUMNS) /* of a block row of three rows */

typedef struct block_rows {
  int64_t rows, columns, ghosts; /* block rows; block columns of this process, and of others */
  int64_t *begin;                /* rows + 1 */
  int32_t *column; /* of each block: below `columns` one of this process, else columns + ghost */
  float *single;   /* 9 a block, by rows; NULL: */
  double *value;   /* 9 a block, by rows */
  void *ghost;     /* ghosts x BLOCK_NUMBERS, of the kind of the values */
  PetscSF halo;    /* brings them; NULL: one process alone */
  MPI_Datatype unit;
} block_rows;

/* scale: 1 / sqrt(diagonal) of each row of this process; 0 where the diagonal is not positive, so
 * that the row stays out of everything. */
thrum_status block_rows_scale(Mat matrix, double *scale, thrum_error *error);

/* Takes PETSc's matrix, whose rows and columns come in threes, with each entry multiplied by the
 * numbers of its row and of its column, both of this process's. */
thrum_status block_rows_take(Mat matrix, const double *row_scale, const double *column_scale,
                             bool single, block_rows *made, thrum_error *error);
void block_rows_free(block_rows *rows); /* leaves it empty; an empty (zeroed) one is fine */

/* y = A x, in double precision and in single. */
thrum_status block_rows_product(const block_rows *a, const double *x, double *y,
                                thrum_error *error);
thrum_status block_rows_product_single(const block_rows *a, const float *x, float *y,
                                       thrum_error *error);

/* One step of a smoother, in single precision: x += d, r -= A d, next = along d + across r. With
 * next NULL the first two alone. */
typedef struct block_step {
  float along, across;
  const float *d;
  float *next, *r, *x;
} block_step;
thrum_status block_rows_step(const block_rows *a, const block_step *step, thrum_error *error);

#endif
