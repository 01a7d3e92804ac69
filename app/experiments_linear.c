/* `thrum experiments --linear`: how far linear modal analysis can be believed, and what the cubic
 * and quartic terms cost. SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#include "app/experiments.h"
#include "app/results.h"
#include "config/progress.h"
#include "validation/experiments/linear_free_vibration.h"
#include "validation/experiments/tables.h"

static const json_column columns[] = {
    COLUMN_TEXT("model", "model", -8),
    COLUMN_NUMBER("rank", "rank", 4, "%.0f"),
    COLUMN_PERCENT("static_5", "5 %", 8, "%.2f"),
    COLUMN_PERCENT("static_20", "20 %", 8, "%.2f"),
    COLUMN_PERCENT("dynamic_5", "5 %", 8, "%.2f"),
    COLUMN_PERCENT("dynamic_20", "20 %", 8, "%.2f"),
    COLUMN_NUMBER("force_us", "force", 8, "%.2f"),
    COLUMN_NUMBER("step_us", "imexv", 8, "%.2f"),
    COLUMN_NUMBER("linear_step_us", "linear", 8, "%.3f"),
    COLUMN_END,
};

static thrum_status publish(const experiments_request *request, const experiment_linear *linear,
                            thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(results_open(request->output, "linear_curves.csv", &writer, error));
  experiment_linear_curves_csv(writer.stream, linear);
  THRUM_TRY(thrum_file_writer_commit(&writer, error));

  if (!request->json) {
    printf("%-8s %4s %35s\n", "", "", "deflection [% of the length] at");
    printf("%-8s %4s %17s %17s %26s\n", "", "", "rest, error", "motion, error", "time [us]");
  }
  const experiments_table table = {"linear", "runs", experiment_linear_rows(linear), columns};
  return experiments_publish(request, &table, 1, false, error);
}

thrum_status experiments_linear(const experiments_request *request,
                                const experiments_bodies *bodies, thrum_error *error) {
  config_progress progress = config_progress_make(request->quiet);
  experiment_linear linear = {.bodies = bodies->bodies,
                              .body_count = bodies->count,
                              .threads = (int)request->threads,
                              .progress = experiments_progress,
                              .progress_context = &progress};
  thrum_status status = experiment_linear_run(&linear, error);
  config_progress_end(&progress, status >= 0);
  THRUM_THEN(status, publish(request, &linear, error));
  free(linear.results);
  return status;
}
