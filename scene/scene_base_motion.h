/* Base motions under the bodies of a scene. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_BASE_MOTION_H
#define THRUM_SCENE_SCENE_BASE_MOTION_H

#include "scene/scene_private.h"

/* THRUM_MISSING for a body that base motions cannot accelerate. */
thrum_status scene_base_motion_check(const scene_body *body, thrum_error *error);

#endif
