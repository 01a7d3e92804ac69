/* A precompute by several processes: rank 0 leads, reads and writes, the others serve it.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_SHARED_PRECOMPUTE_H
#define THRUM_MPI_SHARED_PRECOMPUTE_H

#include <mpi.h>

#include "mpi/body_system.h"
#include "precompute/precompute.h"

/* The lead of the processes of `comm`. It must stay while
 * `shared.precompute` may be called, in rank 0; the others are in shared_serve meanwhile. */
typedef struct shared_lead {
  MPI_Comm comm;
  thrum_precompute_shared shared;
} shared_lead;

void shared_lead_begin(MPI_Comm comm, shared_lead *lead);

/* Serves rank 0, in all other processes, until that ends the service; in between it may call them
 * to a system of equations (shared_system.h). */
void shared_serve(MPI_Comm comm);
void shared_serve_system(MPI_Comm comm);
void shared_serve_end(MPI_Comm comm);

#endif
