/* Spheres that bodies touch by their vertices alone: one that is smaller than a triangle, or is
 * passed within a step, goes through a body unseen. The way of its centre in the axes of the body
 * tells of it: a centre that is in the body, or has come out on its other side, went through its
 * surface (docs/contact.md). Cost: some 50 operations a sphere and step, and those of all vertices
 * and triangles where it is near and has moved by half of its radius against the body.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_sphere.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver/record/run_placement.h"
#include "platform/allocate.h"

#define MOVED 0.5 /* of the radius: a sphere that has moved less is not looked at */

static bool is_sphere(const scene_obstacle_spec *spec) {
  return spec->shape == SCENE_SPHERE && !spec->inside;
}

void scene_run_in_mesh(const scene_run *run, int32_t n, const double place[3], double at[3]) {
  const double scale = run->bodies[n].spec->scale;
  double matrix[16], from[3];
  thrum_scene_body_matrix(run->scene, n, matrix);
  for (int axis = 0; axis < 3; axis++)
    from[axis] = place[axis] - matrix[12 + axis];
  for (int axis = 0; axis < 3; axis++) {
    const double *column = matrix + 4 * axis;
    at[axis] = (column[0] * from[0] + column[1] * from[1] + column[2] * from[2]) / (scale * scale);
  }
}

/* The centre of a sphere now, in the axes of the mesh of a body. */
static void centre_in(const scene_run *run, const scene_obstacle_spec *spec, int32_t body,
                      double at[3]) {
  const double time = (double)thrum_scene_steps(run->scene) * run->dt;
  double place[3];
  for (int axis = 0; axis < 3; axis++)
    place[axis] = spec->centre[axis] + time * spec->velocity[axis];
  scene_run_in_mesh(run, body, place, at);
}

thrum_status scene_run_open_spheres(scene_run *run, thrum_error *error) {
  const int64_t obstacles = run->spec.obstacles.count;
  int64_t spheres = 0;
  for (int64_t o = 0; o < obstacles; o++)
    spheres += is_sphere(&scene_obstacles(&run->spec)[o]);
  for (int32_t n = 0; n < run->spec.bodies.count && spheres > 0 && run->has_hard_obstacles; n++) {
    scene_body_run *body = run->bodies + n;
    if (body->def.touch_count == 0 || body->def.triangle_count == 0)
      continue;

    // where they begin
    THRUM_TRY(
        thrum_reserve(&body->sphere_at, 3 * obstacles, sizeof *body->sphere_at, "spheres", error));
    if (body->surface == NULL)
      THRUM_TRY(thrum_reserve(&body->surface, 3 * body->model->vertex_count, sizeof *body->surface,
                              "spheres", error));
    for (int64_t o = 0; o < obstacles; o++)
      centre_in(run, &scene_obstacles(&run->spec)[o], n, body->sphere_at + 3 * o);
  }
  return THRUM_OK;
}

/* Has a centre moved enough to be looked at? */
static bool has_moved(const double before[3], const double now[3], double radius) {
  double square = 0;
  for (int axis = 0; axis < 3; axis++)
    square += (now[axis] - before[axis]) * (now[axis] - before[axis]);
  return square > MOVED * MOVED * radius * radius;
}

/* Is its way near the body, which may be deformed by half of its size? */
static bool is_near(const scene_body_run *body, const double before[3], const double now[3]) {
  const double margin = 0.5 * body->diagonal / body->spec->scale;
  bool near = true;
  for (int axis = 0; axis < 3; axis++)
    near = near && fmax(before[axis], now[axis]) >= body->least[axis] - margin &&
           fmin(before[axis], now[axis]) <= body->most[axis] + margin;
  return near;
}

/* Six times the volume of a tetrahedron. */
static double volume_of(const double *a, const double *b, const double *c, const double *d) {
  double side[3][3];
  for (int axis = 0; axis < 3; axis++) {
    side[0][axis] = b[axis] - a[axis];
    side[1][axis] = c[axis] - a[axis];
    side[2][axis] = d[axis] - a[axis];
  }
  return side[0][0] * (side[1][1] * side[2][2] - side[1][2] * side[2][1]) -
         side[0][1] * (side[1][0] * side[2][2] - side[1][2] * side[2][0]) +
         side[0][2] * (side[1][0] * side[2][1] - side[1][1] * side[2][0]);
}

/* Does the way from one point to another go through a triangle of the surface? */
static bool goes_through(const scene_body_run *body, const double from[3], const double to[3]) {
  for (int64_t t = 0; t < body->def.triangle_count; t++) {
    const int32_t *corner = body->def.triangles + 3 * t;
    const double *a = body->surface + 3 * (int64_t)corner[0];
    const double *b = body->surface + 3 * (int64_t)corner[1];
    const double *c = body->surface + 3 * (int64_t)corner[2];
    if (volume_of(a, b, c, from) * volume_of(a, b, c, to) >= 0)
      continue;

    // both ends are on other sides of its plane: the way is on one side of all edges
    const double first = volume_of(from, to, a, b), second = volume_of(from, to, b, c),
                 third = volume_of(from, to, c, a);
    if ((first >= 0 && second >= 0 && third >= 0) || (first <= 0 && second <= 0 && third <= 0))
      return true;
  }
  return false;
}

/* The places of the vertices in the axes of the mesh. */
static bool find_surface(const scene_run *run, int32_t n) {
  const scene_body_run *body = run->bodies + n;
  const int64_t count = body->model->vertex_count;
  double q[THRUM_RANK_MAX];
  if (thrum_scene_body_shape(run->scene, n, q, NULL) < 0 ||
      thrum_displacement(body->model, q, 0, count, body->surface, NULL) < 0)
    return false;
  for (int64_t c = 0; c < 3 * count; c++)
    body->surface[c] += body->model->vertices[c];
  return true;
}

bool scene_run_goes_through(const scene_run *run, int32_t n, const double from[3],
                            const double to[3]) {
  const scene_body_run *body = run->bodies + n;
  return is_near(body, from, to) && find_surface(run, n) && goes_through(body, from, to);
}

/* Has the centre of a sphere gone into the body, or through it? */
static bool has_passed(const scene_run *run, int32_t n, const double before[3],
                       const double now[3]) {
  const scene_body_run *body = run->bodies + n;
  return find_surface(run, n) && (goes_through(body, before, now) ||
                                  thrum_triangles_distance(body->surface, body->def.triangles,
                                                           body->def.triangle_count, now) < 0);
}

void scene_run_note_spheres(scene_run *run) {
  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    scene_body_run *body = run->bodies + n;
    double now[3];
    if (body->sphere_at == NULL || body->passed > 0)
      continue;

    // the first sphere that passed is said
    for (int32_t o = 0; o < run->spec.obstacles.count; o++) {
      const scene_obstacle_spec *spec = &scene_obstacles(&run->spec)[o];
      double *before = body->sphere_at + 3 * (int64_t)o;
      if (!is_sphere(spec))
        continue;
      centre_in(run, spec, n, now);
      if (!has_moved(before, now, spec->radius / body->spec->scale))
        continue;
      if (is_near(body, before, now) && has_passed(run, n, before, now))
        body->passed = o + 1;
      memcpy(before, now, sizeof now);
    }
  }
}
