/* Loads the models of a scene file. SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_file_models.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "driver/model/locking.h"
#include "driver/model/model_cut.h"
#include "driver/scene/scene_words.h"
#include "io/paths.h"
#include "mesh/formats/mesh_read.h"
#include "platform/allocate.h"
#include "precompute/model/solid_inertia.h"
#include "thrum/thrum.h"

static bool same_texts(const config_texts *left, const config_texts *right) {
  bool same = left->count == right->count;
  for (int64_t n = 0; n < left->count && same; n++)
    same = strcmp(left->texts[n], right->texts[n]) == 0;
  return same;
}

/* Do two bodies name one model file? Points of a mesh are trained on its yield. Materials that are
 * not given are NaN, so bytes are compared.
 */
static bool same_file(const scene_body_spec *left, const scene_body_spec *right) {
  return strcmp(left->model, right->model) == 0 && same_texts(&left->fix, &right->fix) &&
         memcmp(&left->material.material, &right->material.material,
                sizeof left->material.material) == 0 &&
         left->material.law == right->material.law && left->order == right->order &&
         same_texts(&left->material.regions, &right->material.regions) &&
         (!thrum_mesh_is_named(left->model) ||
          left->material.plastic.yield == right->material.plastic.yield);
}

/* Whether an option is to blame. */
static bool blames(const thrum_error *detail, const char *option) {
  return detail->field != NULL && strcmp(detail->field, option) == 0;
}

/* Refuses what a model cannot be made of, by the key of what is to blame, or else by the model. */
static thrum_status refuse(const scene_spec *spec, const scene_body_spec *body, thrum_status status,
                           const thrum_error *detail) {
  const char *message = detail->message[0] != 0 ? detail->message : thrum_status_text(status);
  const bool regions = blames(detail, "--material"), fix = blames(detail, "--fix");
  return config_record_refuse(&spec->file, regions ? &body->material.at : &body->settings.at,
                              regions ? "regions"
                              : fix   ? "fix"
                                      : "model",
                              status, "%s", regions || fix ? thrum_error_reason(detail) : message);
}

/* Hexahedra and wedges that are free get the inertia of their shape, in a copy of the model. */
static thrum_status add_inertia(scene_loaded *item, thrum_error *error) {
  THRUM_TRY(thrum_solid_inertia(item->model, &item->inertia, error));
  if (item->inertia == NULL)
    return THRUM_OK;
  THRUM_TRY(thrum_reserve(&item->coupled, 1, sizeof *item->coupled, "a model", error));
  *item->coupled = *item->model;
  item->coupled->inertia = item->inertia;
  item->model = item->coupled;
  return THRUM_OK;
}

static thrum_status load_file(const scene_spec *spec, bool quiet, scene_loaded *item) {
  const scene_body_spec *body = item->first;
  mesh_model_def def = mesh_model_def_default();
  def.fix_count = body->fix.count;
  def.free = body->free;
  def.reading.order = body->order;
  def.material = body->material.material;
  def.law = body->material.law;
  if (!isinf(body->material.plastic.yield))
    def.yield = body->material.plastic.yield;
  for (int64_t n = 0; n < body->fix.count; n++)
    def.fixes[n] = body->fix.texts[n];
  def.material_count = body->material.regions.count;
  for (int64_t n = 0; n < def.material_count; n++)
    def.materials[n] = body->material.regions.texts[n];

  // what the making of a model warns of is said of this body, in the words of the file
  char place[SCENE_PLACE_MAX];
  thrum_error detail = {0};
  config_warn_under(scene_body_place(spec, body, place), scene_words);
  thrum_status status =
      mesh_model_load(body->model, &def, quiet, &item->model, &item->file, &detail);
  config_warn_under(NULL, scene_words);
  item->file_model = item->model;

  // the hash ties the files of a run to this model
  THRUM_THEN(status, model_hash_make(item->file.path, item->model, &item->hash, &detail));
  THRUM_THEN(status, add_inertia(item, &detail));

  if (status < 0)
    return refuse(spec, body, status, &detail);

  return THRUM_OK;
}

/* A rank that the model cannot be stepped at is refused by its line. */
static thrum_status check_rank(const scene_spec *spec, const scene_body_spec *body,
                               const thrum_model *model) {
  thrum_error detail = {0};
  int64_t masters = 0;
  const thrum_status status =
      model_masters_asked(model, body->rank, body->condense, &masters, &detail);
  if (status >= 0)
    return THRUM_OK;

  return config_record_refuse(&spec->file, &body->settings.at, "rank", status, "%s",
                              thrum_error_reason(&detail));
}

/* The place of a body's model among those loaded, or a new one. */
static thrum_status load(const scene_spec *spec, bool quiet, const scene_body_spec *body,
                         scene_models *models, int64_t *place) {
  // a file is loaded once
  int64_t n = 0;
  while (n < models->count && !same_file(models->items[n].first, body))
    n++;
  *place = n;
  scene_loaded *item = &models->items[n];
  if (n == models->count) {
    models->count++;
    item->first = body;
    THRUM_TRY(load_file(spec, quiet, item));
  }
  return check_rank(spec, body, item->model);
}

thrum_status scene_models_load(const scene_spec *spec, bool quiet, scene_models *models,
                               thrum_error *error) {
  static const char what[] = "the models of a scene";
  const int64_t count = spec->bodies.count;
  *models = (scene_models){0};
  THRUM_TRY(thrum_reserve(&models->items, count, sizeof *models->items, what, error));
  THRUM_TRY(thrum_reserve(&models->of_body, count, sizeof *models->of_body, what, error));
  for (int64_t n = 0; n < count; n++)
    THRUM_TRY(load(spec, quiet, &scene_bodies(spec)[n], models, &models->of_body[n]));
  return THRUM_OK;
}

void scene_models_warn(const scene_spec *spec, const scene_models *models) {
  char place[SCENE_PLACE_MAX];
  for (int64_t n = 0; n < models->count; n++) {
    const scene_loaded *item = &models->items[n];
    config_warn_under(scene_body_place(spec, item->first, place), scene_words);
    locking_warn(path_basename(item->first->model), item->model);
  }
  config_warn_under(NULL, scene_words);
}

thrum_status scene_models_skin(scene_models *models, int64_t body, const scene_loaded **skinned,
                               thrum_error *error) {
  scene_loaded *item = &models->items[models->of_body[body]];
  display_surface *skin = &item->skin;
  *skinned = item;
  if (item->corners != NULL)
    return THRUM_OK;

  // made once for each file, when the first body needs it
  THRUM_TRY(display_surface_make(item->model, skin, error));

  // the scene wants corners as numbers of the mesh's vertices
  item->corners = malloc(3 * (size_t)skin->triangle_count * sizeof *item->corners + 1);
  if (item->corners == NULL) {
    display_surface_free(skin);
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the surface");
  }
  display_surface_corners(skin, item->corners);
  return THRUM_OK;
}

void scene_models_free(scene_models *models) {
  for (int64_t n = 0; n < models->count; n++) {
    display_surface_free(&models->items[n].skin);
    free(models->items[n].corners);
    free(models->items[n].coupled);
    free(models->items[n].inertia);
    thrum_model_destroy(models->items[n].file_model);
  }
  free(models->items);
  free(models->of_body);
  *models = (scene_models){0};
}
