/* How far the bases of bodies are wrong on which others act: the scene is made again with richer
 * models, and the shapes of its bodies are compared in their own axes.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_JUDGE_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_JUDGE_H

#include "driver/scene/scene_run_parts.h"

/* Why a body on which others act cannot be judged with its scene, NULL: it can;
 * takes in a row; and makes the scene again with richer models, after the run, for the estimates of
 * its bodies. */
const char *scene_run_why_not_judged(const scene_run *run, int32_t number);
thrum_status scene_run_judge_note(scene_run *run, int64_t step, thrum_error *error);
thrum_status scene_run_judge(scene_run *run, thrum_error *error);
void scene_run_judge_close(scene_run *run);

#endif
