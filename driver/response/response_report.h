/* What `thrum response` says of a curve, and the files that it writes.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RESPONSE_RESPONSE_REPORT_H
#define THRUM_DRIVER_RESPONSE_RESPONSE_REPORT_H

#include <cjson/cJSON.h>

#include "driver/response/response_worth.h"

/* What flags it, NULL where nothing does: "lost", "points", "stopped", "unbranched", "coarse",
 * "missed". */
const char *response_flag(const response_curve *curve, const response_worth *worth);

/* The report as an object, which the caller prints or deletes. */
cJSON *response_report_object(const response_curve *curve, const response_worth *worth);
void response_report_table(const response_curve *curve, const response_worth *worth);

/* Warns of what the curve cannot be believed for. */
void response_report_warn(const response_curve *curve, const response_worth *worth);

#endif
