/* The choice of a solver by memory, see solver_choice.h. What the factor takes is MUMPS's own
 * estimate after its analysis, which is exact for its plan. What the multigrid takes follows from
 * the entries of the matrix by a measured share (docs/scale.md).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mpi/solver_choice.h"

#include <math.h>

#include "mpi/petsc_status.h"
#include "platform/memory_limit.h"
#include "precompute/fem/sparse.h"
#include "precompute/options_check.h"

#define MARGIN 1.05         /* heap and buffers that are not counted one by one */
#define MULTIGRID_SHARE 3.0 /* of the matrix: coarse matrices, interpolations, their products */
#define BLOCKS_SHARE 1.4    /* of the matrix: what blocks keep of both, and PETSc's goes */
#define BLOCK_BYTES 1000.0  /* of a component: columns that step together */
#define SPACE_BLOCKS                                                                               \
  10.0                   /* of as many columns as modes: these, and the space that they come from */
#define ENTRY_BYTES 12.0 /* a number and its column */
#define MORE_PROCESSES 1.3 /* as parts share vertices, and fronts are not cut evenly */

// modes and derivatives, which any solver has beside it
static double column_bytes(const solver_choice *c) {
  const double shapes = (double)thrum_options_shapes(c->options);
  return 8 * (shapes + shapes * (shapes + 1) / 2) * (double)c->free_count;
}

// conjugate gradients: PETSc's multigrid while it is made, or what is kept of it with the columns
static double gradients_bytes(const solver_choice *c, double entries) {
  const double matrix = ENTRY_BYTES * entries, n = (double)c->free_count;
  const double space = 8 * n * SPACE_BLOCKS * (double)(c->options->modes + 4);
  const double later = BLOCK_BYTES * n + fmax(space, column_bytes(c)) - matrix;
  return BLOCKS_SHARE * matrix + fmax(MULTIGRID_SHARE * matrix, later);
}

// bytes that this process may still take: the limit of one process, or its share of its machine
static double room_here(const solver_choice *c) {
  if (c->options->memory_limit > 0)
    return fmax(0, c->options->memory_limit - thrum_memory_resident());
  MPI_Comm machine;
  int beside;
  MPI_Comm_split_type(c->comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  MPI_Comm_size(machine, &beside);

  // one reading serves all of a machine: what is free changes from one reading to the next
  double room = thrum_memory_available(NULL) / beside;
  MPI_Bcast(&room, 1, MPI_DOUBLE, 0, machine);
  MPI_Comm_free(&machine);
  return room;
}

// the plan of the factor, which MUMPS keeps for the factor itself
static thrum_status plan_factor(const solver_choice *c, double *bytes, thrum_error *error) {
  MatFactorInfo info;
  PetscInt megabytes;
  PETSC_TRY(MatFactorInfoInitialize(&info));
  PETSC_TRY(MatCholeskyFactorSymbolic(c->factor, c->stiffness, NULL, &info));
  PETSC_TRY(MatMumpsGetInfo(c->factor, 15, &megabytes));
  *bytes = 1e6 * (double)megabytes;
  return THRUM_OK;
}

static thrum_status estimate_here(const solver_choice *c, thrum_solver_use *use,
                                  thrum_error *error) {
  MatInfo entries;
  PETSC_TRY(MatGetInfo(c->stiffness, MAT_LOCAL, &entries));

  // the factor takes blocks that are columns of PETSc's, too
  const double columns = column_bytes(c) + 8.0 * 6 * THRUM_SOLVE_BLOCK * (double)c->free_count;
  use->room = room_here(c);
  use->cg_bytes = MARGIN * gradients_bytes(c, entries.nz_used);
  if (c->factor == NULL)
    return THRUM_OK;
  THRUM_TRY(plan_factor(c, &use->factor_bytes, error));
  use->factor_bytes = MARGIN * (use->factor_bytes + columns);
  return THRUM_OK;
}

// the estimate of the process that lacks most for a solver
static thrum_solver_use worst_of(const solver_choice *c, const thrum_solver_use *here,
                                 thrum_solver solver) {
  struct {
    double lacking;
    int rank;
  } worst = {(solver == THRUM_SOLVER_CG ? here->cg_bytes : here->factor_bytes) - here->room, 0};
  thrum_solver_use use = *here;
  MPI_Comm_rank(c->comm, &worst.rank);
  MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_DOUBLE_INT, MPI_MAXLOC, c->comm);
  MPI_Bcast(&use, (int)sizeof use, MPI_BYTE, worst.rank, c->comm);
  use.solver = solver;
  return use;
}

static bool fits(const thrum_solver_use *use) {
  return (use->solver == THRUM_SOLVER_CG ? use->cg_bytes : use->factor_bytes) <= use->room;
}

// how many processes with as much room as this one would do
static double processes_for(const solver_choice *c, const thrum_solver_use *use) {
  int processes;
  MPI_Comm_size(c->comm, &processes);
  const double bytes = use->solver == THRUM_SOLVER_CG ? use->cg_bytes : use->factor_bytes;
  return ceil(MORE_PROCESSES * processes * bytes / fmax(use->room, 1048576));
}

static thrum_status refuse(const solver_choice *c, const thrum_solver_use *use,
                           thrum_error *error) {
  int processes;
  MPI_Comm_size(c->comm, &processes);
  const bool factor = use->solver == THRUM_SOLVER_FACTOR;
  const double bytes = factor ? use->factor_bytes : use->cg_bytes;
  const double parts = processes_for(c, use);
  return thrum_error_set(
      error, THRUM_OUT_OF_MEMORY,
      "%s would take about %.0f MB more in one of %d processes, and %.0f MB are left for it: "
      "use about %.0f processes with as much each%s",
      factor ? "the factor" : "the multigrid", bytes / 1048576, processes, use->room / 1048576,
      parts, factor ? ", or --solver cg" : ", or a coarser mesh");
}

thrum_status solver_choose(const solver_choice *c, thrum_solver_use *use, thrum_error *error) {
  const thrum_solver asked = c->options->solver;
  thrum_solver_use here = {0};
  THRUM_TRY(estimate_here(c, &here, error));

  // each solver's bytes are those of the process that lacks most for it
  thrum_solver_use factor = worst_of(c, &here, THRUM_SOLVER_FACTOR);
  thrum_solver_use gradients = worst_of(c, &here, THRUM_SOLVER_CG);
  factor.cg_bytes = gradients.cg_bytes;
  gradients.factor_bytes = factor.factor_bytes;

  // `auto` takes the factor where every process has room for it
  const bool by_factor =
      asked == THRUM_SOLVER_FACTOR || (asked == THRUM_SOLVER_AUTO && fits(&factor));
  *use = by_factor ? factor : gradients;
  return fits(use) ? THRUM_OK : refuse(c, use, error);
}

// the process that has least to spare for a solver
static thrum_shared_solver need_of(const solver_choice *c, const thrum_solver_use *here,
                                   thrum_solver solver) {
  const thrum_solver_use use = worst_of(c, here, solver);
  const double bytes = solver == THRUM_SOLVER_CG ? use.cg_bytes : use.factor_bytes;
  double held = thrum_memory_resident();
  int processes;
  MPI_Allreduce(MPI_IN_PLACE, &held, 1, MPI_DOUBLE, MPI_MAX, c->comm);
  MPI_Comm_size(c->comm, &processes);
  return (thrum_shared_solver){.held = held,
                               .more = bytes,
                               .room = use.room,
                               .processes = fits(&use) ? processes : processes_for(c, &use)};
}

thrum_status solver_estimate(const solver_choice *c, thrum_shared_estimate *estimate,
                             thrum_error *error) {
  const thrum_solver asked = c->options->solver;
  thrum_solver_use here = {0};
  THRUM_TRY(estimate_here(c, &here, error));
  estimate->factor = need_of(c, &here, THRUM_SOLVER_FACTOR);
  estimate->cg = need_of(c, &here, THRUM_SOLVER_CG);
  const bool fit = estimate->factor.more <= estimate->factor.room;
  estimate->solver = asked != THRUM_SOLVER_AUTO ? asked
                     : fit                      ? THRUM_SOLVER_FACTOR
                                                : THRUM_SOLVER_CG;

  // MUMPS gives millions as a negative number where an int would not hold the count
  PetscInt nonzeros;
  PETSC_TRY(MatMumpsGetInfog(c->factor, 20, &nonzeros));
  PETSC_TRY(MatMumpsGetRinfog(c->factor, 1, &estimate->flops));
  estimate->nonzeros = nonzeros < 0 ? -1e6 * nonzeros : nonzeros;
  MPI_Comm_size(c->comm, &estimate->processes);
  return THRUM_OK;
}
