/* Bodies: what a def says becomes a state at its start.
 * SPDX-License-Identifier: Apache-2.0 */

#include "scene/scene_base_motion.h"
#include "scene/scene_contact.h"
#include "scene/scene_detail.h"
#include "scene/scene_fields.h"
#include "scene/scene_free_make.h"
#include "scene/scene_link.h"
#include "scene/scene_loads.h"
#include "scene/scene_memory.h"
#include "scene/scene_model.h"
#include "scene/scene_pairs_room.h"
#include "scene/scene_placement.h"
#include "scene/scene_skin.h"
#include "scene/scene_solid.h"
#include "scene/scene_state.h"
#include "scene/scene_surface.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "thrum/condensed_model.h"
#include "thrum/displacement.h"

#define BODY_VECTORS 9

thrum_status thrum_scene_set_workers(thrum_scene *scene, int32_t workers, thrum_scene_run run,
                                     void *context, thrum_error *error) {
  if (workers < 1 || workers > THRUM_SCENE_WORKERS_MAX || (workers > 1 && run == NULL))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a scene has 1 to %d workers, and more than one need a function that "
                           "runs them",
                           THRUM_SCENE_WORKERS_MAX);
  void *workspace = NULL;
  if (scene->workspace_size > 0) {
    workspace = scene_aligned((size_t)workers * scene->workspace_size);
    if (workspace == NULL)
      return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %d workers", (int)workers);
  }
  thrum_status status = scene_scratch_replace(scene, workers, scene->scratch_size, error);
  THRUM_THEN(status, scene_pairs_share(scene, workers, error));
  if (status < 0) {

    // some blocks may be those of the new number
    scene->workers = workers < scene->workers ? workers : scene->workers;
    free(workspace);
    return status;
  }
  free(scene->workspace);
  scene->workspace = workspace;
  scene->workers = workers;
  scene->run = workers > 1 ? run : NULL;
  scene->run_context = context;
  return THRUM_OK;
}

static void free_body(thrum_scene *scene, scene_body *body) {
  if (body == NULL)
    return;

  // a body that was made in part has NULL for what it lacks
  scene_detail_free(scene, body);
  thrum_state_destroy(body->state);
  free(body->vectors);
  free(body->slopes);
  free(body->courses);
  free(body->now);
  free(body->directions);
  free(body->acts);
  free(body->parts);
  free(body->moments);
  free(body->resultants);
  free(body->inertia_work);

  free(body->surface);
  free(body->areas);
  free(body->stretch);
  free(body->touching);
  free(body->touch_areas);
  scene_touch_free(body->touch);
  scene_skin_drop(scene, body->skin);
  free(body->triangles);
  scene_model_drop(scene, body->derived);
  free(body);
}

/* One block for all vectors of a body, and room for the load that gravity is. */
static thrum_status make_vectors(scene_body *body, thrum_error *error) {
  const size_t r = (size_t)body->model->rank;
  body->vectors = calloc(BODY_VECTORS * r, sizeof *body->vectors);
  body->courses = calloc(1, sizeof *body->courses);
  body->now = calloc(1, sizeof *body->now);
  body->directions = calloc(r, sizeof *body->directions);
  if (!body->vectors || !body->courses || !body->now || !body->directions)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a body of rank %zu", r);

  // the vectors share one block
  double **const each[BODY_VECTORS] = {&body->start_q, &body->start_p,  &body->force,
                                       &body->inertia, &body->before,   &body->q,
                                       &body->p,       &body->answered, &body->pulled};
  for (size_t n = 0; n < BODY_VECTORS; n++)
    *each[n] = body->vectors + n * r;

  // gravity is the first load, constant and without end
  body->courses[0] = body->now[0] = (thrum_load){.shape = THRUM_LOAD_CONSTANT, .until = INFINITY};
  body->load_count = 1;
  return THRUM_OK;
}

/* q and p of the start; a mode's amplitude is that of the scaled body. */
static thrum_status make_start(const thrum_scene_body_def *def, scene_body *body,
                               thrum_error *error) {
  const int64_t r = body->model->rank;
  if (def->q != NULL)
    memcpy(body->start_q, def->q, (size_t)r * sizeof *def->q);
  if (def->p != NULL)
    memcpy(body->start_p, def->p, (size_t)r * sizeof *def->p);
  if (def->start_mode == 0)
    return THRUM_OK;
  if (def->start_mode > body->derived->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "there is no mode %lld to start from: the body has modes 1 to %lld",
                           (long long)def->start_mode, (long long)body->derived->rank);
  return thrum_mode_add(body->model, def->start_mode - 1, def->start_amplitude / body->k,
                        body->start_q, error);
}

static thrum_status check_def(const thrum_scene_body_def *def, thrum_error *error) {
  THRUM_TRY(scene_fields_check(THRUM_SCENE_RECORD_BODY, def, error));
  if (def->model == NULL || def->model->rank < 1)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the body's def has no model");

  // a lower rank and condensing both let the other coordinates follow
  if (def->rank > def->model->rank)
    return thrum_error_set_field(error, "rank", THRUM_INVALID_ARGUMENT,
                                 " is %lld; the model has 1 to %lld", (long long)def->rank,
                                 (long long)def->model->rank);
  if (def->rank > 0 && (def->condense != 0 || thrum_model_masters(def->model) > 0))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a body's rank and condense both say how many coordinates are "
                           "stepped: set one of them");
  return THRUM_OK;
}

static void set_name(const thrum_scene *scene, const char *name, scene_body *body) {
  if (name != NULL)
    snprintf(body->name, sizeof body->name, "%.*s", THRUM_SCENE_NAME_MAX - 1, name);
  else
    snprintf(body->name, sizeof body->name, "body%d", (int)scene->body_count + 1);
}

/* Fills a zeroed body; what it owns is freed by free_body, whatever came of it. */
static thrum_status make_body(thrum_scene *scene, const thrum_scene_body_def *def, scene_body *body,
                              thrum_error *error) {
  const thrum_model_scaling by = {def->scale, def->stiffness, def->density};
  const int64_t lower = def->rank < def->model->rank ? def->rank : 0;
  const int64_t fewer = def->condense > 0 ? def->condense : lower;
  const int64_t masters = fewer > 0 ? fewer : thrum_model_masters(def->model);
  const int64_t rank = masters > 0 ? masters : def->model->rank;
  body->model = def->model;
  body->def = def->state;
  body->def.dt = scene->dt;
  body->def.borrows_scratch = 1;
  memcpy(body->colour, def->colour, sizeof body->colour);
  set_name(scene, def->name, body);

  // where it stands, and its vectors at the rank of the model
  THRUM_TRY(scene_placement_make(def->position, def->rotation, &body->placement, error));
  body->here = body->placement;
  THRUM_TRY(make_vectors(body, error));
  THRUM_TRY(scene_model_take(scene, def->model, rank, masters > 0, &by, &body->derived, error));
  // thrum_model_scale: k = (d s^3)^-1/2, g = k / s
  const double volume = by.length * by.length * by.length;
  body->k = 1 / sqrt(by.density * volume);
  body->g = body->k / by.length;
  body->mass = by.density * volume * body->k;

  // the start, and all that acts on the body
  THRUM_TRY(make_start(def, body, error));
  memcpy(body->before, body->start_q, (size_t)body->model->rank * sizeof *body->before);
  if (masters > 0)
    THRUM_TRY(scene_slopes_make(body, error));
  THRUM_TRY(scene_free_make(def, body, error));
  THRUM_TRY(scene_surface_make(def, body, error));
  THRUM_TRY(scene_triangles_keep(def, body, error));
  if (scene->base_motion_count > 0)
    THRUM_TRY(scene_base_motion_check(body, error));
  THRUM_TRY(scene_gravity_reduce(body, scene->gravity, error));
  THRUM_TRY(scene_state_make(scene, body->derived->model, &body->def, body->start_q, body->start_p,
                             &body->state, error));
  THRUM_TRY(scene_skin_take(scene, body, body->derived, &body->skin, error));
  return scene_touch_make(scene, body, body->derived, body->state, &body->touch, error);
}

thrum_status thrum_scene_add_body(thrum_scene *scene, const thrum_scene_body_def *def,
                                  int32_t *number, thrum_error *error) {
  thrum_scene_body_def whole;
  def = scene_body_def_whole(def, &whole);
  THRUM_TRY(check_def(def, error));
  scene_body *body = calloc(1, sizeof *body);
  if (body == NULL || !scene_grow(&scene->bodies, scene->body_count + 1, sizeof *scene->bodies)) {
    free(body);
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a body");
  }

  // a body that cannot be made leaves the scene as it was: room for its touches, which snapshots
  // know, comes last
  thrum_status status = make_body(scene, def, body, error);
  THRUM_THEN(status, scene_make_room(scene, scene->body_count + 1, error));
  THRUM_THEN(status, scene_pairs_room(scene, body, body->skin, error));
  if (status < 0) {
    free_body(scene, body);
    return status;
  }

  if (number != NULL)
    *number = scene->body_count;
  scene->bodies[scene->body_count++] = body;
  scene->revision++;
  scene_loads_retime(scene);
  return THRUM_OK;
}

thrum_status thrum_scene_create(double dt, thrum_scene **scene, thrum_error *error) {
  if (scene == NULL || !isfinite(dt) || !(dt > 0))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the time step of a scene must be finite and > 0 [s]");
  thrum_scene *made = calloc(1, sizeof *made);
  if (made == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a scene");
  made->dt = dt;
  made->workers = 1;
  made->pairs.def = thrum_default_contact_pairs_def();
  *scene = made;
  return THRUM_OK;
}

void thrum_scene_destroy(thrum_scene *scene) {
  if (scene == NULL)
    return;

  // bodies go first: they give their models back to the scene
  for (int32_t n = 0; n < scene->body_count; n++)
    free_body(scene, scene->bodies[n]);

  // parts that own memory come before the lists that hold them
  for (int32_t n = 0; n < scene->probe_count; n++)
    free(scene->probes[n].rows);
  scene_pairs_free(scene);
  scene_solids_free(scene);
  scene_links_free(scene);

  // the lists, the work of the workers, and the scene itself
  free(scene->bodies);
  free(scene->probes);
  free(scene->base_motions);
  free(scene->obstacles);
  free(scene->obstacle_starts);
  free(scene->side);
  free(scene->side_status);
  free(scene->side_body);
  free(scene->side_error);
  free(scene->chunks);
  free(scene->workspace);
  free(scene->scratch);
  free(scene);
}
