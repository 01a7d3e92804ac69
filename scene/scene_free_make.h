/* Free bodies as they are made. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_FREE_MAKE_H
#define THRUM_SCENE_SCENE_FREE_MAKE_H

#include "scene/scene_private.h"

/* Makes a body free where its def says so, with the mass and inertia of its model. */
thrum_status scene_free_make(const thrum_scene_body_def *def, scene_body *body, thrum_error *error);

/* Back to its start. */
void scene_free_reset(scene_body *body);

#endif
