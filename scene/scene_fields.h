/* Ranges of the fields of a def. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_FIELDS_H
#define THRUM_SCENE_FIELDS_H

#include "thrum/scene.h"

/* Refuses a number of a def that is neither in the range of its row nor the default, with
 * THRUM_BAD_VALUE and its name as the field of the error. */
thrum_status scene_fields_check(thrum_scene_record record, const void *def, thrum_error *error);

/* The def as the library knows it, where the caller's may be of an earlier version; NULL where it
 * is none. */
const thrum_scene_body_def *scene_body_def_whole(const thrum_scene_body_def *def,
                                                 thrum_scene_body_def *whole);

#endif
