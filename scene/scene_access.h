/* Bodies of a scene by their numbers.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_ACCESS_H
#define THRUM_SCENE_SCENE_ACCESS_H

#include "scene/scene_data.h"

/* NULL, and the reason, for a number that names no body. */
scene_body *scene_body_at(const thrum_scene *scene, int32_t body, thrum_error *error);

#endif
