/* `thrum experiments --sweep`, --work-precision and --variable: the sweep over time steps.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "app/experiments.h"
#include "config/progress.h"
#include "validation/experiments/sweep.h"
#include "validation/experiments/tables.h"

#define REFERENCE_TIME 1.0 /* over which q is compared at most [s] */
#define ROUNDS 6           /* of --work-precision: the runs, then five to time them */

static const json_column columns[] = {
    COLUMN_TEXT("model", "model", -8),
    COLUMN_TEXT("scheme", "scheme", -19),
    COLUMN_TEXT("start", "start", -7),
    COLUMN_NUMBER("shortest_dt_s", "dt [s]", 7, "%g"),
    COLUMN_NUMBER("dt_s", "to", 7, "%g"),
    COLUMN_NUMBER("simulated_s", "time [s]", 8, "%.3f"),
    COLUMN_NUMBER("us_per_step", "us/step", 8, "%.2f"),
    COLUMN_NUMBER("mean_iterations", "iter.", 6, "%.2f"),
    COLUMN_NUMBER("error", "error", 9, "%.1e"),
    COLUMN_NUMBER("energy_error", "energy", 10, "%.1e"),
    COLUMN_NUMBER("energy_change", "change", 10, "%.1e"),
    COLUMN_TEXT("status", " status", 0),
    COLUMN_END,
};

const experiments_form experiments_sweep_form = {{{NULL, "runs", columns}}, NULL, NULL};

thrum_status experiments_sweep(const experiments_request *request, const experiments_bodies *bodies,
                               bool *flagged, thrum_error *error) {
  const bool of_work = request->kind == EXPERIMENTS_WORK_PRECISION;
  config_progress progress = config_progress_make(request->quiet);
  experiment_sweep sweep = {
      .bodies = bodies->bodies,
      .body_count = bodies->count,
      .dts = request->dts,
      .dt_count = request->dt_count,
      .amplitude = request->amplitudes[0],
      .time = request->time,
      .reference_time = fmin(request->time, REFERENCE_TIME),
      .rounds = of_work ? ROUNDS : 1,
      .threads = (int)request->threads,
      .progress = experiments_progress,
      .progress_context = &progress,
  };

  // the rows are made from the cases, which the sweep owns until its end
  memcpy(sweep.starts, request->starts, sizeof sweep.starts);
  memcpy(sweep.schemes, request->schemes, sizeof sweep.schemes);
  thrum_status status = experiment_sweep_run(&sweep, error);
  config_progress_end(&progress, status >= 0);

  if (status >= 0) {
    *flagged = experiment_sweep_flagged(&sweep);
    const experiments_outcome outcome = {.rows = {experiment_sweep_rows(&sweep)},
                                         .flagged = *flagged};
    status = experiments_publish(request, &outcome, error);
  }
  experiment_sweep_free(&sweep);
  return status;
}
