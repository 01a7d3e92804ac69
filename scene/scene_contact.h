/* Contact and pulls of a body. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_CONTACT_H
#define THRUM_SCENE_SCENE_CONTACT_H

#include "scene/scene_private.h"

/* Makes the data with which a body touches obstacles and is pulled, for `state` of `derived`; NULL
 * where there is neither. */
thrum_status scene_touch_make(const thrum_scene *scene, const scene_body *body,
                              const scene_model *derived, const thrum_state *state,
                              scene_touch **touch, thrum_error *error);
void scene_touch_free(scene_touch *touch);

/* Frees the contact of a body that nothing touches and nothing pulls. */
void scene_touch_trim(const thrum_scene *scene, scene_body *body);

/* Does the body step with its contact, and not side by side with others of its model? */
bool scene_steps_alone(const scene_body *body);

/* Fills in what surrounds a body in the step to come; `pulls` is room for those in use. */
void scene_environment(const thrum_scene *scene, scene_body *body,
                       thrum_pull pulls[THRUM_SCENE_PULLS], thrum_contact_environment *environment);

/* A step of a body with contact and pulls. */
thrum_status scene_touch_step(const thrum_scene *scene, scene_body *body, thrum_error *error);

/* The body's slaves answer to the pulls of the step that was made. */
void scene_answer_pulls(scene_body *body);

#endif
