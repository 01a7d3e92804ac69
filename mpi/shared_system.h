/* Systems of equations whose matrices rank 0 has, and whose factors all processes have together:
 * for statics and steps of the whole mesh (precompute/full). SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_SHARED_SYSTEM_H
#define THRUM_MPI_SHARED_SYSTEM_H

#include <mpi.h>
#include <stdbool.h>

#include "precompute/full/full_solver.h"

/* Systems at a time: of a body's steps, and of the mass, which Newmark's first acceleration takes.
 */
enum { SHARED_SYSTEMS_MAX = 2 };

/* The solver of rank 0, for as long as the others are in shared_serve. `call` brings them to
 * shared_systems_serve. */
typedef struct shared_systems {
  MPI_Comm comm;
  void (*call)(MPI_Comm comm);
  int count;                      /* of systems that are there, */
  bool there[SHARED_SYSTEMS_MAX]; /* and which */
  thrum_full_shared shared;
} shared_systems;

void shared_systems_begin(MPI_Comm comm, void (*call)(MPI_Comm comm), shared_systems *systems);

/* Serves a system, in all other processes, until rank 0 has ended it and those made meanwhile. */
void shared_systems_serve(MPI_Comm comm);

#endif
