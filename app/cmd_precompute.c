/* `thrum precompute`: from a tetrahedral mesh to a model file. The work is done in precompute/;
 * here it is asked for and shown. SPDX-License-Identifier: Apache-2.0 */
#include "app/cmd_precompute.h"

#include <stdlib.h>

#include "app/cmd.h"
#include "config/message.h"
#include "driver/named_model.h"
#include "driver/precompute_cubic.h"
#include "driver/precompute_make.h"
#include "driver/precompute_report.h"
#include "driver/precompute_request.h"
#include "platform/interrupt.h"

static int run_request(precompute_request *request) {
  thrum_error error = {0};
  model_recipe recipe;
  bool flagged = false;

  // the name of one of our models stands for its mesh, with what its recipe says as the defaults
  thrum_status status = model_recipe_find(request->mesh_name, &recipe, &error);
  if (status >= 0 && recipe.found)
    model_recipe_apply(&recipe, request);
  thrum_interrupt_clean("\nthrum: stopped; nothing was written\n");

  if (status >= 0 && precompute_cubic_is_named(request->mesh_name)) {
    status = precompute_cubic_make(request, &error);
  } else if (status >= 0) {
    status = precompute_make(
        request, request->json ? precompute_print_json : precompute_print_table, &flagged, &error);
  }
  if (status < 0)
    return config_refuse(&error);
  return flagged ? COMMAND_FLAGGED : COMMAND_DONE;
}

int cmd_precompute_shared(int argc, char **argv, const thrum_precompute_shared *shared) {
  precompute_request request = {0};
  // no more --fix than arguments, or than a recipe holds
  request.fixes =
      calloc((size_t)argc + CONFIG_FILE_ITEMS_MAX + MODEL_RECIPE_FIXES_MAX, sizeof *request.fixes);
  const size_t room = (size_t)argc + CONFIG_FILE_ITEMS_MAX;
  request.handles = calloc(4 * room, sizeof *request.handles);

  if (request.fixes == NULL || request.handles == NULL) {
    free(request.fixes);
    free(request.handles);
    const thrum_error error = {THRUM_OUT_OF_MEMORY, ""};
    return config_refuse(&error);
  }

  // the texts of handles, trainings, tests and materials share one allocation
  request.train = request.handles + room;
  request.materials = request.handles + 3 * room;
  request.tests = request.train + room;
  int code = precompute_options_read(argc, argv, &request);
  request.options.shared = shared;
  if (code == COMMAND_DONE)
    code = run_request(&request);
  free(request.fixes);
  free(request.handles);
  config_file_free(&request.file);
  return code;
}

int cmd_precompute(int argc, char **argv) {
  return cmd_precompute_shared(argc, argv, NULL);
}
