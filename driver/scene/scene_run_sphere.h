/* Spheres that bodies touch by their vertices alone: one that is smaller than a triangle, or is
 * passed within a step, goes through a body unseen. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_SPHERE_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_SPHERE_H

#include "driver/scene/scene_run_parts.h"

/* The same of spheres, which bodies touch by their vertices alone. */
thrum_status scene_run_open_spheres(scene_run *run, thrum_error *error);
void scene_run_note_spheres(scene_run *run);

#endif
