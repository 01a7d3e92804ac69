/* Which solver the processes use, by what each would take of their memory.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_SOLVER_CHOICE_H
#define THRUM_MPI_SOLVER_CHOICE_H

#include <petscksp.h>

#include "precompute/fem/ranks.h"
#include "precompute/precompute.h"

/* The equations of a whole body, whose solver is to be chosen. */
typedef struct solver_choice {
  MPI_Comm comm;
  const thrum_precompute_options *options;
  int64_t free_count; /* of the part of this process */
  Mat stiffness;
  Mat factor; /* MUMPS's, not yet planned; NULL where conjugate gradients were asked for */
} solver_choice;

/* Fills *use from the matrix and the plan of the factor, which is made: the solver asked for, or
 * for `auto` the factor where it fits into every process. Refuses what does not fit, with the
 * number of processes that would do. Called by all. */
thrum_status solver_choose(const solver_choice *choice, thrum_solver_use *use, thrum_error *error);

/* Fills the solvers of an estimate, and which would be taken, from the matrix and the plan of the
 * factor; the times are left. Called by all, which get the same. */
thrum_status solver_estimate(const solver_choice *choice, thrum_shared_estimate *estimate,
                             thrum_error *error);

#endif
