/* The moving ground under all bodies (thrum/base_motion.h, design 12).
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_base_motion.h"

#include "scene/scene_loads.h"
#include "scene/scene_memory.h"

#include "core/base/finite.h"
#include "core/base/pi.h"

#include <math.h>

#include "thrum/external_load.h"

thrum_status scene_base_motion_check(const scene_body *body, thrum_error *error) {
  if (body->model->axis_mass != NULL)
    return THRUM_OK;
  return thrum_error_set(
      error, THRUM_MISSING,
      "the model of body '%s' has no array axis_mass, which a moving base needs: "
      "precompute it from a mesh",
      body->name);
}

static thrum_status add(thrum_scene *scene, const scene_base_motion *base_motion,
                        thrum_error *error) {
  for (int32_t n = 0; n < scene->body_count; n++)
    THRUM_TRY(scene_base_motion_check(scene->bodies[n], error));
  if (!scene_grow(&scene->base_motions, scene->base_motion_count + 1, sizeof *scene->base_motions))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a base motion");
  scene->base_motions[scene->base_motion_count++] = *base_motion;
  scene->revision++;
  scene->stirred++;
  scene_loads_retime(scene);
  return THRUM_OK;
}

thrum_status thrum_scene_add_base_motion_record(thrum_scene *scene, const thrum_base_motion *motion,
                                                thrum_error *error) {
  THRUM_TRY(thrum_base_motion_check(motion, error));
  if (motion->velocities == NULL || motion->positions == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "the velocities and positions of the ground are "
                           "not known: see thrum_base_motion_integrate");
  if (!thrum_all_within(motion->velocities, 3 * motion->count, THRUM_PLACE_MAX) ||
      !thrum_all_within(motion->positions, 3 * motion->count, THRUM_PLACE_MAX))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "the ground moves beyond 1e30 m or faster than 1e30 m/s");
  return add(scene, &(scene_base_motion){.motion = motion}, error);
}

thrum_status thrum_scene_add_base_motion(thrum_scene *scene, const double amplitude[3],
                                         const thrum_load *course, thrum_error *error) {
  if (!thrum_all_within(amplitude, 3, THRUM_PLACE_MAX) ||
      !thrum_all_within(&course->from, 1, THRUM_PLACE_MAX) || isnan(course->until) ||
      !(course->frequency == 0 ||
        (course->frequency >= 1 / THRUM_PLACE_MAX && course->frequency <= THRUM_PLACE_MAX)))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "a base motion begins within 1e30 s and has an amplitude within 1e30 "
                           "m/s^2 and a frequency of 1e-30 to 1e30 Hz, or 0");

  // the ground of a slow sine goes far
  const double omega = THRUM_TWO_PI * course->frequency;
  for (int axis = 0; axis < 3 && omega > 0; axis++)
    if (!(fabs(amplitude[axis]) <= THRUM_PLACE_MAX * omega * omega))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "a base motion of %g Hz takes the ground beyond 1e30 m",
                             course->frequency);
  const scene_base_motion base_motion = {
      .amplitude = {amplitude[0], amplitude[1], amplitude[2]}, .course = *course, .now = *course};
  return add(scene, &base_motion, error);
}

void thrum_scene_ground(const thrum_scene *scene, double position[3]) {
  const double time = thrum_scene_time(scene);
  position[0] = position[1] = position[2] = 0;
  for (int32_t n = 0; n < scene->base_motion_count; n++) {
    const scene_base_motion *base_motion = &scene->base_motions[n];
    double one[3];
    if (base_motion->motion != NULL)
      thrum_base_motion_at(base_motion->motion, time, one, NULL);
    const double share =
        base_motion->motion == NULL ? thrum_base_motion_sine(&base_motion->course, time) : 0;
    for (int axis = 0; axis < 3; axis++)
      position[axis] +=
          base_motion->motion == NULL ? share * base_motion->amplitude[axis] : one[axis];
  }
}
