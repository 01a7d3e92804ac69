/* Time, steps and bodies of a scene. SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

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

scene_body *scene_body_at(const thrum_scene *scene, int32_t body, thrum_error *error) {
  if (scene != NULL && body >= 0 && body < scene->body_count)
    return scene->bodies[body];
  thrum_error_set(error, THRUM_INVALID_ARGUMENT, "there is no body %d: the scene has %d", (int)body,
                  scene != NULL ? (int)scene->body_count : 0);
  return NULL;
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
