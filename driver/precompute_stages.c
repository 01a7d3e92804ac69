/* The stages of `thrum precompute`, see precompute_stages.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/precompute_stages.h"

#include <math.h>
#include <stdio.h>

#include "io/json.h"

const precompute_stage_label precompute_stage_labels[THRUM_STAGE_COUNT] = {
#define X(name, text) {#name, text},
    THRUM_STAGE_LIST(X)
#undef X
};

static double rate_of(const thrum_precomputed *result, int stage) {
  const double flops = result->flops[stage], seconds = result->seconds[stage];
  return flops > 0 && seconds > 0 ? 1e-9 * flops / seconds : NAN;
}

/* An imported basis needs no factor and no modes; each stage that ran left a peak. */
static bool was_run(const thrum_precomputed *result, int stage) {
  return result->peak_mb[stage] > 0;
}

void precompute_add_stages(cJSON *object, const thrum_precomputed *result) {
  cJSON *table = cJSON_AddObjectToObject(object, "stages");
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++) {
    if (!was_run(result, stage))
      continue;
    cJSON *row = cJSON_AddObjectToObject(table, precompute_stage_labels[stage].name);
    json_number(row, "seconds", result->seconds[stage]);
    json_number(row, "cpu_seconds", result->cpu_seconds[stage]);
    json_number(row, "peak_mb", result->peak_mb[stage]);
    json_number(row, "gflops", rate_of(result, stage));
  }
}

void precompute_print_stages(const thrum_precomputed *result) {
  printf("\n%-20s %10s %10s %10s %10s\n", "stage", "time [s]", "CPU [s]", "peak [MB]", "[Gflop/s]");
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++) {
    const double rate = rate_of(result, stage);
    if (!was_run(result, stage))
      continue;
    printf("%-20s %10.3f %10.3f %10.0f ", precompute_stage_labels[stage].text,
           result->seconds[stage], result->cpu_seconds[stage], result->peak_mb[stage]);
    // assembly and small dense work are not counted
    if (isnan(rate))
      printf("%10s\n", "-");
    else
      printf("%10.2f\n", rate);
  }
}
