/* A scene: two beams of one model side by side over a floor, the second with a tenth of the
 * stiffness. Gravity sets in and bends both, and the soft one lands on the floor. The program says
 * every tenth of a second how far their tips are down.   two_bodies beam.npz
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "thrum/scene.h"

/* Puts a beam into the scene, whose group "tip" may touch the floor, and follows that group. */
static thrum_status add_beam(thrum_scene *scene, const thrum_model *model, double y,
                             double stiffness, thrum_error *error) {
  int32_t body;
  thrum_scene_body_def def = thrum_default_scene_body_def();
  thrum_status status = thrum_model_group(model, "tip", &def.touch, &def.touch_count, error);
  if (status < 0)
    return status;

  // all else has a default
  def.model = model;
  def.position[1] = y;
  def.stiffness = stiffness;
  def.state.damping_alpha = 2; // [1/s]
  status = thrum_scene_add_body(scene, &def, &body, error);
  return status < 0 ? status
                    : thrum_scene_add_probe(scene, NULL, body, def.touch, def.touch_count, error);
}

/* Gravity, the floor and both beams. */
static thrum_status fill(thrum_scene *scene, const thrum_model *model, thrum_error *error) {
  const double gravity[3] = {0, 0, -9.81}; // [m/s^2]
  thrum_obstacle floor = thrum_default_obstacle();
  floor.centre[2] = -0.15; // [m]

  thrum_status status = thrum_scene_set_gravity(scene, gravity, error);
  if (status >= 0)
    status = thrum_scene_add_obstacle(scene, &floor, NULL, error);
  if (status >= 0)
    status = add_beam(scene, model, 0.0, 1.0, error);
  if (status >= 0)
    status = add_beam(scene, model, 0.5, 0.1, error);
  return status;
}

int main(int argc, char **argv) {
  thrum_error error = {0};
  const thrum_model *model = NULL;
  thrum_scene *scene = NULL;
  if (argc != 2 || thrum_model_load(argv[1], &model, &error) < 0)
    return fprintf(stderr, "usage: two_bodies MODEL.npz\n%s\n", error.message), 1;

  // the positions at rest, from which the tips move
  double rest[2] = {0, 0}, position[3];
  int failed = thrum_scene_create(0.003, &scene, &error) < 0 || fill(scene, model, &error) < 0;
  for (int n = 0; n < 2 && !failed; n++) {
    failed = thrum_scene_probe_get(scene, n, position, NULL, &error) < 0;
    rest[n] = position[2];
  }

  // one second and a half
  for (int step = 1; step <= 500 && !failed; step++) {
    failed = thrum_scene_step(scene, &error) < 0;
    double down[2] = {0, 0};
    for (int n = 0; n < 2 && !failed; n++) {
      failed = thrum_scene_probe_get(scene, n, position, NULL, &error) < 0;
      down[n] = rest[n] - position[2];
    }
    if (step % 50 == 0 && !failed)
      printf("%.2f s: %.4f m and %.4f m down\n", thrum_scene_time(scene), down[0], down[1]);
  }

  if (failed)
    fprintf(stderr, "two_bodies: %s\n", error.message);
  thrum_scene_destroy(scene);
  thrum_model_destroy(model);
  return failed;
}
