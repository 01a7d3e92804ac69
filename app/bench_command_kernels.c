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

static void print_pass(const bench_request *request, const bench_kernels *bench, int pass,
                       const thrum_model *model) {
  const bench_time time = bench->time[pass];
  const double bytes = bench_coefficient_bytes(model) * bench->coefficients[pass];
  const double gflops = 1e-3 * bench->operations[pass] / time.minimum;
  const char *level;
  const double bandwidth = bench_machine_bandwidth(&request->rates, bytes, &level);
  printf("%5lld %-14s %9.3f %9.3f %9.2f", (long long)model->rank, passes[pass].text, time.minimum,
         time.median, gflops);
  if (request->machine)
    printf(" %7.0f %% %7.0f %% of %-4s %9.3f", 100 * gflops / request->rates.peak_gflops,
           100 * 1e-3 * bytes / time.minimum / bandwidth, level, 1e-3 * bytes / bandwidth);
  printf("\n");
}

static thrum_status run(const bench_request *request, const thrum_model *model, cJSON *rows,
                        thrum_error *error) {
  // the measurement, with the options of the command
  const int wanted = request->step.implicit_wanted;
  bench_kernels bench = {.kernel = request->kernel,
                         .implicit = wanted >= 0 ? wanted : IMPLICIT_DEFAULT,
                         .batches = request->batches};
  THRUM_TRY(bench_kernels_run(model, &bench, error));

  // the head of the table comes with the first row
  if (!request->json && cJSON_GetArraySize(rows) == 0)
    printf("%5s %-14s %9s %9s %9s%s\n", "rank", "pass", "us", "median", "GFLOP/s",
           request->machine ? "  FMA peak  bandwidth    bound us" : "");

  // one row of JSON for all passes, and a line of the table for each
  cJSON *row = json_add_row(rows);
  json_number(row, "rank", (double)model->rank);
  json_string(row, "kernel", thrum_kernel_name(bench.kernel));
  json_number(row, "implicit_modes", (double)bench.implicit);
  for (int pass = 0; pass < THRUM_PASS_COUNT; pass++) {
    if (!request->json)
      print_pass(request, &bench, pass, model);
    bench_row_time(row, passes[pass].key, &bench.time[pass]);
    bench_row_bandwidth(request, row, passes[pass].name, bench.time[pass].minimum,
                        bench_coefficient_bytes(model) * bench.coefficients[pass],
                        bench.operations[pass]);
  }
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
