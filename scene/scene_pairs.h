/* Bodies that touch each other. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_PAIRS_H
#define THRUM_SCENE_SCENE_PAIRS_H

#include "scene/scene_private.h"

/* Groups the bodies that are near each other; loads are known. */
void scene_pairs_find(thrum_scene *scene);

/* Steps the bodies of the next group on a worker; each has its own status in `stepped`. Returns the
 * first of them. */
int32_t scene_pairs_step(thrum_scene *scene, int32_t worker, thrum_error *error);

/* Books what the groups did, after all of them have stepped. */
void scene_pairs_gather(thrum_scene *scene);

#endif
