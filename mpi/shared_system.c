/* Systems of equations with shared factors, see shared_system.h. A process has an even share of
 * the rows, the upper triangle of each: those are the columns of the lower triangle that rank 0
 * has, so that slices of its arrays are all that is sent. The factor is MUMPS's L D L^T (Amestoy et
 * al. 2001, doi:10.1137/S0895479899358194), whose negative pivots tell a matrix that is not
 * positive definite.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mpi/shared_system.h"

#include <petscksp.h>
#include <stdlib.h>
#include <string.h>

#include "mpi/agreement.h"
#include "mpi/inertia_factor.h"
#include "mpi/petsc_status.h"
#include "platform/allocate.h"
#include "precompute/fem/sparse_matrix.h"

enum { TAG = 1 };
typedef enum action { ACTION_END, ACTION_PLAN, ACTION_COMPUTE, ACTION_SOLVE } action;

typedef struct order {
  action action;
  int number;   /* of the system */
  int64_t size; /* of the plan */
} order;

/* The system as one process has it. */
typedef struct shared_system {
  MPI_Comm comm;
  shared_systems *systems; /* of rank 0, */
  int number;              /* and its place among them */
  int processes, rank;
  PetscInt own;        /* rows of this process, */
  int *counts, *first; /* of each, and where they begin */
  int64_t *begin;      /* own + 1: where each row starts, from 0 */
  PetscInt *column;    /* begin[own] */
  double *value;
  Mat matrix;
  KSP ksp;
  Vec right, solution;
} shared_system;

static void system_free(shared_system *s) {
  KSPDestroy(&s->ksp);
  MatDestroy(&s->matrix);
  VecDestroy(&s->right);
  VecDestroy(&s->solution);
  free(s->counts);
  free(s->begin);
  free(s->column);
  free(s->value);
  *s = (shared_system){0};
}

/* --- rows on their way from rank 0 ------------------------------------------------------------ */

// sends every process its slice of an array by columns; `from` NULL: this is one of them
static void share_slices(const shared_system *s, const thrum_sparse *matrix, const void *from,
                         size_t size, MPI_Datatype type, int64_t count, void *to) {
  for (int r = 1; matrix != NULL && r < s->processes; r++) {
    const int64_t *begin = matrix->begin + s->first[r];
    MPI_Send((const char *)from + size * (size_t)begin[0], (int)(begin[s->counts[r]] - begin[0]),
             type, r, TAG, s->comm);
  }
  if (matrix == NULL)
    MPI_Recv(to, (int)count, type, 0, TAG, s->comm, MPI_STATUS_IGNORE);
}

// where the rows of each process begin, and those of this one
static thrum_status share_begins(shared_system *s, const thrum_sparse *matrix, thrum_error *error) {
  THRUM_TRY(thrum_reserve(&s->begin, s->own + 1, sizeof *s->begin, "the equations", error));
  for (int r = 1; matrix != NULL && r < s->processes; r++)
    MPI_Send(matrix->begin + s->first[r], s->counts[r] + 1, MPI_INT64_T, r, TAG, s->comm);
  if (matrix != NULL)
    memcpy(s->begin, matrix->begin, (size_t)(s->own + 1) * sizeof *s->begin);
  else
    MPI_Recv(s->begin, (int)s->own + 1, MPI_INT64_T, 0, TAG, s->comm, MPI_STATUS_IGNORE);

  // the rows of this part are counted from 0 on
  const int64_t offset = s->begin[0];
  for (PetscInt row = 0; row <= s->own; row++)
    s->begin[row] -= offset;
  return THRUM_OK;
}

static thrum_status share_pattern(shared_system *s, const thrum_sparse *matrix,
                                  thrum_error *error) {
  int64_t *rows = NULL;
  THRUM_TRY(share_begins(s, matrix, error));
  const int64_t entries = s->begin[s->own];
  THRUM_TRY(thrum_reserve(&s->column, entries + 1, sizeof *s->column, "the equations", error));
  THRUM_TRY(thrum_reserve(&s->value, entries + 1, sizeof *s->value, "the equations", error));
  THRUM_TRY(thrum_reserve(&rows, entries + 1, sizeof *rows, "the equations", error));

  // the rows of a column of the lower triangle are the columns of a row of the upper one
  share_slices(s, matrix, matrix ? matrix->row : NULL, sizeof *rows, MPI_INT64_T, entries, rows);
  for (int64_t e = 0; e < entries; e++)
    s->column[e] = (PetscInt)(matrix ? matrix->row[e] : rows[e]);
  free(rows);
  return THRUM_OK;
}

static const double *share_values(shared_system *s, const thrum_sparse *matrix) {
  share_slices(s, matrix, matrix ? matrix->value : NULL, sizeof *s->value, MPI_DOUBLE,
               s->begin[s->own], s->value);
  return matrix != NULL ? matrix->value : s->value;
}

/* --- what all do ------------------------------------------------------------------------------ */

static thrum_status make_matrix(shared_system *s, int64_t size, thrum_error *error) {
  PetscInt *inner = NULL;
  THRUM_TRY(thrum_reserve(&inner, 2 * (int64_t)s->own + 1, sizeof *inner, "the equations", error));
  PetscInt *outer = inner + s->own;
  const PetscInt last = s->first[s->rank] + s->own;
  for (PetscInt row = 0; row < s->own; row++)
    for (int64_t e = s->begin[row]; e < s->begin[row + 1]; e++)
      (*(s->column[e] < last ? &inner[row] : &outer[row]))++;

  thrum_status status = THRUM_OK;
  PETSC_THEN(status, MatCreateSBAIJ(s->comm, 1, s->own, s->own, (PetscInt)size, (PetscInt)size, 0,
                                    inner, 0, outer, &s->matrix));
  PETSC_THEN(status, MatCreateVecs(s->matrix, &s->solution, &s->right));
  free(inner);
  return status;
}

// the shares of the rows, the pattern, and the solver
static thrum_status plan(shared_system *s, int64_t size, const thrum_sparse *matrix,
                         thrum_error *error) {
  PetscInt all = (PetscInt)size;
  s->own = PETSC_DECIDE;
  MPI_Comm_size(s->comm, &s->processes);
  MPI_Comm_rank(s->comm, &s->rank);
  PETSC_TRY(PetscSplitOwnership(s->comm, &s->own, &all));
  THRUM_TRY(thrum_reserve(&s->counts, 2 * s->processes, sizeof *s->counts, "the equations", error));
  s->first = s->counts + s->processes;
  MPI_Allgather(&s->own, 1, MPIU_INT, s->counts, 1, MPI_INT, s->comm);
  for (int r = 1; r < s->processes; r++)
    s->first[r] = s->first[r - 1] + s->counts[r - 1];

  THRUM_TRY(share_pattern(s, matrix, error));
  THRUM_TRY(make_matrix(s, size, error));
  PETSC_TRY(KSPCreate(s->comm, &s->ksp));
  return THRUM_OK;
}

// THRUM_SINGULAR where a pivot is not positive
static thrum_status check_factor(PC pc, Mat factor, thrum_error *error) {
  PCFailedReason reason;
  PetscInt negative = 0;
  PETSC_TRY(PCGetFailedReason(pc, &reason));
  if (reason == PC_FACTOR_OUTMEMORY)
    return petsc_status(PETSC_ERR_MEM, error);
  if (reason == PC_NOERROR)
    PETSC_TRY(MatGetInertia(factor, &negative, NULL, NULL));
  return reason == PC_NOERROR && negative == 0
             ? THRUM_OK
             : thrum_error_set(error, THRUM_SINGULAR, "the matrix is not positive definite");
}

static thrum_status compute(shared_system *s, const thrum_sparse *matrix, thrum_error *error) {
  const double *value = share_values(s, matrix);
  for (PetscInt row = 0; row < s->own; row++) {
    const PetscInt whole = s->first[s->rank] + row;
    const int64_t at = s->begin[row];
    PETSC_TRY(MatSetValues(s->matrix, 1, &whole, (PetscInt)(s->begin[row + 1] - at), s->column + at,
                           value + at, INSERT_VALUES));
  }
  PETSC_TRY(MatAssemblyBegin(s->matrix, MAT_FINAL_ASSEMBLY));
  PETSC_TRY(MatAssemblyEnd(s->matrix, MAT_FINAL_ASSEMBLY));
  PC pc;
  Mat factor;
  THRUM_TRY(inertia_factor_make(s->matrix, s->ksp, INERTIA_AS_THEY_COME, &pc, &factor, error));
  return check_factor(pc, factor, error);
}

static thrum_status solve(shared_system *s, const double *b, double *x, thrum_error *error) {
  double *right;
  const double *solution;
  PETSC_TRY(VecGetArray(s->right, &right));
  MPI_Scatterv(b, s->counts, s->first, MPI_DOUBLE, right, (int)s->own, MPI_DOUBLE, 0, s->comm);
  PETSC_TRY(VecRestoreArray(s->right, &right));
  PETSC_TRY(KSPSolve(s->ksp, s->right, s->solution));
  PETSC_TRY(VecGetArrayRead(s->solution, &solution));
  MPI_Gatherv(solution, (int)s->own, MPI_DOUBLE, x, s->counts, s->first, MPI_DOUBLE, 0, s->comm);
  PETSC_TRY(VecRestoreArrayRead(s->solution, &solution));
  return THRUM_OK;
}

/* --- rank 0 ----------------------------------------------------------------------------------- */

static void say(const shared_system *s, action what, int64_t size) {
  order told = {what, s->number, size};
  agree_on_bytes(s->comm, &told, (int64_t)sizeof told);
}

static void lead_end(void *system) {
  shared_system *s = system;
  say(s, ACTION_END, 0);
  s->systems->there[s->number] = false;
  s->systems->count--;
  system_free(s);
  free(s);
}

// a system without a matrix in a place of its own; the others come with the first and stay
static thrum_status lead_begin(shared_systems *systems, shared_system **system,
                               thrum_error *error) {
  if (systems->count == SHARED_SYSTEMS_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "no more than %d shared factors at a time",
                           SHARED_SYSTEMS_MAX);
  THRUM_TRY(thrum_reserve(system, 1, sizeof **system, "the equations", error));
  shared_system *s = *system;
  s->comm = systems->comm;
  s->systems = systems;
  while (systems->there[s->number])
    s->number++;

  if (systems->count == 0)
    systems->call(s->comm);
  systems->there[s->number] = true;
  systems->count++;
  return THRUM_OK;
}

static thrum_status lead_plan(void *context, const thrum_sparse *matrix, void **system,
                              thrum_error *error) {
  shared_system *s = NULL;
  THRUM_TRY(lead_begin(context, &s, error));
  say(s, ACTION_PLAN, matrix->size);
  const thrum_status status = agree_on_status(s->comm, plan(s, matrix->size, matrix, error), error);
  if (status >= 0)
    *system = s;
  else
    lead_end(s);
  return status;
}

static thrum_status lead_compute(void *system, const thrum_sparse *matrix, thrum_error *error) {
  shared_system *s = system;
  say(s, ACTION_COMPUTE, 0);
  return agree_on_status(s->comm, compute(s, matrix, error), error);
}

static thrum_status lead_solve(void *system, const double *b, double *x, thrum_error *error) {
  shared_system *s = system;
  say(s, ACTION_SOLVE, 0);
  return agree_on_status(s->comm, solve(s, b, x, error), error);
}

void shared_systems_begin(MPI_Comm comm, void (*call)(MPI_Comm comm), shared_systems *systems) {
  *systems = (shared_systems){.comm = comm, .call = call};
  systems->shared = (thrum_full_shared){systems, lead_plan, lead_compute, lead_solve, lead_end};
}

/* --- the others ------------------------------------------------------------------------------- */

// what fails here rank 0 hears, and then it ends the system
static void serve_order(shared_system *s, const order *told) {
  thrum_error error = {0};
  thrum_status status = THRUM_OK;
  if (told->action == ACTION_PLAN)
    status = plan(s, told->size, NULL, &error);
  else if (told->action == ACTION_COMPUTE)
    status = compute(s, NULL, &error);
  else
    status = solve(s, NULL, NULL, &error);
  agree_on_status(s->comm, status, &error);
}

void shared_systems_serve(MPI_Comm comm) {
  shared_system systems[SHARED_SYSTEMS_MAX] = {{0}};
  int count = 0;
  do {
    order told = {.action = ACTION_END};
    agree_on_bytes(comm, &told, (int64_t)sizeof told);
    shared_system *s = &systems[told.number];
    if (told.action == ACTION_END) {
      system_free(s);
      count--;
      continue;
    }

    // a plan is where a system begins
    s->comm = comm;
    count += told.action == ACTION_PLAN;
    serve_order(s, &told);
  } while (count > 0);
}
