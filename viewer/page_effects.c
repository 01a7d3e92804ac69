/* Everything that acts on the bodies of a page over time: loads, base motion, wind.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "page.h"

#define MOTIONS_MAX 16

static thrum_base_motion motions[MOTIONS_MAX];
static double *motion_memory[MOTIONS_MAX]; // owned
static int32_t motion_count;

void bridge_forget_motions(void) {
  while (motion_count > 0)
    free(motion_memory[--motion_count]);
}

/* numbers: from, until [s], frequency [Hz]. */
static thrum_load course_of(int32_t shape) {
  return (thrum_load){.shape = (thrum_load_shape)shape,
                      .from = bridge_number[0],
                      .until = bridge_number[1],
                      .frequency = bridge_number[2]};
}

/* A reduced load. reduced: of the model's rank; parts: of a free body, 9 of them. numbers: course
 * 3, moments 9, resultant 3. */
int32_t EXPORT(bridge_add_load)(int32_t body, int32_t shape, const double *reduced,
                                const double *parts) {
  thrum_scene_load load = {
      .kind = THRUM_SCENE_REDUCED, .course = course_of(shape), .reduced = reduced, .parts = parts};
  memcpy(load.moments, bridge_number + 3, sizeof load.moments);
  memcpy(load.resultant, bridge_number + 12, sizeof load.resultant);
  return thrum_scene_add_load(bridge_scene, body, &load, &bridge_error);
}

/* numbers: course 3, amplitude 3 [m/s^2]. */
int32_t EXPORT(bridge_add_base_motion)(int32_t shape) {
  const thrum_load course = course_of(shape);
  return thrum_scene_add_base_motion(bridge_scene, bridge_number + 3, &course, &bridge_error);
}

/* samples from bridge_alloc, kept: count times, then count x 3 accelerations, velocities and
 * positions. */
int32_t EXPORT(bridge_add_motion)(int32_t count, double *samples) {
  if (motion_count == MOTIONS_MAX) {
    free(samples);
    return thrum_error_set(&bridge_error, THRUM_UNSUPPORTED,
                           "a page moves the ground by at most %d files", MOTIONS_MAX);
  }
  motion_memory[motion_count] = samples;
  thrum_base_motion *motion = &motions[motion_count++];
  *motion = (thrum_base_motion){.count = count,
                                .times = samples,
                                .accelerations = samples + count,
                                .velocities = samples + 4 * count,
                                .positions = samples + 7 * count};
  return thrum_scene_add_base_motion_record(bridge_scene, motion, &bridge_error);
}

/* numbers: velocity 3 [m/s], density of the air [kg/m^3], drag coefficient. */
int32_t EXPORT(bridge_set_wind)(void) {
  return thrum_scene_set_wind(bridge_scene, bridge_number, bridge_number[3], bridge_number[4],
                              &bridge_error);
}
