/* `thrum bench accelerator`. SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "app/bench_command.h"
#include "app/bench_speed.h"
#include "bench/measure_accelerator.h"
#include "config/message.h"
#include "io/json.h"

static void print_device(const thrum_accelerator_info *info) {
  printf("%s (%s), %d compute units, %s precision", info->name, info->platform, (int)info->units,
         info->single ? "single" : "single and double");
}

static thrum_status run_mesh(const bench_request *request, const thrum_model *model, cJSON *rows,
                             thrum_error *error) {
  bench_mesh_body bench = {
      .step = request->step, .device = (int32_t)request->device, .single = request->single};
  bench.step.batches = request->batches;
  THRUM_TRY(bench_mesh_body_run(model, &bench, error));

  if (!request->json) {
    print_device(&bench.info);
    printf("\n%8s %8s %10s %10s %12s %10s %10s %7s %10s\n", "vertices", "tets", "h [s]",
           "ms a step", "one core ms", "Newton", "gradients", "steps", "error");
    printf("%8lld %8lld %10.3g %10.3f %12.3f %10.2f %10.1f %7lld %10.1e\n",
           (long long)bench.vertices, (long long)bench.tets, bench.step.def.dt, bench.ms,
           bench.ms_here, bench.iterations, bench.solver_iterations, (long long)bench.steps,
           bench.error);
  }
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
  json_string(row, "device", bench.info.name);
  json_string(row, "platform", bench.info.platform);
  cJSON_AddBoolToObject(row, "single", bench.info.single);
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

  // the device stands before the first row
  if (!request->json) {
    if (cJSON_GetArraySize(rows) == 0) {
      print_device(&bench.info);
      printf("; single-precision peak %.1f GFLOP/s\n", bench.peak_gflops);
      printf("%5s %7s %10s %14s %10s %10s %7s %10s\n", "rank", "bodies", "h [s]", "body-steps/s",
             "GFLOP/s", "of peak", "steps", "error");
    }
    printf("%5lld %7lld %10.3g %14.4g %10.2f %9.1f%% %7lld %10.1e\n", (long long)model->rank,
           (long long)bench.bodies, bench.step.def.dt, bench.body_steps, bench.gflops,
           100 * bench.gflops / bench.peak_gflops, (long long)bench.steps, bench.error);
  }

  // the same as JSON
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
  json_string(row, "device", bench.info.name);
  json_string(row, "platform", bench.info.platform);
  cJSON_AddBoolToObject(row, "single", bench.info.single);
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
