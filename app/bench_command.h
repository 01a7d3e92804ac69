/* The measurements of `thrum bench`, one file each. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_BENCH_COMMAND_H
#define THRUM_APP_BENCH_COMMAND_H

#include "config/options.h"

/* X(name); argv[0] is it */
#define BENCH_COMMAND_LIST(X)                                                                      \
  X(step) X(kernels) X(batch) X(accelerator) X(contact) X(displacement) X(precompute)

#define X(name)                                                                                    \
  extern const config_command command_bench_##name;                                                \
  int bench_##name##_command(int argc, char **argv);
BENCH_COMMAND_LIST(X)
#undef X

#endif
