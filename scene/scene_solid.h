/* Obstacles with a surface. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_SOLID_H
#define THRUM_SCENE_SCENE_SOLID_H

#include "scene/scene_private.h"

/* Where all solids go in the step to come. */
void scene_solids_move(thrum_scene *scene);

void scene_solids_free(thrum_scene *scene);

#endif
