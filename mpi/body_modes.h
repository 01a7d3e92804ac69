/* The lowest modes of a body that several processes share. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MPI_BODY_MODES_H
#define THRUM_MPI_BODY_MODES_H

#include "mpi/body_system.h"

/* Adds to the ranks of a system (body_system_ranks) what finds and counts eigenvalues. */
void body_modes_add(thrum_ranks *ranks);

#endif
