/* The surfaces with which bodies touch each other. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_SKIN_H
#define THRUM_SCENE_SCENE_SKIN_H

#include "scene/scene_private.h"

/* Keeps the triangles of a def for the body's skin. */
thrum_status scene_triangles_keep(const thrum_scene_body_def *def, scene_body *body,
                                  thrum_error *error);

/* May the body, as a body of `derived`, touch others? */
bool scene_collides(const thrum_scene *scene, const scene_body *body, const scene_model *derived);

/* Finds or makes the skin of a body of `derived`, NULL where it touches none; scene_skin_drop
 * undoes (NULL does nothing). */
thrum_status scene_skin_take(thrum_scene *scene, const scene_body *body, const scene_model *derived,
                             scene_skin **taken, thrum_error *error);
void scene_skin_drop(thrum_scene *scene, scene_skin *skin);

#endif
