/* `thrum bench kernels`. SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "app/bench_command.h"
#include "app/bench_speed.h"
#include "config/message.h"
#include "io/json.h"

#define IMPLICIT_DEFAULT 3

static const struct {
  const char *name, *text, *key;
} passes[THRUM_PASS_COUNT] = {
#define X(name, operations, key, text) {key, text, "us_" key},
    THRUM_PASS_LIST(X)
#undef X
};

#define HEAD " rank pass                  us    median   GFLOP/s"
#define WIDTH 21 /* of the rank and the name of a pass */
static const report_line lines[] = {
#define X(name, operations, key, text)                                                             \
  REPORT_LINE("{rank:5.0f} " text, "{us_" key ":9.3f} {us_" key "_median:9.3f} {" key              \
                                   "_gflops:9.2f}" BENCH_RATES(key "_")),
    THRUM_PASS_LIST(X)
#undef X
        {0},
};

static thrum_status run(const bench_request *request, const thrum_model *model, cJSON *rows,
                        thrum_error *error) {
  // the measurement, with the options of the command
  const int wanted = request->step.implicit_wanted;
  bench_kernels bench = {.kernel = request->kernel,
                         .implicit = wanted >= 0 ? wanted : IMPLICIT_DEFAULT,
                         .batches = request->batches};
  THRUM_TRY(bench_kernels_run(model, &bench, error));

  // one row for all passes, of which each has a line of the table
  cJSON *row = json_add_row(rows);
  json_number(row, "rank", (double)model->rank);
  json_string(row, "kernel", thrum_kernel_name(bench.kernel));
  json_number(row, "implicit_modes", (double)bench.implicit);
  for (int pass = 0; pass < THRUM_PASS_COUNT; pass++) {
    bench_row_time(row, passes[pass].key, &bench.time[pass]);
    bench_row_bandwidth(request, row, passes[pass].name, bench.time[pass].minimum,
                        bench_coefficient_bytes(model) * bench.coefficients[pass],
                        bench.operations[pass]);
  }
  bench_row_print(request, rows, request->machine ? HEAD BENCH_RATES_HEAD : HEAD, WIDTH, lines);
  return THRUM_OK;
}

int bench_kernels_command(int argc, char **argv) {
  static const char *const curves[] = {
      "us_energy",   "us_force",       "us_tangent", "us_tangent_vector",
      "us_restrict", "force_bound_us", NULL};
  bench_request request;
  CONFIG_TRY(bench_options_read(&command_bench_kernels, argc, argv, &request));
  return bench_each_model(&request, run, curves);
}
