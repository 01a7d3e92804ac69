/* Values of scene files that are more than a number, a text or a list.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_VALUES_H
#define THRUM_DRIVER_SCENE_VALUES_H

#include "config/record.h"

/* X(name): `take` of a key of the table, see config/record.h. Those of settings take a
 * scene_settings, frames a scene_outputs_spec; rotation and colour go to the key's field. */
#define SCENE_TAKES(X)                                                                             \
  X(damping)                                                                                       \
  X(newmark) X(split) X(adaptive) X(fallback) X(iterations) X(rotation) X(colour) X(frames)

#define X(name)                                                                                    \
  thrum_status scene_take_##name(const config_record_file *file, const config_record *record,      \
                                 const config_key *key, const json_node *value, void *to);
SCENE_TAKES(X)
#undef X

#endif
