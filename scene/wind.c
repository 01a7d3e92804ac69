/* Air that drags on the windward surface:  f_v = 1/2 rho C_d A |w - v| (w - v)  on each vertex v,
 * with A = max(0, -a . (w - v)/|w - v|), a its outward area vector at rest. So a convex body at
 * rest feels 1/2 rho C_d |w|^2 times its frontal area (Hoerner 1965, Fluid-dynamic drag, chapter
 * I).
 *
 * What the body's own motion adds, f(w - v) - f(w), is taken at the start of the step and divided
 * by 1 + h kappa, kappa = rho C_d sum |a_v| |w - v|max |U_v|^2 a bound of its rate: an explicit
 * force could otherwise turn the motion over. Cost: 12 r operations a vertex of the surface, and
 * the synchronised momentum.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#include <math.h>
#include <string.h>

#include "scene/internal.h"

thrum_status thrum_scene_set_wind(thrum_scene *scene, const double velocity[3], double density,
                                  double drag, thrum_error *error) {
  const double air = 0.5 * density * drag;
  if (!isfinite(velocity[0]) || !isfinite(velocity[1]) || !isfinite(velocity[2]) ||
      !(density >= 0) || !(drag >= 0) || !isfinite(air))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "a wind wants a velocity that is finite, and a density and a drag "
                           "coefficient >= 0");
  memcpy(scene->wind, velocity, sizeof scene->wind);
  scene->air = air;
  return THRUM_OK;
}

/* Drag on one vertex with this area vector, past which the air goes with `speed`. */
static void drag_on(double air, const double area[3], const double speed[3], double force[3]) {
  const double facing = -(area[0] * speed[0] + area[1] * speed[1] + area[2] * speed[2]);
  for (int axis = 0; axis < 3; axis++)
    force[axis] = facing > 0 ? air * facing * speed[axis] : 0;
}

static double length_of(const double *vector) {
  return sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
}

/* The velocity of a vertex in the body's axes, without that of the body as a whole. */
static void velocity_of(const scene_body *body, const double *rows, double velocity[3]) {
  const int64_t r = body->model->rank, rank = body->derived->rank;
  for (int axis = 0; axis < 3; axis++) {
    double sum = 0;
    for (int64_t i = 0; i < rank; i++)
      sum += rows[axis * r + i] * body->p[i];
    velocity[axis] = body->k * sum;
  }
}

/* How much of the drag's change with the body's own motion one step can take. */
static double limit(const thrum_scene *scene, const scene_body *body, const double wind[3],
                    double fastest) {
  double rate = 0, whole = 0;
  for (int64_t n = 0; n < body->surface_count; n++) {
    rate += length_of(body->areas + 3 * n) * body->stretch[n];
    whole += length_of(body->areas + 3 * n);
  }
  if (body->free)
    rate += whole / body->way.mass;
  return 1 / (1 + scene->dt * 2 * scene->air * (length_of(wind) + fastest) * rate);
}

thrum_status scene_wind_add(const thrum_scene *scene, scene_body *body, double resultant[3],
                            thrum_error *error) {
  const thrum_status status = scene_body_read(body, true, error);
  if (status < 0)
    return status;
  const int64_t r = body->model->rank, rank = body->derived->rank;
  double wind[3], way[3], sum[3] = {0}, world[3], fastest = 0;
  scene_to_body(&body->placement, scene->wind, wind);
  scene_to_body(&body->placement, body->way.velocity, way);
  for (int64_t n = 0; n < body->surface_count; n++) {
    double v[3];
    velocity_of(body, body->model->basis + 3 * (int64_t)body->surface[n] * r, v);
    const double speed = length_of(v);
    fastest = speed > fastest ? speed : fastest;
  }
  const double share = limit(scene, body, wind, fastest + length_of(way));
  for (int64_t n = 0; n < body->surface_count; n++) {
    const double *rows = body->model->basis + 3 * (int64_t)body->surface[n] * r;
    double v[3], past[3], still[3], force[3];
    velocity_of(body, rows, v);
    for (int axis = 0; axis < 3; axis++)
      past[axis] = wind[axis] - v[axis] - way[axis];
    drag_on(scene->air, body->areas + 3 * n, wind, still);
    drag_on(scene->air, body->areas + 3 * n, past, force);
    for (int axis = 0; axis < 3; axis++) {
      const double f = still[axis] + share * (force[axis] - still[axis]);
      sum[axis] += f;
      for (int64_t i = 0; i < rank; i++)
        body->force[i] += body->k * rows[axis * r + i] * f;
    }
  }
  scene_to_world(&body->placement, sum, world);
  for (int axis = 0; axis < 3; axis++)
    resultant[axis] += world[axis];
  return THRUM_OK;
}
