/* `thrum precompute`: from a tetrahedral mesh to a model file. The work is done in precompute/;
 * here it is asked for and shown. SPDX-License-Identifier: Apache-2.0 */
#include "app/cmd.h"
#include "app/mpi_program.h"
#include "config/message.h"
#include "driver/make/named_model.h"
#include "driver/make/precompute_cubic.h"
#include "driver/make/precompute_make.h"
#include "driver/make/precompute_report.h"
#include "driver/make/precompute_request.h"
#include "driver/make/precompute_train.h"
#include "platform/allocate.h"
#include "platform/interrupt.h"

/* Conjugate gradients take less memory than the factor that did not fit. */
static thrum_status go_on_elsewhere(char *const *argv, thrum_error *error) {
  config_warn("the factor does not fit into the memory: thrum-mpi goes on, which has conjugate "
              "gradients as well");
  return mpi_program_become(argv, error);
}

static int run_request(precompute_request *request, char *const *argv) {
  thrum_error error = {0};
  model_recipe recipe;
  bool flagged = false;

  // the name of one of our models stands for its mesh, with what its recipe says as the defaults
  thrum_status status = model_recipe_find(request->mesh_name, &recipe, &error);
  if (status >= 0 && recipe.found)
    model_recipe_apply(&recipe, request);
  if (request->keep_runs != NULL)
    thrum_interrupt_clean("\nthrum: stopped; no model was written, and the same command goes on "
                          "with the runs that are kept\n");

  if (status >= 0 && precompute_cubic_is_named(request->mesh_name)) {
    status = precompute_cubic_make(request, &error);
  } else if (status >= 0) {
    status = precompute_make(request, precompute_print_report, &flagged, &error);
  }
  if (status == THRUM_OUT_OF_MEMORY && request->elsewhere)
    status = go_on_elsewhere(argv, &error);
  return config_end(status, flagged, &error);
}

/* The solver decides which program makes the model: this one, alone or as one of several processes,
 * or thrum-mpi in its place. */
static int run_where_it_can(precompute_request *request, char *const *argv) {
  const bool several = request->options.shared != NULL;
  const char *alone = precompute_request_alone(request);
  const thrum_solver solver = request->options.solver;
  thrum_error error = {0};
  if (alone != NULL && (several || solver == THRUM_SOLVER_CG))
    return config_end(thrum_error_set(&error, THRUM_UNSUPPORTED,
                                      "%s is of thrum precompute with a factor: leave thrum-mpi or "
                                      "--solver cg out",
                                      alone),
                      false, &error);

  // what was asked for is over there, or it may be there once it is known what the factor takes
  if (!several && solver == THRUM_SOLVER_CG)
    return config_end(mpi_program_become(argv, &error), false, &error);
  request->elsewhere =
      !several && alone == NULL && solver == THRUM_SOLVER_AUTO && mpi_program_exists();
  return run_request(request, argv);
}

int cmd_precompute_shared(int argc, char **argv, const thrum_precompute_shared *shared) {
  precompute_request request = {0};
  thrum_error error = {0};
  thrum_scope scope = thrum_scope_begin("the options", &error);

  // no more than arguments and items of a file, and of --fix than a recipe holds besides
  const int64_t room = argc + CONFIG_FILE_ITEMS_MAX;
  request.fixes =
      thrum_scope_allocate(&scope, room + MODEL_RECIPE_FIXES_MAX, sizeof *request.fixes);
  request.springs = thrum_scope_allocate(&scope, room, sizeof *request.springs);
  request.actuators = thrum_scope_allocate(&scope, room, sizeof *request.actuators);
  request.handles = thrum_scope_allocate(&scope, room, sizeof *request.handles);
  request.train = thrum_scope_allocate(&scope, room, sizeof *request.train);
  request.tests = thrum_scope_allocate(&scope, room, sizeof *request.tests);
  request.materials = thrum_scope_allocate(&scope, room, sizeof *request.materials);

  int code =
      scope.status < 0 ? config_refuse(&error) : precompute_options_read(argc, argv, &request);
  request.options.shared = shared;
  if (code == COMMAND_DONE && request.jobs.list)
    code = config_end(precompute_train_print(&request, argv, &error), false, &error);
  else if (code == COMMAND_DONE)
    code = run_where_it_can(&request, argv);
  thrum_scope_free(&scope);
  config_file_free(&request.file);
  return code;
}

int cmd_precompute(int argc, char **argv) {
  return cmd_precompute_shared(argc, argv, NULL);
}
