/* Obstacles of a scene as they move. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_OBSTACLE_H
#define THRUM_SCENE_SCENE_OBSTACLE_H

#include "scene/scene_private.h"

/* After a step, and back to the start. */
void scene_obstacles_move(thrum_scene *scene);
void scene_obstacles_reset(thrum_scene *scene);

#endif
