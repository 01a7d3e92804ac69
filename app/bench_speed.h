/* The models that `thrum bench step`, `bench batch` and `bench kernels` run over, and their
 * outputs. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_BENCH_SPEED_H
#define THRUM_APP_BENCH_SPEED_H

#include <cjson/cJSON.h>

#include "app/bench_options.h"
#include "io/report.h"

/* Calls `run` with a model of each rank; stops at the first failure. */
typedef thrum_status bench_run(const bench_request *request, const thrum_model *model, cJSON *rows,
                               thrum_error *error);
int bench_each_model(bench_request *request, bench_run *run, const char *const *curves);

/* Prints the lines of the last row, behind the head of its columns where it is the first. */
void bench_row_print(const bench_request *request, const cJSON *rows, const char *head, int width,
                     const report_line *lines);

/* A report of one measurement: its head and its lines, or JSON; deletes it. */
void bench_report_end(cJSON *report, bool json, const report_line *head, int width,
                      const report_line *lines);

/* Columns of a row that follow from the rates of the machine, and their head. */
#define BENCH_RATES_HEAD "  FMA peak  bandwidth    bound us"
#define BENCH_RATES(of)                                                                            \
  "[ {" of "share_of_fma_peak:7.0f%} {" of "share_of_bandwidth:7.0f%} of {" of "level:-4s} {" of   \
  "bound_us:9.3f}]"

/* Parts of a row as JSON: a time, KEY and KEY_median; and figures that measurements share. */
void bench_row_time(cJSON *row, const char *key, const bench_time *time);
void bench_row_bandwidth(const bench_request *request, cJSON *row, const char *key, double us,
                         double bytes, double operations);

#endif
