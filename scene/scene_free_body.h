/* How a free body moves as a whole. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_FREE_BODY_H
#define THRUM_SCENE_SCENE_FREE_BODY_H

#include "scene/scene_private.h"

/* One step as a whole, or of its translation alone: THRUM_NOT_FINITE, and nothing moves, where it
 * would leave the finite numbers. */
thrum_status scene_free_step(scene_body *body, const scene_wrench *wrench, double dt,
                             thrum_error *error);
thrum_status scene_free_move(scene_body *body, const double force[3], double dt,
                             thrum_error *error);

/* Where a free body is now. */
void scene_free_place(scene_body *body);

/* Velocity of the frame at an arm from the centre, both in the world. */
void scene_free_velocity(const scene_body *body, const double arm[3], double velocity[3]);

/* The centre of mass in the world. */
void scene_free_centre(const scene_body *body, double centre[3]);

#endif
