/* The models that `thrum bench step`, `bench batch` and `bench kernels` run over, and their
 * outputs. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_BENCH_SPEED_H
#define THRUM_APP_BENCH_SPEED_H

#include <cjson/cJSON.h>

#include "app/bench_options.h"

/* Calls `run` with a model of each rank; stops at the first failure. */
typedef thrum_status bench_run(const bench_request *request, const thrum_model *model, cJSON *rows,
                               thrum_error *error);
int bench_each_model(bench_request *request, bench_run *run, const char *const *curves);

/* Parts of a row as JSON: a time, KEY and KEY_median; and figures that measurements share. */
void bench_row_time(cJSON *row, const char *key, const bench_time *time);
void bench_row_bandwidth(const bench_request *request, cJSON *row, const char *key, double us,
                         double bytes, double operations);

#endif
