/* The stepper of a scene: all bodies of a scene file in the world.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_STEPPER_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_STEPPER_H

#include "driver/scene/scene_run_parts.h"

/* The scene as a stepper, whose bodies are those of the file. */
driver_stepper scene_run_stepper(scene_run *run);

#endif
