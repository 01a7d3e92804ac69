/* Loads as they act on the coordinates of a body: what is reduced once, where there is a whole
 * mesh, can be added where there is none. SPDX-License-Identifier: Apache-2.0 */

#include "scene/scene_reduced_load.h"

#include "scene/scene_access.h"

#include "core/base/finite.h"

#include <string.h>

thrum_status scene_reduced_check(const scene_body *body, const thrum_scene_load_def *load,
                                 thrum_error *error) {
  const int64_t r = body->model->rank;
  if (load->reduced == NULL || (body->free && load->parts == NULL))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a reduced load of body '%s' has no array %s", body->name,
                           load->reduced == NULL ? "reduced" : "parts, which free bodies need");
  if (load->rank != r)
    return thrum_error_set_field(error, "reduced", THRUM_MODEL_MISMATCH,
                                 " has %lld numbers, and body '%s' %lld coordinates",
                                 (long long)load->rank, body->name, (long long)r);
  if (thrum_all_finite(load->reduced, r) && (!body->free || thrum_all_finite(load->parts, 9 * r)))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_BAD_VALUE, "a reduced load of body '%s' is not finite",
                         body->name);
}

int64_t thrum_scene_load_count(const thrum_scene *scene, int32_t number) {
  scene_body *body = NULL;
  return scene_body_at(scene, number, &body, NULL) >= 0 ? body->load_count - 1
                                                        : 0; // the first is gravity
}

thrum_status thrum_scene_load_get(const thrum_scene *scene, int32_t number, int64_t index,
                                  thrum_scene_load_def *load, thrum_error *error) {
  // the first load of a body is its weight, which is not counted here
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  if (index < 0 || index >= body->load_count - 1)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "body '%s' has no load %lld", body->name,
                           (long long)index);

  const int64_t r = body->model->rank, place = index + 1;
  *load = thrum_default_scene_load_def();
  load->kind = THRUM_SCENE_REDUCED;
  load->course = body->courses[place];
  load->reduced = body->directions + place * r;
  load->rank = r;

  // a free body turns, so its loads come with their parts along its axes
  if (!body->free)
    return THRUM_OK;
  load->parts = body->parts + 9 * place * r;
  memcpy(load->moments, body->moments + 9 * place, sizeof load->moments);
  memcpy(load->resultant, body->resultants + 3 * place, sizeof load->resultant);
  return THRUM_OK;
}
