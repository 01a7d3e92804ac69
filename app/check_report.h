/* The report on an examined mesh, which several commands print.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_CHECK_REPORT_H
#define THRUM_APP_CHECK_REPORT_H

#include <cjson/cJSON.h>

#include "mesh/mesh_examine.h"

/* The table on standard output; `flags` are those of thrum_mesh_flags. */
void check_report_print(const char *name, const thrum_mesh *mesh, const thrum_mesh_examined *e,
                        unsigned flags);

/* The same as a JSON object, with the status "done" or "flagged". */
cJSON *check_report_object(const char *name, const thrum_mesh *mesh, const thrum_mesh_examined *e,
                           unsigned flags);

#endif
