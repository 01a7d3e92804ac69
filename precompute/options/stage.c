/* Progress of stages, see stage.h. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/options/stage.h"

thrum_status thrum_report(const thrum_reporter *reporter, double fraction, thrum_error *error) {
  if (!reporter || !reporter->options->progress)
    return THRUM_OK;
  const thrum_precompute_options *options = reporter->options;
  if (options->progress(options->progress_context, reporter->stage, fraction))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_INTERRUPTED, "stopped on request");
}
