/* `thrum simulate`: reads the options and hands them to the run of a model or of a scene.
 * SPDX-License-Identifier: Apache-2.0 */
#include "app/cmd.h"
#include "app/mpi_program.h"
#include "config/message.h"
#include "driver/run/simulate_run.h"
#include "driver/scene/scene_options.h"
#include "driver/spec/model_names.h"
#include "platform/allocate.h"

int cmd_simulate_shared(int argc, char **argv, const thrum_full_shared *shared,
                        const thrum_precompute_shared *precompute) {
  // there are no more loads and starts than arguments, and items of an options file
  const int64_t most = argc + CONFIG_FILE_ITEMS_MAX;
  thrum_error error = {0};
  thrum_scope scope = thrum_scope_begin("the options", &error);
  simulate_request request = {
      .loads = thrum_scope_allocate(&scope, most, sizeof *request.loads),
      .actuates = thrum_scope_allocate(&scope, most, sizeof *request.actuates),
      .starts = thrum_scope_allocate(&scope, most, sizeof *request.starts),
      .probes = thrum_scope_allocate(&scope, most, sizeof *request.probes),
      .base_motions = thrum_scope_allocate(&scope, most, sizeof *request.base_motions),
      .shared = shared};
  int code = scope.status < 0 ? config_refuse(&error) : simulate_options_read(argc, argv, &request);
  if (code == COMMAND_DONE && shared != NULL && !request.full)
    code = mpi_program_wants_full("simulate");
  request.mesh_def.shared = precompute;

  // a name that ends in .json is a scene, which has few options of its own
  const bool ready = code == COMMAND_DONE;
  if (ready && is_scene_name(request.model_path))
    code = scene_run_command(argc, argv);
  else if (ready)
    code = simulate_run_request(&request);

  for (int64_t n = 0; n < request.base_motion_count; n++)
    base_motion_close(&request.base_motions[n]);
  thrum_scope_free(&scope);
  config_file_free(&request.file);
  return code;
}

int cmd_simulate(int argc, char **argv) {
  return cmd_simulate_shared(argc, argv, NULL, NULL);
}
