/* The surface of a def, into vertices and triangles that the caller frees. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_SOLID_SHAPE_H
#define THRUM_SCENE_SCENE_SOLID_SHAPE_H

#include "scene/scene_private.h"

thrum_status scene_solid_surface(const thrum_scene_solid_def *def, scene_solid *solid,
                                 thrum_error *error);

#endif
