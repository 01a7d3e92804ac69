/* The V-cycle, see multigrid.h. All matrices are scaled to a diagonal of ones, so that numbers stay
 * in the range of single precision and the smoother needs no diagonal. It is Chebyshev's polynomial
 * of the residual (Adams, Brezina, Hu, Tuminaro 2003, doi:10.1016/S0021-9991(03)00194-3), the same
 * before and after the coarser grid, so the cycle is symmetric and positive. The coarsest grid has
 * a Cholesky factor in double precision in every process. A cycle reads each matrix DEGREE times
 * before and as often after the coarser grid.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mpi/multigrid.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mpi/agreement.h"
#include "mpi/petsc_status.h"
#include "platform/allocate.h"

#define DEGREE 2            /* of the smoother */
#define SMOOTHED_SHARE 0.05 /* of the largest eigenvalue, from which on the smoother works */
#define SAFETY 1.1          /* of the largest eigenvalue, which is found from below */
#define POWER_STEPS 10      /* that find it */
#define COARSEST_MAX 5000   /* rows that every process has a factor of */

typedef struct level {
  int64_t rows;              /* of this process, block rows */
  double *scale;             /* 3 rows, 1 / sqrt(diagonal) */
  double most;               /* the largest eigenvalue, from above */
  block_rows matrix;         /* not of the coarsest */
  block_rows finer, coarser; /* from the next level to this one, and back */
  float *right, *solution;   /* rows x BLOCK_NUMBERS: right is the residual afterwards */
  float *direction, *other;  /* rows x BLOCK_NUMBERS */
} level;

struct multigrid {
  MPI_Comm comm;
  int levels;
  level *level; /* the finest first */

  /* The coarsest grid, whole in every process. */
  int64_t whole, first; /* its rows, and the first of this process */
  double *factor;       /* whole x whole, by rows, lower triangle */
  double *gathered;     /* whole x BLOCK_COLUMNS */
};

/* --- making ----------------------------------------------------------------------------------- */

static Mat matrix_of(PC grids, PetscInt at, thrum_status *status, thrum_error *error) {
  KSP smoother;
  Mat matrix = NULL;
  PETSC_THEN(*status, PCMGGetSmoother(grids, at, &smoother));
  PETSC_THEN(*status, KSPGetOperators(smoother, &matrix, NULL));
  return matrix;
}

static thrum_status make_vectors(level *l, thrum_error *error) {
  const int64_t count = l->rows * BLOCK_NUMBERS;
  float **const vectors[] = {&l->right, &l->solution, &l->direction, &l->other};
  for (int n = 0; n < 4; n++)
    THRUM_TRY(thrum_reserve(vectors[n], count, sizeof(float), "the multigrid", error));
  return THRUM_OK;
}

static thrum_status make_level(Mat matrix, const double *scale, level *l, thrum_error *error) {
  PetscInt rows;
  PETSC_TRY(MatGetLocalSize(matrix, &rows, NULL));
  if (rows % 3 != 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "rows do not come in threes");
  l->rows = rows / 3;
  THRUM_TRY(thrum_reserve(&l->scale, rows, sizeof *l->scale, "the multigrid", error));
  if (scale != NULL)
    memcpy(l->scale, scale, sizeof *scale * (size_t)rows);
  else
    THRUM_TRY(block_rows_scale(matrix, l->scale, error));
  return make_vectors(l, error);
}

// ways between a level and the next coarser one: P scaled, and its transpose
static thrum_status make_ways(Mat interpolation, level *fine, level *coarse, thrum_error *error) {
  // in the scaled unknowns D^1/2 x, P becomes D_fine^1/2 P D_coarse^-1/2
  double *up = NULL;
  THRUM_TRY(thrum_reserve(&up, 3 * fine->rows, sizeof *up, "the multigrid", error));
  for (int64_t i = 0; i < 3 * fine->rows; i++)
    up[i] = fine->scale[i] > 0 ? 1 / fine->scale[i] : 0;

  Mat transposed = NULL;
  thrum_status status =
      block_rows_take(interpolation, up, coarse->scale, true, &fine->finer, error);
  PETSC_THEN(status, MatTranspose(interpolation, MAT_INITIAL_MATRIX, &transposed));
  THRUM_THEN(status, block_rows_take(transposed, coarse->scale, up, true, &fine->coarser, error));
  MatDestroy(&transposed);
  free(up);
  return status;
}

// the coarsest matrix, scaled, whole in every process
static thrum_status gather_coarsest(multigrid *m, Mat matrix, thrum_error *error) {
  const level *l = &m->level[m->levels - 1];
  PetscInt first, end;
  double *scale = m->gathered;
  PETSC_TRY(MatGetOwnershipRange(matrix, &first, &end));
  m->first = first;
  memcpy(scale + first, l->scale, sizeof *scale * (size_t)(end - first));
  MPI_Allreduce(MPI_IN_PLACE, scale, (int)m->whole, MPI_DOUBLE, MPI_SUM, m->comm);

  // own rows, then those of the others
  for (PetscInt i = first; i < end; i++) {
    PetscInt count;
    const PetscInt *column;
    const double *value;
    PETSC_TRY(MatGetRow(matrix, i, &count, &column, &value));
    for (PetscInt e = 0; e < count; e++)
      m->factor[i * m->whole + column[e]] = scale[i] * value[e] * scale[column[e]];
    PETSC_TRY(MatRestoreRow(matrix, i, &count, &column, &value));
    if (!(scale[i] > 0))
      m->factor[i * m->whole + i] = 1;
  }
  MPI_Allreduce(MPI_IN_PLACE, m->factor, (int)(m->whole * m->whole), MPI_DOUBLE, MPI_SUM, m->comm);
  return THRUM_OK;
}

static thrum_status make_coarsest(multigrid *m, Mat matrix, thrum_error *error) {
  PetscInt whole;
  PETSC_TRY(MatGetSize(matrix, &whole, NULL));
  if (whole > COARSEST_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "the coarsest grid has %d rows", (int)whole);
  m->whole = whole;
  THRUM_TRY(thrum_reserve(&m->factor, m->whole * m->whole, sizeof(double), "the multigrid", error));
  THRUM_TRY(thrum_reserve(&m->gathered, m->whole * BLOCK_COLUMNS, sizeof(double), "the multigrid",
                          error));
  THRUM_TRY(gather_coarsest(m, matrix, error));
  if (LAPACKE_dpotrf(LAPACK_ROW_MAJOR, 'L', (int)whole, m->factor, (int)whole) != 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "the coarsest matrix is not positive");
  return THRUM_OK;
}

// the largest eigenvalue by the power method, from as many starts as there are columns
static thrum_status find_most(const multigrid *m, level *l, thrum_error *error) {
  const int64_t count = l->rows * BLOCK_NUMBERS;
  uint64_t state = 0x9e3779b97f4a7c15u;
  for (int64_t i = 0; i < count; i++) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    l->direction[i] = (float)(state >> 40) / 16777216.0F - 0.5F;
  }

  // the growth of a column is never above the eigenvalue
  for (int step = 0; step < POWER_STEPS; step++) {
    double square[2][BLOCK_COLUMNS] = {{0}};
    THRUM_TRY(block_rows_product_single(&l->matrix, l->direction, l->other, error));
    for (int64_t i = 0; i < count; i++) {
      const double before = (double)l->direction[i], after = (double)l->other[i];
      square[0][i % BLOCK_COLUMNS] += before * before;
      square[1][i % BLOCK_COLUMNS] += after * after;
    }
    agree_on_sums(m->comm, square[0], 2 * BLOCK_COLUMNS);

    // the fastest column counts, and all go on with unit length
    l->most = 0;
    for (int c = 0; c < BLOCK_COLUMNS; c++)
      l->most = fmax(l->most, sqrt(square[1][c] / square[0][c]));
    for (int64_t i = 0; i < count; i++)
      l->direction[i] = l->other[i] / (float)sqrt(square[1][i % BLOCK_COLUMNS]);
  }
  l->most *= SAFETY;
  return THRUM_OK;
}

static thrum_status make_levels(multigrid *m, PC grids, const double *scale, thrum_error *error) {
  thrum_status status = THRUM_OK;
  const int last = m->levels - 1;
  for (int n = 0; n < m->levels && status >= 0; n++) {
    Mat matrix = matrix_of(grids, last - n, &status, error);
    THRUM_THEN(status, make_level(matrix, n == 0 ? scale : NULL, &m->level[n], error));

    // the coarsest has a factor, the others a smoother
    if (n == last)
      THRUM_THEN(status, make_coarsest(m, matrix, error));
    if (n < last)
      THRUM_THEN(status, block_rows_take(matrix, m->level[n].scale, m->level[n].scale, true,
                                         &m->level[n].matrix, error));
    if (n < last)
      THRUM_THEN(status, find_most(m, &m->level[n], error));
    if (n == 0)
      continue;

    // PETSc counts from the coarsest level, and has a way with the finer end of it
    Mat interpolation = NULL;
    PETSC_THEN(status, PCMGGetInterpolation(grids, last - n + 1, &interpolation));
    THRUM_THEN(status, make_ways(interpolation, &m->level[n - 1], &m->level[n], error));
  }
  return status;
}

thrum_status multigrid_create(PC grids, const double *scale, multigrid **made, thrum_error *error) {
  PetscInt levels;
  PETSC_TRY(PCMGGetLevels(grids, &levels));
  multigrid *m = calloc(1, sizeof *m);
  level *all = calloc((size_t)levels, sizeof *all);
  if (!m || !all) {
    free(m);
    free(all);
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the multigrid");
  }

  // all levels, or none
  m->level = all;
  m->levels = levels;
  thrum_status status = THRUM_OK;
  PETSC_THEN(status, PetscObjectGetComm((PetscObject)grids, &m->comm));
  THRUM_THEN(status, make_levels(m, grids, scale, error));
  if (status >= 0)
    *made = m;
  else
    multigrid_free(m);
  return status;
}

void multigrid_free(multigrid *m) {
  if (m == NULL)
    return;

  // levels that were not made are zero, and all of this takes NULL
  for (int n = 0; n < m->levels; n++) {
    level *l = &m->level[n];
    block_rows_free(&l->matrix);
    block_rows_free(&l->finer);
    block_rows_free(&l->coarser);
    free(l->scale);
    free(l->right);
    free(l->solution);
    free(l->direction);
    free(l->other);
  }
  free(m->level);
  free(m->factor);
  free(m->gathered);
  free(m);
}

/* --- a cycle ---------------------------------------------------------------------------------- */

// x = A^-1 b of the coarsest grid, which every process solves whole
static void solve_coarsest(multigrid *m) {
  level *l = &m->level[m->levels - 1];
  const int whole = (int)m->whole;
  double *own = m->gathered + m->first * BLOCK_COLUMNS;

  // the right-hand sides of all processes
  memset(m->gathered, 0, sizeof(double) * (size_t)(m->whole * BLOCK_COLUMNS));
  for (int64_t i = 0; i < l->rows * BLOCK_NUMBERS; i++)
    own[i] = (double)l->right[i];
  MPI_Allreduce(MPI_IN_PLACE, m->gathered, whole * BLOCK_COLUMNS, MPI_DOUBLE, MPI_SUM, m->comm);

  // forth and back
  cblas_dtrsm(CblasRowMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, whole,
              BLOCK_COLUMNS, 1, m->factor, whole, m->gathered, BLOCK_COLUMNS);
  cblas_dtrsm(CblasRowMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, whole, BLOCK_COLUMNS,
              1, m->factor, whole, m->gathered, BLOCK_COLUMNS);
  for (int64_t i = 0; i < l->rows * BLOCK_NUMBERS; i++)
    l->solution[i] = (float)own[i];
}

/* Chebyshev's recurrence for the interval of the smoother. */
typedef struct chebyshev {
  double centre, half;
} chebyshev;

static chebyshev chebyshev_of(const level *l) {
  const double least = SMOOTHED_SHARE * l->most;
  return (chebyshev){(l->most + least) / 2, (l->most - least) / 2};
}

// DEGREE - 1 directions after the first, which is there, as `r` and `x` follow
static thrum_status smooth_on(level *l, chebyshev c, thrum_error *error) {
  const double sigma = c.centre / c.half;
  double rho = 1 / sigma;
  for (int n = 1; n < DEGREE; n++) {
    const double next = 1 / (2 * sigma - rho);
    const block_step step = {
        (float)(next * rho), (float)(2 * next / c.half), l->direction, l->other, l->right,
        l->solution};
    THRUM_TRY(block_rows_step(&l->matrix, &step, error));
    float *turned = l->direction;
    l->direction = l->other;
    l->other = turned;
    rho = next;
  }
  return THRUM_OK;
}

// smooths from a start of zero, and finds the residual for the coarser grid
static thrum_status smooth_down(level *l, thrum_error *error) {
  const chebyshev c = chebyshev_of(l);
  const float first = (float)(1 / c.centre);
  for (int64_t i = 0; i < l->rows * BLOCK_NUMBERS; i++) {
    l->direction[i] = first * l->right[i];
    l->solution[i] = 0;
  }
  THRUM_TRY(smooth_on(l, c, error));
  const block_step step = {0, 0, l->direction, NULL, l->right, l->solution};
  return block_rows_step(&l->matrix, &step, error);
}

// smooths on from the correction of the coarser grid, which is in `direction`; the last residual is
// not needed
static thrum_status smooth_up(level *l, thrum_error *error) {
  const chebyshev c = chebyshev_of(l);
  const block_step step = {0, (float)(1 / c.centre), l->direction, l->other, l->right, l->solution};
  THRUM_TRY(block_rows_step(&l->matrix, &step, error));
  float *turned = l->direction;
  l->direction = l->other;
  l->other = turned;
  THRUM_TRY(smooth_on(l, c, error));
  for (int64_t i = 0; i < l->rows * BLOCK_NUMBERS; i++)
    l->solution[i] += l->direction[i];
  return THRUM_OK;
}

float *multigrid_right(multigrid *m) {
  return m->level[0].right;
}

thrum_status multigrid_cycle(multigrid *m, const float **solution, thrum_error *error) {
  const int last = m->levels - 1;

  // down to the coarsest grid, and up again
  for (int n = 0; n < last; n++) {
    THRUM_TRY(smooth_down(&m->level[n], error));
    THRUM_TRY(block_rows_product_single(&m->level[n].coarser, m->level[n].right,
                                        m->level[n + 1].right, error));
  }
  solve_coarsest(m);
  for (int n = last - 1; n >= 0; n--) {
    THRUM_TRY(block_rows_product_single(&m->level[n].finer, m->level[n + 1].solution,
                                        m->level[n].direction, error));
    THRUM_TRY(smooth_up(&m->level[n], error));
  }
  *solution = m->level[0].solution;
  return THRUM_OK;
}
