/* Refusals of a scene file by the line of what is refused.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_REFUSE_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_REFUSE_H

#include "driver/scene/scene_run_parts.h"

/* Passes a status of the engine on; a failure becomes a message about one key
 * of a record, or about the record (key NULL). */
thrum_status scene_run_pass(const scene_run *run, const config_record *at, const char *key,
                            thrum_status status, const thrum_error *detail);
thrum_status scene_run_no_memory(thrum_error *error);

#endif
