/* What `thrum bench step` and `thrum bench kernels` share: options, models, and their outputs.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_BENCH_SPEED_H
#define THRUM_APP_BENCH_SPEED_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#include "bench/speed.h"
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
  int64_t bodies;     /* of bench batch */
  const char *folder; /* for a table and a plot; NULL: none */
  bool machine;       /* measure the machine too */
  bool json, quiet;
  bench_machine rates;
} bench_request;

/* Fills the request from argv; COMMAND_DONE or COMMAND_USAGE. */
int bench_options_read(const char *command, int argc, char **argv, bench_request *request);

/* Calls `run` with a model of each rank; stops at the first failure. */
typedef thrum_status bench_run(const bench_request *request, const thrum_model *model, cJSON *rows,
                               thrum_error *error);
int bench_each_model(bench_request *request, bench_run *run, const char *const *curves);

/* A row as JSON: shared figures. */
void bench_row_bandwidth(const bench_request *request, cJSON *row, const char *key, double us,
                         double bytes, double operations);

#endif
