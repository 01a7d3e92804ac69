/* `thrum info` of the folder of a run. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_INFO_RUN_H
#define THRUM_APP_INFO_RUN_H

#include <stdbool.h>

#include "thrum/status.h"

/* Says what the run in the folder `path`, of a model or of a scene, was made of and how it ended.
 * Neither its model nor its other files are read. Fails where its report cannot be read. */
thrum_status info_run(const char *path, bool json, thrum_error *error);

#endif
