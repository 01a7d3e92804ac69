/* The measurements of `thrum bench`, one file each. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_BENCH_COMMAND_H
#define THRUM_APP_BENCH_COMMAND_H

typedef struct cli_bench {
  const char *name;
  int (*run)(int argc, char **argv); /* argv[0] is its name */
  const char *summary;
} cli_bench;

int bench_batch_command(int argc, char **argv);
int bench_displacement_command(int argc, char **argv);
int bench_step_command(int argc, char **argv);
int bench_kernels_command(int argc, char **argv);
int bench_pipeline_command(int argc, char **argv);

#endif
