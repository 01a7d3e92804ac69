/* Obstacles of a scene file that are touched by their faces: their surfaces, places and paths.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_SOLID_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_SOLID_H

#include "driver/scene/scene_run_parts.h"

/* The way of an obstacle with a path: *count times [s] and as many places, of a position [m] and a
 * rotation w, x, y, z each, with places between where it turns further than the short way. The
 * caller frees both. */
thrum_status scene_run_way(const scene_run *run, const scene_obstacle_spec *spec, double **times,
                           double **places, int64_t *count, thrum_error *error);

/* Adds an obstacle that is touched by its faces. */
thrum_status scene_run_add_solid(const scene_run *run, const scene_obstacle_spec *spec,
                                 thrum_scene *scene);

/* Which of the file's obstacles is the scene's solid, or other obstacle, of this
 * number. */
int32_t scene_run_obstacle_index(const scene_run *run, bool solid, int32_t number);

#endif
