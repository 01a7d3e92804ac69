/* Bodies whose stiff coordinates follow the others. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_CONDENSED_H
#define THRUM_SCENE_SCENE_CONDENSED_H

#include "scene/scene_private.h"

/* body->force, on all coordinates, becomes that on the masters; body->inertia too if `base`.
 * THRUM_BAD_VALUE, and nothing changes, where the force is not finite. */
thrum_status scene_condensed_load(const scene_body *body, bool base, thrum_error *error);

/* The points that touch as they follow now, pulls apart. */
thrum_status scene_condensed_touch(scene_body *body, thrum_error *error);

/* pull->give: how far the slaves of a condensed body give way at a vertex. */
void scene_condensed_pull(const scene_body *body, int64_t vertex, thrum_pull *pull);

#endif
