/* Changes between two steps: the state is made anew where it must be, and q and p are carried over.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_access.h"
#include "scene/scene_detail.h"
#include "scene/scene_free_make.h"
#include "scene/scene_link.h"
#include "scene/scene_loads.h"
#include "scene/scene_obstacle.h"
#include "scene/scene_rebuild.h"
#include "scene/scene_skin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The same, condensed or not as before. */
static thrum_status rebuild(thrum_scene *scene, scene_body *body, const thrum_state_def *def,
                            int64_t rank, double stiffness, thrum_error *error) {
  return scene_rebuild(scene, body, def, rank, body->derived->condensed, stiffness, error);
}

thrum_status thrum_scene_set_damping(thrum_scene *scene, int32_t number, double alpha, double beta,
                                     thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  thrum_state_def def = body->def;
  def.damping_alpha = alpha;
  def.damping_beta = beta;
  return rebuild(scene, body, &def, body->derived->rank, body->derived->by.stiffness, error);
}

thrum_status thrum_scene_set_stiffness(thrum_scene *scene, int32_t number, double stiffness,
                                       thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  THRUM_TRY(rebuild(scene, body, &body->def, body->derived->rank, stiffness, error));
  scene->stirred++;
  return THRUM_OK;
}

thrum_status thrum_scene_set_integrator(thrum_scene *scene, int32_t number,
                                        thrum_integrator integrator, thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  thrum_state_def def = body->def;
  def.integrator = integrator;
  return rebuild(scene, body, &def, body->derived->rank, body->derived->by.stiffness, error);
}

/* The number of coordinates is the business of a level of detail, where there is one. */
static thrum_status check_detail(const scene_body *body, thrum_error *error) {
  if (body->detail == NULL)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "body '%s' has a level of detail, which sets how many coordinates it "
                         "steps: take that away first",
                         body->name);
}

/* A link knows the coordinates that its bodies step. */
static thrum_status check_tied(const scene_body *body, thrum_error *error) {
  if (body->tied == 0)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "body '%s' is or was linked, so it goes on with the coordinates that it "
                         "steps",
                         body->name);
}

/* What follows does not touch with its surface. */
static thrum_status check_touches(const thrum_scene *scene, const scene_body *body,
                                  thrum_error *error) {
  if (!scene_collides(scene, body, body->derived))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "body '%s' touches %s, so it steps all of its coordinates; with "
                         "thrum_scene_set_condensed it would touch none",
                         body->name,
                         body->self_contact ? "itself" : "others or obstacles with faces");
}

thrum_status thrum_scene_set_rank(thrum_scene *scene, int32_t number, int64_t rank,
                                  thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  THRUM_TRY(check_detail(body, error));
  THRUM_TRY(check_tied(body, error));
  if (rank < 1 || rank > body->model->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "rank %lld is asked for; the model has 1 to %lld", (long long)rank,
                           (long long)body->model->rank);
  // coordinates that are not stepped follow, for a body without them would lock
  const bool fewer = rank < body->model->rank;
  THRUM_TRY(fewer ? check_touches(scene, body, error) : THRUM_OK);
  return scene_rebuild(scene, body, &body->def, rank, fewer || thrum_model_masters(body->model) > 0,
                       body->derived->by.stiffness, error);
}

thrum_status thrum_scene_set_condensed(thrum_scene *scene, int32_t number, int64_t masters,
                                       thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  THRUM_TRY(check_detail(body, error));
  THRUM_TRY(check_tied(body, error));
  if (masters > 0 && body->self_contact)
    return thrum_error_set(
        error, THRUM_UNSUPPORTED,
        "body '%s' touches itself, so it steps all of its coordinates: it cannot "
        "be condensed",
        body->name);
  return scene_condense(scene, number, masters, error);
}

/* A snapshot that a change which fails half-way goes back to; NULL without memory. */
static void *keep(const thrum_scene *scene, size_t *size, thrum_error *error) {
  *size = thrum_scene_snapshot_size(scene);
  void *memory = malloc(*size);
  if (memory == NULL)
    thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory to keep the scene as it is");
  else
    thrum_scene_snapshot(scene, memory, *size, NULL);
  return memory;
}

thrum_status thrum_scene_set_dt(thrum_scene *scene, double dt, thrum_error *error) {
  if (!isfinite(dt) || !(dt > 0))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "dt is %g; it must be finite and > 0 [s]",
                           dt);
  size_t size = 0;
  void *kept = keep(scene, &size, error);
  thrum_status status = kept != NULL ? THRUM_OK : THRUM_OUT_OF_MEMORY;
  for (int32_t n = 0; status >= 0 && n < scene->body_count; n++) {
    scene_body *body = scene->bodies[n];
    status = thrum_state_set_dt(body->derived->model, body->state, dt, error);
    body->q_known = body->p_known = false;
  }
  if (status < 0 && kept != NULL)
    thrum_scene_restore(scene, kept, size, NULL);
  free(kept);
  if (status < 0)
    return status;

  // time courses are counted from here on in steps of the new length
  scene->origin = thrum_scene_time(scene);
  scene->origin_step = scene->steps;
  scene->dt = dt;
  for (int32_t n = 0; n < scene->body_count; n++)
    scene->bodies[n]->def.dt = dt;
  scene->revision++;
  scene_loads_retime(scene);
  return THRUM_OK;
}

/* A body at its start, with the counters of a new one. */
static thrum_status restart(thrum_scene *scene, scene_body *body, thrum_error *error) {
  const thrum_model *model = body->derived->model;

  // a fresh state forgets its counters and its solver
  thrum_status status = thrum_state_init(body->state, thrum_state_bytes(body->state), model,
                                         &body->def, &body->state, error);
  THRUM_THEN(status, thrum_state_lend(body->state, scene->scratch, scene->scratch_size, error));

  body->status = THRUM_OK;

  // motion as a whole, touches and energies begin again
  if (body->free)
    scene_free_reset(body);
  if (body->touch != NULL)
    thrum_contact_reset(body->touch->contact);
  scene_detail_restart(body);
  body->work_load = body->work_base = 0;
  body->before_state = (scene_counts){0};
  body->q_known = body->p_known = false;
  memcpy(body->before, body->start_q, (size_t)model->rank * sizeof *body->before);
  memset(body->answered, 0, (size_t)body->model->rank * sizeof *body->answered);
  memset(body->pulled, 0, (size_t)body->model->rank * sizeof *body->pulled);

  if (status < 0)
    return status;
  return thrum_state_set(model, body->state, body->start_q, body->start_p, error);
}

thrum_status thrum_scene_reset(thrum_scene *scene, thrum_error *error) {
  size_t size = 0;

  // what a level of detail has condensed starts with all of its coordinates
  for (int32_t n = 0; n < scene->body_count; n++)
    THRUM_TRY(scene_detail_wake(scene, n, error));
  void *kept = keep(scene, &size, error);
  thrum_status status = kept != NULL ? THRUM_OK : THRUM_OUT_OF_MEMORY;
  for (int32_t n = 0; status >= 0 && n < scene->body_count; n++)
    status = restart(scene, scene->bodies[n], error);
  if (status < 0 && kept != NULL)
    thrum_scene_restore(scene, kept, size, NULL);
  free(kept);
  if (status < 0)
    return status;

  // time begins again, for obstacles and time courses too
  scene->steps = scene->origin_step = 0;
  scene->origin = 0;
  scene_obstacles_reset(scene);
  thrum_contact_pairs_reset(scene->pairs.contact);
  scene_links_reset(scene);
  scene_loads_retime(scene);
  return THRUM_OK;
}
