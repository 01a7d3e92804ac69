/* `thrum info` of the folder of a run. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_INFO_RUN_H
#define THRUM_APP_INFO_RUN_H

#include <cjson/cJSON.h>
#include <stdbool.h>

#include "thrum/status.h"

/* info_run_check.c: refuses a report that is not that of `thrum simulate`, or holds what no run
 * has; `file` stands in the message. */
thrum_status info_run_check(const char *file, const cJSON *report, bool scene, thrum_error *error);

/* info_run_options.c: prints loads, starts and base motions, a line each, and on one line all other
 * options that were not the usual ones. */
void info_run_print_options(const cJSON *report);

/* Says what the run in the folder `path`, of a model or of a scene, was made of and how it ended.
 * It also says whether its other files and its model are there. Fails where its report cannot
 * be read, or holds what no run has. */
thrum_status info_run(const char *path, bool json, thrum_error *error);

#endif
