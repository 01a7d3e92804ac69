/* A run of a scene file: what it says as a scene, its files, and the loop over the steps.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_H

#include "driver/scene/scene_run_parts.h"

/* Reads the file of the request, and frees what a run holds, whatever came of it. */
thrum_status scene_run_read(scene_run *run, thrum_error *error);
void scene_run_close(scene_run *run);

/* A scene from its file to its folder; an exit code. */
int scene_run_request(const scene_request *request);

#endif
