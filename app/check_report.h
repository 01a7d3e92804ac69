/* The report on an examined mesh, which several commands print.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_CHECK_REPORT_H
#define THRUM_APP_CHECK_REPORT_H

#include <cjson/cJSON.h>
#include <stdbool.h>

#include "mesh/mesh_examine.h"

/* The report as an object, with the status "done" or "flagged"; `flags` are those of
 * thrum_mesh_flags. */
cJSON *check_report_object(const char *name, const thrum_mesh *mesh, const thrum_mesh_examined *e,
                           unsigned flags);

/* Prints it as JSON or as a table, with "tool" and "surface" where it has these, and deletes it. */
void check_report_show(cJSON *report, bool json);

#endif
