/* `thrum experiments`: loads the models, makes the folder, and calls the kind of experiment that
 * was asked for. The experiments themselves are in validation/experiments/.
 * SPDX-License-Identifier: Apache-2.0
 */
#include <stdlib.h>

#include "app/cmd.h"
#include "app/experiments.h"
#include "config/message.h"
#include "io/folder.h"
#include "io/paths.h"
#include "platform/interrupt.h"

/* The body of a model: a named model is pushed as its recipe says, a model file at its group
 * `load`, or else at `tip`, along its softest axis. */
static thrum_status make_body(const char *name, const thrum_model *model, experiment_body *body,
                              thrum_error *error) {
  model_recipe recipe;
  THRUM_TRY(model_recipe_find(name, &recipe, error));
  if (recipe.found)
    return experiment_body_init(name, model, recipe.load_group, recipe.load_direction, body, error);

  static const double softest[3] = {0, 0, 0};
  const int32_t *vertices = NULL;
  int64_t count = 0;
  const bool tip = thrum_model_group(model, "load", &vertices, &count, NULL) < 0;
  return experiment_body_init(path_basename(name), model, tip ? "tip" : "load", softest, body,
                              error);
}

static thrum_status load_bodies(const experiments_request *request, experiments_bodies *bodies,
                                thrum_error *error) {
  for (int64_t n = 0; n < request->model_count; n++) {
    const thrum_model *model = NULL;
    THRUM_TRY(named_model_load(request->models[n], request->quiet, &model, NULL, error));

    // `count` says how many pairs of a model and its body the caller has to free
    const thrum_status status =
        make_body(request->models[n], model, &bodies->bodies[bodies->count], error);
    if (status < 0) {
      thrum_model_free(model);
      return status;
    }
    bodies->models[bodies->count++] = model;
  }
  return THRUM_OK;
}

static thrum_status run_kind(const experiments_request *request, const experiments_bodies *bodies,
                             bool *flagged, thrum_error *error) {
  switch (request->kind) {
  case EXPERIMENTS_LONG:
    return experiments_long(request, bodies, flagged, error);

  // these three differ in their plan only
  case EXPERIMENTS_SWEEP:
  case EXPERIMENTS_WORK_PRECISION:
  case EXPERIMENTS_VARIABLE:
    return experiments_sweep(request, bodies, flagged, error);
  case EXPERIMENTS_EXTREMES:
    return experiments_extremes(request, flagged, error);
  case EXPERIMENTS_LINEAR:
    return experiments_linear(request, bodies, error);

  case EXPERIMENTS_MATRIX:
  case EXPERIMENTS_STEP_SIZES:
  default:
    return experiments_matrix(request, bodies, flagged, error);
  }
}

static int run_request(const experiments_request *request) {
  thrum_error error = {0};
  bool flagged = false;
  thrum_interrupt_clean("\nthrum: stopped; the folder holds whole files only\n");
  experiments_bodies *bodies = calloc(1, sizeof *bodies);
  if (bodies == NULL) {
    thrum_error_set(&error, THRUM_OUT_OF_MEMORY, "out of memory");
    return config_refuse(&error);
  }

  // a folder that cannot be used is found before hours of computing
  thrum_status status = folder_make(request->output, &error);
  THRUM_THEN(status, load_bodies(request, bodies, &error));
  THRUM_THEN(status, run_kind(request, bodies, &flagged, &error));

  for (int64_t n = 0; n < bodies->count; n++) {
    experiment_body_free(&bodies->bodies[n]);
    thrum_model_free(bodies->models[n]);
  }
  free(bodies);
  return config_end(status, flagged, &error);
}

int cmd_experiments(int argc, char **argv) {
  experiments_request request = {0};
  int code = experiments_options_read(argc, argv, &request);
  if (code == COMMAND_DONE)
    code = run_request(&request);
  free(request.list);
  return code;
}
