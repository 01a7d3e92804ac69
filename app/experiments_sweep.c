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

thrum_status experiments_sweep(const experiments_request *request, const experiments_bodies *bodies,
                               bool *flagged, thrum_error *error) {
  const bool of_work = request->kind == EXPERIMENTS_WORK_PRECISION;
  const bool of_variable = request->kind == EXPERIMENTS_VARIABLE;
  config_progress progress = config_progress_make(request->quiet);
  experiment_sweep sweep = {
      .bodies = bodies->bodies,
      .body_count = bodies->count,
      .starts = {[EXPERIMENT_START_impulse] = true, [EXPERIMENT_START_smooth] = of_work},
      .dts = of_variable ? experiment_variable_dts : experiment_sweep_dts,
      .dt_count = of_variable ? experiment_variable_dt_count : experiment_sweep_dt_count,
      .amplitude = request->amplitudes[0],
      .time = request->time,
      .reference_time = fmin(request->time, REFERENCE_TIME),
      .rounds = of_work ? ROUNDS : 1,
      .threads = (int)request->threads,
      .progress = experiments_progress,
      .progress_context = &progress,
  };

  // the files are written from the cases, which the sweep owns until its end
  memcpy(sweep.schemes, request->schemes, sizeof sweep.schemes);
  thrum_status status = experiment_sweep_run(&sweep, error);
  config_progress_end(&progress, status >= 0);

  if (status >= 0) {
    const experiments_table table = {experiments_kind_name(request->kind), "runs",
                                     experiment_sweep_rows(&sweep), columns};
    *flagged = experiment_sweep_flagged(&sweep);
    status = experiments_publish(request, &table, 1, *flagged, error);
  }
  experiment_sweep_free(&sweep);
  return status;
}
