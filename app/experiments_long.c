/* `thrum experiments --long`: the long runs.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/experiments.h"
#include "config/message.h"
#include "config/progress.h"
#include "io/file.h"
#include "validation/experiments/long_run.h"
#include "validation/experiments/tables.h"

/* A request with its runs, for the progress that writes the tables. */
typedef struct long_work {
  const experiments_request *request;
  experiment_long runs;
  config_progress progress;
} long_work;

static const json_column columns[] = {
    COLUMN_TEXT("model", "model", -8),
    COLUMN_TEXT("scheme", "scheme", -19),
    COLUMN_PERCENT("amplitude", "swing", 5, "%.0f%%"),
    COLUMN_NUMBER("steps", "steps", 9, "%.0f"),
    COLUMN_NUMBER("us_per_step", "us/step", 9, "%.2f"),
    COLUMN_NUMBER("total_change", "energy", 10, "%.1e"),
    COLUMN_NUMBER("total_worst", "worst", 10, "%.1e"),
    COLUMN_NUMBER("high_change", "high", 9, "%.1e"),
    COLUMN_NUMBER("high_slope_per_s", "slope", 9, "%.1e"),
    COLUMN_NUMBER("high_slope_error_correlated_per_s", "se", 9, "%.1e"),
    COLUMN_TEXT("status", " status", 0),
    COLUMN_END,
};

const experiments_form experiments_long_form = {
    {{"long", "runs", columns}}, "long_windows.csv", NULL};

/* Marks the runs that the tables in the folder hold already as done; without tables there are none.
 */
static void resume(long_work *work) {
  char path[NAMED_MODEL_PATH_MAX];
  void *table = NULL, *windows = NULL;
  size_t size = 0;
  snprintf(path, sizeof path, "%s/long.csv", work->request->output);
  if (thrum_file_read(path, &table, &size, NULL) < 0)
    return;

  snprintf(path, sizeof path, "%s/%s", work->request->output, experiments_long_form.list);
  if (thrum_file_read(path, &windows, &size, NULL) >= 0)
    experiment_tables_read_long(table, windows, &work->runs);
  free(table);
  free(windows);
}

static void write_windows(FILE *stream, const void *of) {
  experiment_windows_csv(stream, of);
}

static experiments_outcome outcome_of(const experiment_long *runs) {
  return (experiments_outcome){
      .rows = {experiment_long_rows(runs)},
      .write_list = write_windows,
      .of = runs,
      .flagged = experiment_long_flagged(runs),
  };
}

/* The tables of the runs that are done. */
static thrum_status write_tables(const long_work *work, thrum_error *error) {
  const experiments_outcome outcome = outcome_of(&work->runs);
  thrum_status status = experiments_write_rows(work->request, "long", outcome.rows[0], error);
  THRUM_THEN(status,
             experiments_write_list(work->request, experiments_long_form.list, &outcome, error));
  cJSON_Delete(outcome.rows[0]);
  return status;
}

/* After each run: the tables keep what is done, should the program be stopped. */
static bool keep(void *context, double fraction) {
  long_work *work = context;
  thrum_error error = {0};
  experiments_progress(&work->progress, fraction);
  if (work->request->result == NULL && write_tables(work, &error) < 0)
    config_warn("%s", error.message);
  return true;
}

thrum_status experiments_long(const experiments_request *request, const experiments_bodies *bodies,
                              bool *flagged, thrum_error *error) {
  long_work work = {.request = request, .progress = config_progress_make(request->quiet)};
  experiment_long *runs = &work.runs;
  *runs = (experiment_long){
      .bodies = bodies->bodies,
      .body_count = bodies->count,
      .amplitudes = request->amplitudes,
      .amplitude_count = request->amplitude_count,
      .dt = request->dt,
      .steps = request->steps,
      .threads = (int)request->threads,
      .progress = keep,
      .progress_context = &work,
  };
  memcpy(runs->schemes, request->schemes, sizeof runs->schemes);
  thrum_status status = experiment_long_plan(runs, error);
  if (status < 0)
    goto cleanup;

  // what an earlier call has done is not run again
  if (request->resume)
    resume(&work);
  status = experiment_long_run(runs, error);
  config_progress_end(&work.progress, status >= 0);

  if (status >= 0) {
    const experiments_outcome outcome = outcome_of(runs);
    *flagged = outcome.flagged;
    status = experiments_publish(request, &outcome, error);
  }

cleanup:
  experiment_long_free(runs);
  return status;
}
