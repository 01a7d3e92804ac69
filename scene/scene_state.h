/* States of bodies, and what they borrow for a step. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_STATE_H
#define THRUM_SCENE_SCENE_STATE_H

#include "scene/scene_private.h"

/* A state of a def, which borrows scratch, at a model, with q and p (rank) in it;
 * thrum_state_destroy frees. */
thrum_status scene_state_make(thrum_scene *scene, const thrum_model *model,
                              const thrum_state_def *def, const double *q, const double *p,
                              thrum_state **state, thrum_error *error);

/* Scratch and workspace of a worker; the scratch is lent to a body's state. */
void scene_lend(const thrum_scene *scene, const scene_body *body, int32_t worker);
void *scene_workspace(const thrum_scene *scene, int32_t worker);

/* Room for the slopes of a condensed body, where there is none yet. */
thrum_status scene_slopes_make(scene_body *body, thrum_error *error);

/* `workers` blocks of scratch, each of `size`, in place of what there is. */
thrum_status scene_scratch_replace(thrum_scene *scene, int32_t workers, size_t size,
                                   thrum_error *error);

#endif
