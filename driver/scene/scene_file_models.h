/* The models of a scene file, each loaded once however many bodies have it.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_FILE_MODELS_H
#define THRUM_DRIVER_SCENE_SCENE_FILE_MODELS_H

#include "driver/model/display_surface.h"
#include "driver/model/model_hash.h"
#include "driver/scene/scene_spec.h"

/* A model as one or several bodies name it. */
typedef struct scene_loaded {
  const scene_body_spec *first; /* the body that named it first */
  const thrum_model *model;
  thrum_model *coupled; /* NULL, or the copy that `model` is, with the inertia of its shape; both */
  double *inertia;      /* owned, */
  const thrum_model *file_model; /* as is the one of the file */
  named_model_file file;
  model_hash hash;
  display_surface skin; /* once it is asked for, */
  int32_t *corners;     /* and its triangles by vertices of the model; owned */
} scene_loaded;

typedef struct scene_models {
  scene_loaded *items; /* owned */
  int64_t count;
  int64_t *of_body; /* the place of each body's model; owned */
} scene_models;

/* Loads, or makes and loads, what the bodies name; ranks beyond a model's are refused by their
 * line. scene_models_free frees, whatever came back. */
thrum_status scene_models_load(const scene_spec *spec, bool quiet, scene_models *models,
                               thrum_error *error);
void scene_models_free(scene_models *models);

/* Warns of each that its linear tetrahedra lock. */
void scene_models_warn(const scene_spec *spec, const scene_models *models);

/* The surface of a body's mesh, made once for each model. */
thrum_status scene_models_skin(scene_models *models, int64_t body, const scene_loaded **skinned,
                               thrum_error *error);

static inline const scene_loaded *scene_model_of(const scene_models *models, int64_t body) {
  return &models->items[models->of_body[body]];
}

#endif
