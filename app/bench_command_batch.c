/* `thrum bench batch`. SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "app/bench_command.h"
#include "app/bench_speed.h"
#include "config/message.h"
#include "io/json.h"

static const char head[] =
    " rank  bodies  alone us    median   many us    median     h [s]  implicit  "
    "iterations  real time  bits";
static const report_line lines[] = {
    REPORT_LINE("", "{rank:5.0f} {bodies:7.0f} {us_per_step_alone:9.2f} "
                    "{us_per_step_alone_median:9.2f} {us_per_step:9.2f} {us_per_step_median:9.2f} "
                    "{h:9.3g} {implicit_modes:9.0f} {mean_iterations:11.2f} "
                    "{bodies_in_real_time:10.0f} {same_bits? same|DIFFER}"),
    {0},
};

static thrum_status run(const bench_request *request, const thrum_model *model, cJSON *rows,
                        thrum_error *error) {
  // the measurement, with the options of the command
  bench_batch batch = {.step = request->step, .bodies = request->bodies};
  batch.step.def.kernel = request->kernel;
  batch.step.batches = request->batches;
  THRUM_TRY(bench_batch_run(model, &batch, error));

  // how many bodies one core steps in real time
  const double real_time = 1e6 * batch.step.dt / batch.together.minimum;

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
  bench_row_print(request, rows, head, 0, lines);
  return THRUM_OK;
}

int bench_batch_command(int argc, char **argv) {
  static const char *const curves[] = {"us_per_step", "us_per_step_alone", NULL};
  bench_request request;
  CONFIG_TRY(bench_options_read(&command_bench_batch, argc, argv, &request));
  return bench_each_model(&request, run, curves);
}
