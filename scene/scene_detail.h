/* Bodies that are stepped with fewer coordinates while they are far or still. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_DETAIL_H
#define THRUM_SCENE_SCENE_DETAIL_H

#include "scene/scene_private.h"

void scene_detail_free(thrum_scene *scene, scene_body *body);

/* A body that starts again has not been looked at. */
void scene_detail_restart(scene_body *body);

/* A body that steps fewer coordinates steps all of them again, for a start; it may jump. */
thrum_status scene_detail_wake(thrum_scene *scene, int32_t number, thrum_error *error);

#endif
