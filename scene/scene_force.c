/* The force of contact on a body in the last step: by everything, or by one of what it touches.
 *
 * Cost: one pass over the touches. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_access.h"

#include <string.h>

/* Adds a force, and an impulse as its mean over the step. */
static void add(const thrum_scene *scene, double sign, const double of[3], const double impulse[3],
                double force[3]) {
  for (int axis = 0; axis < 3; axis++)
    force[axis] += sign * (of[axis] + impulse[axis] / scene->dt);
}

/* Of planes, spheres and rooms; `from` is the number of one, or below 0 all of them. */
static void add_obstacles(const thrum_scene *scene, const scene_body *body, int32_t from,
                          double force[3]) {
  thrum_touch touch;
  if (body->touch == NULL)
    return;
  for (int64_t n = 0; thrum_contact_touch_get(body->touch->contact, n, &touch, NULL) >= 0; n++)
    if (from < 0 || touch.obstacle == from)
      add(scene, 1.0, touch.force, touch.impulse, force);
}

/* Of bodies and solids, each on both of its sides; what a body does to itself adds up to nothing.
 */
static void add_others(const thrum_scene *scene, int32_t body, thrum_scene_thing from,
                       double force[3]) {
  thrum_pair_touch touch;
  for (int64_t n = 0; thrum_scene_collision_get(scene, n, &touch, NULL) >= 0; n++)
    for (int side = 0; side < 2; side++) {
      const thrum_scene_thing other = thrum_scene_thing_of(touch.bodies[1 - side]);
      const bool is_from = other.kind == from.kind && other.number == from.number;
      if (touch.bodies[side] == body && (from.kind == THRUM_SCENE_ANYTHING || is_from))
        add(scene, side == 0 ? 1.0 : -1.0, touch.force, touch.impulse, force);
    }
}

/* How many things of a kind there are; below 0: that is no kind of one. */
static int32_t count_of(const thrum_scene *scene, thrum_scene_kind kind) {
  switch (kind) {
  case THRUM_SCENE_BODY:
    return thrum_scene_body_count(scene);
  case THRUM_SCENE_SOLID:
    return thrum_scene_solid_count(scene);
  case THRUM_SCENE_OBSTACLE:
    return thrum_scene_obstacle_count(scene);
  default:
    return -1;
  }
}

thrum_scene_thing thrum_scene_thing_of(int32_t number) {
  return number < SOLID_MEMBERS ? (thrum_scene_thing){THRUM_SCENE_BODY, number}
                                : (thrum_scene_thing){THRUM_SCENE_SOLID, number - SOLID_MEMBERS};
}

thrum_status thrum_scene_contact_force(const thrum_scene *scene, int32_t number,
                                       thrum_scene_thing from, double force[3],
                                       thrum_error *error) {
  const bool any = from.kind == THRUM_SCENE_ANYTHING;
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  if (!any && (from.number < 0 || from.number >= count_of(scene, from.kind)))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%d is the number of no body, solid or obstacle of the scene",
                           (int)from.number);

  // the two kinds of touches
  double sum[3] = {0.0, 0.0, 0.0};
  if (any || from.kind == THRUM_SCENE_OBSTACLE)
    add_obstacles(scene, body, any ? -1 : from.number, sum);
  if (from.kind != THRUM_SCENE_OBSTACLE)
    add_others(scene, number, from, sum);
  memcpy(force, sum, sizeof sum);
  return THRUM_OK;
}
