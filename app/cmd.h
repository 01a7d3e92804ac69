/* The subcommands of `thrum`: what they say of themselves, and what runs them.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_CMD_H
#define THRUM_APP_CMD_H

#include "config/options.h"
#include "precompute/full/full_solver.h"
#include "precompute/precompute.h"

/* X(name), in the order in which they are listed; a further command is one line here. */
// clang-format off
#define COMMAND_LIST(X) \
  X(precompute) \
  X(mesh) \
  X(check) \
  X(convert) \
  X(simulate) \
  X(compare) \
  X(view) \
  X(static) \
  X(response) \
  X(identify) \
  X(experiments) \
  X(tradeoff) \
  X(verify) \
  X(info) \
  X(embed) \
  X(export) \
  X(bench) \
  X(schema)
// clang-format on

#define X(name)                                                                                    \
  extern const config_command command_##name;                                                      \
  int cmd_##name(int argc, char **argv);
COMMAND_LIST(X)
#undef X

/* The commands of `thrum-mpi`. The factor of the full order is one that the processes of `shared`
 * have together, and those of `precompute` make the model of a mesh; NULL: this process alone. */
int cmd_precompute_shared(int argc, char **argv, const thrum_precompute_shared *precompute);
int cmd_simulate_shared(int argc, char **argv, const thrum_full_shared *shared,
                        const thrum_precompute_shared *precompute);
int cmd_static_shared(int argc, char **argv, const thrum_full_shared *shared,
                      const thrum_precompute_shared *precompute);

#endif
