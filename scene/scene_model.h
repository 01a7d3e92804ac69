/* The models that bodies step, each shared by all bodies that want the same. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_MODEL_H
#define THRUM_SCENE_SCENE_MODEL_H

#include "scene/scene_private.h"

/* Finds or makes the model of a body; scene_model_drop undoes. */
thrum_status scene_model_take(thrum_scene *scene, const thrum_model *from, int64_t rank,
                              bool condensed, const thrum_model_scaling *by, scene_model **taken,
                              thrum_error *error);
void scene_model_drop(thrum_scene *scene, scene_model *model);

/* Finds or makes the inertia of a model. */
thrum_status scene_model_inertia(scene_model *model, thrum_error *error);

/* Room for stepping bodies side by side, after bodies or models have changed. */
thrum_status scene_make_room(thrum_scene *scene, int32_t bodies, thrum_error *error);

#endif
