/* Which solver the processes use, by what each would take of their memory.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_SOLVER_CHOICE_H
#define THRUM_MPI_SOLVER_CHOICE_H

#include "mpi/body_system.h"

/* Fills system->use from the matrix and, unless conjugate gradients were asked for, from the plan
 * of MUMPS's factor: the solver asked for, or for `auto` the factor where it fits into every
 * process. Refuses what does not fit, with the number of processes that would do. Called by all. */
thrum_status solver_choose(body_system *system, Mat factor, thrum_error *error);

#endif
