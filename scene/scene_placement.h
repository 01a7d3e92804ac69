/* Between the axes of a body and the world. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_PLACEMENT_H
#define THRUM_SCENE_SCENE_PLACEMENT_H

#include "scene/scene_private.h"

thrum_status scene_placement_make(const double position[3], const double rotation[4],
                                  thrum_placement *placement, thrum_error *error);
void scene_to_world(const thrum_placement *placement, const double in_body[3], double out[3]);
void scene_to_body(const thrum_placement *placement, const double in_world[3], double out[3]);

#endif
