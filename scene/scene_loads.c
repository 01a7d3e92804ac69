/* Loads on the bodies over time: gravity, loads, the moving ground (design 5, 12).
 *
 * A load is fixed in the world, so it is turned into the body's axes and reduced once; a step sums
 * directions times their mean over it. Time is counted from the scene's origin, which moves when dt
 * changes, so that whole steps stay whole.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_loads.h"

#include "scene/scene_access.h"
#include "scene/scene_actuation.h"
#include "scene/scene_fields.h"
#include "scene/scene_memory.h"
#include "scene/scene_parts.h"
#include "scene/scene_placement.h"
#include "scene/scene_reduced_load.h"

#include "core/base/def.h"
#include "core/base/finite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "thrum/external_load.h"

/* reduced (zero before) += U'^T M' a of a uniform acceleration in world axes. */
static thrum_status reduce_acceleration(const scene_body *body, const double acceleration[3],
                                        double *reduced, thrum_error *error) {
  double local[3];
  scene_to_body(&body->placement, acceleration, local);
  const thrum_status status = thrum_load_add_gravity(body->model, local, reduced, error);
  for (int64_t i = 0; status >= 0 && i < body->model->rank; i++)
    reduced[i] *= body->mass;
  return status;
}

/* Nothing needs the mass of bodies that nothing accelerates. */
static thrum_status gravity_direction(const scene_body *body, const double gravity[3],
                                      double *direction, thrum_error *error) {
  const int64_t r = body->model->rank;
  memset(direction, 0, (size_t)r * sizeof *direction);
  if (gravity[0] == 0 && gravity[1] == 0 && gravity[2] == 0)
    return THRUM_OK;
  return reduce_acceleration(body, gravity, direction, error);
}

thrum_status scene_gravity_reduce(scene_body *body, const double gravity[3], thrum_error *error) {
  // body->force is made anew in every step
  THRUM_TRY(gravity_direction(body, gravity, body->force, error));
  memcpy(body->directions, body->force, (size_t)body->model->rank * sizeof *body->force);
  if (!body->free)
    return THRUM_OK;
  thrum_scene_load_def load = thrum_default_scene_load_def();
  load.kind = THRUM_SCENE_ACCELERATION;
  memcpy(load.vector, gravity, sizeof load.vector);
  return scene_parts_make(body, &load, 0, error);
}

thrum_status thrum_scene_set_gravity(thrum_scene *scene, const double gravity[3],
                                     thrum_error *error) {
  if (!thrum_all_finite(gravity, 3))
    return thrum_error_set(error, THRUM_BAD_VALUE, "gravity is not finite");
  for (int32_t n = 0; n < scene->body_count; n++) {
    // all are tried before one is changed
    THRUM_TRY(gravity_direction(scene->bodies[n], gravity, scene->bodies[n]->force, error));
  }
  memcpy(scene->gravity, gravity, sizeof scene->gravity);
  scene->stirred++;
  for (int32_t n = 0; n < scene->body_count; n++)
    scene_gravity_reduce(scene->bodies[n], gravity, NULL);
  return THRUM_OK;
}

void thrum_scene_gravity(const thrum_scene *scene, double gravity[3]) {
  memcpy(gravity, scene->gravity, sizeof scene->gravity);
}

/* reduced (zero before) += U'^T f of a field in world axes. */
static thrum_status reduce_field(const scene_body *body, const double *field, double *reduced,
                                 thrum_error *error) {
  const size_t count = (size_t)body->model->vertex_count;
  double *local = malloc(3 * count * sizeof *local + 1);
  if (local == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a field of forces");
  for (size_t v = 0; v < count; v++)
    scene_to_body(&body->placement, field + 3 * v, local + 3 * v);
  const thrum_status status = thrum_load_add_field(body->model, local, reduced, error);
  free(local);
  return status;
}

static thrum_status reduce_load(const scene_body *body, const thrum_scene_load_def *load,
                                double *reduced, thrum_error *error) {
  double local[3];
  thrum_status status = THRUM_OK;

  // accelerations and reduced loads have their scale already
  switch (load->kind) {
  case THRUM_SCENE_ACCELERATION:
    return reduce_acceleration(body, load->vector, reduced, error);
  case THRUM_SCENE_REDUCED:
    status = scene_reduced_check(body, load, error);
    if (status >= 0)
      memcpy(reduced, load->reduced, (size_t)body->model->rank * sizeof *reduced);
    return status;
  case THRUM_SCENE_FIELD:
    status = load->field == NULL
                 ? thrum_error_set(error, THRUM_INVALID_ARGUMENT, "a field of forces is NULL")
                 : reduce_field(body, load->field, reduced, error);
    break;
  case THRUM_SCENE_FORCE:
    scene_to_body(&body->placement, load->vector, local);
    status = thrum_load_add_shared(body->model, load->vertices, load->count, local, reduced, error);
    break;
  default:
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "a load is of no known kind");
  }

  // a force acts on the scaled body through its scaled basis
  for (int64_t i = 0; status >= 0 && i < body->model->rank; i++)
    reduced[i] *= body->k;
  return status;
}

/* The numbers of a load by their rows, and its choices. */
static thrum_status check_load(const scene_body *body, const thrum_scene_load_def *load,
                               thrum_error *error) {
  THRUM_TRY(scene_fields_check(THRUM_SCENE_RECORD_LOAD, load, error));
  if ((unsigned)load->course.shape > THRUM_LOAD_RAMP)
    return thrum_error_set_field(error, "shape", THRUM_INVALID_ARGUMENT,
                                 " of a load is none that is known");
  if (load->field != NULL && load->field_count != body->model->vertex_count)
    return thrum_error_set_field(
        error, "field", THRUM_MODEL_MISMATCH, " has %lld forces, and the model %lld vertices",
        (long long)load->field_count, (long long)body->model->vertex_count);
  return THRUM_OK;
}

thrum_status thrum_scene_add_load(thrum_scene *scene, int32_t number,
                                  const thrum_scene_load_def *load, thrum_error *error) {
  thrum_scene_load_def whole = thrum_default_scene_load_def();
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  load = thrum_def_whole(load, &whole, sizeof whole);
  THRUM_TRY(check_load(body, load, error));

  // room first, so that a load is added whole or not at all
  const int64_t r = body->model->rank, count = body->load_count + 1;
  if (!scene_grow(&body->courses, count, sizeof *body->courses) ||
      !scene_grow(&body->now, count, sizeof *body->now) ||
      !scene_grow(&body->directions, count * r, sizeof *body->directions))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a load");
  double *direction = body->directions + body->load_count * r;
  memset(direction, 0, (size_t)r * sizeof *direction);
  thrum_status status = reduce_load(body, load, direction, error);
  if (status >= 0 && body->free)
    status = scene_parts_make(body, load, body->load_count, error);
  if (status < 0)
    return status;
  body->courses[body->load_count++] = load->course;
  scene->revision++;
  scene->stirred++;
  scene_loads_retime(scene);
  return THRUM_OK;
}

static thrum_load counted_from(const thrum_load *course, double origin) {
  thrum_load now = *course;
  now.from -= origin;
  now.until -= origin;
  return now;
}

void scene_loads_retime(thrum_scene *scene) {
  for (int32_t n = 0; n < scene->body_count; n++) {
    scene_body *body = scene->bodies[n];
    // gravity stands outside of time
    body->now[0] = body->courses[0];
    for (int64_t l = 1; l < body->load_count; l++)
      body->now[l] = counted_from(&body->courses[l], scene->origin);
  }
  for (int32_t n = 0; n < scene->base_motion_count; n++)
    scene->base_motions[n].now = counted_from(&scene->base_motions[n].course, scene->origin);
  scene_actuation_retime(scene);
}

/* Mean of one sampled motion over the step that lies `ahead` of the one to come. With dt changed
 * midway, steps are no multiples of dt any more, and the mean is what the velocity gains. */
static void motion_mean(const thrum_scene *scene, const thrum_base_motion *motion, int64_t ahead,
                        double mean[3]) {
  if (scene->origin == 0 && scene->origin_step == 0) {
    thrum_base_motion_mean(motion, scene->steps + ahead, scene->dt, mean);
    return;
  }
  double before[3], after[3];
  const double time = thrum_scene_time(scene) + (double)ahead * scene->dt;
  thrum_base_motion_at(motion, time, NULL, before);
  thrum_base_motion_at(motion, time + scene->dt, NULL, after);
  for (int axis = 0; axis < 3; axis++)
    mean[axis] = (after[axis] - before[axis]) / scene->dt;
}

/* Mean acceleration of the base over that step. */
static void base_motion_mean(const thrum_scene *scene, int64_t ahead, double mean[3]) {
  const int64_t step = scene->steps - scene->origin_step + ahead;
  mean[0] = mean[1] = mean[2] = 0;
  for (int32_t n = 0; n < scene->base_motion_count; n++) {
    const scene_base_motion *base_motion = &scene->base_motions[n];
    double one[3];
    if (base_motion->motion != NULL)
      motion_mean(scene, base_motion->motion, ahead, one);
    const double share =
        base_motion->motion == NULL ? thrum_load_mean(&base_motion->now, step, scene->dt) : 0;
    for (int axis = 0; axis < 3; axis++)
      mean[axis] += base_motion->motion == NULL ? share * base_motion->amplitude[axis] : one[axis];
  }
}

void scene_loads_ahead(const thrum_scene *scene, scene_body *body, int64_t ahead, double mean[3]) {
  const int64_t r = body->model->rank, step = scene->steps - scene->origin_step + ahead;
  thrum_load_sum(body->now, body->directions, body->load_count, r, step, scene->dt, body->force);
  if (scene->base_motion_count == 0)
    return;

  // the base moves: inertia in the axes of the body
  double local[3];
  base_motion_mean(scene, ahead, mean);
  scene_to_body(&body->here, mean, local);
  memset(body->inertia, 0, (size_t)r * sizeof *body->inertia);
  // cannot fail: looked at when the base motion was added
  thrum_base_motion_load(body->model, local, body->inertia, NULL);
  for (int64_t i = 0; i < r; i++) {
    body->inertia[i] *= body->mass;
    body->force[i] += body->inertia[i];
  }
}

void scene_loads_sum(const thrum_scene *scene, scene_body *body, scene_wrench *wrench) {
  double mean[3] = {0};
  if (body->free)
    scene_parts_sum(scene, body, scene->steps - scene->origin_step, wrench);
  scene_loads_ahead(scene, body, 0, mean);

  // the whole of a free body stays behind the base
  for (int axis = 0; axis < 3 && body->free && scene->base_motion_count > 0; axis++)
    wrench->force[axis] -= body->way.mass * mean[axis];
}
