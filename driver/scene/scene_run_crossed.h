/* Do bodies of a scene pass through each other or through obstacles? The status surfaces_crossed
 * and the warnings that say who and how deep (docs/contact.md).
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_CROSSED_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_CROSSED_H

#include "driver/scene/scene_run_parts.h"

/* Makes a run ready to look for bodies that go through each other or through
 * obstacles; notes how deep they are after a step; and says whether any did, with warnings. */
thrum_status scene_run_look_for_crossings(scene_run *run, thrum_error *error);
void scene_run_note_depths(scene_run *run);
bool scene_run_have_crossed(const scene_run *run);

/* Looks whether something is in a condensed body, which touches none, at a row of the run. */
thrum_status scene_run_look_through(scene_run *run, double time, thrum_error *error);

/* Were steps made without contact? */
bool scene_run_has_declined(const scene_run *run);
void scene_run_warn_of_depth(const scene_run *run);

#endif
