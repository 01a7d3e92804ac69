/* Products of a shared matrix with many columns, see block_rows.h. The sums of a block row stay in
 * registers while its blocks pass; 18 operations a block and column, for 40 or 76 bytes a block.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mpi/block_rows.h"

#include <math.h>
#include <petscsf.h>
#include <stdlib.h>
#include <string.h>

#include "mpi/petsc_status.h"
#include "platform/allocate.h"

thrum_status block_rows_scale(Mat matrix, double *scale, thrum_error *error) {
  Vec diagonal = NULL;
  const double *value = NULL;
  PetscInt rows = 0;
  thrum_status status = THRUM_OK;
  PETSC_THEN(status, MatGetLocalSize(matrix, &rows, NULL));
  PETSC_THEN(status, MatCreateVecs(matrix, NULL, &diagonal));
  PETSC_THEN(status, MatGetDiagonal(matrix, diagonal));
  PETSC_THEN(status, VecGetArrayRead(diagonal, &value));

  // rows of grids that have fewer unknowns than they should are empty
  for (PetscInt i = 0; i < rows && status >= 0; i++)
    scale[i] = value[i] > 0 ? 1 / sqrt(value[i]) : 0;
  PETSC_THEN(status, VecRestoreArrayRead(diagonal, &value));
  VecDestroy(&diagonal);
  return status;
}

/* --- taking a matrix -------------------------------------------------------------------------- */

/* PETSc's two parts of the rows of a process: of its own columns, and of those of others. */
typedef struct two_parts {
  Mat part[2];
  const PetscInt *begin[2], *column[2];
  const double *value[2];
  const PetscInt *ghost; /* number of each column of the second part in the whole matrix */
  PetscInt rows, columns, ghosts;
} two_parts;

static thrum_status open_part(two_parts *p, int which, thrum_error *error) {
  PetscInt rows;
  PetscBool done;
  if (p->part[which] == NULL)
    return THRUM_OK;
  PETSC_TRY(MatGetRowIJ(p->part[which], 0, PETSC_FALSE, PETSC_FALSE, &rows, &p->begin[which],
                        &p->column[which], &done));
  if (!done)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "PETSc gives no rows of its matrix");
  PETSC_TRY(MatSeqAIJGetArrayRead(p->part[which], &p->value[which]));
  return THRUM_OK;
}

static void close_part(two_parts *p, int which) {
  PetscInt rows;
  PetscBool done;
  if (p->value[which] != NULL)
    (void)MatSeqAIJRestoreArrayRead(p->part[which], &p->value[which]);
  if (p->begin[which] != NULL)
    (void)MatRestoreRowIJ(p->part[which], 0, PETSC_FALSE, PETSC_FALSE, &rows, &p->begin[which],
                          &p->column[which], &done);
}

static thrum_status open_matrix(Mat matrix, two_parts *p, thrum_error *error) {
  MPI_Comm comm;
  int processes;
  PETSC_TRY(PetscObjectGetComm((PetscObject)matrix, &comm));
  MPI_Comm_size(comm, &processes);
  PETSC_TRY(MatGetLocalSize(matrix, &p->rows, &p->columns));
  if (p->rows % 3 != 0 || p->columns % 3 != 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "rows do not come in threes");

  // one process has one part
  p->part[0] = matrix;
  if (processes > 1)
    PETSC_TRY(MatMPIAIJGetSeqAIJ(matrix, &p->part[0], &p->part[1], &p->ghost));
  if (processes > 1)
    PETSC_TRY(MatGetSize(p->part[1], NULL, &p->ghosts));
  THRUM_TRY(open_part(p, 0, error));
  return open_part(p, 1, error);
}

// columns of others in threes: the block of each, and the numbers of the blocks in the whole matrix
static int64_t find_ghosts(const two_parts *p, int32_t *block, PetscInt *whole) {
  int64_t count = 0;
  for (PetscInt j = 0; j < p->ghosts; j++) {
    if (count == 0 || whole[count - 1] != p->ghost[j] / 3)
      whole[count++] = p->ghost[j] / 3;
    block[j] = (int32_t)(count - 1);
  }
  return count;
}

// a way to bring the blocks of others
static thrum_status make_halo(Mat matrix, const PetscInt *whole, block_rows *m,
                              thrum_error *error) {
  MPI_Comm comm;
  PetscLayout layout = NULL;
  thrum_status status = THRUM_OK;
  PETSC_THEN(status, PetscObjectGetComm((PetscObject)matrix, &comm));
  PETSC_THEN(status,
             PetscLayoutCreateFromSizes(comm, (PetscInt)m->columns, PETSC_DETERMINE, 1, &layout));
  PETSC_THEN(status, PetscSFCreate(comm, &m->halo));
  PETSC_THEN(status, PetscSFSetGraphLayout(m->halo, layout, (PetscInt)m->ghosts, NULL,
                                           PETSC_COPY_VALUES, whole));
  PETSC_THEN(status, PetscSFSetUp(m->halo));
  PETSC_THEN(status, PetscLayoutDestroy(&layout));
  return status;
}

static thrum_status bring(const block_rows *m, const void *x, void *ghost, MPI_Datatype unit,
                          thrum_error *error) {
  if (m->halo == NULL)
    return THRUM_OK;
  PETSC_TRY(PetscSFBcastBegin(m->halo, unit, x, ghost, MPI_REPLACE));
  PETSC_TRY(PetscSFBcastEnd(m->halo, unit, x, ghost, MPI_REPLACE));
  return THRUM_OK;
}

// the block column of an entry
static int32_t block_of(const two_parts *p, const block_rows *m, const int32_t *ghost_block,
                        int which, PetscInt entry) {
  const PetscInt column = p->column[which][entry];
  return which == 0 ? (int32_t)(column / 3) : (int32_t)(m->columns + ghost_block[column]);
}

// counts the blocks of each block row, and writes their columns where there is room for them; last:
// -1 for each block column at first
static void find_blocks(const two_parts *p, block_rows *m, const int32_t *ghost_block,
                        int64_t *last) {
  int64_t count = 0;
  for (int64_t i = 0; i < m->rows; i++) {
    const int64_t first = count;

    // a block is new in its row where it was last met before the row began
    for (int which = 0; which < 2 && p->part[which] != NULL; which++)
      for (PetscInt e = p->begin[which][3 * i]; e < p->begin[which][3 * i + 3]; e++) {
        const int32_t block = block_of(p, m, ghost_block, which, e);
        if (last[block] >= first)
          continue;
        last[block] = count;
        if (m->column != NULL)
          m->column[count] = block;
        count++;
      }
    m->begin[i + 1] = count;
  }
}

// the values, scaled; place: room for where the blocks of a row stand
static void fill_blocks(const two_parts *p, block_rows *m, const int32_t *ghost_block,
                        const double *row_scale, const double *column_scale,
                        const double *ghost_scale, int64_t *place) {
  for (int64_t i = 0; i < m->rows; i++) {
    for (int64_t b = m->begin[i]; b < m->begin[i + 1]; b++)
      place[m->column[b]] = b;

    // entries of its three rows, of own columns and of those of others
    for (int which = 0; which < 2 && p->part[which] != NULL; which++)
      for (int a = 0; a < 3; a++)
        for (PetscInt e = p->begin[which][3 * i + a]; e < p->begin[which][3 * i + a + 1]; e++) {
          const PetscInt column = p->column[which][e];
          const int32_t block = block_of(p, m, ghost_block, which, e);
          const int axis = which == 0 ? (int)(column % 3) : (int)(p->ghost[column] % 3);
          const double other =
              which == 0 ? column_scale[column] : ghost_scale[3 * (block - m->columns) + axis];
          const double value = row_scale[3 * i + a] * p->value[which][e] * other;
          const int64_t at = 9 * place[block] + 3 * a + axis;
          if (m->single != NULL)
            m->single[at] = (float)value;
          else
            m->value[at] = value;
        }
  }
}

// room for the blocks, once they are counted
static thrum_status reserve_blocks(block_rows *m, bool single, thrum_error *error) {
  const int64_t blocks = m->begin[m->rows];
  const size_t size = single ? sizeof(float) : sizeof(double);
  THRUM_TRY(thrum_reserve(&m->column, blocks, sizeof *m->column, "the solver", error));
  THRUM_TRY(thrum_reserve(&m->ghost, m->ghosts * BLOCK_NUMBERS, size, "the solver", error));
  return single ? thrum_reserve(&m->single, 9 * blocks, size, "the solver", error)
                : thrum_reserve(&m->value, 9 * blocks, size, "the solver", error);
}

static thrum_status take_parts(Mat matrix, const two_parts *p, const double *row_scale,
                               const double *column_scale, bool single, block_rows *m,
                               thrum_error *error) {
  thrum_scope memory = thrum_scope_begin("the solver", error);
  int32_t *block = thrum_scope_allocate(&memory, p->ghosts, sizeof *block);
  PetscInt *whole = thrum_scope_allocate(&memory, p->ghosts, sizeof *whole);
  thrum_status status = memory.status;
  m->rows = p->rows / 3;
  m->columns = p->columns / 3;
  m->ghosts = status >= 0 ? find_ghosts(p, block, whole) : 0;
  if (status >= 0 && p->part[1] != NULL)
    status = make_halo(matrix, whole, m, error);

  // the scale of the columns of others
  double *ghost_scale = thrum_scope_allocate(&memory, 3 * m->ghosts, sizeof *ghost_scale);
  int64_t *last = thrum_scope_allocate(&memory, m->columns + m->ghosts, sizeof *last);
  THRUM_THEN(status, memory.status);
  THRUM_THEN(status, thrum_reserve(&m->begin, m->rows + 1, sizeof *m->begin, "the solver", error));
  MPI_Datatype three;
  MPI_Type_contiguous(3, MPI_DOUBLE, &three);
  MPI_Type_commit(&three);
  THRUM_THEN(status, bring(m, column_scale, ghost_scale, three, error));
  MPI_Type_free(&three);

  // blocks are counted, then found again where they stand
  for (int pass = 0; pass < 2 && status >= 0; pass++) {
    memset(last, 0xff, sizeof *last * (size_t)(m->columns + m->ghosts));
    m->begin[0] = 0;
    find_blocks(p, m, block, last);
    if (pass == 0)
      status = reserve_blocks(m, single, error);
  }
  if (status >= 0)
    fill_blocks(p, m, block, row_scale, column_scale, ghost_scale, last);
  thrum_scope_free(&memory);
  return status;
}

thrum_status block_rows_take(Mat matrix, const double *row_scale, const double *column_scale,
                             bool single, block_rows *made, thrum_error *error) {
  two_parts p = {0};
  *made = (block_rows){.unit = MPI_DATATYPE_NULL};
  thrum_status status = open_matrix(matrix, &p, error);
  THRUM_THEN(status, take_parts(matrix, &p, row_scale, column_scale, single, made, error));
  close_part(&p, 0);
  close_part(&p, 1);
  MPI_Type_contiguous(BLOCK_NUMBERS, single ? MPI_FLOAT : MPI_DOUBLE, &made->unit);
  MPI_Type_commit(&made->unit);
  if (status < 0)
    block_rows_free(made);
  return status;
}

void block_rows_free(block_rows *m) {
  if (m->unit != 0 && m->unit != MPI_DATATYPE_NULL)
    MPI_Type_free(&m->unit);
  (void)PetscSFDestroy(&m->halo);
  free(m->begin);
  free(m->column);
  free(m->single);
  free(m->value);
  free(m->ghost);
  *m = (block_rows){.unit = MPI_DATATYPE_NULL};
}

/* --- products --------------------------------------------------------------------------------- */

/* The loops are compiled for the instructions of several processors, and the best are taken. */
#if (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__)
#define HAS_X86 1
#define INLINE static inline __attribute__((always_inline))
#else
#define HAS_X86 0
#define INLINE static inline
#endif

#define REAL float
#define NAME(name) name##_single
#include "mpi/block_kernel.inl"
#undef REAL
#undef NAME

#define REAL double
#define NAME(name) name##_double
#include "mpi/block_kernel.inl"
#undef REAL
#undef NAME

static void product_double_plain(const block_rows *m, const double *x, double *y) {
  product_double(m, m->value, x, y);
}

static void product_single_plain(const block_rows *m, const float *x, float *y) {
  product_single(m, m->single, x, y);
}

static void step_plain(const block_rows *m, const block_step *s) {
  step_single(m, m->single, s->d, s->along, s->across, s->x, s->r, s->next);
}

#if HAS_X86
#define FOR_PROCESSOR(suffix, words)                                                               \
  __attribute__((target(words))) static void product_double##suffix(const block_rows *m,           \
                                                                    const double *x, double *y) {  \
    product_double(m, m->value, x, y);                                                             \
  }                                                                                                \
  __attribute__((target(words))) static void product_single##suffix(const block_rows *m,           \
                                                                    const float *x, float *y) {    \
    product_single(m, m->single, x, y);                                                            \
  }                                                                                                \
  __attribute__((target(words))) static void step##suffix(const block_rows *m,                     \
                                                          const block_step *s) {                   \
    step_single(m, m->single, s->d, s->along, s->across, s->x, s->r, s->next);                     \
  }
FOR_PROCESSOR(_avx2, "avx2")
FOR_PROCESSOR(_avx512, "avx512f")
#endif

typedef struct kernels {
  void (*product_double)(const block_rows *, const double *, double *);
  void (*product_single)(const block_rows *, const float *, float *);
  void (*step)(const block_rows *, const block_step *);
} kernels;

static kernels kernels_of_processor(void) {
#if HAS_X86
  if (__builtin_cpu_supports("avx512f"))
    return (kernels){product_double_avx512, product_single_avx512, step_avx512};
  if (__builtin_cpu_supports("avx2"))
    return (kernels){product_double_avx2, product_single_avx2, step_avx2};
#endif
  return (kernels){product_double_plain, product_single_plain, step_plain};
}

thrum_status block_rows_product(const block_rows *m, const double *x, double *y,
                                thrum_error *error) {
  THRUM_TRY(bring(m, x, m->ghost, m->unit, error));
  kernels_of_processor().product_double(m, x, y);
  return THRUM_OK;
}

thrum_status block_rows_product_single(const block_rows *m, const float *x, float *y,
                                       thrum_error *error) {
  THRUM_TRY(bring(m, x, m->ghost, m->unit, error));
  kernels_of_processor().product_single(m, x, y);
  return THRUM_OK;
}

thrum_status block_rows_step(const block_rows *m, const block_step *step, thrum_error *error) {
  THRUM_TRY(bring(m, step->d, m->ghost, m->unit, error));
  kernels_of_processor().step(m, step);
  return THRUM_OK;
}
