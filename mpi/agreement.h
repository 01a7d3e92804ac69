/* Agreement between processes: on commands, and on whether all came through.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_AGREEMENT_H
#define THRUM_MPI_AGREEMENT_H

#include <mpi.h>
#include <stdint.h>

#include "thrum/status.h"

/* Gives all processes the worst status of any, and with a failure the message of the first process
 * that has it. A process that failed and is left alone for some seconds, because others wait for it
 * elsewhere, prints its message and ends all. */
thrum_status agree_on_status(MPI_Comm comm, thrum_status status, thrum_error *error);

/* Hands `size` bytes from rank 0 to all; those who wait sleep, as it may take long. */
void agree_on_bytes(MPI_Comm comm, void *bytes, int64_t size);

/* Sums each of `count` numbers over all processes. One adds up and tells, so that all have the same
 * bits, which MPI_Allreduce does not promise. */
void agree_on_sums(MPI_Comm comm, double *numbers, int64_t count);

#endif
