/* `thrum simulate`: reads the options and hands them to the run of a model or of a scene.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "app/cmd.h"
#include "config/message.h"
#include "driver/scene_options.h"
#include "driver/scene_spec.h"
#include "driver/simulate_run.h"

int cmd_simulate(int argc, char **argv) {
  // there are no more loads and starts than arguments, and items of an options file
  const size_t most = (size_t)argc + CONFIG_FILE_ITEMS_MAX;
  simulate_request request = {.loads = calloc(most, sizeof *request.loads),
                              .starts = calloc(most, sizeof *request.starts),
                              .base_motions = calloc(most, sizeof *request.base_motions)};
  int code = COMMAND_DONE;
  if (request.loads == NULL || request.starts == NULL || request.base_motions == NULL) {
    const thrum_error error = {THRUM_OUT_OF_MEMORY, ""};
    code = config_refuse(&error);
  } else {
    code = simulate_options_read(argc, argv, &request);
  }

  // a name that ends in .json is a scene, which has few options of its own
  const bool ready = code == COMMAND_DONE;
  if (ready && scene_spec_is_named(request.model_path))
    code = scene_run_command(argc, argv);
  else if (ready)
    code = simulate_run_request(&request);

  free(request.loads);
  free(request.starts);
  for (int64_t n = 0; n < request.base_motion_count; n++)
    base_motion_close(&request.base_motions[n]);
  free(request.base_motions);
  config_file_free(&request.file);
  return code;
}
