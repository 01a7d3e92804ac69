/* Loads that are given on the coordinates of a body. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_REDUCED_LOAD_H
#define THRUM_SCENE_SCENE_REDUCED_LOAD_H

#include "scene/scene_private.h"

/* Whether this reduced load may be added to the body. */
thrum_status scene_reduced_check(const scene_body *body, const thrum_scene_load_def *load,
                                 thrum_error *error);

#endif
