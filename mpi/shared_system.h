/* A system of equations whose matrix rank 0 has, and whose factor all processes have together: for
 * statics of the whole mesh (precompute/full). SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_SHARED_SYSTEM_H
#define THRUM_MPI_SHARED_SYSTEM_H

#include <mpi.h>

#include "precompute/full/full_solver.h"

/* The solver of rank 0, for as long as the others are in shared_serve. `call` brings them to
 * shared_system_serve. */
typedef struct shared_systems {
  MPI_Comm comm;
  void (*call)(MPI_Comm comm);
  thrum_full_shared shared;
} shared_systems;

void shared_systems_begin(MPI_Comm comm, void (*call)(MPI_Comm comm), shared_systems *systems);

/* Serves one system, in all other processes, until rank 0 ends it. */
void shared_system_serve(MPI_Comm comm);

#endif
