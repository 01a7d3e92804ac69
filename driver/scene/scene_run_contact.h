/* The forces of contact, row by row in contact.csv: what each body felt of each obstacle and body
 * that it touched in the last step. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_CONTACT_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_CONTACT_H

#include "driver/scene/scene_run_parts.h"

/* The force of each body and obstacle on each other one. */
bool scene_run_has_contact(const scene_run *run);
thrum_status scene_run_open_contact(scene_run *run, thrum_error *error);
thrum_status scene_run_record_contact(scene_run *run, int64_t step, double time,
                                      thrum_error *error);

#endif
