/* `thrum bench batch`. SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "app/bench_command.h"
#include "app/bench_speed.h"
#include "config/message.h"
#include "io/json.h"

static thrum_status run(const bench_request *request, const thrum_model *model, cJSON *rows,
                        thrum_error *error) {
  // the measurement, with the options of the command
  bench_batch batch = {.step = request->step, .bodies = request->bodies};
  batch.step.def.kernel = request->kernel;
  batch.step.batches = request->batches;
  THRUM_TRY(bench_batch_run(model, &batch, error));

  // how many bodies one core steps in real time
  const double real_time = 1e6 * batch.step.dt / batch.together.minimum;

  // a line of the table, whose head comes with the first row
  if (!request->json) {
    if (cJSON_GetArraySize(rows) == 0)
      printf("%5s %7s %9s %9s %9s %9s %9s %9s %11s %10s %5s\n", "rank", "bodies", "alone us",
             "median", "many us", "median", "h [s]", "implicit", "iterations", "real time", "bits");
    printf("%5lld %7lld %9.2f %9.2f %9.2f %9.2f %9.3g %9d %11.2f %10.0f %5s\n",
           (long long)model->rank, (long long)batch.bodies, batch.alone.minimum, batch.alone.median,
           batch.together.minimum, batch.together.median, batch.step.dt, (int)batch.implicit_modes,
           batch.iterations, real_time, batch.same_bits ? "same" : "DIFFER");
  }

  // the same as JSON
  cJSON *row = json_add_row(rows);
  json_number(row, "rank", (double)model->rank);
  json_number(row, "bodies", (double)batch.bodies);
  bench_row_time(row, "us_per_step", &batch.together);
  bench_row_time(row, "us_per_step_alone", &batch.alone);
  json_number(row, "h", batch.step.dt);
  json_number(row, "implicit_modes", batch.implicit_modes);
  json_number(row, "mean_iterations", batch.iterations);
  json_number(row, "bodies_in_real_time", real_time);
  json_number(row, "state_bytes", batch.state_bytes);
  json_number(row, "workspace_bytes", batch.workspace_bytes);
  cJSON_AddBoolToObject(row, "same_bits", batch.same_bits);
  json_string(row, "kernel", thrum_kernel_name(thrum_kernel_chosen(request->kernel)));
  return THRUM_OK;
}

int bench_batch_command(int argc, char **argv) {
  static const char *const curves[] = {"us_per_step", "us_per_step_alone", NULL};
  bench_request request;
  CONFIG_TRY(bench_options_read(&command_bench_batch, argc, argv, &request));
  return bench_each_model(&request, run, curves);
}
