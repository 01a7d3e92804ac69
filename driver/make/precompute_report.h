/* The results of a precomputation as meta, as a JSON line and as a table.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_PRECOMPUTE_REPORT_H
#define THRUM_DRIVER_MAKE_PRECOMPUTE_REPORT_H

#include "driver/make/precompute_outcome.h"

/* The JSON text stored as meta, which the caller frees; NULL: no memory. The request's reproducible
 * leaves the times out. */
char *precompute_meta(const precompute_outcome *outcome);

/* The outcome on standard output, as an object for --json or as the table that is made of it. */
void precompute_print_report(const precompute_outcome *outcome);

#endif
