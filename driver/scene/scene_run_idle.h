/* What a scene says and what has no effect in it: loads that move nothing or come too late, motions
 * of a base that nothing is held by, and keys that others make void.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_IDLE_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_IDLE_H

#include "driver/scene/scene_run_parts.h"

/* Warns of what the file says and what has no effect, and of a step that is
 * coarse against what moves. */
void scene_run_warn_of_idle(const scene_run *run);

#endif
