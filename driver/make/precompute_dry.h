/* `thrum precompute --dry-run`. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_PRECOMPUTE_DRY_H
#define THRUM_DRIVER_MAKE_PRECOMPUTE_DRY_H

#include "driver/make/precompute_outcome.h"

/* Prints the memory and the time that the model would take; *flagged: it would not fit. */
thrum_status precompute_dry_run(const precompute_outcome *outcome, const uint8_t *fixed,
                                bool *flagged, thrum_error *error);

#endif
