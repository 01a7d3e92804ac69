/* Whether a body is still, for its level of detail: it moves slowly as a whole, and nothing is
 * about to act on it. What follows masters answers to a load at once and has no momentum, so a push
 * on a body that steps few coordinates is lost on the others: a body is stepped whole before a load
 * comes or changes, and while something that moves could touch it.
 *
 * A load that changes by df gives coordinates of unit mass the velocities sum dt df, which vertices
 * have at most k sum_i |v_i| max |U_i| of. Cost: r operations a load and step that is looked at.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_still.h"

#include "scene/scene_free_body.h"
#include "scene/scene_loads.h"
#include "scene/scene_placement.h"

#include "core/base/vec3.h"

#include <math.h>
#include <string.h>

static double length_of(const double vector[3]) {
  return sqrt(thrum_dot3(vector, vector));
}

double scene_bound(const scene_body *body, int64_t first, const double *q, const double *other) {
  double sum = 0;
  for (int64_t i = first; i < body->model->rank; i++)
    sum += fabs(q[i] - (other != NULL ? other[i] : 0)) * body->detail->peaks[i];
  return body->k * sum;
}

double scene_rigid_speed(const scene_body *body) {
  const scene_detail *detail = body->detail;
  double most = 0;
  if (!body->free)
    return 0;

  // a rigid motion is fastest at a corner of the box
  for (int corner = 0; corner < 8; corner++) {
    double local[3], arm[3], velocity[3];
    for (int axis = 0; axis < 3; axis++) {
      const double side = corner >> axis & 1 ? detail->half[axis] : -detail->half[axis];
      local[axis] =
          body->derived->by.length * (detail->middle[axis] + side) - body->rigid_frame.centre[axis];
    }
    scene_to_world(&body->here, local, arm);
    scene_free_velocity(body, arm, velocity);
    most = fmax(most, length_of(velocity));
  }
  return most;
}

/* Whether an obstacle that moves could reach the body within this time. */
static bool may_be_hit(const thrum_scene *scene, const scene_body *body, const double *q,
                       double time) {
  const scene_detail *detail = body->detail;
  if (body->touch == NULL || body->touch->idle)
    return false;

  // the ball around the body as it is bent now
  double rest[3], middle[3], normal[3];
  for (int axis = 0; axis < 3; axis++)
    rest[axis] = body->derived->by.length * detail->middle[axis];
  scene_to_world(&body->here, rest, middle);
  for (int axis = 0; axis < 3; axis++)
    middle[axis] += body->here.origin[axis];
  const double radius =
      body->derived->by.length * length_of(detail->half) + scene_bound(body, 0, q, NULL);

  for (int32_t n = 0; n < scene->obstacle_count; n++) {
    const double speed = length_of(scene->obstacles[n].velocity);
    if (speed > 0 &&
        !(thrum_obstacle_gap(&scene->obstacles[n], middle, normal) > radius + speed * time))
      return true;
  }
  return false;
}

double scene_coming_speed(const thrum_scene *scene, scene_body *body, const double *q,
                          int64_t steps) {
  const int64_t r = body->model->rank;
  double under[THRUM_RANK_MAX], gained[THRUM_RANK_MAX] = {0}, base[3], most = 0;
  for (int n = 0; n < THRUM_SCENE_PULLS; n++)
    if (body->pulls[n].used)
      return INFINITY;
  if (may_be_hit(scene, body, q, (double)steps * scene->dt))
    return INFINITY;

  // what a load that changes gives, from the load of the last step on
  scene_loads_ahead(scene, body, scene->steps > 0 ? -1 : 0, base);
  memcpy(under, body->force, (size_t)r * sizeof *under);
  for (int64_t step = 0; step < steps; step++) {
    scene_loads_ahead(scene, body, step, base);
    for (int64_t i = 0; i < r; i++)
      gained[i] += scene->dt * (body->force[i] - under[i]);
    most = fmax(most, scene_bound(body, 0, gained, NULL));
  }
  return most;
}
