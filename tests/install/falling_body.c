/* A user's program on the installed scene library: an oscillator made by hand swings in a scene.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>

#include "thrum/scene.h"

int main(void) {
  /* omega = 2 pi: the period is one second */
  const double omega2 = 39.47841760435743, c3 = 0, c4 = 0, start = 1;
  const int32_t format[2] = {THRUM_MODEL_FORMAT_MAJOR, THRUM_MODEL_FORMAT_MINOR};
  thrum_model model = {0};
  model.format = format;
  model.rank = 1;
  model.c3_count = thrum_c3_count(1);
  model.c4_count = thrum_c4_count(1);
  model.omega2 = &omega2;
  model.c3 = &c3;
  model.c4 = &c4;

  thrum_error error = {.status = THRUM_OK};
  thrum_scene *scene = NULL;
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &model;
  def.q = &start;
  int32_t body = -1;
  int failed = thrum_scene_create(0.001, &scene, &error) < 0 ||
               thrum_scene_add_body(scene, &def, &body, &error) < 0;
  for (int step = 0; step < 1000 && !failed; step++)
    failed = thrum_scene_step(scene, &error) < 0;
  if (failed)
    fprintf(stderr, "%s\n", error.message);
  else
    printf("thrum %s: body %d of a scene after one period\n", thrum_version(), (int)body);
  thrum_scene_destroy(scene);
  return failed;
}
