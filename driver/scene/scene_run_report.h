/* The report of a scene's run: a table for people, one JSON object for programs and scene.json.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_REPORT_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_REPORT_H

#include "driver/scene/scene_run_parts.h"

cJSON *scene_run_json(const scene_run *run);

/* The table that is made of that object. */
void scene_run_table(const scene_run *run, const cJSON *report);

#endif
