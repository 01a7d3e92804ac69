/* Forces that act on the mesh of a body of a scene at present, in the axes and the units of its
 * model as it is in its file: loads, obstacles, other bodies, links and wind. They tell what a
 * basis lacks (scene_run_judge.c); where the library does not list a force by vertices, it is put
 * on those that are nearest. SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_forces.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "driver/record/run_placement.h"
#include "platform/allocate.h"

#define TOUCHING 1e-3 /* of a body's diagonal: vertices so near an obstacle touch it */

/* A body at present. */
typedef struct body_now {
  const scene_run *run;
  int32_t number;
  const scene_body_run *body;
  double *acceleration; /* that acts on all of its mass, in its axes [m/s^2] */
  double matrix[16], diagonal;
  double *world;  /* 3 vertex_count: where its vertices are [m] */
  double *one;    /* 3 vertex_count: of one load */
  double *forces; /* 3 vertex_count: the sum */
} body_now;

/* A vector of the world in the axes of the body, times a factor. */
static void into_body(const body_now *now, const double vector[3], double factor, double out[3]) {
  const double scale = now->body->spec->scale;
  double turned[3];
  for (int axis = 0; axis < 3; axis++)
    turned[axis] = factor / scale *
                   (now->matrix[4 * axis] * vector[0] + now->matrix[4 * axis + 1] * vector[1] +
                    now->matrix[4 * axis + 2] * vector[2]);
  memcpy(out, turned, sizeof turned);
}

/* What a force on the body is on the model in its file [1]: forces go with stiffness and area. */
static double force_factor(const scene_body_spec *spec) {
  return 1 / (spec->stiffness * spec->scale * spec->scale);
}

static int64_t nearest_vertex(const body_now *now, const double place[3]) {
  int64_t nearest = 0;
  double least = INFINITY;
  for (int64_t v = 0; v < now->body->model->vertex_count; v++) {
    const double *at = now->world + 3 * v;
    const double dx = at[0] - place[0], dy = at[1] - place[1], dz = at[2] - place[2];
    const double square = dx * dx + dy * dy + dz * dz;
    nearest = square < least ? v : nearest;
    least = fmin(square, least);
  }
  return nearest;
}

static void add_at(const body_now *now, const double place[3], const double force[3]) {
  double turned[3];
  const int64_t v = nearest_vertex(now, place);
  into_body(now, force, force_factor(now->body->spec), turned);
  for (int axis = 0; axis < 3; axis++)
    now->forces[3 * v + axis] += turned[axis];
}

/* --- loads ------------------------------------------------------------------------------------ */

/* Loads and gravity, which keep their direction in the world while a free body turns. */
static thrum_status add_loads(const body_now *now, int64_t step, thrum_error *error) {
  const scene_body_run *body = now->body;
  const scene_body_spec *spec = body->spec;
  const int64_t all = 3 * body->model->vertex_count;
  double axes[9];
  THRUM_TRY(thrum_scene_axes(spec->rotation, axes, error));
  for (int64_t n = 0; n < body->request.load_count; n++) {
    load_spec load = body->request.loads[n];
    const double share = thrum_load_mean(&load.course, step > 0 ? step - 1 : 0, now->run->dt);
    if (share == 0)
      continue;

    // from the axes of the body at the start into the world, and into those of now
    double world[3];
    for (int axis = 0; axis < 3; axis++)
      world[axis] = axes[3 * axis] * load.vector[0] + axes[3 * axis + 1] * load.vector[1] +
                    axes[3 * axis + 2] * load.vector[2];
    into_body(now, world, 1, load.vector);

    // gravity goes with the mass, a traction with the area of the mesh
    const double factor = load.gravity    ? spec->density * spec->scale / spec->stiffness
                          : load.traction ? 1 / spec->stiffness
                                          : force_factor(spec);
    memset(now->one, 0, (size_t)all * sizeof *now->one);
    if (load.gravity)
      cblas_daxpy(3, share * factor, load.vector, 1, now->acceleration, 1);
    else
      THRUM_TRY(load_spec_fill(body->model, &load, now->one, error));
    cblas_daxpy((int)all, share * factor, now->one, 1, now->forces, 1);
  }
  return THRUM_OK;
}

/* The inertia of a body on a ground that moves. */
static void add_ground(const body_now *now, int64_t step) {
  const scene_body_spec *spec = now->body->spec;
  double ground[3], turned[3];
  if (now->run->base_motion_count == 0)
    return;
  base_motions_mean(now->run->base_motions, now->run->base_motion_count, step > 0 ? step - 1 : 0,
                    now->run->dt, ground);
  into_body(now, ground, spec->density * spec->scale / spec->stiffness, turned);
  cblas_daxpy(3, -1, turned, 1, now->acceleration, 1);
}

/* --- touches ---------------------------------------------------------------------------------- */

/* Normals at the vertices that are near obstacles, into now->one; false: none is. */
static bool find_near(const body_now *now) {
  const thrum_scene_body_def *def = &now->body->def;
  bool any = false;
  memset(now->one, 0, 3 * (size_t)now->body->model->vertex_count * sizeof *now->one);
  for (int32_t o = 0; o < thrum_scene_obstacle_count(now->run->scene); o++) {
    thrum_obstacle obstacle;
    if (thrum_scene_obstacle_get(now->run->scene, o, &obstacle, NULL) < 0)
      continue;
    for (int64_t n = 0; n < def->touch_count; n++) {
      const int32_t v = def->touch[n];
      double normal[3], turned[3];
      if (thrum_obstacle_gap(&obstacle, now->world + 3 * v, normal) > TOUCHING * now->diagonal)
        continue;
      into_body(now, normal, 1, turned);
      for (int axis = 0; axis < 3; axis++)
        now->one[3 * v + axis] += turned[axis];
      any = true;
    }
  }
  return any;
}

/* Forces of planes, spheres and rooms: along the normals of the vertices that are near, as strong
 * as is nearest to what the coordinates felt. */
static thrum_status add_obstacles(const body_now *now, thrum_error *error) {
  const thrum_model *model = now->body->model;
  const int rank = (int)model->rank;
  double felt[THRUM_RANK_MAX], of_one[THRUM_RANK_MAX] = {0};
  if (now->body->def.touch_count == 0 || !find_near(now))
    return THRUM_OK;
  THRUM_TRY(thrum_scene_body_contact_load(now->run->scene, now->number, felt, error));
  cblas_dgemv(CblasRowMajor, CblasTrans, (int)(3 * model->vertex_count), rank, 1, model->basis,
              rank, now->one, 1, 0, of_one, 1);
  const double size = cblas_ddot(rank, of_one, 1, of_one, 1);
  const double share = cblas_ddot(rank, of_one, 1, felt, 1);
  if (size > 0 && share > 0)
    cblas_daxpy((int)(3 * model->vertex_count), share / size, now->one, 1, now->forces, 1);
  return THRUM_OK;
}

/* Touches of other bodies, of solids and of the body itself; an impact as the mean of its step. */
static void add_touches(const body_now *now) {
  const thrum_contact_pairs_report of = thrum_scene_collisions(now->run->scene);
  for (int64_t n = 0; n < of.touching + of.struck; n++) {
    thrum_pair_touch touch;
    if (thrum_scene_collision_get(now->run->scene, n, &touch, NULL) < 0)
      break;
    for (int side = 0; side < 2; side++) {
      double force[3];
      if (touch.bodies[side] != now->number)
        continue;
      for (int axis = 0; axis < 3; axis++)
        force[axis] =
            (side == 0 ? 1 : -1) * (touch.force[axis] + touch.impulse[axis] / now->run->dt);
      add_at(now, touch.position, force);
    }
  }
}

/* --- links and wind --------------------------------------------------------------------------- */

static thrum_status add_links(const body_now *now, thrum_error *error) {
  for (int32_t n = 0; n < thrum_scene_link_count(now->run->scene); n++) {
    thrum_scene_link link;
    THRUM_TRY(thrum_scene_link_get(now->run->scene, n, &link, error));
    for (int side = 0; side < 2 && link.holds; side++) {
      double force[3];
      if (link.bodies[side] != now->number)
        continue;
      for (int axis = 0; axis < 3; axis++)
        force[axis] = (side == 0 ? 1 : -1) * link.report.force[axis];
      add_at(now, link.places[side], force);
    }
  }
  return THRUM_OK;
}

/* The drag of the wind on a triangle that stands still. */
static void add_drag(const body_now *now, const int32_t *corners) {
  const scene_wind_spec *wind = &now->run->spec.wind;
  const double *a = now->world + 3 * corners[0], *b = now->world + 3 * corners[1],
               *c = now->world + 3 * corners[2];
  double area[3], force[3], turned[3], speed = 0, facing = 0;
  for (int axis = 0; axis < 3; axis++) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    area[axis] = 0.5 * ((b[next] - a[next]) * (c[last] - a[last]) -
                        (b[last] - a[last]) * (c[next] - a[next]));
    facing -= area[axis] * wind->velocity[axis];
    speed += wind->velocity[axis] * wind->velocity[axis];
  }
  if (!(facing > 0) || !(speed > 0))
    return;
  for (int axis = 0; axis < 3; axis++)
    force[axis] = 0.5 * wind->density * wind->drag * facing * wind->velocity[axis];
  into_body(now, force, force_factor(now->body->spec) / 3, turned);
  for (int k = 0; k < 9; k++)
    now->forces[3 * corners[k / 3] + k % 3] += turned[k % 3];
}

/* --- all -------------------------------------------------------------------------------------- */

thrum_status scene_run_forces(const scene_run *run, int32_t number, int64_t step, double *forces,
                              double acceleration[3], thrum_error *error) {
  const scene_body_run *body = &run->bodies[number];
  const thrum_model *model = body->model;
  double q[THRUM_RANK_MAX];
  body_now now = {.run = run,
                  .number = number,
                  .body = body,
                  .acceleration = acceleration,
                  .forces = forces,
                  .diagonal = body->spec->scale *
                              thrum_box3_diagonal(model->vertices, model->vertex_count)};
  THRUM_TRY(thrum_scene_body_shape(run->scene, number, q, error));
  thrum_scene_body_matrix(run->scene, number, now.matrix);
  THRUM_TRY(thrum_reserve(&now.world, 6 * model->vertex_count, sizeof *now.world,
                          "the judgement of the basis", error));
  now.one = now.world + 3 * model->vertex_count;
  memset(forces, 0, 3 * (size_t)model->vertex_count * sizeof *forces);
  memset(acceleration, 0, 3 * sizeof *acceleration);

  // where its vertices are
  thrum_status status = thrum_displacement(model, q, 0, model->vertex_count, now.world, error);
  for (int64_t v = 0; v < model->vertex_count && status >= 0; v++) {
    for (int axis = 0; axis < 3; axis++)
      now.world[3 * v + axis] += model->vertices[3 * v + axis];
    run_placement_point(now.matrix, now.world + 3 * v, now.world + 3 * v);
  }

  THRUM_THEN(status, add_loads(&now, step, error));
  THRUM_THEN(status, add_obstacles(&now, error));
  THRUM_THEN(status, add_links(&now, error));
  if (status >= 0) {
    add_ground(&now, step);
    add_touches(&now);
    for (int64_t t = 0; t < body->def.triangle_count && run->spec.wind.at.node != NULL; t++)
      add_drag(&now, body->def.triangles + 3 * t);
  }
  free(now.world);
  return status;
}
