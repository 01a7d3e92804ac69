/* `thrum precompute` for programs beside `thrum`. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_CMD_PRECOMPUTE_H
#define THRUM_APP_CMD_PRECOMPUTE_H

#include "precompute/precompute.h"

/* The command, whose model the processes of `shared` make together; NULL: this one alone. */
int cmd_precompute_shared(int argc, char **argv, const thrum_precompute_shared *shared);

#endif
