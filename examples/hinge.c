/* A double pendulum of two free bodies of one model: a hinge ties the first to the world, a ball
 * joint the second to the first. After a second the ball joint lets go. The program says every
 * quarter of a second what energy there is, and how far the joints are open.   hinge free.npz
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "thrum/scene.h"

/* A body that begins at x. */
static thrum_status add(thrum_scene *scene, const thrum_model *model, double x,
                        thrum_error *error) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = model;
  def.position[0] = x; // [m]
  def.free = 1;
  return thrum_scene_add_body(scene, &def, NULL, error);
}

/* A joint of a body at x, with another body or with the world (-1). */
static thrum_status join(thrum_scene *scene, thrum_link_kind kind, int32_t body, int32_t other,
                         double x, double until, thrum_error *error) {
  thrum_scene_link_def def = thrum_default_scene_link_def();
  def.kind = kind;
  def.body = body;
  def.other = other;
  def.place[0] = x; // [m]
  def.place[1] = def.place[2] = 0;
  def.axis[1] = 1; // of the hinge, with the rest of the default taken away
  def.axis[2] = 0;
  def.until = until; // [s]
  return thrum_scene_add_link(scene, &def, NULL, error);
}

/* Energy of all bodies, with what joints have lost, and how far they are open. */
static thrum_status report(thrum_scene *scene, thrum_error *error) {
  thrum_scene_account account;
  thrum_scene_link first, second;

  /* each call is made only where those before it succeeded */
  thrum_status status = thrum_scene_account_get(scene, &account, error);
  if (status >= 0)
    status = thrum_scene_link_get(scene, 0, &first, error);
  if (status >= 0)
    status = thrum_scene_link_get(scene, 1, &second, error);

  if (status >= 0)
    printf(
        "%.2f s: %.3f J of motion, %.0e J in all, %.0e J taken by the joints, which were open by "
        "%.0e m at most%s\n",
        thrum_scene_time(scene), account.kinetic, account.total,
        first.report.lost + second.report.lost,
        first.report.largest_drift + second.report.largest_drift,
        second.holds ? "" : "; the second has let go");
  return status;
}

int main(int argc, char **argv) {
  const double gravity[3] = {0, 0, -9.81}; // [m/s^2]
  thrum_error error = {0};
  const thrum_model *model = NULL;
  thrum_scene *scene = NULL;
  if (argc != 2 || thrum_model_load(argv[1], &model, &error) < 0)
    return fprintf(stderr, "usage: hinge MODEL.npz\n%s\n", error.message), 1;

  // the model is 0.4 m long, from its origin on
  int failed = thrum_scene_create(0.002, &scene, &error) < 0 ||
               thrum_scene_set_gravity(scene, gravity, &error) < 0 ||
               add(scene, model, 0, &error) < 0 || add(scene, model, 0.4, &error) < 0 ||
               join(scene, THRUM_LINK_HINGE, 0, -1, 0, 1e9, &error) < 0 ||
               join(scene, THRUM_LINK_BALL, 0, 1, 0.4, 1, &error) < 0;

  // a second and a quarter
  for (int step = 1; step <= 625 && !failed; step++)
    failed = thrum_scene_step(scene, &error) < 0 || (step % 125 == 0 && report(scene, &error) < 0);

  if (failed)
    fprintf(stderr, "hinge: %s\n", error.message);
  thrum_scene_destroy(scene);
  thrum_model_destroy(model);
  return failed;
}
