/* Where bodies touch obstacles and each other, to be marked in the picture.
 * SPDX-License-Identifier: Apache-2.0 */
#include "page.h"

#include <stdbool.h>

#define TOUCHES_MAX 1024

static float places[3 * TOUCHES_MAX];
static int32_t place_count;

static void add_place(const double place[3]) {
  for (int axis = 0; axis < 3 && place_count < TOUCHES_MAX; axis++)
    places[3 * place_count + axis] = (float)place[axis];
  if (place_count < TOUCHES_MAX)
    place_count++;
}

// whether a point lies in an obstacle or on it, as it is where contact by springs holds it up
static bool is_touching(const thrum_scene *scene, const double point[3]) {
  thrum_obstacle obstacle;
  double normal[3];
  for (int32_t n = 0; n < thrum_scene_obstacle_count(scene); n++)
    if (thrum_scene_obstacle_get(scene, n, &obstacle, NULL) == THRUM_OK &&
        thrum_obstacle_gap(&obstacle, point, normal) <= 0.0)
      return true;
  return false;
}

// vertices of one body that lie in obstacles
static void add_body(thrum_scene *scene, int32_t body) {
  const page_model *shown = page_body_model(scene, body);
  double matrix[16];
  float *x = shown->positions;
  thrum_scene_body_matrix(scene, body, matrix);
  if (thrum_scene_body_positions(scene, body, shown->surface, x, 3, NULL) != THRUM_OK)
    return;

  // positions are in the axes of the model
  for (int64_t n = 0; n < shown->touch_count; n++) {
    const float *local = x + 3 * shown->touch[n];
    double place[3];
    for (int axis = 0; axis < 3; axis++)
      place[axis] = matrix[axis] * (double)local[0] + matrix[4 + axis] * (double)local[1] +
                    matrix[8 + axis] * (double)local[2] + matrix[12 + axis];
    if (is_touching(scene, place))
      add_place(place);
  }
}

/* Finds the places of touches at present; x, y, z of each, as floats, until the next call. */
const float *EXPORT(page_touches)(thrum_scene *scene) {
  place_count = 0;
  for (int32_t n = 0; n < thrum_scene_body_count(scene); n++)
    if (thrum_scene_obstacle_count(scene) > 0)
      add_body(scene, n);

  // touches of bodies with each other and with solids are listed by the scene
  const int64_t touching = thrum_scene_collisions(scene).touching;
  for (int64_t n = 0; n < touching; n++) {
    thrum_pair_touch touch;
    if (thrum_scene_collision_get(scene, n, &touch, NULL) == THRUM_OK)
      add_place(touch.position);
  }
  return places;
}

/* How many places the last page_touches found. */
int32_t EXPORT(page_touch_count)(void) {
  return place_count;
}
