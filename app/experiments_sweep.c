/* `thrum experiments --sweep`: the sweep over time steps.
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "app/experiments.h"
#include "config/progress.h"
#include "validation/experiments/sweep.h"
#include "validation/experiments/tables.h"

static const json_column columns[] = {
    COLUMN_TEXT("model", "model", -8),
    COLUMN_TEXT("integrator", "method", -8),
    COLUMN_NUMBER("dt_s", "dt [s]", 7, "%g"),
    COLUMN_NUMBER("simulated_s", "time [s]", 8, "%.3f"),
    COLUMN_NUMBER("us_per_step", "us/step", 8, "%.2f"),
    COLUMN_NUMBER("mean_iterations", "iter.", 6, "%.2f"),
    COLUMN_NUMBER("energy_error", "error", 10, "%.1e"),
    COLUMN_NUMBER("energy_change", "change", 10, "%.1e"),
    COLUMN_TEXT("status", " status", 0),
    COLUMN_END,
};

thrum_status experiments_sweep(const experiments_request *request, const experiments_bodies *bodies,
                               bool *flagged, thrum_error *error) {
  config_progress progress = config_progress_make(request->quiet);
  experiment_sweep sweep = {
      .bodies = bodies->bodies,
      .body_count = bodies->count,
      .amplitude = request->amplitudes[0],
      .time = request->time,
      .threads = (int)request->threads,
      .progress = experiments_progress,
      .progress_context = &progress,
  };
  memcpy(sweep.integrators, request->integrators, sizeof sweep.integrators);
  thrum_status status = experiment_sweep_run(&sweep, error);
  config_progress_end(&progress, status >= 0);

  if (status >= 0) {
    const experiments_table table = {"sweep", "runs", experiment_sweep_rows(&sweep), columns};
    *flagged = experiment_sweep_flagged(&sweep);
    status = experiments_publish(request, &table, 1, *flagged, error);
  }
  experiment_sweep_free(&sweep);
  return status;
}
