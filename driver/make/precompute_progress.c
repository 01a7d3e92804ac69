/* Stages as they go on, see precompute_progress.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/precompute_progress.h"

#include <stdio.h>

precompute_stage_label precompute_stage_label_of(thrum_stage stage, bool cubature) {
  static const precompute_stage_label labels[THRUM_STAGE_COUNT] = {
#define X(name, text) {#name, text},
      THRUM_STAGE_LIST(X)
#undef X
  };
  return cubature && stage == THRUM_STAGE_polynomial
             ? (precompute_stage_label){"cubature", "cubature points"}
             : labels[stage];
}

bool precompute_progress_show(void *context, thrum_stage stage, double fraction) {
  precompute_progress *progress = context;
  char label[sizeof progress->bar.label];
  snprintf(label, sizeof label, "%s%s", progress->basis,
           precompute_stage_label_of(stage, progress->cubature).text);
  config_progress_update(&progress->bar, label, fraction);
  return true;
}
