/* `thrum experiments --linear`: how far linear modal analysis can be believed, and what the cubic
 * and quartic terms cost. SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "app/experiments.h"
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

const experiments_form experiments_linear_form = {
    {{"linear", "runs", columns}},
    "linear_curves.csv",
    "                  deflection [% of the length] at\n"
    "                    rest, error     motion, error                  time [us]\n"};

static void write_curves(FILE *stream, const void *of) {
  experiment_linear_curves_csv(stream, of);
}

thrum_status experiments_linear(const experiments_request *request,
                                const experiments_bodies *bodies, bool *flagged,
                                thrum_error *error) {
  config_progress progress = config_progress_make(request->quiet);
  experiment_linear linear = {.bodies = bodies->bodies,
                              .body_count = bodies->count,
                              .threads = (int)request->threads,
                              .progress = experiments_progress,
                              .progress_context = &progress};
  thrum_status status = experiment_linear_run(&linear, error);
  config_progress_end(&progress, status >= 0);
  *flagged = false;
  if (status >= 0) {
    const experiments_outcome outcome = {
        .rows = {experiment_linear_rows(&linear)}, .write_list = write_curves, .of = &linear};
    status = experiments_publish(request, &outcome, error);
  }
  free(linear.results);
  return status;
}
