/* Bodies that go on with other coordinates or another material. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_REBUILD_H
#define THRUM_SCENE_SCENE_REBUILD_H

#include "scene/scene_private.h"

/* Makes the body's state and model anew, as the def, rank and stiffness say. */
thrum_status scene_rebuild(thrum_scene *scene, scene_body *body, const thrum_state_def *def,
                           int64_t rank, bool condensed, double stiffness, thrum_error *error);

/* thrum_scene_set_condensed of a body that may have a level of detail. */
thrum_status scene_condense(thrum_scene *scene, int32_t number, int64_t masters,
                            thrum_error *error);

#endif
