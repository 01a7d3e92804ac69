/* Obstacles with faces: a free body falls on a pole that is narrower than it, and a wall that goes
 * along a path pushes it off. The program says every fifth of a second where the body is.
 *   solids free.npz
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#include "outer_triangles.h"
#include "thrum/scene.h"

/* The pole, and the wall with the time and place (position, rotation w, x, y, z) of its way's ends.
 */
static thrum_status add_solids(thrum_scene *scene, thrum_error *error) {
  static const double times[2] = {1.0, 2.0};
  static const double places[14] = {-0.5, 0, 0.45, 1, 0, 0, 0, 0.1, 0, 0.45, 1, 0, 0, 0};
  thrum_scene_solid_def pole = thrum_default_scene_solid_def();
  pole.shape = THRUM_SOLID_CYLINDER;
  pole.radius = 0.03; // [m]
  pole.height = 0.3;
  pole.position[0] = 0.2;
  pole.position[2] = 0.15;
  pole.restitution = 0.2;

  thrum_scene_solid_def wall = thrum_default_scene_solid_def();
  wall.half[0] = 0.02;
  wall.half[1] = 0.3;
  wall.half[2] = 0.1;
  wall.path_times = times;
  wall.path_places = places;
  wall.path_count = 2;
  const thrum_status status = thrum_scene_add_solid(scene, &pole, NULL, error);
  return status < 0 ? status : thrum_scene_add_solid(scene, &wall, NULL, error);
}

int main(int argc, char **argv) {
  static const double gravity[3] = {0, 0, -9.81};
  thrum_error error = {0};
  const thrum_model *model = NULL;
  thrum_scene *scene = NULL;
  if (argc != 2 || thrum_model_load(argv[1], &model, &error) < 0)
    return fprintf(stderr, "usage: solids MODEL.npz\n%s\n", error.message), 1;

  // a body 0.4 m long, its middle above the pole
  thrum_scene_body_def body = thrum_default_scene_body_def();
  int32_t *triangles = outer_triangles(model, &body.triangle_count);
  body.model = model;
  body.triangles = triangles;
  body.position[2] = 0.43;
  body.free = 1;
  body.state.damping_alpha = 2;
  int failed = triangles == NULL || thrum_scene_create(0.002, &scene, &error) < 0 ||
               thrum_scene_set_gravity(scene, gravity, &error) < 0 ||
               thrum_scene_add_body(scene, &body, NULL, &error) < 0 ||
               thrum_scene_add_probe(scene, "middle", 0, NULL, 0, &error) < 0 ||
               add_solids(scene, &error) < 0;
  free(triangles);

  // two seconds
  for (int step = 1; step <= 1000 && !failed; step++) {
    double x[3];
    failed =
        thrum_scene_step(scene, &error) < 0 || thrum_scene_probe_get(scene, 0, x, NULL, &error) < 0;
    if (failed || step % 100 != 0)
      continue;
    const thrum_contact_pairs_report report = thrum_scene_collisions(scene);
    printf("%.1f s: at %6.3f %6.3f %6.3f m, %lld places touch, the wall has done %.3f J\n",
           thrum_scene_time(scene), x[0], x[1], x[2], (long long)report.touching, report.driven);
  }

  if (failed)
    fprintf(stderr, "solids: %s\n", error.message);
  thrum_scene_destroy(scene);
  thrum_model_destroy(model);
  return failed;
}
