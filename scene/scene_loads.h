/* Loads of bodies over time. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_LOADS_H
#define THRUM_SCENE_SCENE_LOADS_H

#include "scene/scene_private.h"

/* Reduces gravity, the first load of every body. */
thrum_status scene_gravity_reduce(scene_body *body, const double gravity[3], thrum_error *error);

/* Counts all time courses from the scene's origin, after one was added or dt has changed. */
void scene_loads_retime(thrum_scene *scene);

/* The mean load of the step that lies `ahead` of the one to come into body->force, by the
 * directions of the last step; mean acceleration of the base, set where there are base motions. */
void scene_loads_ahead(const thrum_scene *scene, scene_body *body, int64_t ahead, double mean[3]);

/* The mean load of the step to come into body->force; what it does to a free body as a whole. */
void scene_loads_sum(const thrum_scene *scene, scene_body *body, scene_wrench *wrench);

#endif
