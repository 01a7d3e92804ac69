/* The bodies of `thrum experiments`: models by name or file, and how they are pushed.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "app/experiments.h"
#include "io/paths.h"

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

thrum_status experiments_body_load(const experiments_request *request, int64_t n,
                                   experiments_bodies *bodies, thrum_error *error) {
  const thrum_model *model = NULL;
  THRUM_TRY(named_model_load_thesis(request->models[n], request->quiet, &model, error));

  // a model that is there has its body, and the caller frees both
  const thrum_status status = make_body(request->models[n], model, &bodies->bodies[n], error);
  if (status < 0)
    thrum_model_destroy(model);
  else
    bodies->models[n] = model;
  return status;
}

void experiments_bodies_free(experiments_bodies *bodies) {
  for (int64_t n = 0; bodies != NULL && n < EXPERIMENTS_MODELS_MAX; n++) {
    if (bodies->models[n] != NULL)
      experiment_body_free(&bodies->bodies[n]);
    thrum_model_destroy(bodies->models[n]);
  }
  free(bodies);
}
