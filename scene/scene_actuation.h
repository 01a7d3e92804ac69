/* Levels of the actuators of bodies over time. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_ACTUATION_H
#define THRUM_SCENE_SCENE_ACTUATION_H

#include "scene/scene_private.h"

/* Sets the mean levels of the step to come; nothing where a body has no courses. */
thrum_status scene_actuation_set(const thrum_scene *scene, scene_body *body, thrum_error *error);

/* May the body step coordinates that others follow? THRUM_UNSUPPORTED where it has courses, as
 * actuators act on coordinates that are stepped. */
thrum_status scene_actuation_check_followed(const scene_body *body, thrum_error *error);

/* Counts all courses from the scene's origin. */
void scene_actuation_retime(thrum_scene *scene);

/* What the actuators of the state have done since it was made [J]. */
double scene_actuation_work(const scene_body *body);

#endif
