/* Agreement between processes, see agreement.h. SPDX-License-Identifier: Apache-2.0 */
#include "mpi/agreement.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "platform/clock.h"

#define PATIENCE 5.0 /* seconds that a failed process waits for the others */

enum { EXIT_REFUSED = 1 };

// waits for a request without using a core up; false when that takes more than `seconds`, 0: for
// ever
static bool wait_for(MPI_Request *request, double seconds) {
  const struct timespec pause = {0, 500000};
  const double began = clock_seconds();
  for (;;) {
    int done;
    MPI_Test(request, &done, MPI_STATUS_IGNORE);
    if (done)
      return true;
    if (seconds > 0 && clock_seconds() - began > seconds)
      return false;
    nanosleep(&pause, NULL);
  }
}

void agree_on_bytes(MPI_Comm comm, void *bytes, int64_t size) {
  MPI_Request request;
  MPI_Ibcast(bytes, (int)size, MPI_BYTE, 0, comm, &request);
  wait_for(&request, 0);
}

void agree_on_sums(MPI_Comm comm, double *numbers, int64_t count) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  MPI_Reduce(rank == 0 ? MPI_IN_PLACE : numbers, rank == 0 ? numbers : NULL, (int)count, MPI_DOUBLE,
             MPI_SUM, 0, comm);
  MPI_Bcast(numbers, (int)count, MPI_DOUBLE, 0, comm);
}

thrum_status agree_on_status(MPI_Comm comm, thrum_status status, thrum_error *error) {
  int rank;
  MPI_Comm_rank(comm, &rank);

  // the worst status, and the first that has it
  struct {
    int status, rank;
  } own = {(int)status, rank}, worst;
  MPI_Request request;
  MPI_Iallreduce(&own, &worst, 1, MPI_2INT, MPI_MINLOC, comm, &request);
  if (!wait_for(&request, status < 0 ? PATIENCE : 0)) {
    fprintf(stderr, "thrum-mpi: process %d: %s\n", rank, error->message);
    MPI_Abort(comm, EXIT_REFUSED);
  }
  if (worst.status >= 0)
    return status;

  // all hear what it says
  MPI_Bcast(error->message, sizeof error->message, MPI_CHAR, worst.rank, comm);
  error->status = (thrum_status)worst.status;
  return error->status;
}
