/* Contact and pulls of a body.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_CONTACT_H
#define THRUM_SCENE_SCENE_CONTACT_H

#include "scene/scene_data.h"

/* Makes the data with which a body touches obstacles and is pulled, for `state` of `derived`; NULL
 * where there is neither. */
thrum_status scene_touch_make(const thrum_scene *scene, const scene_body *body,
                              const scene_model *derived, const thrum_state *state,
                              scene_touch **touch, thrum_error *error);
void scene_touch_free(scene_touch *touch);

/* A step of a body with contact and pulls. */
thrum_status scene_touch_step(const thrum_scene *scene, scene_body *body,
                              const scene_wrench *wrench, thrum_error *error);

#endif
