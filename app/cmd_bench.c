/* `thrum bench`: how fast the runtime is on this machine. The measurements are in bench/.
 * SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/bench_command.h"
#include "app/cmd.h"
#include "config/message.h"

static const cli_bench benches[] = {
    {"step", bench_step_command, "a step of a body that swings"},
    {"kernels", bench_kernels_command, "the passes over the coefficients"},
    {"batch", bench_batch_command, "many bodies of one model stepped together"},
    {"displacement", bench_displacement_command, "u = U q of a mesh that is shown"},
    {"precompute", bench_pipeline_command, "the pipeline against mesh size or rank"},
};
enum { BENCH_COUNT = sizeof benches / sizeof benches[0] };

static int print_help(FILE *stream) {
  fputs("usage: thrum bench WHAT [OPTIONS]\n\n"
        "Measures the runtime on one core of this machine: microseconds, minimum and median.\n\n",
        stream);
  for (int n = 0; n < BENCH_COUNT; n++)
    fprintf(stream, "  %-12s %s\n", benches[n].name, benches[n].summary);
  fputs("\n"
        "  thrum bench WHAT --help   options of a measurement\n\n"
        "examples:\n"
        "  thrum bench step --rank 15,30,60 --implicit 3\n"
        "  thrum bench kernels --kernel avx2\n"
        "  thrum bench batch --bodies 300 --rank 30\n"
        "  thrum bench displacement\n"
        "  thrum bench displacement --vertices 5000 --rank 60 --json\n",
        stream);
  return stream == stdout ? COMMAND_DONE : COMMAND_USAGE;
}

int cmd_bench(int argc, char **argv) {
  if (argc < 2)
    return print_help(stderr);
  if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)
    return print_help(stdout);
  const char *names[BENCH_COUNT];
  for (int n = 0; n < BENCH_COUNT; n++) {
    if (strcmp(argv[1], benches[n].name) == 0)
      return benches[n].run(argc - 1, argv + 1);
    names[n] = benches[n].name;
  }
  const char *nearest = config_nearest(argv[1], names, BENCH_COUNT);
  if (nearest != NULL)
    return config_usage("bench", "unknown measurement '%s'; did you mean '%s'?", argv[1], nearest);
  return config_usage("bench", "unknown measurement '%s'", argv[1]);
}
