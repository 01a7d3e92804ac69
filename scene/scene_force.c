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
  for (int64_t n = 0; thrum_contact_touch(body->touch->contact, n, &touch, NULL) >= 0; n++)
    if (from < 0 || touch.obstacle == from)
      add(scene, 1.0, touch.force, touch.impulse, force);
}

/* Of bodies and solids, each on both of its sides; what a body does to itself adds up to nothing.
 */
static void add_others(const thrum_scene *scene, int32_t body, int32_t from, double force[3]) {
  thrum_pair_touch touch;
  for (int64_t n = 0; thrum_scene_collision(scene, n, &touch, NULL) >= 0; n++)
    for (int side = 0; side < 2; side++)
      if (touch.bodies[side] == body && (from < 0 || touch.bodies[1 - side] == from))
        add(scene, side == 0 ? 1.0 : -1.0, touch.force, touch.impulse, force);
}

/* Is there such a body, solid or obstacle? */
static bool is_known(const thrum_scene *scene, int32_t from) {
  if (from == THRUM_SCENE_ANYTHING)
    return true;
  if (from >= THRUM_SCENE_OBSTACLE)
    return from - THRUM_SCENE_OBSTACLE < thrum_scene_obstacle_count(scene);
  if (from >= THRUM_SCENE_SOLID)
    return from - THRUM_SCENE_SOLID < thrum_scene_solid_count(scene);
  return from >= 0 && from < thrum_scene_body_count(scene);
}

thrum_status thrum_scene_contact_force(const thrum_scene *scene, int32_t number, int32_t from,
                                       double force[3], thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  if (!is_known(scene, from))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%d is the number of no body, solid or obstacle of the scene",
                           (int)from);

  // the two kinds of touches
  double sum[3] = {0.0, 0.0, 0.0};
  if (from < 0 || from >= THRUM_SCENE_OBSTACLE)
    add_obstacles(scene, body, from < 0 ? from : from - THRUM_SCENE_OBSTACLE, sum);
  if (from < THRUM_SCENE_OBSTACLE)
    add_others(scene, number, from, sum);
  memcpy(force, sum, sizeof sum);
  return THRUM_OK;
}
