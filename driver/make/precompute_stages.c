/* The stages of `thrum precompute`, see precompute_stages.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/precompute_stages.h"

#include <math.h>
#include <stdio.h>

#include "driver/make/precompute_progress.h"
#include "io/json.h"

static double rate_of(const thrum_precomputed *result, int stage) {
  const double flops = result->flops[stage], seconds = result->seconds[stage];
  return flops > 0 && seconds > 0 ? 1e-9 * flops / seconds : NAN;
}

/* An imported basis needs no factor and no modes; each stage that ran left a peak. */
static bool was_run(const thrum_precomputed *result, int stage) {
  return result->peak_mb[stage] > 0;
}

static void add_row(cJSON *table, const char *name, double seconds, double cpu_seconds,
                    double peak_mb, double gflops) {
  cJSON *row = cJSON_AddObjectToObject(table, name);
  json_number(row, "seconds", seconds);
  json_number(row, "cpu_seconds", cpu_seconds);
  json_number(row, "peak_mb", peak_mb);
  json_number(row, "gflops", gflops);
}

void precompute_add_stages(cJSON *object, const thrum_precomputed *result, bool cubature,
                           const train_outcome *training) {
  cJSON *table = cJSON_AddObjectToObject(object, "stages");
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++)
    if (was_run(result, stage))
      add_row(table, precompute_stage_label_of((thrum_stage)stage, cubature).name,
              result->seconds[stage], result->cpu_seconds[stage], result->peak_mb[stage],
              rate_of(result, stage));
  if (training->run_count > 0)
    add_row(table, "training", training->seconds, training->cpu_seconds, training->peak_mb, NAN);
}

static void print_row(const char *text, double seconds, double cpu_seconds, double peak_mb,
                      double gflops) {
  printf("%-20s %10.3f %10.3f %10.0f ", text, seconds, cpu_seconds, peak_mb);

  // assembly, small dense work and runs are not counted
  if (isnan(gflops))
    printf("%10s\n", "-");
  else
    printf("%10.2f\n", gflops);
}

void precompute_print_stages(const thrum_precomputed *result, bool cubature,
                             const train_outcome *training) {
  printf("\n%-20s %10s %10s %10s %10s\n", "stage", "time [s]", "CPU [s]", "peak [MB]", "[Gflop/s]");
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++)
    if (was_run(result, stage))
      print_row(precompute_stage_label_of((thrum_stage)stage, cubature).text,
                result->seconds[stage], result->cpu_seconds[stage], result->peak_mb[stage],
                rate_of(result, stage));
  if (training->run_count > 0)
    print_row("training", training->seconds, training->cpu_seconds, training->peak_mb, NAN);
}
