/* Free bodies whose rotation and shape act on each other. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_COUPLED_H
#define THRUM_SCENE_SCENE_COUPLED_H

#include "scene/scene_private.h"

/* Makes ready what a body needs to step a model by a def as a coupled one. */
thrum_status scene_coupled_fit(scene_body *body, scene_model *derived, const thrum_state_def *def,
                               thrum_error *error);

/* The frame's inertia and internal momentum at the start of the body. */
thrum_status scene_coupled_start(scene_body *body, thrum_error *error);

/* One step of state, frame and centre of mass. */
thrum_status scene_coupled_step(scene_body *body, thrum_error *error);

/* Adds to the moments of the loads on the body at rest those on the shape in body->q. */
void scene_coupled_moments(const thrum_scene *scene, const scene_body *body, int64_t step,
                           double moments[9]);

#endif
