/* What `thrum identify` says of a fit, and the files that it writes.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_IDENTIFY_IDENTIFY_REPORT_H
#define THRUM_DRIVER_IDENTIFY_IDENTIFY_REPORT_H

#include <cjson/cJSON.h>

#include "driver/identify/identify_fit.h"

/* What flags it, NULL where nothing does: "unconverged", "unseen" (a parameter does not show). */
const char *identify_flag(const identify_fit *fit);

/* The report as an object, which the caller prints or deletes. */
cJSON *identify_report_object(const identify_fit *fit);
void identify_report_table(const identify_fit *fit);

/* Warns of what the fit cannot be believed for. */
void identify_report_warn(const identify_fit *fit);

/* Writes identify.json (`text`), fit.csv and the plot into the folder of the request; none where it
 * names no folder. */
thrum_status identify_files_write(const identify_fit *fit, const char *text, thrum_error *error);

#endif
