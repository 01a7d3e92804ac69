/* Links between bodies and with the world. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_LINK_H
#define THRUM_SCENE_SCENE_LINK_H

#include "scene/scene_private.h"

/* Finds which links hold in the step to come, and where their ends in the world go. */
void scene_links_begin(thrum_scene *scene);

/* Puts the links of a group into `room`, and their ends in the world behind its `count` members.
 * After the step scene_links_keep takes back what it did. */
thrum_contact_links scene_links_gather(thrum_scene *scene, int32_t group,
                                       thrum_contact_member *members, int64_t *count,
                                       thrum_link *room);
void scene_links_keep(thrum_scene *scene, int32_t group, const thrum_contact_links *links);

/* Does a joint hold the two bodies together? They do not touch then. */
bool scene_links_join(const thrum_scene *scene, int32_t a, int32_t b);

void scene_links_reset(thrum_scene *scene);
void scene_links_free(thrum_scene *scene);

#endif
