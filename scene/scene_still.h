/* Whether a body is still, for its level of detail. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_STILL_H
#define THRUM_SCENE_SCENE_STILL_H

#include "scene/scene_private.h"

/* Bound of the displacement of any vertex by coordinates from `first` on of the scaled body, less
 * `other` (NULL: none) [m]; of its speed for velocities. */
double scene_bound(const scene_body *body, int64_t first, const double *q, const double *other);

/* Bound of the speed of a free body's vertices by its motion as a whole [m/s]; 0 of others. */
double scene_rigid_speed(const scene_body *body);

/* Bound of the speed that what acts on the body in the `steps` to come will give to a vertex, over
 * the load that it stands under [m/s]; INFINITY where it is pulled or something that moves may
 * touch it. q: its shape. body->force and body->inertia are used up. */
double scene_coming_speed(const thrum_scene *scene, scene_body *body, const double *q,
                          int64_t steps);

#endif
