/* Loads on a body that rotates. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_PARTS_H
#define THRUM_SCENE_SCENE_PARTS_H

#include "scene/scene_private.h"

/* Reduces load `index` of a free body in every direction that the body may rotate to. */
thrum_status scene_parts_make(scene_body *body, const thrum_scene_load_def *load, int64_t index,
                              thrum_error *error);

/* The directions of its loads as it stands now, and what they do to it as a whole. */
void scene_parts_sum(const thrum_scene *scene, scene_body *body, int64_t step,
                     scene_wrench *wrench);

#endif
