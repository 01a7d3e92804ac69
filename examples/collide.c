/* Two free bodies of one model that fly into each other: a scene with collisions. The program says
 * every twentieth of a second how far apart they are, how many places touch, and what energy and
 * momentum they have together.   collide free.npz
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#include "outer_triangles.h"
#include "thrum/scene.h"

/* A body at x that flies along it. */
static thrum_status add(thrum_scene *scene, const thrum_model *model, const int32_t *triangles,
                        int64_t count, double x, double y, double speed, thrum_error *error) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = model;
  def.triangles = triangles;
  def.triangle_count = count;
  def.position[0] = x; // [m]
  def.position[1] = y;
  def.velocity[0] = speed; // [m/s]
  def.free = 1;
  return thrum_scene_add_body(scene, &def, NULL, error);
}

int main(int argc, char **argv) {
  thrum_error error = {0};
  const thrum_model *model = NULL;
  thrum_scene *scene = NULL;
  if (argc != 2 || thrum_model_load(argv[1], &model, &error) < 0)
    return fprintf(stderr, "usage: collide MODEL.npz\n%s\n", error.message), 1;

  // what touches: surfaces, with friction, and half of the speed comes back
  int64_t count = 0;
  int32_t *triangles = outer_triangles(model, &count);
  thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  def.friction = 0.3;
  def.restitution = 0.5;
  int failed = triangles == NULL || thrum_scene_create(0.002, &scene, &error) < 0 ||
               thrum_scene_set_collisions(scene, &def, &error) < 0 ||
               add(scene, model, triangles, count, 0, 0, 2, &error) < 0 ||
               add(scene, model, triangles, count, 0.6, 0.08, -1, &error) < 0;
  free(triangles);

  // half a second
  for (int step = 1; step <= 250 && !failed; step++) {
    thrum_scene_account account;
    failed =
        thrum_scene_step(scene, &error) < 0 || thrum_scene_account_get(scene, &account, &error) < 0;
    if (failed || step % 25 != 0)
      continue;
    const thrum_contact_pairs_report report = thrum_scene_collisions(scene);
    printf("%.2f s: %2lld places touch, energy %.4f J and %.4f J lost, momentum %.12f kg m/s\n",
           thrum_scene_time(scene), (long long)report.touching, account.total, report.lost,
           account.momentum[0]);
  }

  if (failed)
    fprintf(stderr, "collide: %s\n", error.message);
  thrum_scene_destroy(scene);
  thrum_model_destroy(model);
  return failed;
}
