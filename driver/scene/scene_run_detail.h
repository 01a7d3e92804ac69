/* The keys "error", "budget" and "detail" of bodies: how many coordinates each of them steps.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_DETAIL_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_DETAIL_H

#include "driver/scene/scene_run_parts.h"

/* Condenses the bodies that ask for an error or a budget, and sets the levels
 * of detail. */
thrum_status scene_run_find_detail(scene_run *run, thrum_error *error);

/* Warns of condensed bodies that pass through what is there. */
void scene_run_warn_of_passing(scene_run *run);

#endif
