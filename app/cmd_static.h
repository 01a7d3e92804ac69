/* `thrum static` for programs beside `thrum`. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_CMD_STATIC_H
#define THRUM_APP_CMD_STATIC_H

#include "precompute/full/full_solver.h"

/* The command, the factor of whose full order the processes of `shared` have together; NULL: this
 * one alone. */
int cmd_static_shared(int argc, char **argv, const thrum_full_shared *shared);

#endif
