/* Options of `thrum bench step`, `bench batch` and `bench kernels`.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_BENCH_OPTIONS_H
#define THRUM_APP_BENCH_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "bench/machine.h"
#include "bench/measure.h"
#include "config/options.h"
#include "thrum/thrum.h"

#define BENCH_RANKS_MAX 64

typedef struct bench_request {
  const char *command;    /* "bench step" */
  const char *model_path; /* NULL: the beam, at each rank */
  int64_t ranks[BENCH_RANKS_MAX];
  int64_t rank_count;
  bool ranks_given; /* by the user */
  bench_step step;
  thrum_kernel_id kernel;
  int64_t batches;
  int64_t bodies; /* of bench batch and bench accelerator */
  int64_t device; /* of bench accelerator */
  int32_t single;
  bool full;          /* the whole mesh */
  const char *folder; /* for a table and a plot; NULL: none */
  bool machine;       /* measure the machine too */
  bool json, quiet;
  bench_machine rates;
} bench_request;

/* Fills the request from argv; COMMAND_DONE or COMMAND_USAGE. */
int bench_options_read(const config_command *about, int argc, char **argv, bench_request *request);

#endif
