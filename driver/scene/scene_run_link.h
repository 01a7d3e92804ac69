/* Links of a scene file: what they tie, the paths of their ends, and what they did.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_LINK_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_LINK_H

#include "driver/scene/scene_run_parts.h"

/* Ties what the file links; opens links.npy, adds a row to it and ends it; then
 * what its links did, for scene.json, and printed as lines of the table. */
thrum_status scene_run_links(scene_run *run, thrum_error *error);
thrum_status scene_run_open_links(scene_run *run, thrum_error *error);
thrum_status scene_run_record_links(scene_run *run, thrum_error *error);
thrum_status scene_run_end_links(scene_run *run, thrum_error *error);
bool scene_run_is_linked(const scene_run *run, int32_t number);

/* May something touch the body, or does a link tie it? */
bool scene_run_is_met(const scene_run *run, int32_t number);

cJSON *scene_run_links_json(const scene_run *run);

/* Warns of the joint that was open the widest, beyond what links promise. */
void scene_run_warn_of_joints(const scene_run *run);
bool scene_run_joints_opened(const scene_run *run);

#endif
