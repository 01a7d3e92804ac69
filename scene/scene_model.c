/* The models that bodies step, made of those that they were given, each once.
 * SPDX-License-Identifier: Apache-2.0 */

#include "scene/scene_model.h"

#include "scene/scene_memory.h"

#include <stdlib.h>

/* The model without what a step never reads. */
static thrum_model lean(const thrum_model *model) {
  thrum_model copy = *model;
  copy.vertex_count = copy.tet_count = copy.region_count = 0;
  copy.group_count = copy.group_name_bytes = copy.group_vertex_count = copy.meta_bytes = 0;
  copy.meta = copy.fixed = copy.group_names = NULL;
  copy.vertices = copy.springs = copy.material = copy.basis = copy.rigid = NULL;
  copy.tets = copy.midsides = copy.tet_region = copy.group_ends = copy.group_vertices = NULL;
  return copy;
}

static thrum_status no_memory(const thrum_model *from, thrum_error *error) {
  return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a model of rank %lld",
                         (long long)from->rank);
}

/* model->model, condensed to its rank, in memory of its own. */
static thrum_status condense(const thrum_model *from, scene_model *model, thrum_error *error) {
  size_t size = 0;
  THRUM_TRY(thrum_model_condense_size(from, model->rank, &size, error));
  model->memory = scene_aligned(size);
  if (model->memory == NULL)
    return no_memory(from, error);
  return thrum_model_condense(model->memory, size, from, model->rank, &model->model, error);
}

/* The same, scaled; what was in model->memory goes. */
static thrum_status scale(scene_model *model, thrum_error *error) {
  size_t size = 0;
  const thrum_model copy = lean(model->model);
  THRUM_TRY(thrum_model_scale_size(&copy, &size, error));
  void *memory = scene_aligned(size);
  if (memory == NULL)
    return no_memory(model->from, error);
  thrum_status status = thrum_model_scale(memory, size, &copy, &model->by, &model->model, error);
  if (status >= 0 && model->condensed)
    model->unscaled = model->memory;
  else
    free(status < 0 ? memory : model->memory);
  if (status >= 0)
    model->memory = memory;
  return status;
}

static bool same(const scene_model *model, const thrum_model *from, int64_t rank, bool condensed,
                 const thrum_model_scaling *by) {
  return model->from == from && model->rank == rank && model->condensed == condensed &&
         model->by.length == by->length && model->by.stiffness == by->stiffness &&
         model->by.density == by->density;
}

thrum_status scene_model_take(thrum_scene *scene, const thrum_model *from, int64_t rank,
                              bool condensed, const thrum_model_scaling *by, scene_model **taken,
                              thrum_error *error) {
  // bodies of one model, rank and scale share what is derived from it
  for (scene_model *model = scene->models; model != NULL; model = model->next) {
    if (same(model, from, rank, condensed, by)) {
      model->users++;
      *taken = model;
      return THRUM_OK;
    }
  }

  scene_model *model = calloc(1, sizeof *model);
  if (model == NULL)
    return no_memory(from, error);
  *model = (scene_model){
      .from = from, .model = from, .rank = rank, .condensed = condensed, .by = *by, .users = 1};
  thrum_status status = THRUM_OK;

  // the rank first, as scaling fewer coordinates is cheaper
  if (condensed)
    status = condense(from, model, error);
  if (status >= 0 && (by->length != 1 || by->stiffness != 1 || by->density != 1))
    status = scale(model, error);

  if (status < 0) {
    free(model->unscaled);
    free(model->memory);
    free(model);
    return status;
  }

  model->next = scene->models;
  scene->models = model;
  *taken = model;
  return THRUM_OK;
}

void scene_model_drop(thrum_scene *scene, scene_model *model) {
  if (model == NULL || --model->users > 0)
    return;
  for (scene_model **at = &scene->models; *at != NULL; at = &(*at)->next) {
    if (*at == model) {
      *at = model->next;
      break;
    }
  }
  thrum_inertia_destroy(model->inertia);
  free(model->unscaled);
  free(model->memory);
  free(model);
}

thrum_status scene_model_inertia(scene_model *model, thrum_error *error) {
  if (model->inertia != NULL)
    return THRUM_OK;
  if (model->condensed)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a condensed body is not coupled to its rotation: step all of its "
                           "coordinates");
  return thrum_inertia_create(model->from, model->rank, &model->by, &model->inertia, error);
}

thrum_status scene_make_room(thrum_scene *scene, int32_t bodies, thrum_error *error) {
  size_t needed = 0;

  // models of one body alone are stepped without a batch
  for (const scene_model *model = scene->models; model != NULL; model = model->next) {
    size_t size = 0;
    if (model->users < 2)
      continue;
    THRUM_TRY(thrum_batch_size(model->model, &size, error));
    needed = size > needed ? size : needed;
    needed = scene_round_up(needed); // blocks of workers follow each other
  }

  // the largest model decides; a larger workspace replaces the old one
  void *workspace = NULL;
  if (needed > scene->workspace_size) {
    workspace = scene_aligned((size_t)scene->workers * needed);
    if (workspace == NULL)
      return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %d bodies", (int)bodies);
    free(scene->workspace);
    scene->workspace = workspace;
    scene->workspace_size = needed;
  }

  // lists of the bodies that a step batches, so that no step allocates
  if (!scene_grow(&scene->side, bodies + 1, sizeof *scene->side) ||
      !scene_grow(&scene->side_status, bodies + 1, sizeof *scene->side_status) ||
      !scene_grow(&scene->side_body, bodies + 1, sizeof *scene->side_body) ||
      !scene_grow(&scene->side_error, bodies + 1, sizeof *scene->side_error) ||
      !scene_grow(&scene->chunks, bodies + 1, sizeof *scene->chunks))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %d bodies", (int)bodies);
  return THRUM_OK;
}
