/* `thrum experiments`: the matrix of bodies, loads, dampings and schemes, also of --step-sizes.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "app/experiments.h"
#include "config/progress.h"
#include "validation/experiments/tables.h"

#define ROWS 1000
#define SPARSE_ROWS 100
#define DENSE_TIME 1.0 /* of --step-sizes: over which its curves are laid over each other [s] */

static const json_column columns[] = {
    COLUMN_TEXT("model", "model", -8),
    COLUMN_TEXT("load", "load", -8),
    COLUMN_NUMBER("damping", "damp.", 5, "%g"),
    COLUMN_NUMBER("dt_s", "dt [s]", 6, "%g"),
    COLUMN_TEXT("scheme", "scheme", -19),
    COLUMN_NUMBER("simulated_s", "time [s]", 8, "%.3f"),
    COLUMN_NUMBER("us_per_step", "us/step", 8, "%.2f"),
    COLUMN_NUMBER("mean_iterations", "iter.", 6, "%.2f"),
    COLUMN_PERCENT("peak_amplitude", "bend", 6, "%.3g%%"),
    COLUMN_NUMBER("energy_end_j", "end [J]", 10, "%.3g"),
    COLUMN_TEXT("status", " status", 0),
    COLUMN_END,
};

const experiments_form experiments_matrix_form = {{{"runs", "runs", columns}}, "curves.csv", NULL};

/* The runs, for the list of their curves. */
typedef struct matrix_runs {
  const experiment_run *runs;
  int64_t count;
} matrix_runs;

static void write_curves(FILE *stream, const void *of) {
  const matrix_runs *all = of;
  experiment_curves_csv(stream, all->runs, all->count);
}

static thrum_status publish(const experiments_request *request, const experiment_run *runs,
                            int64_t count, bool *flagged, thrum_error *error) {
  *flagged = experiment_runs_flagged(runs, count);
  const experiments_outcome outcome = {
      .rows = {experiment_matrix_rows(runs, count)},
      .write_list = write_curves,
      .of = &(matrix_runs){runs, count},
      .flagged = *flagged,
  };
  return experiments_publish(request, &outcome, error);
}

thrum_status experiments_matrix(const experiments_request *request,
                                const experiments_bodies *bodies, bool *flagged,
                                thrum_error *error) {
  static const double step_sizes[] = {0.001, 0.005, 0.01}; // of the thesis' experiment 5.5
  const bool of_step_sizes = request->kind == EXPERIMENTS_STEP_SIZES;
  config_progress progress = config_progress_make(request->quiet);
  experiment_matrix matrix = {
      .bodies = bodies->bodies,
      .body_count = bodies->count,
      .dts = of_step_sizes ? step_sizes : &request->dt,
      .dt_count = of_step_sizes ? sizeof step_sizes / sizeof step_sizes[0] : 1,
      .damping_count = of_step_sizes ? 1 : EXPERIMENT_DAMPING_COUNT,
      .row_count = of_step_sizes ? SPARSE_ROWS : ROWS,
      .time = request->time,
      .dense = of_step_sizes ? DENSE_TIME : 0,
      .threads = (int)request->threads,
      .progress = experiments_progress,
      .progress_context = &progress,
  };
  memcpy(matrix.loads, request->loads, sizeof matrix.loads);
  memcpy(matrix.schemes, request->schemes, sizeof matrix.schemes);
  const int64_t count = experiment_matrix_count(&matrix);
  experiment_run *runs = calloc((size_t)count + 1, sizeof *runs);
  if (runs == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory");

  thrum_status status = experiment_matrix_run(&matrix, runs, error);
  config_progress_end(&progress, status >= 0);
  THRUM_THEN(status, publish(request, runs, count, flagged, error));
  experiment_runs_free(runs, count);
  return status;
}
