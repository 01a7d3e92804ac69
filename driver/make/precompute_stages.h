/* The stages of `thrum precompute`: what each took. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_PRECOMPUTE_STAGES_H
#define THRUM_DRIVER_MAKE_PRECOMPUTE_STAGES_H

#include <cjson/cJSON.h>

#include "driver/make/precompute_train.h"
#include "precompute/precompute.h"

/* Adds `stages`: for each its seconds, cpu_seconds, peak_mb (of the process until its end) and
 * gflops, a rate, null where the work is not counted; and the training, where there was one. */
void precompute_add_stages(cJSON *object, const thrum_precomputed *result, bool cubature,
                           const train_outcome *training);

void precompute_print_stages(const thrum_precomputed *result, bool cubature,
                             const train_outcome *training);

#endif
