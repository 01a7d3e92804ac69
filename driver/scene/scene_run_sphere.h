/* Spheres that bodies touch by their vertices alone: one that is smaller than a triangle, or is
 * passed within a step, goes through a body unseen. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_SPHERE_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_SPHERE_H

#include "driver/scene/scene_run_parts.h"

/* The same of spheres, which bodies touch by their vertices alone. */
thrum_status scene_run_open_spheres(scene_run *run, thrum_error *error);
void scene_run_note_spheres(scene_run *run);

/* A place of the world in the axes of the mesh of body `n`, as it lies now. */
void scene_run_in_mesh(const scene_run *run, int32_t n, const double place[3], double at[3]);

/* Does the way between two places in these axes go through the surface of body `n`, which has a box
 * and room for its surface? */
bool scene_run_goes_through(const scene_run *run, int32_t n, const double from[3],
                            const double to[3]);

#endif
