/* `thrum experiments`: loads the models, makes the folder, and switches to the kind of experiment
 * that was asked for. The experiments themselves are in study/. SPDX-License-Identifier: Apache-2.0
 */
#include <stdio.h>
#include <stdlib.h>

#include "app/commands.h"
#include "app/experiments.h"
#include "app/results.h"
#include "config/message.h"
#include "config/progress.h"
#include "io/folder.h"
#include "io/json.h"
#include "io/paths.h"
#include "platform/interrupt.h"

/* Where a model is pushed: what its recipe says, or for a file the group load, else tip. */
static thrum_status make_body(const char *name, const thrum_model *model, experiment_body *body,
                              thrum_error *error) {
  cli_model_recipe recipe;
  const thrum_status status = cli_model_recipe_find(name, &recipe, error);
  if (status < 0)
    return status;
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
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < request->model_count && status >= 0; n++) {
    const thrum_model *model = NULL;
    status = cli_model_load(request->models[n], request->quiet, &model, NULL, error);
    if (status < 0)
      return status;
    status = make_body(request->models[n], model, &bodies->bodies[n], error);
    if (status < 0) {
      thrum_model_free(model);
      return status;
    }
    bodies->models[bodies->count++] = model;
  }
  return status;
}

thrum_status experiments_write(const experiments_request *request, const char *name,
                               experiment_text *text, thrum_error *error) {
  return cli_results_write(request->output, name, text, error);
}

experiment_place experiments_place(const experiments_request *request) {
  static const char *const commands[] = {
      "thrum experiments", "thrum experiments --long", "thrum experiments --sweep",
      "thrum experiments --extremes", "thrum experiments --linear"};
  return cli_results_place(commands[request->kind]);
}

bool experiments_progress(void *context, double fraction) {
  config_progress_update(context, "experiments", fraction);
  return true;
}

cJSON *experiments_json(const experiments_request *request, bool flagged) {
  static const char *const kinds[] = {"matrix", "long", "sweep", "extremes", "linear"};
  cJSON *object = json_report("experiments", flagged ? "flagged" : "done");
  cJSON_AddStringToObject(object, "kind", kinds[request->kind]);
  const experiment_place place = experiments_place(request);
  json_string(object, "machine", place.machine);
  cJSON_AddStringToObject(object, "compiler", place.compiler);
  cJSON_AddStringToObject(object, "blas_core", place.blas_core);
  json_string(object, "output", request->output);
  json_number(object, "threads", (double)request->threads);
  return object;
}

void experiments_json_levels(cJSON *object, const thrum_state_report *report) {
  cJSON *fallback_levels = cJSON_AddObjectToObject(object, "fallback_levels");
  for (int n = 0; n < EXPERIMENT_LEVEL_COUNT; n++)
    json_number(fallback_levels, experiment_level_names[n], (double)experiment_level(report, n));
}

static int run_request(const experiments_request *request) {
  thrum_error error = {0};
  bool flagged = false;
  thrum_interrupt_clean("\nthrum: stopped; the folder holds whole files only\n");
  experiments_bodies *bodies = calloc(1, sizeof *bodies);
  thrum_status status = bodies == NULL
                            ? thrum_error_set(&error, THRUM_OUT_OF_MEMORY, "out of memory")
                            // a folder that cannot be used is found before hours of computing
                            : folder_make(request->output, &error);
  if (status >= 0)
    status = load_bodies(request, bodies, &error);
  if (status >= 0 && request->kind == EXPERIMENTS_MATRIX)
    status = experiments_matrix(request, bodies, &flagged, &error);
  if (status >= 0 && request->kind == EXPERIMENTS_LONG)
    status = experiments_long(request, bodies, &flagged, &error);
  if (status >= 0 && request->kind == EXPERIMENTS_SWEEP)
    status = experiments_sweep(request, bodies, &flagged, &error);
  if (status >= 0 && request->kind == EXPERIMENTS_EXTREMES)
    status = experiments_extremes(request, &flagged, &error);
  if (status >= 0 && request->kind == EXPERIMENTS_LINEAR)
    status = experiments_linear(request, bodies, &error);
  for (int64_t n = 0; bodies != NULL && n < bodies->count; n++) {
    experiment_body_free(&bodies->bodies[n]);
    thrum_model_free(bodies->models[n]);
  }
  free(bodies);
  if (status < 0)
    return config_refuse(&error);
  return flagged ? COMMAND_FLAGGED : COMMAND_DONE;
}

int cmd_experiments(int argc, char **argv) {
  experiments_request request = {0};
  int code = experiments_options_read(argc, argv, &request);
  if (code == COMMAND_DONE)
    code = run_request(&request);
  free(request.list);
  return code;
}
