/* `thrum bench`: how fast the runtime is on this machine. The measurements are in bench/.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "app/cmd.h"
#include "app/commands.h"
#include "config/message.h"

static const config_option options[] = {OPTION_HELP, OPTION_END};

const config_command command_bench = {
    .name = "bench",
    .summary = "measure the runtime on this machine",
    .usage = "step|kernels|batch|accelerator|contact|displacement|precompute [OPTIONS]",
    .about = "Measures the runtime on one core of this machine: microseconds, minimum and median. "
             "Each measurement has options of its own, which thrum bench step --help and so on "
             "list.",
    .options = options,
    .examples = "bench step --rank 15,30,60 --implicit 3\n"
                "bench kernels --kernel avx2\n"
                "bench batch --bodies 300 --rank 30\n"
                "bench accelerator --bodies 10000 --rank 20\n"
                "bench contact\n"
                "bench displacement\n"
                "bench displacement --vertices 5000 --rank 60 --json",
};

int cmd_bench(int argc, char **argv) {
  if (argc < 2) {
    fputs("usage: thrum bench MEASUREMENT [OPTIONS]\n\n", stderr);
    app_commands_print(stderr, bench_commands);
    return COMMAND_USAGE;
  }
  if (argv[1][0] == '-')
    return config_options_read(&command_bench, argc, argv, NULL);
  const app_command *found = app_command_find(bench_commands, "bench", "measurement", argv[1]);
  return found != NULL ? found->run(argc - 1, argv + 1) : COMMAND_USAGE;
}
