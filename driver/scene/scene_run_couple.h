/* Which free bodies are coupled where the file does not say, and those that turned fast without it.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_COUPLE_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_COUPLE_H

#include "driver/scene/scene_run_parts.h"

/* Is a body coupled, by the file or, where that does not say, as it begins to
 * turn so fast that it matters (needs its spin in body->def)? Looks at how fast others turn after a
 * step, with warnings of them; adds "turning", those that are coupled without being asked for. */
bool scene_run_couples(const scene_run *run, scene_body_run *body);
void scene_run_note_turns(scene_run *run);
void scene_run_warn_of_turns(const scene_run *run);
void scene_run_coupled_json(const scene_run *run, cJSON *object);

#endif
