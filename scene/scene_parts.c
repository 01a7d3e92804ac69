/* Loads on a body that turns: they stay in the world while the body's axes do not, so each is
 * reduced once for every pair of axes and put together in every step (design 15; 9 r operations a
 * load).
 *
 * With f the load's world component b and a axis of the body: part_ab = U'^T of f_b along a, and
 * the direction now is sum axes_ba part_ab, axes from the body to the world. Its torque about the
 * centre is that of the body as a rigid one: with the moments M_ab = sum arm_a f_b, of axes M.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_parts.h"

#include "scene/scene_coupled.h"
#include "scene/scene_memory.h"

#include <stdlib.h>
#include <string.h>

#include "thrum/external_load.h"

/* A field whose component `b` acts along axis `a`. */
static thrum_status reduce_field(const scene_body *body, const double *field, int a, int b,
                                 double *reduced, thrum_error *error) {
  const int64_t count = body->model->vertex_count;
  double *local = calloc(3 * (size_t)count + 1, sizeof *local);
  if (local == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a field of forces");
  for (int64_t v = 0; v < count; v++)
    local[3 * v + a] = field[3 * v + b];
  const thrum_status status = thrum_load_add_field(body->model, local, reduced, error);
  free(local);
  return status;
}

/* Component b of the load along axis a of the body, as the scaled body has it. */
static thrum_status reduce_part(const scene_body *body, const thrum_scene_load_def *load, int a,
                                int b, double *reduced, thrum_error *error) {
  double local[3] = {0};
  double factor = body->k;
  thrum_status status = THRUM_OK;

  local[a] = load->vector[b];
  memset(reduced, 0, (size_t)body->model->rank * sizeof *reduced);

  // a field, a shared force or an acceleration
  if (load->kind == THRUM_SCENE_FIELD) {
    status = reduce_field(body, load->field, a, b, reduced, error);
  } else if (load->kind == THRUM_SCENE_FORCE) {
    status = thrum_load_add_shared(body->model, load->vertices, load->count, local, reduced, error);
  } else if (local[a] != 0) {
    status = thrum_load_add_gravity(body->model, local, reduced, error);
    factor = body->mass;
  }

  for (int64_t i = 0; i < body->model->rank; i++)
    reduced[i] *= factor;
  return status;
}

/* moments[3 a + b] += arm_a force_b of one vertex. */
static void add_moment(const scene_body *body, int64_t vertex, const double force[3],
                       double moments[9]) {
  for (int a = 0; a < 3; a++) {
    const double arm = body->derived->by.length * body->model->vertices[3 * vertex + a] -
                       body->rigid_frame.centre[a];
    for (int b = 0; b < 3; b++)
      moments[3 * a + b] += arm * force[b];
  }
}

/* Force and moments of the load on the body as a whole. */
static void find_whole(const scene_body *body, const thrum_scene_load_def *load, double moments[9],
                       double resultant[3]) {
  const int64_t all = body->model->vertex_count;
  const int64_t count = load->vertices ? load->count : all;
  memset(moments, 0, 9 * sizeof *moments);
  memset(resultant, 0, 3 * sizeof *resultant);

  // the resultant of an acceleration acts on the mass, that of a force is the force
  for (int axis = 0; axis < 3 && load->kind != THRUM_SCENE_FIELD; axis++)
    resultant[axis] =
        (load->kind == THRUM_SCENE_ACCELERATION ? body->way.mass : 1) * load->vector[axis];

  // a shared force has a moment of each share
  for (int64_t n = 0; n < count && load->kind == THRUM_SCENE_FORCE; n++) {
    const double share[3] = {load->vector[0] / (double)count, load->vector[1] / (double)count,
                             load->vector[2] / (double)count};
    add_moment(body, load->vertices ? load->vertices[n] : n, share, moments);
  }

  // a field has a force of its own at each vertex
  for (int64_t v = 0; v < all && load->kind == THRUM_SCENE_FIELD; v++) {
    add_moment(body, v, load->field + 3 * v, moments);
    for (int axis = 0; axis < 3; axis++)
      resultant[axis] += load->field[3 * v + axis];
  }
}

thrum_status scene_parts_make(scene_body *body, const thrum_scene_load_def *load, int64_t index,
                              thrum_error *error) {
  const int64_t r = body->model->rank, count = index + 1;
  if (index >= body->load_count &&
      (!scene_grow(&body->parts, 9 * count * r, sizeof *body->parts) ||
       !scene_grow(&body->moments, 9 * count, sizeof *body->moments) ||
       !scene_grow(&body->resultants, 3 * count, sizeof *body->resultants)))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a load");

  // a reduced load brings its parts along
  if (load->kind == THRUM_SCENE_REDUCED) {
    memcpy(body->parts + 9 * index * r, load->parts, 9 * (size_t)r * sizeof *body->parts);
    memcpy(body->moments + 9 * index, load->moments, sizeof load->moments);
    memcpy(body->resultants + 3 * index, load->resultant, sizeof load->resultant);
    return THRUM_OK;
  }

  // each component of the load along each axis of the body
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      THRUM_TRY(reduce_part(body, load, a, b, body->parts + (9 * index + 3 * a + b) * r, error));
  find_whole(body, load, body->moments + 9 * index, body->resultants + 3 * index);
  return THRUM_OK;
}

void scene_parts_sum(const thrum_scene *scene, scene_body *body, int64_t step,
                     scene_wrench *wrench) {
  const int64_t r = body->model->rank;
  const double *axes = body->here.axes;
  double moments[9], world[9] = {0};

  // the parts of each load, turned with the body
  memset(body->directions, 0, (size_t)(body->load_count * r) * sizeof *body->directions);
  for (int64_t l = 0; l < body->load_count; l++)
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) {
        const double *part = body->parts + (9 * l + 3 * a + b) * r;
        for (int64_t i = 0; i < r; i++)
          body->directions[l * r + i] += axes[3 * b + a] * part[i];
      }

  // the loads of this step, summed
  thrum_load_sum(body->now, body->resultants, body->load_count, 3, step, scene->dt, wrench->force);
  thrum_load_sum(body->now, body->moments, body->load_count, 9, step, scene->dt, moments);
  if (body->inertia_work != NULL)
    scene_coupled_moments(scene, body, step, moments);

  // the torque is the antisymmetric part of the moments in the world
  for (int j = 0; j < 3; j++)
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++)
        world[3 * j + b] += axes[3 * j + a] * moments[3 * a + b];
  for (int axis = 0; axis < 3; axis++) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    wrench->torque[axis] = world[3 * next + last] - world[3 * last + next];
  }
}
