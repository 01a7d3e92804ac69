/* How free bodies move and turn as a whole (thrum/rigid_frame.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_free_body.h"

#include "scene/scene_placement.h"

#include "core/base/finite.h"
#include "core/base/vec3.h"

#include <string.h>

#define WAY_MAX 1e100 /* how far a body goes [m] and how fast [m/s]: distances stay finite */

void scene_free_place(scene_body *body) {
  body->here = thrum_placement_now(&body->placement, &body->rigid_frame, body->way.position);
}

static thrum_status fail_beyond(thrum_error *error) {
  return thrum_error_set(error, THRUM_NOT_FINITE,
                         "the step would take the body beyond the range of finite numbers");
}

thrum_status scene_free_move(scene_body *body, const double force[3], double dt,
                             thrum_error *error) {
  thrum_translation way = body->way;
  thrum_translation_step(&way, force, dt);
  if (!thrum_all_within(way.position, 3, WAY_MAX) || !thrum_all_within(way.velocity, 3, WAY_MAX))
    return fail_beyond(error);
  body->way = way;
  return THRUM_OK;
}

thrum_status scene_free_step(scene_body *body, const scene_wrench *wrench, double dt,
                             thrum_error *error) {
  thrum_rigid_frame frame = body->rigid_frame;
  thrum_rigid_frame_step(&frame, &body->placement, wrench->torque, dt, NULL);
  if (!thrum_all_finite(frame.attitude, 9) || !thrum_all_finite(frame.momentum, 3))
    return fail_beyond(error);
  THRUM_TRY(scene_free_move(body, wrench->force, dt, error));
  body->rigid_frame = frame;
  scene_free_place(body);
  return THRUM_OK;
}

void scene_free_centre(const scene_body *body, double centre[3]) {
  scene_to_world(&body->here, body->rigid_frame.centre, centre);
  for (int axis = 0; axis < 3; axis++)
    centre[axis] += body->here.origin[axis];
}

void scene_free_velocity(const scene_body *body, const double arm[3], double velocity[3]) {
  double spin[3];
  thrum_rigid_frame_velocity(&body->rigid_frame, &body->placement, spin);
  thrum_cross3(spin, arm, velocity);
  for (int axis = 0; axis < 3; axis++)
    velocity[axis] += body->way.velocity[axis];
}
