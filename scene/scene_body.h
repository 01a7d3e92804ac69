/* Bodies of a scene as they are made.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_BODY_H
#define THRUM_SCENE_SCENE_BODY_H

#include "scene/scene_data.h"

/* A state of a def at a model, with q and p (rank) in it; thrum_state_destroy frees. */
thrum_status scene_state_make(const thrum_model *model, const thrum_state_def *def, const double *q,
                              const double *p, thrum_state **state, thrum_error *error);

#endif
