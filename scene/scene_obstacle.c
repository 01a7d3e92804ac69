/* Obstacles of a scene: what bodies touch (thrum/contact.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_obstacle.h"

#include "scene/scene_contact.h"
#include "scene/scene_fields.h"
#include "scene/scene_memory.h"

#include <string.h>

/* Copies an obstacle without what the caller's memory has between its members: snapshots hold it.
 */
static void put(thrum_obstacle *to, const thrum_obstacle *from) {
  memset(to, 0, sizeof *to);
  to->cookie = from->cookie;
#define COPY(where, kind, name, ...) memcpy(&to->name, &from->name, sizeof to->name);
  THRUM_OBSTACLE_FIELDS(COPY)
#undef COPY
}

/* Makes the contacts that bodies have not got yet; all of them or none. */
static thrum_status make_contacts(thrum_scene *scene, thrum_error *error) {
  thrum_status status = THRUM_OK;
  int32_t made = 0;
  for (; made < scene->body_count && status >= 0; made++) {
    scene_body *body = scene->bodies[made];
    body->touch_next = NULL;
    if (body->touch_count > 0 && (body->touch == NULL || body->touch->idle))
      status = scene_touch_make(scene, body, body->derived, body->state, &body->touch_next, error);
  }

  // all were made, or none is kept
  for (int32_t n = 0; n < made; n++) {
    scene_body *body = scene->bodies[n];
    if (status < 0) {
      scene_touch_free(body->touch_next);
    } else if (body->touch_next != NULL) {
      scene_touch_free(body->touch);
      body->touch = body->touch_next;
    }
    body->touch_next = NULL;
  }
  return status;
}

thrum_status thrum_scene_add_obstacle(thrum_scene *scene, const thrum_obstacle *obstacle,
                                      int32_t *number, thrum_error *error) {
  THRUM_TRY(scene_fields_check(THRUM_SCENE_RECORD_OBSTACLE, obstacle, error));
  THRUM_TRY(thrum_obstacle_check(obstacle, scene->obstacle_count, error));
  const int64_t count = scene->obstacle_count + 1;
  if (!scene_grow(&scene->obstacles, count, sizeof *scene->obstacles) ||
      !scene_grow(&scene->obstacle_starts, count, sizeof *scene->obstacle_starts))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for an obstacle");

  // bodies that could touch nothing before need a contact now
  put(&scene->obstacles[scene->obstacle_count], obstacle);
  put(&scene->obstacle_starts[scene->obstacle_count], obstacle);
  scene->obstacle_count++;
  thrum_status status = make_contacts(scene, error);
  if (status < 0) {
    scene->obstacle_count--;
    return status;
  }
  scene->revision++;
  scene->stirred++;
  if (number != NULL)
    *number = scene->obstacle_count - 1;
  return THRUM_OK;
}

int32_t thrum_scene_obstacle_count(const thrum_scene *scene) {
  return scene->obstacle_count;
}

static thrum_status check_number(const thrum_scene *scene, int32_t number, thrum_error *error) {
  if (number >= 0 && number < scene->obstacle_count)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "there is no obstacle %d: the scene has %d",
                         (int)number, (int)scene->obstacle_count);
}

thrum_status thrum_scene_obstacle_get(const thrum_scene *scene, int32_t number,
                                      thrum_obstacle *obstacle, thrum_error *error) {
  THRUM_TRY(check_number(scene, number, error));
  *obstacle = scene->obstacles[number];
  return THRUM_OK;
}

thrum_status thrum_scene_set_obstacle(thrum_scene *scene, int32_t number,
                                      const thrum_obstacle *obstacle, thrum_error *error) {
  THRUM_TRY(check_number(scene, number, error));
  THRUM_TRY(scene_fields_check(THRUM_SCENE_RECORD_OBSTACLE, obstacle, error));
  THRUM_TRY(thrum_obstacle_check(obstacle, number, error));
  put(&scene->obstacles[number], obstacle);
  put(&scene->obstacle_starts[number], obstacle);
  scene->stirred++;
  return THRUM_OK;
}

void scene_obstacles_move(thrum_scene *scene) {
  for (int32_t n = 0; n < scene->obstacle_count; n++)
    for (int axis = 0; axis < 3; axis++)
      scene->obstacles[n].centre[axis] += scene->dt * scene->obstacles[n].velocity[axis];
}

void scene_obstacles_reset(thrum_scene *scene) {
  if (scene->obstacle_count > 0)
    memcpy(scene->obstacles, scene->obstacle_starts,
           (size_t)scene->obstacle_count * sizeof *scene->obstacles);
}
