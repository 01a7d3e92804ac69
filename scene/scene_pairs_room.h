/* Room for bodies that touch each other, and what they need for it. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_PAIRS_ROOM_H
#define THRUM_SCENE_SCENE_PAIRS_ROOM_H

#include "scene/scene_private.h"

/* Equips the bodies for the touches that there are now, and takes what none of them needs. */
thrum_status scene_pairs_equip(thrum_scene *scene, thrum_error *error);

/* Room for all bodies; `extra` (may be NULL) comes with extra_skin, or gets it. */
thrum_status scene_pairs_room(thrum_scene *scene, const scene_body *extra,
                              const scene_skin *extra_skin, thrum_error *error);
void scene_pairs_free(thrum_scene *scene);

/* Room for `workers` that step groups at once. */
thrum_status scene_pairs_share(thrum_scene *scene, int32_t workers, thrum_error *error);

/* The block in which a worker steps groups; the first is that of the scene. */
thrum_contact_pairs *scene_pairs_block(const scene_pairs *pairs, int32_t worker);

#endif
