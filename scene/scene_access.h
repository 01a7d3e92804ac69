/* Bodies of a scene by their numbers. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_ACCESS_H
#define THRUM_SCENE_SCENE_ACCESS_H

#include "scene/scene_private.h"

/* THRUM_INVALID_ARGUMENT for a number that names no body. */
thrum_status scene_body_at(const thrum_scene *scene, int32_t number, scene_body **body,
                           thrum_error *error);

/* THRUM_MISSING for a body without a basis, THRUM_INVALID_ARGUMENT for a vertex that it has not. */
thrum_status scene_vertex_check(const scene_body *body, int64_t vertex, thrum_error *error);

#endif
