/* The parts of a scene file that all bodies share: base motions, wind, obstacles and probes.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_WORLD_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_WORLD_H

#include "driver/scene/scene_run_parts.h"

/* What acts on all bodies, before they are added (base motions) and after. */
thrum_status scene_run_base_motions(scene_run *run, thrum_error *error);
bool scene_run_collides(const scene_run *run);
thrum_contact_pairs_def scene_run_collisions_def(const scene_run *run);

/* Does a body touch others or itself, and does any? */
bool scene_run_body_meets(const scene_run *run, const scene_body_run *body);
bool scene_run_bodies_meet(const scene_run *run);

/* Are there obstacles that are touched by their faces? */
bool scene_run_has_solids(const scene_run *run);

/* Do bodies touch each other or themselves, or obstacles by their faces? */
bool scene_run_touches(const scene_run *run);
thrum_status scene_run_collisions(const scene_run *run);

/* Refuses a body that begins inside an obstacle or another body; says what a body is in, by its
 * name where it has one. */
#define SCENE_OVERLAP_NAME 120
void scene_run_name_overlap(const scene_run *run, const thrum_scene_overlap *overlap,
                            char in[SCENE_OVERLAP_NAME]);
thrum_status scene_run_check_start(const scene_run *run, thrum_error *error);
thrum_status scene_run_wind(const scene_run *run, thrum_scene *scene);
thrum_status scene_run_obstacles(const scene_run *run, thrum_scene *scene);

thrum_status scene_run_add_base_motion(const base_motion_spec *base_motion, thrum_scene *scene,
                                       thrum_error *error);
thrum_status scene_run_probes(scene_run *run);

/* Does a body step some of its coordinates alone, so that it touches no other and no faces? False
 * of -1. */
bool scene_run_is_condensed(const scene_run *run, int32_t body);

#endif
