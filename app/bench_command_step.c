/* `thrum bench step`. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "app/bench_command.h"
#include "app/bench_speed.h"
#include "config/message.h"
#include "driver/model/model_cut.h"
#include "io/json.h"

#define HEAD " rank   us/step    median       h [s]  implicit  iterations  refactor   GFLOP/s"
static const report_line lines[] = {
    REPORT_LINE("", "{rank:5.0f} {us_per_step:9.2f} {us_per_step_median:9.2f} {h:11.3g} "
                    "{implicit_modes:9.0f} {mean_iterations:11.2f} {mean_factorisations:9.2f} "
                    "{gflops:9.2f}" BENCH_RATES("")),
    {0},
};

static thrum_status measure(const bench_request *request, const thrum_model *model, cJSON *rows,
                            thrum_error *error) {
  // the measurement, with the options of the command
  bench_step step = request->step;
  step.def.kernel = request->kernel;
  step.batches = request->batches;
  THRUM_TRY(bench_step_run(model, &step, error));

  // one row, with the rates that were reached beside those of the machine
  const char *level;
  const double each = bench_coefficient_bytes(model), bytes = each * bench_terms(model->rank);
  const double bandwidth = bench_machine_bandwidth(&request->rates, bytes, &level);
  const double gflops = 1e-3 * step.operations / step.time.minimum;
  const double bound = 1e-3 * each * step.coefficients / bandwidth;

  cJSON *row = json_add_row(rows);
  json_number(row, "rank", (double)model->rank);
  bench_row_time(row, "us_per_step", &step.time);
  json_number(row, "h", step.dt);
  json_number(row, "implicit_modes", step.implicit_modes);
  json_number(row, "mean_iterations", step.iterations);
  json_number(row, "mean_factorisations", step.factorisations);
  json_number(row, "steps", (double)step.steps_measured);
  json_number(row, "gflops", gflops);
  json_number(row, "bound_us", request->machine ? bound : NAN);
  json_number(row, "share_of_fma_peak",
              request->machine ? gflops / request->rates.peak_gflops : NAN);
  json_number(row, "share_of_bandwidth", request->machine ? bound / step.time.minimum : NAN);
  json_string(row, "level", level);
  json_string(row, "kernel", thrum_kernel_name(thrum_kernel_chosen(request->kernel)));
  bench_row_print(request, rows, request->machine ? HEAD BENCH_RATES_HEAD : HEAD, 0, lines);
  return THRUM_OK;
}

/* Measures what is stepped of a condensed file. */
static thrum_status run(const bench_request *request, const thrum_model *model, cJSON *rows,
                        thrum_error *error) {
  const thrum_model *stepped = NULL;
  void *memory = NULL;
  thrum_status status = model_condense_to(model, 0, &memory, &stepped, error);
  THRUM_THEN(status, measure(request, stepped, rows, error));
  free(memory);
  return status;
}

int bench_step_command(int argc, char **argv) {
  static const char *const curves[] = {"us_per_step", "us_per_step_median", "bound_us", NULL};
  bench_request request;
  CONFIG_TRY(bench_options_read(&command_bench_step, argc, argv, &request));
  return bench_each_model(&request, run, curves);
}
