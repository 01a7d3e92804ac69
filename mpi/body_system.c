/* The equations of a whole body, see body_system.h. The factor is MUMPS's (Amestoy et al. 2001,
 * doi:10.1137/S0895479899358194); conjugate gradients take PETSc's smoothed aggregation (Vanek,
 * Mandel, Brezina 1996, doi:10.1007/BF02238511) with the six rigid modes as near null space.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mpi/body_system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mpi/agreement.h"
#include "mpi/petsc_status.h"
#include "mpi/solver_choice.h"
#include "platform/allocate.h"
#include "platform/memory_return.h"
#include "precompute/options_check.h"

#define CG_TOLERANCE 1e-12     /* of a residual; models then agree with those of a factor to 1e-8 */
#define ENERGY_TOLERANCE 1e-11 /* of the error in the norm of K */
#define ROUGH_TOLERANCE 1e-3   /* the same, where a method makes up for it */
#define CG_STEPS_MAX 250 /* sound meshes take 30 to 75; without the multigrid they take more */

// row of a component of the part
static PetscInt row_of(const body_part *part, int64_t component) {
  return (PetscInt)(3 * (int64_t)part->place[component / 3] + component % 3);
}

/* --- matrices --------------------------------------------------------------------------------- */

// an empty matrix with room for blocks of 3 x 3 (stiffness) or of a diagonal (mass)
static thrum_status make_matrix(const body_system *s, bool blocks, Mat *matrix,
                                thrum_error *error) {
  const int64_t own = s->part->facts.own;
  const PetscInt rows = (PetscInt)(3 * own);
  int32_t *inner = NULL;
  THRUM_TRY(thrum_reserve(&inner, 6 * own, sizeof *inner, "the equations", error));
  for (int64_t r = 0; r < 3 * own; r++) {
    inner[r] = (blocks ? 3 : 1) * s->part->inner[r / 3];
    inner[3 * own + r] = (blocks ? 3 : 1) * s->part->outer[r / 3];
  }

  // compressed rows, as both the factor and the multigrid take them
  int code = MatCreateAIJ(s->comm, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, 0, inner, 0,
                          inner + 3 * own, matrix);
  if (code == 0)
    code = MatSetBlockSize(*matrix, 3);
  if (code == 0)
    code = MatSetOption(*matrix, MAT_SYMMETRIC, PETSC_TRUE);
  free(inner);
  PETSC_TRY(code);
  return THRUM_OK;
}

// adds the terms of a part, both triangles
static thrum_status add_matrix(const body_system *s, const thrum_sparse *terms, Mat matrix,
                               thrum_error *error) {
  int64_t longest = 1;
  for (int64_t j = 0; j < terms->size; j++)
    longest = terms->begin[j + 1] - terms->begin[j] > longest
                  ? terms->begin[j + 1] - terms->begin[j]
                  : longest;
  PetscInt *rows = NULL;
  THRUM_TRY(thrum_reserve(&rows, longest, sizeof *rows, "the equations", error));

  // a column below and with the diagonal, then the row beside it
  int code = 0;
  for (int64_t j = 0; j < terms->size && code == 0; j++) {
    const int64_t first = terms->begin[j], count = terms->begin[j + 1] - first;
    for (int64_t e = 0; e < count; e++)
      rows[e] = row_of(s->part, s->component[terms->row[first + e]]);
    const double *value = terms->value + first;
    code = MatSetValues(matrix, (PetscInt)count, rows, 1, rows, value, ADD_VALUES);
    if (code == 0 && count > 1)
      code = MatSetValues(matrix, 1, rows, (PetscInt)count - 1, rows + 1, value + 1, ADD_VALUES);
  }
  free(rows);
  PETSC_TRY(code);
  return THRUM_OK;
}

static thrum_status close_matrix(Mat matrix, thrum_error *error) {
  PETSC_TRY(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  PETSC_TRY(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  return THRUM_OK;
}

// mean of the diagonals of the terms: of the size of the stiffness
static double typical_stiffness(const body_system *s, const thrum_sparse *terms) {
  double sum = 0;
  for (int64_t j = 0; j < terms->size; j++)
    sum += terms->value[terms->begin[j]];
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, s->comm);
  return sum / (double)s->size;
}

// held components of the vertices that the part owns keep a stiffness of their own
static thrum_status add_held(const body_system *s, Mat matrix, thrum_error *error) {
  const body_part *part = s->part;
  for (int64_t c = 0; c < 3 * part->facts.vertices; c++)
    if (part->own[c / 3] && part->fixed[c / 3] >> (c % 3) & 1)
      PETSC_TRY(MatSetValue(matrix, row_of(part, c), row_of(part, c), s->typical, ADD_VALUES));
  return THRUM_OK;
}

thrum_status body_system_add_springs(const body_system *s, double times, Mat matrix,
                                     thrum_error *error) {
  PetscInt first, end;
  PETSC_TRY(MatGetOwnershipRange(matrix, &first, &end));
  const thrum_support *support = &s->part->facts.support;
  for (int n = 0; n < THRUM_SUPPORTS; n++) {
    const PetscInt row = (PetscInt)(3 * support->vertex[n]);
    for (int c = 0; c < 9 && row >= first && row < end; c++)
      PETSC_TRY(MatSetValue(matrix, row + c / 3, row + c % 3,
                            times * s->typical * support->direction[n][c / 3][c % 3], ADD_VALUES));
  }
  return THRUM_OK;
}

static thrum_status make_matrices(body_system *s, const thrum_sparse *stiffness,
                                  const thrum_sparse *mass, thrum_error *error) {
  s->typical = typical_stiffness(s, stiffness);
  THRUM_TRY(make_matrix(s, true, &s->stiffness, error));
  THRUM_TRY(add_matrix(s, stiffness, s->stiffness, error));
  THRUM_TRY(add_held(s, s->stiffness, error));
  if (s->part->facts.free_body)
    THRUM_TRY(body_system_add_springs(s, 1, s->stiffness, error));
  THRUM_TRY(close_matrix(s->stiffness, error));
  PETSC_TRY(MatSetOption(s->stiffness, MAT_SPD, PETSC_TRUE));

  THRUM_TRY(make_matrix(s, false, &s->mass, error));
  THRUM_TRY(add_matrix(s, mass, s->mass, error));
  return close_matrix(s->mass, error);
}

/* --- between parts and rows ------------------------------------------------------------------- */

static thrum_status take(void *context, const thrum_fem *fem, thrum_error *error) {
  body_system *s = context;
  s->free_count = fem->free_count;
  s->component = fem->component;
  PetscInt *rows = NULL;
  THRUM_TRY(thrum_reserve(&rows, s->free_count, sizeof *rows, "the equations", error));
  for (int64_t f = 0; f < s->free_count; f++)
    rows[f] = row_of(s->part, s->component[f]);

  // a list of rows for the free components, in their order
  IS list = NULL;
  const PetscInt count = (PetscInt)s->free_count, own = (PetscInt)(3 * s->part->facts.own);
  thrum_status status = THRUM_OK;
  PETSC_THEN(status, ISCreateGeneral(PETSC_COMM_SELF, count, rows, PETSC_COPY_VALUES, &list));
  free(rows);

  // the rows of this process, the components of its part, and the way between them
  PETSC_THEN(status, VecCreateMPI(s->comm, own, PETSC_DETERMINE, &s->all));
  PETSC_THEN(status, VecSetBlockSize(s->all, 3));
  PETSC_THEN(status, VecCreateSeqWithArray(PETSC_COMM_SELF, 1, count, NULL, &s->local));
  PETSC_THEN(status, VecScatterCreate(s->local, NULL, s->all, list, &s->spread));
  ISDestroy(&list);
  return status;
}

// PETSc's vectors over memory of ours, which an addition only reads
static double *lend(const double *array) {
  union {
    const double *read;
    double *write;
  } pointer = {.read = array};
  return pointer.write;
}

thrum_status body_system_add(body_system *s, const double *terms, Vec rows, thrum_error *error) {
  PETSC_TRY(VecSet(rows, 0));
  PETSC_TRY(VecPlaceArray(s->local, lend(terms)));
  PETSC_TRY(VecScatterBegin(s->spread, s->local, rows, ADD_VALUES, SCATTER_FORWARD));
  PETSC_TRY(VecScatterEnd(s->spread, s->local, rows, ADD_VALUES, SCATTER_FORWARD));
  PETSC_TRY(VecResetArray(s->local));
  return THRUM_OK;
}

thrum_status body_system_hand_out(body_system *s, Vec rows, double *values, thrum_error *error) {
  PETSC_TRY(VecPlaceArray(s->local, values));
  PETSC_TRY(VecScatterBegin(s->spread, rows, s->local, INSERT_VALUES, SCATTER_REVERSE));
  PETSC_TRY(VecScatterEnd(s->spread, rows, s->local, INSERT_VALUES, SCATTER_REVERSE));
  PETSC_TRY(VecResetArray(s->local));
  return THRUM_OK;
}

/* --- the solver ------------------------------------------------------------------------------- */

static thrum_status set_mumps(body_system *s, Mat *factor, thrum_error *error) {
  PC pc;
  PETSC_TRY(KSPSetType(s->ksp, KSPPREONLY));
  PETSC_TRY(KSPGetPC(s->ksp, &pc));
  PETSC_TRY(PCSetType(pc, PCCHOLESKY));
  PETSC_TRY(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  PETSC_TRY(PCFactorSetUpMatSolverType(pc));
  PETSC_TRY(PCFactorGetMatrix(pc, factor));

  // room for delayed pivots, in percent
  PETSC_TRY(MatMumpsSetIcntl(*factor, 14, 50));
  return THRUM_OK;
}

// the six rigid motions at the vertices that the part owns
static thrum_status set_near_null_space(body_system *s, thrum_error *error) {
  const body_part *part = s->part;
  Vec places = NULL;
  MatNullSpace space = NULL;
  double *values = NULL;

  // the places of these vertices, by rows
  thrum_status status = THRUM_OK;
  PETSC_THEN(status, VecDuplicate(s->all, &places));
  PETSC_THEN(status, VecGetArray(places, &values));
  for (int64_t n = 0, next = 0; n < part->facts.vertices && status >= 0; n++)
    if (part->own[n])
      memcpy(values + 3 * next++, part->mesh.vertices + 3 * n, 3 * sizeof *values);
  PETSC_THEN(status, VecRestoreArray(places, &values));

  // PETSc makes the rigid motions from the places
  PETSC_THEN(status, MatNullSpaceCreateRigidBody(places, &space));
  PETSC_THEN(status, MatSetNearNullSpace(s->stiffness, space));
  MatNullSpaceDestroy(&space);
  VecDestroy(&places);
  return status;
}

static thrum_status set_gradients(body_system *s, thrum_error *error) {
  PC pc;
  PETSC_TRY(KSPSetType(s->ksp, KSPCG));
  PETSC_TRY(KSPSetTolerances(s->ksp, CG_TOLERANCE, 0, PETSC_DEFAULT, CG_STEPS_MAX));
  PETSC_TRY(KSPGetPC(s->ksp, &pc));
  THRUM_TRY(set_near_null_space(s, error));
  PETSC_TRY(PCSetType(pc, PCGAMG));
  return THRUM_OK;
}

// a factor is planned, unless conjugate gradients were asked for, and may prove too large
static thrum_status set_solver(body_system *s, thrum_error *error) {
  solver_choice choice = {s->comm, s->options, s->free_count, s->stiffness, NULL};
  if (s->options->solver != THRUM_SOLVER_CG)
    THRUM_TRY(set_mumps(s, &choice.factor, error));
  THRUM_TRY(solver_choose(&choice, &s->use, error));
  return s->use.solver == THRUM_SOLVER_CG ? set_gradients(s, error) : THRUM_OK;
}

// what the factor holds, once it is there
static thrum_status count_nonzeros(body_system *s, thrum_error *error) {
  PC pc;
  Mat factor;
  PetscInt millions;
  if (s->use.solver == THRUM_SOLVER_CG)
    return THRUM_OK;
  PETSC_TRY(KSPGetPC(s->ksp, &pc));
  PETSC_TRY(PCFactorGetMatrix(pc, &factor));

  // MUMPS gives millions as a negative number where an int would not hold the count
  PETSC_TRY(MatMumpsGetInfog(factor, 29, &millions));
  s->use.nonzeros = millions < 0 ? -1e6 * millions : millions;
  return THRUM_OK;
}

// why a set-up failed: a pivot that is not positive is the matrix's fault, not the solver's
static thrum_status check_setup(const body_system *s, thrum_error *error) {
  PC pc;
  PCFailedReason reason;
  PETSC_TRY(KSPGetPC(s->ksp, &pc));
  PETSC_TRY(PCGetFailedReason(pc, &reason));
  if (reason == PC_NOERROR)
    return THRUM_OK;
  if (reason == PC_FACTOR_OUTMEMORY)
    return petsc_status(PETSC_ERR_MEM, error);
  return thrum_error_set(error, THRUM_SINGULAR, "the matrix is not positive definite");
}

// conjugate gradients for blocks take over what PETSc has set up, which then goes; what they do not
// know, such as another preconditioner by an option of PETSc, PETSc itself solves with
static thrum_status take_gradients(body_system *s, thrum_error *error) {
  PC pc;
  PetscBool usual, known;
  PETSC_TRY(KSPGetPC(s->ksp, &pc));
  PETSC_TRY(PetscObjectTypeCompare((PetscObject)s->ksp, KSPCG, &usual));
  PETSC_TRY(PetscObjectTypeCompare((PetscObject)pc, PCGAMG, &known));
  if (!usual || !known)
    return THRUM_OK;
  const thrum_status status = block_gradients_create(s->stiffness, pc, &s->gradients, error);
  if (status == THRUM_UNSUPPORTED)
    return THRUM_OK;
  THRUM_TRY(status);

  // the matrices stay where modes are counted
  PETSC_TRY(KSPDestroy(&s->ksp));
  PETSC_TRY(MatSetNearNullSpace(s->stiffness, NULL));
  if (!thrum_options_count_wanted(s->options->check, s->size)) {
    PETSC_TRY(MatDestroy(&s->stiffness));
    PETSC_TRY(MatDestroy(&s->mass));
  }
  memory_return();
  return THRUM_OK;
}

static thrum_status prepare(void *context, const thrum_sparse *stiffness, const thrum_sparse *mass,
                            thrum_error *error) {
  body_system *s = context;
  THRUM_TRY(make_matrices(s, stiffness, mass, error));
  PETSC_TRY(KSPCreate(s->comm, &s->ksp));
  PETSC_TRY(KSPSetOperators(s->ksp, s->stiffness, s->stiffness));
  THRUM_TRY(set_solver(s, error));

  // users who know PETSc may change these settings by -thrum_ksp_... in PETSC_OPTIONS
  PETSC_TRY(KSPSetOptionsPrefix(s->ksp, "thrum_"));
  PETSC_TRY(KSPSetFromOptions(s->ksp));
  PETSC_TRY(KSPSetUp(s->ksp));
  THRUM_TRY(check_setup(s, error));
  return s->use.solver == THRUM_SOLVER_CG ? take_gradients(s, error) : count_nonzeros(s, error);
}

thrum_status body_system_estimate(body_system *s, const thrum_fem *fem,
                                  const thrum_sparse *stiffness, const thrum_sparse *mass,
                                  thrum_shared_estimate *estimate, thrum_error *error) {
  THRUM_TRY(take(s, fem, error));
  THRUM_TRY(make_matrices(s, stiffness, mass, error));
  PETSC_TRY(KSPCreate(s->comm, &s->ksp));
  PETSC_TRY(KSPSetOperators(s->ksp, s->stiffness, s->stiffness));
  solver_choice choice = {s->comm, s->options, s->free_count, s->stiffness, NULL};
  THRUM_TRY(set_mumps(s, &choice.factor, error));
  estimate->free_dofs = s->size;
  return solver_estimate(&choice, estimate, error);
}

// whether the last solve came to its end
static thrum_status check_solved(const body_system *s, thrum_error *error) {
  KSPConvergedReason reason;
  PetscInt steps;
  PETSC_TRY(KSPGetConvergedReason(s->ksp, &reason));
  PETSC_TRY(KSPGetIterationNumber(s->ksp, &steps));
  if (reason > 0)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_NOT_CONVERGED,
                         "conjugate gradients did not converge in %d steps (PETSc reason %d): "
                         "check the mesh (see thrum check), or take --solver factor",
                         (int)steps, (int)reason);
}

thrum_status body_system_solve_rows(body_system *s, Vec right, Vec solution, thrum_error *error) {
  PETSC_TRY(KSPSolve(s->ksp, right, solution));
  return check_solved(s, error);
}

// one column of a block, which conjugate gradients take one by one
static thrum_status solve_column(body_system *s, const double *right, double *solution,
                                 thrum_error *error) {
  Vec answer;
  PETSC_TRY(VecDuplicate(s->all, &answer));
  thrum_status status = body_system_add(s, right, s->all, error);
  THRUM_THEN(status, body_system_solve_rows(s, s->all, answer, error));
  THRUM_THEN(status, body_system_hand_out(s, answer, solution, error));
  VecDestroy(&answer);
  return status;
}

// the columns of a block, their solution by the factor, and back
static thrum_status solve_columns(body_system *s, const double *right, PetscInt columns, Mat rights,
                                  Mat answers, double *solution, thrum_error *error) {
  Vec column;
  for (PetscInt c = 0; c < columns; c++) {
    PETSC_TRY(MatDenseGetColumnVecWrite(rights, c, &column));
    THRUM_TRY(body_system_add(s, right + c * s->free_count, column, error));
    PETSC_TRY(MatDenseRestoreColumnVecWrite(rights, c, &column));
  }
  THRUM_TRY(close_matrix(rights, error));

  PETSC_TRY(KSPMatSolve(s->ksp, rights, answers));
  for (PetscInt c = 0; c < columns; c++) {
    PETSC_TRY(MatDenseGetColumnVecRead(answers, c, &column));
    THRUM_TRY(body_system_hand_out(s, column, solution + c * s->free_count, error));
    PETSC_TRY(MatDenseRestoreColumnVecRead(answers, c, &column));
  }
  return THRUM_OK;
}

// a block of columns, which a factor takes together
static thrum_status solve_block(body_system *s, const double *right, PetscInt columns,
                                double *solution, thrum_error *error) {
  Mat rights = NULL, answers = NULL;
  PetscInt rows;
  thrum_status status = THRUM_OK;
  PETSC_THEN(status, VecGetLocalSize(s->all, &rows));
  PETSC_THEN(status,
             MatCreateDense(s->comm, rows, PETSC_DECIDE, PETSC_DETERMINE, columns, NULL, &rights));
  PETSC_THEN(status, MatDuplicate(rights, MAT_DO_NOT_COPY_VALUES, &answers));
  THRUM_THEN(status, solve_columns(s, right, columns, rights, answers, solution, error));
  MatDestroy(&rights);
  MatDestroy(&answers);
  return status;
}

// a few columns by conjugate gradients: rows of this process, where columns stand side by side
static thrum_status solve_group(body_system *s, bool exact, const double *right, int columns,
                                double *solution, thrum_error *error) {
  double *rows;
  const int64_t count = 3 * s->part->facts.own;
  memset(s->block, 0, sizeof *s->block * (size_t)(count * BLOCK_COLUMNS));
  for (int c = 0; c < columns; c++) {
    THRUM_TRY(body_system_add(s, right + c * s->free_count, s->all, error));
    PETSC_TRY(VecGetArray(s->all, &rows));
    for (int64_t i = 0; i < count; i++)
      s->block[i * BLOCK_COLUMNS + c] = rows[i];
    PETSC_TRY(VecRestoreArray(s->all, &rows));
  }

  THRUM_TRY(block_gradients_solve(s->gradients, s->block,
                                  exact ? ENERGY_TOLERANCE : ROUGH_TOLERANCE, error));
  for (int c = 0; c < columns; c++) {
    PETSC_TRY(VecGetArray(s->all, &rows));
    for (int64_t i = 0; i < count; i++)
      rows[i] = s->block[i * BLOCK_COLUMNS + c];
    PETSC_TRY(VecRestoreArray(s->all, &rows));
    THRUM_TRY(body_system_hand_out(s, s->all, solution + c * s->free_count, error));
  }
  return THRUM_OK;
}

static thrum_status solve_groups(body_system *s, bool exact, const double *right, int64_t columns,
                                 double *solution, thrum_error *error) {
  if (s->block == NULL)
    THRUM_TRY(thrum_reserve(&s->block, 3 * s->part->facts.own * BLOCK_COLUMNS, sizeof *s->block,
                            "the solution", error));
  for (int64_t first = 0; first < columns; first += BLOCK_COLUMNS) {
    const int64_t left = columns - first;
    THRUM_TRY(solve_group(s, exact, right + first * s->free_count,
                          (int)(left < BLOCK_COLUMNS ? left : BLOCK_COLUMNS),
                          solution + first * s->free_count, error));
  }
  return THRUM_OK;
}

static thrum_status solve(void *context, bool exact, const double *right, int64_t columns,
                          double *solution, thrum_error *error) {
  body_system *s = context;
  if (s->gradients != NULL)
    return solve_groups(s, exact, right, columns, solution, error);
  if (s->use.solver != THRUM_SOLVER_CG && columns > 1)
    return solve_block(s, right, (PetscInt)columns, solution, error);
  for (int64_t c = 0; c < columns; c++)
    THRUM_TRY(solve_column(s, right + c * s->free_count, solution + c * s->free_count, error));
  return THRUM_OK;
}

/* --- sums ------------------------------------------------------------------------------------- */

static void sum(void *context, double *numbers, int64_t count) {
  const body_system *s = context;
  agree_on_sums(s->comm, numbers, count);
}

static void largest(void *context, double *numbers, int64_t count) {
  const body_system *s = context;
  MPI_Allreduce(MPI_IN_PLACE, numbers, (int)count, MPI_DOUBLE, MPI_MAX, s->comm);
}

static thrum_status add_terms(void *context, double *force, thrum_error *error) {
  body_system *s = context;
  THRUM_TRY(body_system_add(s, force, s->all, error));
  return body_system_hand_out(s, s->all, force, error);
}

static double norm(void *context, const double *x) {
  const body_system *s = context;
  double square = 0;
  for (int64_t f = 0; f < s->free_count; f++)
    if (s->part->own[s->component[f] / 3])
      square += x[f] * x[f];
  sum(context, &square, 1);
  return sqrt(square);
}

// block methods are for solves that are rough, and cheaper together
static bool rough(const void *context) {
  return ((const body_system *)context)->gradients != NULL;
}

static thrum_solver_use solver_use(const void *context) {
  const body_system *s = context;
  thrum_solver_use use = s->use;
  if (s->gradients != NULL) {
    const block_gradients_counts counts = block_gradients_counted(s->gradients);
    use.solves = counts.columns;
    use.steps = counts.steps;
  }
  return use;
}

body_system body_system_begin(MPI_Comm comm, const body_part *part,
                              const thrum_precompute_options *options) {
  return (body_system){
      .comm = comm, .part = part, .options = options, .size = part->facts.free_count};
}

static void release(void *context) {
  body_system *s = context;
  KSPDestroy(&s->ksp);
  block_gradients_free(s->gradients);
  free(s->block);
  MatDestroy(&s->mass);
  MatDestroy(&s->stiffness);
  s->gradients = NULL;
  s->block = NULL;
  memory_return();
}

void body_system_free(body_system *s) {
  release(s);
  VecScatterDestroy(&s->spread);
  VecDestroy(&s->local);
  VecDestroy(&s->all);
  *s = (body_system){0};
}

thrum_ranks body_system_ranks(body_system *s) {
  return (thrum_ranks){.size = s->size,
                       .vertex = s->part->vertex,
                       .own = s->part->own,
                       .free_body = s->part->facts.free_body,

                       // functions of this file, which get the system as their context
                       .context = s,
                       .take = take,
                       .sum = sum,
                       .largest = largest,
                       .add_terms = add_terms,
                       .norm = norm,
                       .prepare = prepare,
                       .solve = solve,
                       .rough = rough,
                       .release = release,
                       .solver_use = solver_use};
}
