/* The ground that base motions under all bodies (thrum/base_motion.h, design 12).
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>

#include "scene/scene_private.h"
#include "thrum/external_load.h"

thrum_status scene_base_motion_check(const scene_body *body, thrum_error *error) {
  if (body->model->axis_mass != NULL)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_MISSING,
                         "the model of body '%s' has no array axis_mass, which shaking needs: "
                         "precompute it from a mesh",
                         body->name);
}

static thrum_status add(thrum_scene *scene, const scene_base_motion *base_motion,
                        thrum_error *error) {
  for (int32_t n = 0; n < scene->body_count; n++) {
    const thrum_status status = scene_base_motion_check(scene->bodies[n], error);
    if (status < 0)
      return status;
  }
  if (!scene_grow(&scene->base_motions, scene->base_motion_count + 1, sizeof *scene->base_motions))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a base motion");
  scene->base_motions[scene->base_motion_count++] = *base_motion;
  scene->revision++;
  scene_loads_retime(scene);
  return THRUM_OK;
}

thrum_status thrum_scene_add_base_motion_record(thrum_scene *scene, const thrum_base_motion *motion,
                                                thrum_error *error) {
  const thrum_status status = thrum_base_motion_check(motion, error);
  if (status < 0)
    return status;
  if (motion->velocities == NULL || motion->positions == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "the velocities and positions of the ground are "
                           "not known: see thrum_base_motion_integrate");
  return add(scene, &(scene_base_motion){.motion = motion}, error);
}

thrum_status thrum_scene_add_base_motion(thrum_scene *scene, const double amplitude[3],
                                         const thrum_load *course, thrum_error *error) {
  if (!isfinite(amplitude[0]) || !isfinite(amplitude[1]) || !isfinite(amplitude[2]) ||
      isnan(course->from) || isnan(course->until) || !isfinite(course->frequency))
    return thrum_error_set(error, THRUM_BAD_VALUE, "a base motion is not finite");
  const scene_base_motion base_motion = {
      .amplitude = {amplitude[0], amplitude[1], amplitude[2]}, .course = *course, .now = *course};
  return add(scene, &base_motion, error);
}

/* Of one sampled motion; with dt changed midway, steps are no multiples of dt any more, and the
 * mean is what the velocity gains. */
static void motion_mean(const thrum_scene *scene, const thrum_base_motion *motion, double mean[3]) {
  if (scene->origin == 0 && scene->origin_step == 0) {
    thrum_base_motion_mean(motion, scene->steps, scene->dt, mean);
    return;
  }
  double before[3], after[3];
  const double time = thrum_scene_time(scene);
  thrum_base_motion_at(motion, time, NULL, before);
  thrum_base_motion_at(motion, time + scene->dt, NULL, after);
  for (int axis = 0; axis < 3; axis++)
    mean[axis] = (after[axis] - before[axis]) / scene->dt;
}

void scene_base_motion_mean(const thrum_scene *scene, double mean[3]) {
  const int64_t step = scene->steps - scene->origin_step;
  mean[0] = mean[1] = mean[2] = 0;
  for (int32_t n = 0; n < scene->base_motion_count; n++) {
    const scene_base_motion *base_motion = &scene->base_motions[n];
    double one[3];
    if (base_motion->motion != NULL)
      motion_mean(scene, base_motion->motion, one);
    const double share =
        base_motion->motion == NULL ? thrum_load_mean(&base_motion->now, step, scene->dt) : 0;
    for (int axis = 0; axis < 3; axis++)
      mean[axis] += base_motion->motion == NULL ? share * base_motion->amplitude[axis] : one[axis];
  }
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
