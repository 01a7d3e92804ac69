/* Free bodies: how one moves as a whole.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_FREE_BODY_H
#define THRUM_SCENE_SCENE_FREE_BODY_H

#include "scene/scene_data.h"

/* Makes a body free where its def says so, with the mass and inertia of its model. */
thrum_status scene_free_make(const thrum_scene_body_def *def, scene_body *body, thrum_error *error);

/* One step as a whole; where a free body is now; back to its start. */
void scene_free_step(scene_body *body, const scene_wrench *wrench, double dt);
void scene_free_place(scene_body *body);
void scene_free_reset(scene_body *body);

/* Velocity of the frame at an arm from the centre, both in the world. */
void scene_free_velocity(const scene_body *body, const double arm[3], double velocity[3]);

/* The centre of mass in the world. */
void scene_free_centre(const scene_body *body, double centre[3]);

#endif
