/* The stages of `thrum precompute`: what each took. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_PRECOMPUTE_STAGES_H
#define THRUM_DRIVER_PRECOMPUTE_STAGES_H

#include <cjson/cJSON.h>

#include "precompute/precompute.h"
#include "thrum/thrum.h"

typedef struct precompute_stage_label {
  const char *name; /* for machines */
  const char *text;
} precompute_stage_label;

extern const precompute_stage_label precompute_stage_labels[THRUM_STAGE_COUNT];

/* Adds `stages`: for each its seconds, cpu_seconds, peak_mb (of the process until its end) and
 * gflops, a rate, null where the work is not counted. */
void precompute_add_stages(cJSON *object, const thrum_precomputed *result);

void precompute_print_stages(const thrum_precomputed *result);

#endif
