/* `thrum bench step`. SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "cli/bench.h"
#include "cli/bench_speed.h"

static thrum_status run(const bench_request *request, const thrum_model *model, cJSON *rows,
                        thrum_error *error) {
  bench_step step = request->step;
  step.def.kernel = request->kernel;
  step.batches = request->batches;
  const thrum_status status = bench_step_run(model, &step, error);
  if (status < 0)
    return status;
  if (!request->json) {
    if (cJSON_GetArraySize(rows) == 0)
      printf("%5s %9s %9s %11s %9s %11s %9s\n", "rank", "us/step", "median", "h [s]", "implicit",
             "iterations", "refactor");
    printf("%5lld %9.2f %9.2f %11.3g %9d %11.2f %9.2f\n", (long long)model->rank, step.time.minimum,
           step.time.median, step.dt, (int)step.implicit_modes, step.iterations,
           step.factorisations);
  }
  cJSON *row = cJSON_CreateObject();
  cli_json_number(row, "rank", (double)model->rank);
  cli_json_number(row, "us_per_step", step.time.minimum);
  cli_json_number(row, "us_per_step_median", step.time.median);
  cli_json_number(row, "h", step.dt);
  cli_json_number(row, "implicit_modes", step.implicit_modes);
  cli_json_number(row, "mean_iterations", step.iterations);
  cli_json_number(row, "mean_factorisations", step.factorisations);
  cli_json_number(row, "steps", (double)step.steps_measured);
  cli_json_string(row, "kernel", thrum_kernel_name(thrum_kernel_chosen(request->kernel)));
  cJSON_AddItemToArray(rows, row);
  return THRUM_OK;
}

int bench_step_command(int argc, char **argv) {
  static const char *const curves[] = {"us_per_step", "us_per_step_median", NULL};
  bench_request request;
  const int code = bench_options_read("bench step", argc, argv, &request);
  return code != CLI_DONE || request.help ? code : bench_each_model(&request, run, curves);
}
