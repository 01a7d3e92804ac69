/* Conjugate gradients (Hestenes, Stiefel 1952, doi:10.6028/jres.049.044) for blocks, see
 * block_gradients.h. The columns of a block step together, each with numbers of its own, so that
 * each matrix is read once for all of them. The preconditioner is in single precision, all else in
 * double, as with the factor of one process (precompute/fem/refined_solve.c). Unknowns are scaled
 * to a diagonal of ones.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mpi/block_gradients.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "mpi/agreement.h"
#include "mpi/multigrid.h"
#include "mpi/petsc_status.h"
#include "platform/allocate.h"

#define STEPS_MAX 250 /* sound meshes take 20 to 75 */

struct block_gradients {
  MPI_Comm comm;
  int64_t rows;  /* of this process, in threes */
  double *scale; /* 3 rows, 1 / sqrt(diagonal) */
  block_rows matrix;
  multigrid *grids;
  double *residual, *direction, *image; /* rows x BLOCK_NUMBERS */
  block_gradients_counts counts;
};

typedef double numbers[BLOCK_COLUMNS]; /* one of each column */

static thrum_status make(Mat matrix, PC grids, block_gradients *s, thrum_error *error) {
  PetscInt rows;
  PETSC_TRY(PetscObjectGetComm((PetscObject)matrix, &s->comm));
  PETSC_TRY(MatGetLocalSize(matrix, &rows, NULL));
  s->rows = rows / 3;
  THRUM_TRY(thrum_reserve(&s->scale, rows, sizeof *s->scale, "the solver", error));
  THRUM_TRY(block_rows_scale(matrix, s->scale, error));
  return multigrid_create(grids, s->scale, &s->grids, error);
}

thrum_status block_gradients_create(Mat matrix, PC grids, block_gradients **made,
                                    thrum_error *error) {
  block_gradients *s = NULL;
  THRUM_TRY(thrum_reserve(&s, 1, sizeof *s, "the solver", error));
  thrum_status status = make(matrix, grids, s, error);
  THRUM_THEN(status, block_rows_take(matrix, s->scale, s->scale, false, &s->matrix, error));
  if (status >= 0)
    *made = s;
  else
    block_gradients_free(s);
  return status;
}

void block_gradients_free(block_gradients *s) {
  if (s == NULL)
    return;
  multigrid_free(s->grids);
  block_rows_free(&s->matrix);
  free(s->scale);
  free(s->residual);
  free(s->direction);
  free(s->image);
  free(s);
}

block_gradients_counts block_gradients_counted(const block_gradients *s) {
  return s->counts;
}

// vectors of a block, kept for the next one
static thrum_status reserve(block_gradients *s, thrum_error *error) {
  const int64_t count = s->rows * BLOCK_NUMBERS;
  double **const vectors[] = {&s->residual, &s->direction, &s->image};
  for (int n = 0; n < 3; n++)
    if (*vectors[n] == NULL)
      THRUM_TRY(thrum_reserve(vectors[n], count, sizeof(double), "the solution", error));
  return THRUM_OK;
}

// the residual is the right-hand side, scaled, and of unit length in each column
static void begin(block_gradients *s, double *columns, numbers length) {
  numbers square = {0};
  for (int64_t i = 0; i < 3 * s->rows; i++)
    for (int c = 0; c < BLOCK_COLUMNS; c++) {
      const int64_t at = i * BLOCK_COLUMNS + c;
      s->residual[at] = s->scale[i] * columns[at];
      square[c] += s->residual[at] * s->residual[at];
      s->direction[at] = columns[at] = 0;
    }
  agree_on_sums(s->comm, square, BLOCK_COLUMNS);

  // a column that is zero stays zero
  numbers inverse;
  for (int c = 0; c < BLOCK_COLUMNS; c++) {
    length[c] = sqrt(square[c]);
    inverse[c] = length[c] > 0 ? 1 / length[c] : 0;
  }
  for (int64_t i = 0; i < 3 * s->rows; i++)
    for (int c = 0; c < BLOCK_COLUMNS; c++)
      s->residual[i * BLOCK_COLUMNS + c] *= inverse[c];
}

// z = A r by the multigrid, energy = r . z
static thrum_status precondition(block_gradients *s, const float **z, numbers energy,
                                 thrum_error *error) {
  const int64_t count = s->rows * BLOCK_NUMBERS;
  float *right = multigrid_right(s->grids);
  for (int64_t i = 0; i < count; i++)
    right[i] = (float)s->residual[i];
  THRUM_TRY(multigrid_cycle(s->grids, z, error));

  // summed in lanes of the columns
  numbers sum = {0};
  for (int64_t i = 0; i < count; i += BLOCK_COLUMNS)
    for (int c = 0; c < BLOCK_COLUMNS; c++)
      sum[c] += s->residual[i + c] * (double)(*z)[i + c];
  agree_on_sums(s->comm, sum, BLOCK_COLUMNS);
  memcpy(energy, sum, sizeof sum);
  return THRUM_OK;
}

// p = z + share p, K p, and the curvature p . K p
static thrum_status turn(block_gradients *s, const float *z, const numbers share, numbers curvature,
                         thrum_error *error) {
  const int64_t count = s->rows * BLOCK_NUMBERS;
  for (int64_t i = 0; i < count; i += BLOCK_COLUMNS)
    for (int c = 0; c < BLOCK_COLUMNS; c++)
      s->direction[i + c] = (double)z[i + c] + share[c] * s->direction[i + c];
  THRUM_TRY(block_rows_product(&s->matrix, s->direction, s->image, error));
  numbers sum = {0};
  for (int64_t i = 0; i < count; i += BLOCK_COLUMNS)
    for (int c = 0; c < BLOCK_COLUMNS; c++)
      sum[c] += s->direction[i + c] * s->image[i + c];
  agree_on_sums(s->comm, sum, BLOCK_COLUMNS);
  memcpy(curvature, sum, sizeof sum);
  return THRUM_OK;
}

static void advance(block_gradients *s, double *solution, const numbers step) {
  const int64_t count = s->rows * BLOCK_NUMBERS;
  for (int64_t i = 0; i < count; i += BLOCK_COLUMNS)
    for (int c = 0; c < BLOCK_COLUMNS; c++) {
      solution[i + c] += step[c] * s->direction[i + c];
      s->residual[i + c] -= step[c] * s->image[i + c];
    }
}

// the solution in the unknowns of the caller, once more of the length that was taken away
static void finish(const block_gradients *s, double *solution, const numbers length) {
  for (int64_t i = 0; i < 3 * s->rows; i++)
    for (int c = 0; c < BLOCK_COLUMNS; c++)
      solution[i * BLOCK_COLUMNS + c] *= s->scale[i] * length[c];
}

static thrum_status not_converged(int steps, thrum_error *error) {
  return thrum_error_set(error, THRUM_NOT_CONVERGED,
                         "conjugate gradients did not converge in %d steps: check the mesh (see "
                         "thrum check), or take --solver factor",
                         steps);
}

static thrum_status iterate(block_gradients *s, double *solution, double tolerance,
                            const numbers length, thrum_error *error) {
  const float *z;
  numbers energy, start = {0}, before = {0};
  for (int n = 0; n < STEPS_MAX; n++) {
    THRUM_TRY(precondition(s, &z, energy, error));

    // rounding can make a preconditioner of no use, and an overflow anything
    for (int c = 0; c < BLOCK_COLUMNS; c++)
      if (!(energy[c] >= 0))
        return not_converged(n, error);

    // a column that has converged stands still
    numbers share, curvature, step;
    int going = 0;
    bool on[BLOCK_COLUMNS];
    for (int c = 0; c < BLOCK_COLUMNS; c++) {
      start[c] = n == 0 ? energy[c] : start[c];
      on[c] = length[c] > 0 && energy[c] > tolerance * tolerance * start[c] &&
              (n == 0 || before[c] > 0);
      share[c] = n > 0 && on[c] ? energy[c] / before[c] : 0;
      before[c] = on[c] ? energy[c] : 0;
      going += on[c];
    }
    s->counts.steps += going;
    if (going == 0)
      return THRUM_OK;

    // a step of its own length in each column
    THRUM_TRY(turn(s, z, share, curvature, error));
    for (int c = 0; c < BLOCK_COLUMNS; c++)
      step[c] = on[c] && curvature[c] > 0 ? energy[c] / curvature[c] : 0;
    advance(s, solution, step);
  }
  return not_converged(STEPS_MAX, error);
}

thrum_status block_gradients_solve(block_gradients *s, double *columns, double tolerance,
                                   thrum_error *error) {
  numbers length;
  THRUM_TRY(reserve(s, error));
  begin(s, columns, length);
  for (int c = 0; c < BLOCK_COLUMNS; c++)
    s->counts.columns += length[c] > 0;
  THRUM_TRY(iterate(s, columns, tolerance, length, error));
  finish(s, columns, length);
  return THRUM_OK;
}
