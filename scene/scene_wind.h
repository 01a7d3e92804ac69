/* Drag of the air on a body. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_WIND_H
#define THRUM_SCENE_SCENE_WIND_H

#include "scene/scene_private.h"

/* Adds the drag of the step to come to body->force, and to the wrench. */
thrum_status scene_wind_add(const thrum_scene *scene, scene_body *body, scene_wrench *wrench,
                            thrum_error *error);

#endif
