/* The lowest modes by SLEPc, see body_modes.h: Krylov-Schur (Stewart 2001,
 * doi:10.1137/S0895479800371529; Hernandez, Roman, Vidal 2005, doi:10.1145/1089014.1089019) on
 * K^-1 M in the M inner product, shift-invert at 0, with the solver that is there already. Modes
 * below a shift are counted by the inertia of K - s M, which MUMPS factorises.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mpi/body_modes.h"

#include <stdlib.h>
#include <string.h>

#include "mpi/inertia_factor.h"
#include "mpi/petsc_status.h"
#include "precompute/fem/rigid_modes.h"
#include "precompute/options_check.h"

#define KRYLOV_TOLERANCE 1e-10
#define RESTARTS_MAX 300

// SLEPc's solver of K x = f is the one of the system
static PetscErrorCode apply_solver(PC pc, Vec right, Vec solution) {
  body_system *s;
  PetscErrorCode code = PCShellGetContext(pc, &s);
  if (code == 0 && body_system_solve_rows(s, right, solution, &s->failure) < 0)
    code = PETSC_ERR_NOT_CONVERGED;
  return code;
}

// shift-invert at 0, whose solver is applied as it stands
static thrum_status set_transformation(body_system *s, EPS eps, thrum_error *error) {
  ST st;
  KSP shell;
  PC pc;
  PETSC_TRY(EPSGetST(eps, &st));
  PETSC_TRY(STSetType(st, STSINVERT));
  PETSC_TRY(STSetMatMode(st, ST_MATMODE_SHELL));
  PETSC_TRY(STGetKSP(st, &shell));
  PETSC_TRY(KSPSetType(shell, KSPPREONLY));
  PETSC_TRY(KSPGetPC(shell, &pc));
  PETSC_TRY(PCSetType(pc, PCSHELL));
  PETSC_TRY(PCShellSetContext(pc, s));
  PETSC_TRY(PCShellSetApply(pc, apply_solver));
  return THRUM_OK;
}

// a start vector without structure, the same however the body is cut
static thrum_status set_start(body_system *s, EPS eps, thrum_error *error) {
  Vec start = NULL;
  double *values = NULL;
  const body_part *part = s->part;
  thrum_status status = THRUM_OK;
  PETSC_THEN(status, VecDuplicate(s->all, &start));
  PETSC_THEN(status, VecGetArray(start, &values));

  // each number is made from that of its component in the whole mesh
  int64_t next = 0;
  for (int64_t c = 0; c < 3 * part->facts.vertices && status >= 0; c++) {
    if (!part->own[c / 3])
      continue;
    uint64_t state = 3 * (uint64_t)part->vertex[c / 3] + (uint64_t)(c % 3) + 0x9e3779b97f4a7c15u;
    for (int pass = 0; pass < 3; pass++)
      state = (state ^ (state >> 29)) * 6364136223846793005u + 1442695040888963407u;
    values[next++] = (double)(state >> 11) / 9007199254740992.0 - 0.5;
  }

  PETSC_THEN(status, VecRestoreArray(start, &values));
  PETSC_THEN(status, EPSSetInitialSpace(eps, 1, &start));
  VecDestroy(&start);
  return status;
}

// rows of one rigid mode: values agree between parts, so those that come last are as good as any
static thrum_status set_rigid_mode(body_system *s, const double *rigid, Vec rows,
                                   thrum_error *error) {
  PETSC_TRY(VecPlaceArray(s->local, rigid));
  PETSC_TRY(VecScatterBegin(s->spread, s->local, rows, INSERT_VALUES, SCATTER_FORWARD));
  PETSC_TRY(VecScatterEnd(s->spread, s->local, rows, INSERT_VALUES, SCATTER_FORWARD));
  PETSC_TRY(VecResetArray(s->local));
  return THRUM_OK;
}

// keeps the search orthogonal to the rigid modes, whose values are of the part
static thrum_status set_rigid(body_system *s, const double *rigid, EPS eps, thrum_error *error) {
  const PetscInt six = THRUM_RIGID_COUNT;
  Vec *space;
  PETSC_TRY(VecDuplicateVecs(s->all, six, &space));
  thrum_status status = THRUM_OK;
  for (int n = 0; n < THRUM_RIGID_COUNT; n++)
    THRUM_THEN(status, set_rigid_mode(s, rigid + n * s->free_count, space[n], error));
  PETSC_THEN(status, EPSSetDeflationSpace(eps, six, space));
  VecDestroyVecs(six, &space);
  return status;
}

// the eigenpairs that SLEPc found, lowest first
static thrum_status take_pairs(body_system *s, EPS eps, int64_t count, double *values,
                               double *vectors, thrum_error *error) {
  PetscInt found;
  PETSC_TRY(EPSGetConverged(eps, &found));
  if (found < count)
    return thrum_error_set(error, THRUM_NOT_CONVERGED,
                           "%d of %lld modes converged: check the material, the scale and the "
                           "quality of the mesh, or lower --modes",
                           (int)found, (long long)count);
  for (int64_t i = 0; i < count; i++) {
    PETSC_TRY(EPSGetEigenpair(eps, (PetscInt)i, &values[i], NULL, s->all, NULL));
    THRUM_TRY(body_system_hand_out(s, s->all, vectors + i * s->free_count, error));
  }
  return THRUM_OK;
}

static thrum_status solve_pairs(body_system *s, EPS eps, const double *rigid, int64_t count,
                                double *values, double *vectors, thrum_error *error) {
  const int64_t room = s->size - (rigid ? THRUM_RIGID_COUNT : 0), wanted = 2 * count + 10;
  PETSC_TRY(EPSSetOperators(eps, s->stiffness, s->mass));
  PETSC_TRY(EPSSetProblemType(eps, EPS_GHEP));
  PETSC_TRY(EPSSetType(eps, EPSKRYLOVSCHUR));
  PETSC_TRY(EPSSetWhichEigenpairs(eps, EPS_TARGET_MAGNITUDE));
  PETSC_TRY(EPSSetTarget(eps, 0));
  PETSC_TRY(EPSSetTolerances(eps, KRYLOV_TOLERANCE, RESTARTS_MAX));
  PETSC_TRY(EPSSetDimensions(eps, (PetscInt)count, (PetscInt)(wanted < room ? wanted : room),
                             PETSC_DEFAULT));
  THRUM_TRY(set_transformation(s, eps, error));
  THRUM_TRY(set_start(s, eps, error));
  if (rigid)
    THRUM_TRY(set_rigid(s, rigid, eps, error));
  PETSC_TRY(EPSSolve(eps));
  return take_pairs(s, eps, count, values, vectors, error);
}

static thrum_status lowest(void *context, const double *rigid, int64_t count, double *values,
                           double *vectors, thrum_error *error) {
  body_system *s = context;
  EPS eps;
  PETSC_TRY(EPSCreate(s->comm, &eps));
  thrum_status status = solve_pairs(s, eps, rigid, count, values, vectors, error);

  // what a solve said tells more than that SLEPc stopped there
  if (s->failure.status < 0)
    status = thrum_error_set(error, s->failure.status, "%s", s->failure.message);
  PETSC_TRY(EPSDestroy(&eps));
  return status;
}

static bool counts(const void *context) {
  const body_system *s = context;
  return thrum_options_count_wanted(s->options->check, s->size);
}

// K - shift M, of a free body without its springs
static thrum_status shifted(const body_system *s, double shift, Mat *matrix, thrum_error *error) {
  PETSC_TRY(MatDuplicate(s->stiffness, MAT_COPY_VALUES, matrix));
  PETSC_TRY(MatAXPY(*matrix, -shift, s->mass, SUBSET_NONZERO_PATTERN));
  if (s->part->facts.free_body)
    THRUM_TRY(body_system_add_springs(s, -1, *matrix, error));
  PETSC_TRY(MatAssemblyBegin(*matrix, MAT_FINAL_ASSEMBLY));
  PETSC_TRY(MatAssemblyEnd(*matrix, MAT_FINAL_ASSEMBLY));
  PETSC_TRY(MatSetOption(*matrix, MAT_SYMMETRIC, PETSC_TRUE));
  PETSC_TRY(MatSetOption(*matrix, MAT_SPD, PETSC_FALSE));
  return THRUM_OK;
}

// what fails inside MUMPS is told by the preconditioner alone, and its signs then mean nothing
static thrum_status take_inertia(PC pc, Mat factor, PetscInt *negative, thrum_error *error) {
  PCFailedReason reason;
  PETSC_TRY(PCGetFailedReason(pc, &reason));
  if (reason == PC_FACTOR_OUTMEMORY)
    return petsc_status(PETSC_ERR_MEM, error);
  if (reason != PC_NOERROR)
    return thrum_error_set(error, THRUM_NOT_CONVERGED,
                           "modes could not be counted, as MUMPS failed (PETSc reason %d): take "
                           "--check search",
                           (int)reason);
  PETSC_TRY(MatGetInertia(factor, negative, NULL, NULL));
  return THRUM_OK;
}

static thrum_status count_below(void *context, double shift, int64_t *count, thrum_error *error) {
  body_system *s = context;
  Mat matrix = NULL, factor = NULL;
  KSP ksp = NULL;
  PC pc = NULL;
  PetscInt negative = 0;
  thrum_status status = shifted(s, shift, &matrix, error);
  PETSC_THEN(status, KSPCreate(s->comm, &ksp));
  THRUM_THEN(status, inertia_factor_make(matrix, ksp, INERTIA_PUT_OFF, &pc, &factor, error));
  THRUM_THEN(status, take_inertia(pc, factor, &negative, error));
  KSPDestroy(&ksp);
  MatDestroy(&matrix);
  if (status >= 0)
    *count = negative;
  return status;
}

void body_modes_add(thrum_ranks *ranks) {
  ranks->lowest = lowest;
  ranks->counts = counts;
  ranks->count_below = count_below;
}
