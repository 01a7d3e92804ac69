/* A scene file as a scene: its models loaded, its texts understood, its bodies placed.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_BUILD_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_BUILD_H

#include "driver/scene/scene_run_parts.h"

/* Loads the models and makes the scene; the latter alone, where there are bodies
 * and models. */
thrum_status scene_run_build(scene_run *run, thrum_error *error);
thrum_status scene_run_make(scene_run *run, thrum_error *error);

/* The same of what scene_run_make makes and the bodies. */
void scene_run_unmake(scene_run *run);

#endif
