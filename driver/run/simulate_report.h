/* How the figures of a run are shown. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_SIMULATE_REPORT_H
#define THRUM_DRIVER_RUN_SIMULATE_REPORT_H

#include "driver/run/run.h"

/* The beginning of the object of a run or of a scene's run: the report of `thrum simulate`, and why
 * the run ended early where `stop` says so. */
cJSON *simulate_report_begin(const char *status, const thrum_error *stop);

/* The object of --json and run.json. */
cJSON *simulate_report_json(const driver_body *body);

/* The options as they were understood, defaults included, for "options" in it. */
cJSON *simulate_options_json(const simulate_request *request);

/* Adds "condensed": how far a condensed model can be believed; null for any other. */
void simulate_report_condensed(cJSON *object, const simulate_figures *figures);

/* The table that is made of that object. */
void simulate_report_table(const driver_body *body, const cJSON *report);

#endif
