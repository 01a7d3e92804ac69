/* `thrum simulate` for programs beside `thrum`. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_CMD_SIMULATE_H
#define THRUM_APP_CMD_SIMULATE_H

#include "precompute/full/full_solver.h"
#include "precompute/precompute.h"

/* The command, the factors of whose full order the processes of `shared` have together, and the
 * model of whose mesh those of `precompute` make; NULL: this one alone. */
int cmd_simulate_shared(int argc, char **argv, const thrum_full_shared *shared,
                        const thrum_precompute_shared *precompute);

#endif
