/* How a long stage tells its progress and learns that it should stop; and the clock of the stages.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_OPTIONS_STAGE_H
#define THRUM_PRECOMPUTE_OPTIONS_STAGE_H

#include "precompute/options/precompute_options.h"
#include "thrum/status.h"

/* Where a stage reports to; with a NULL pointer nothing is reported. */
typedef struct thrum_reporter {
  const thrum_precompute_options *options;
  thrum_stage stage;
} thrum_reporter;

/* Tells the caller's progress function; THRUM_INTERRUPTED when it answers false. */
thrum_status thrum_report(const thrum_reporter *reporter, double fraction, thrum_error *error);

#endif
