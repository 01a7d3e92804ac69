/* Time, steps and bodies of a scene. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_access.h"

#include <string.h>

double thrum_scene_time(const thrum_scene *scene) {
  return scene->origin + (double)(scene->steps - scene->origin_step) * scene->dt;
}

int64_t thrum_scene_steps(const thrum_scene *scene) {
  return scene->steps;
}

double thrum_scene_dt(const thrum_scene *scene) {
  return scene->dt;
}

thrum_status scene_body_at(const thrum_scene *scene, int32_t number, scene_body **body,
                           thrum_error *error) {
  if (scene == NULL || number < 0 || number >= scene->body_count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "there is no body %d: the scene has %d",
                           (int)number, scene != NULL ? (int)scene->body_count : 0);
  *body = scene->bodies[number];
  return THRUM_OK;
}

thrum_status scene_vertex_check(const scene_body *body, int64_t vertex, thrum_error *error) {
  const thrum_model *model = body->model;
  if (!model->basis || !model->vertices)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model of body '%s' has no basis, so no point of it can be followed "
                           "or pulled",
                           body->name);
  if (vertex < 0 || vertex >= model->vertex_count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "vertex %lld of body '%s': there are %lld", (long long)vertex,
                           body->name, (long long)model->vertex_count);
  return THRUM_OK;
}

int32_t thrum_scene_body_count(const thrum_scene *scene) {
  return scene->body_count;
}

int32_t thrum_scene_find_body(const thrum_scene *scene, const char *name) {
  for (int32_t n = 0; n < scene->body_count; n++)
    if (strcmp(scene->bodies[n]->name, name) == 0)
      return n;
  return -1;
}
