/* The results of a precomputation as meta, as a JSON line and as a table.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_PRECOMPUTE_REPORT_H
#define THRUM_DRIVER_MAKE_PRECOMPUTE_REPORT_H

#include "driver/make/precompute_outcome.h"

/* The JSON text stored as meta, which the caller frees; NULL: no memory. The request's reproducible
 * leaves the times out. */
char *precompute_meta(const precompute_outcome *outcome);

/* The outcome on standard output. */
void precompute_print_json(const precompute_outcome *outcome);
void precompute_print_table(const precompute_outcome *outcome);

#endif
