/* `thrum bench accelerator`. SPDX-License-Identifier: Apache-2.0 */
#include "app/bench_command.h"
#include "app/bench_speed.h"
#include "bench/measure_accelerator.h"
#include "config/message.h"
#include "io/json.h"

static const report_line device[] = {
    REPORT_LINE("", "{device} ({platform}), {compute_units:.0f} compute units, "
                    "{single?single|single and double} precision[; single-precision peak "
                    "{device_peak_gflops:.1f} GFLOP/s]"),
    {0},
};
static const char head[] =
    " rank  bodies      h [s]   body-steps/s    GFLOP/s    of peak   steps      error";
static const report_line lines[] = {
    REPORT_LINE("", "{rank:5.0f} {bodies:7.0f} {h:10.3g} {body_steps_per_second:14.4g} "
                    "{gflops:10.2f} {share_of_peak:8.1f%} {steps:7.0f} {error:10.1e}"),
    {0},
};

/* Names the device of a row. */
static void add_device(cJSON *row, const thrum_accelerator_info *info) {
  json_string(row, "device", info->name);
  json_string(row, "platform", info->platform);
  json_number(row, "compute_units", info->units);
  cJSON_AddBoolToObject(row, "single", info->single);
}

/* Prints the last row, behind the device where it is the first. */
static void print_row(const bench_request *request, const cJSON *rows, const char *columns,
                      const report_line *of) {
  if (!request->json && cJSON_GetArraySize(rows) == 1)
    report_print(cJSON_GetArrayItem(rows, 0), NULL, 0, device);
  bench_row_print(request, rows, columns, 0, of);
}

static const char mesh_head[] = "vertices     tets      h [s]  ms a step  one core ms     Newton  "
                                "gradients   steps      error";
static const report_line mesh_lines[] = {
    REPORT_LINE("", "{vertices:8.0f} {tetrahedra:8.0f} {h:10.3g} {ms_per_step:10.3f} "
                    "{ms_per_step_of_one_core:12.3f} {mean_iterations:10.2f} "
                    "{mean_solver_iterations:10.1f} {steps:7.0f} {error:10.1e}"),
    {0},
};

static thrum_status run_mesh(const bench_request *request, const thrum_model *model, cJSON *rows,
                             thrum_error *error) {
  bench_mesh_body bench = {
      .step = request->step, .device = (int32_t)request->device, .single = request->single};
  bench.step.batches = request->batches;
  THRUM_TRY(bench_mesh_body_run(model, &bench, error));

  cJSON *row = json_add_row(rows);
  json_number(row, "vertices", (double)bench.vertices);
  json_number(row, "tetrahedra", (double)bench.tets);
  json_number(row, "h", bench.step.def.dt);
  json_number(row, "ms_per_step", bench.ms);
  json_number(row, "ms_per_step_of_one_core", bench.ms_here);
  json_number(row, "mean_iterations", bench.iterations);
  json_number(row, "mean_solver_iterations", bench.solver_iterations);
  json_number(row, "steps", (double)bench.steps);
  json_number(row, "error", bench.error);
  add_device(row, &bench.info);
  print_row(request, rows, mesh_head, mesh_lines);
  return THRUM_OK;
}

static thrum_status run(const bench_request *request, const thrum_model *model, cJSON *rows,
                        thrum_error *error) {
  bench_accelerator bench = {.step = request->step,
                             .bodies = request->bodies,
                             .device = (int32_t)request->device,
                             .single = request->single};
  bench.step.batches = request->batches;
  THRUM_TRY(bench_accelerator_run(model, &bench, error));

  cJSON *row = json_add_row(rows);
  json_number(row, "rank", (double)model->rank);
  json_number(row, "bodies", (double)bench.bodies);
  json_number(row, "h", bench.step.def.dt);
  json_number(row, "body_steps_per_second", bench.body_steps);
  json_number(row, "us_per_step", 1e6 / bench.body_steps);
  json_number(row, "gflops", bench.gflops);
  json_number(row, "device_peak_gflops", bench.peak_gflops);
  json_number(row, "share_of_peak", bench.gflops / bench.peak_gflops);
  json_number(row, "steps", (double)bench.steps);
  json_number(row, "error", bench.error);
  add_device(row, &bench.info);
  print_row(request, rows, head, lines);
  return THRUM_OK;
}

int bench_accelerator_command(int argc, char **argv) {
  static const char *const curves[] = {"us_per_step", NULL};
  bench_request request;
  CONFIG_TRY(bench_options_read(&command_bench_accelerator, argc, argv, &request));
  if (!request.full)
    return bench_each_model(&request, run, curves);

  // the mesh of the beam is the same at each rank
  static const char *const mesh_curves[] = {"ms_per_step", "ms_per_step_of_one_core", NULL};
  request.rank_count = 1;
  return bench_each_model(&request, run_mesh, mesh_curves);
}
