/* Contact and pulls of one body: a contact (thrum/contact.h) over the points that touch or are
 * pulled, whose rows of U' = k U are all that is copied of the basis.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_contact.h"

#include "scene/scene_access.h"
#include "scene/scene_condensed.h"
#include "scene/scene_free_body.h"
#include "scene/scene_memory.h"
#include "scene/scene_placement.h"
#include "scene/scene_shape.h"
#include "scene/scene_skin.h"

#include "core/base/finite.h"
#include "core/base/vec3.h"

#include <stdlib.h>
#include <string.h>

static bool pulled(const scene_body *body) {
  bool any = false;
  for (int n = 0; n < THRUM_SCENE_PULLS; n++)
    any = any || body->pulls[n].used;
  return any;
}

void scene_touch_free(scene_touch *touch) {
  if (touch == NULL)
    return;
  free(touch->rest);
  free(touch->rows);
  free(touch->vertices);
  free(touch->places);
  free(touch->contact);
  free(touch);
}

/* Point `place` becomes the model's vertex `vertex`. */
static void fill_point(const scene_body *body, scene_touch *touch, int64_t place, int64_t vertex) {
  const thrum_model *from = body->model;
  const int64_t rank = touch->model.rank;
  touch->vertices[place] = vertex;
  for (int axis = 0; axis < 3; axis++) {
    const double *row = from->basis + (3 * vertex + axis) * from->rank;
    touch->rest[3 * place + axis] = body->derived->by.length * from->vertices[3 * vertex + axis];
    for (int64_t i = 0; i < rank; i++)
      touch->rows[(3 * place + axis) * rank + i] = body->k * row[i];
  }
}

/* The stepped model with the points as its mesh, and the material that its stiffness follows. */
static void make_model(const scene_body *body, const scene_model *derived, scene_touch *touch) {
  const thrum_model *from = body->model;
  touch->model = *derived->model;
  touch->model.vertex_count = touch->count;
  touch->model.vertices = touch->rest;
  touch->model.basis = touch->rows;
  for (int64_t n = 0; from->material && n < from->region_count; n++)
    if (derived->by.stiffness * from->material[3 * n] > touch->material[0])
      touch->material[0] = derived->by.stiffness * from->material[3 * n];
  touch->model.material = touch->material;
  touch->model.region_count = 1;
}

static thrum_status make_contact(const scene_body *body, int64_t points, const thrum_state *state,
                                 scene_touch *touch, thrum_error *error) {
  thrum_contact_def def = thrum_default_contact_def();
  size_t size = 0;

  // the first points touch, the places behind them are for pulls; a body that only is pulled has
  // one
  def.vertices = touch->places;
  def.vertex_count = points > 0 ? points : 1;
  def.areas = points > 0 && body->areas_known ? body->touch_areas : NULL;
  def.stiffness = body->touch_stiffness;
  def.pull_max = THRUM_SCENE_PULLS;

  // pulls may be as strong as the size of the body says, of which few points may be known here
  const thrum_model *whole = body->model;
  def.diagonal =
      body->derived->by.length * thrum_box3_diagonal(whole->vertices, whole->vertex_count);

  THRUM_TRY(thrum_contact_size(&touch->model, state, &def, &size, error));
  void *memory = scene_aligned(size);
  if (memory == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a contact of %zu bytes",
                           size);

  touch->contact = memory;
  touch->bytes = size + (size_t)(3 * touch->count * (touch->model.rank + 1)) * sizeof(double);
  return thrum_contact_init(memory, size, &touch->model, state, &def, &touch->contact, error);
}

thrum_status scene_touch_make(const thrum_scene *scene, const scene_body *body,
                              const scene_model *derived, const thrum_state *state,
                              scene_touch **made, thrum_error *error) {
  // a body that nothing can touch and nothing pulls needs no contact
  const int64_t points = scene->obstacle_count > 0 ? body->touch_count : 0;
  *made = NULL;
  if (points == 0 && !pulled(body) && body->tied == 0 && !scene_collides(scene, body, derived))
    return THRUM_OK;

  // points for what may touch, and for each pull that may come
  scene_touch *touch = calloc(1, sizeof *touch);
  if (touch != NULL) {
    const size_t count = (size_t)(points + THRUM_SCENE_PULLS);
    touch->count = (int64_t)count;
    touch->idle = points == 0;
    touch->rest = calloc(3 * count, sizeof *touch->rest);
    touch->rows = calloc(3 * count * (size_t)derived->rank, sizeof *touch->rows);
    touch->places = calloc(count, sizeof *touch->places);
    touch->vertices = calloc(count, sizeof *touch->vertices);
  }
  if (touch == NULL || !touch->rest || !touch->rows || !touch->places || !touch->vertices) {
    scene_touch_free(touch);
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a contact");
  }

  // places that no point has yet
  for (int64_t n = 0; n < touch->count; n++)
    touch->vertices[n] = -1;

  // the reduced model of these points alone
  make_model(body, derived, touch);
  for (int64_t n = 0; n < points; n++) {
    touch->places[n] = (int32_t)n;
    fill_point(body, touch, n, body->touching[n]);
  }
  for (int n = 0; n < THRUM_SCENE_PULLS; n++)
    if (body->pulls[n].used)
      fill_point(body, touch, points + n, body->pulls[n].vertex);

  const thrum_status status = make_contact(body, points, state, touch, error);
  if (status < 0)
    scene_touch_free(touch);
  else
    *made = touch;
  return status;
}

/* Bodies that nothing touches are stepped side by side again. */
void scene_touch_trim(const thrum_scene *scene, scene_body *body) {
  if (body->touch == NULL || !body->touch->idle || pulled(body) || body->tied > 0 ||
      scene_collides(scene, body, body->derived))
    return;
  scene_touch_free(body->touch);
  body->touch = NULL;
}

/* The pulls in use, and their number. */
static int64_t list_pulls(const scene_body *body, thrum_pull pulls[THRUM_SCENE_PULLS]) {
  const int64_t first = body->touch->count - THRUM_SCENE_PULLS;

  // the last points of the contact are those of the pulls, one a slot
  int64_t count = 0;
  for (int n = 0; n < THRUM_SCENE_PULLS; n++) {
    const scene_pull *pull = &body->pulls[n];
    const int32_t place = (int32_t)(first + n);
    if (!pull->used)
      continue;

    thrum_pull *listed = &pulls[count++];
    *listed = (thrum_pull){.vertices = {place, place, place},
                           .weights = {1, 0, 0},
                           .stiffness = pull->stiffness,
                           .damping = pull->damping};
    memcpy(listed->target, pull->target, sizeof listed->target);
    if (body->derived->condensed)
      scene_condensed_pull(body, pull->vertex, listed);
  }
  return count;
}

void scene_environment(const thrum_scene *scene, scene_body *body,
                       thrum_pull pulls[THRUM_SCENE_PULLS],
                       thrum_contact_environment *environment) {
  *environment =
      (thrum_contact_environment){.placement = &body->placement,
                                  .translation = body->free ? &body->way : NULL,
                                  .rigid_frame = body->free ? &body->rigid_frame : NULL,
                                  .obstacles = scene->obstacles,
                                  .obstacle_count = body->touch->idle ? 0 : scene->obstacle_count,
                                  .pulls = pulls,
                                  .pull_count = list_pulls(body, pulls),
                                  .load = body->force};
  memcpy(environment->force, body->wrench.force, sizeof environment->force);
  memcpy(environment->torque, body->wrench.torque, sizeof environment->torque);
  environment->inertia = body->inertia_work != NULL ? body->derived->inertia : NULL;
  environment->inertia_work = body->inertia_work;
}

bool scene_steps_alone(const scene_body *body) {
  return body->touch != NULL && (!body->touch->idle || pulled(body));
}

thrum_status scene_touch_step(const thrum_scene *scene, scene_body *body, thrum_error *error) {
  // a condensed body's points as its coordinates follow now
  if (body->derived->condensed)
    THRUM_TRY(scene_condensed_touch(body, error));

  // where the body is and what acts on it in this step
  thrum_pull pulls[THRUM_SCENE_PULLS];
  thrum_contact_environment environment;
  scene_environment(scene, body, pulls, &environment);

  // the contact takes the step of the body; a free one has moved as a whole
  const thrum_status status = thrum_contact_step(&body->touch->model, body->state,
                                                 body->touch->contact, &environment, error);
  if (status >= 0 && body->free)
    scene_free_place(body);
  if (status >= 0 && body->derived->condensed)
    scene_answer_pulls(body);
  return status;
}

/* Adds what a force on one of the points, in the world, is on the coordinates of the body. */
static void add_point_force(const scene_body *body, int64_t place, const double force[3],
                            double *load) {
  const thrum_model *shape = body->model;
  double in_body[3];
  scene_to_body(&body->here, force, in_body);
  const double *rows = shape->basis + 3 * body->touch->vertices[place] * shape->rank;
  for (int axis = 0; axis < 3; axis++)
    for (int64_t i = 0; i < shape->rank; i++)
      load[i] += body->k * in_body[axis] * rows[axis * shape->rank + i];
}

/* Adds what the pulls of the last step are on the coordinates of the body. */
static void add_pull_forces(const scene_body *body, double *load) {
  int64_t count = 0;
  for (int n = 0; n < THRUM_SCENE_PULLS; n++) {
    double force[3];
    if (body->pulls[n].used &&
        thrum_contact_pull_force(body->touch->contact, count++, force, NULL) >= 0)
      add_point_force(body, body->touch->count - THRUM_SCENE_PULLS + n, force, load);
  }
}

void scene_answer_pulls(scene_body *body) {
  memset(body->pulled, 0, (size_t)body->model->rank * sizeof *body->pulled);
  add_pull_forces(body, body->pulled);
}

thrum_status thrum_scene_body_contact_load(const thrum_scene *scene, int32_t number, double *load,
                                           thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  memset(load, 0, (size_t)body->model->rank * sizeof *load);
  if (body->touch == NULL)
    return THRUM_OK;

  // the touches of the last step, and the pulls of its slots in use
  thrum_touch touch;
  for (int64_t n = 0; thrum_contact_touch_get(body->touch->contact, n, &touch, NULL) >= 0; n++)
    add_point_force(body, touch.vertex, touch.force, load);
  add_pull_forces(body, load);

  // from the scaled body's coordinates q', q = g q', to those of the model, in the model's own time
  for (int64_t i = 0; i < body->model->rank; i++)
    load[i] *= body->g / scene_stiffening(body);
  return THRUM_OK;
}

/* --- pulls ------------------------------------------------------------------------------------ */

/* The body and slot of a pull in use. */
static thrum_status find_pull(const thrum_scene *scene, int32_t number, scene_body **body,
                              scene_pull **pull, thrum_error *error) {
  const int32_t n = number / THRUM_SCENE_PULLS;
  if (number < 0 || n >= scene->body_count ||
      !scene->bodies[n]->pulls[number % THRUM_SCENE_PULLS].used)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "there is no pull %d now", (int)number);
  *body = scene->bodies[n];
  *pull = &(*body)->pulls[number % THRUM_SCENE_PULLS];
  return THRUM_OK;
}

static thrum_status check_pull(const scene_body *body, int64_t vertex, const double target[3],
                               double stiffness, double damping, thrum_error *error) {
  // the model must have a vertex to pull at
  THRUM_TRY(scene_vertex_check(body, vertex, error));

  // written so that NaN is refused as well
  if (!thrum_all_within(target, 3, THRUM_PLACE_MAX))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the target of a pull is not within 1e30 m");
  if (!(stiffness >= 0 && stiffness <= THRUM_CONTACT_STIFFNESS_MAX) ||
      !(damping <= THRUM_CONTACT_STIFFNESS_MAX))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "the stiffness of a pull must be 0 to 1e30, its damping at most that");
  return THRUM_OK;
}

thrum_status thrum_scene_pull_start(thrum_scene *scene, int32_t number, int64_t vertex,
                                    const double target[3], double stiffness, double damping,
                                    int32_t *pull, thrum_error *error) {
  // the pull is checked before anything changes
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  THRUM_TRY(check_pull(body, vertex, target, stiffness, damping, error));

  // the first place that no pull uses
  int slot = 0;
  while (slot < THRUM_SCENE_PULLS && body->pulls[slot].used)
    slot++;
  if (slot == THRUM_SCENE_PULLS)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "body '%s' has %d pulls already",
                           body->name, THRUM_SCENE_PULLS);

  scene_pull *made = &body->pulls[slot];
  *made = (scene_pull){.used = true, .vertex = vertex, .stiffness = stiffness, .damping = damping};
  memcpy(made->target, target, sizeof made->target);

  // the first pull of a body that touches nothing makes its contact
  thrum_status status = THRUM_OK;
  if (body->touch == NULL)
    status = scene_touch_make(scene, body, body->derived, body->state, &body->touch, error);
  else
    fill_point(body, body->touch, body->touch->count - THRUM_SCENE_PULLS + slot, vertex);
  if (status < 0) {
    made->used = false;
    return status;
  }

  // a snapshot from before this belongs to a scene of another shape
  scene->revision++;
  if (pull != NULL)
    *pull = number * THRUM_SCENE_PULLS + slot;
  return THRUM_OK;
}

thrum_status thrum_scene_pull_move(thrum_scene *scene, int32_t number, const double target[3],
                                   thrum_error *error) {
  scene_body *body = NULL;
  scene_pull *pull = NULL;
  THRUM_TRY(find_pull(scene, number, &body, &pull, error));
  THRUM_TRY(check_pull(body, pull->vertex, target, pull->stiffness, pull->damping, error));
  memcpy(pull->target, target, sizeof pull->target);
  return THRUM_OK;
}

thrum_status thrum_scene_pull_end(thrum_scene *scene, int32_t number, thrum_error *error) {
  scene_body *body = NULL;
  scene_pull *pull = NULL;
  THRUM_TRY(find_pull(scene, number, &body, &pull, error));
  pull->used = false;
  scene->stirred++;
  scene_touch_trim(scene, body);
  scene->revision++;
  return THRUM_OK;
}

thrum_status thrum_scene_pull_get(thrum_scene *scene, int32_t number, double point[3],
                                  double force[3], thrum_error *error) {
  scene_body *body = NULL;
  scene_pull *pull = NULL;
  THRUM_TRY(find_pull(scene, number, &body, &pull, error));

  // the contact counts only the pulls in use
  int64_t place = 0;
  for (const scene_pull *before = body->pulls; before < pull; before++)
    place += before->used;

  // a pull that has not acted yet has no force
  if (force != NULL) {
    memset(force, 0, 3 * sizeof *force);
    thrum_contact_pull_force(body->touch->contact, place, force, NULL);
  }

  if (point == NULL)
    return THRUM_OK;
  return thrum_scene_body_vertex(scene, number / THRUM_SCENE_PULLS, pull->vertex, point, NULL,
                                 error);
}
