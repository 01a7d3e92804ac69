/* The program `thrum-mpi` (mpi/README.md), as commands of `thrum` use it: a command can go on as
 * `thrum-mpi` on one process, because that program has PETSc's conjugate gradients. It lies beside
 * `thrum` where it was built, or where the environment variable THRUM_MPI says.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_MPI_PROGRAM_H
#define THRUM_APP_MPI_PROGRAM_H

#include <stdbool.h>

#include "thrum/status.h"

/* The refusal of a command that several processes do for the whole mesh alone; COMMAND_USAGE. */
int mpi_program_wants_full(const char *command);

bool mpi_program_exists(void);

/* This process becomes thrum-mpi with the arguments of a command, argv[0] its name; nothing may be
 * printed or open for writing by then. Returns only with a failure: there is no such program. */
thrum_status mpi_program_become(char *const *argv, thrum_error *error);

#endif
