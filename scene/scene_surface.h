/* The surface of a body, for wind and contact. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_SURFACE_H
#define THRUM_SCENE_SCENE_SURFACE_H

#include "scene/scene_private.h"

/* Areas of the def's triangles, and the vertices that may touch. */
thrum_status scene_surface_make(const thrum_scene_body_def *def, scene_body *body,
                                thrum_error *error);

#endif
