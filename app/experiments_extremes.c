/* `thrum experiments --extremes`: bodies, loads and steps far outside the usual, and one body in
 * many units. SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "app/experiments.h"
#include "config/progress.h"
#include "validation/experiments/tables.h"

static const json_column columns[] = {
    COLUMN_TEXT("subject", "subject", -10),
    COLUMN_TEXT("case", "case", -34),
    COLUMN_TEXT("scheme", "scheme", -19),
    COLUMN_TEXT("outcome", "outcome", -10),
    COLUMN_NUMBER("energy_error", "error", 9, "%.1e"),
    COLUMN_PERCENT("peak_amplitude", "bend", 9, "%.3g%%"),
    COLUMN_NUMBER("mean_iterations", "iter.", 6, "%.2f"),
    COLUMN_TEXT("reason", "", 0),
    COLUMN_END,
};
static const json_column unit_columns[] = {
    COLUMN_TEXT("units", "units", -10),
    COLUMN_TEXT("case", "case", -34),
    COLUMN_TEXT("scheme", "scheme", -19),
    COLUMN_NUMBER("difference", "differs by", 10, "%.1e"),
    COLUMN_END,
};

const experiments_form experiments_extremes_form = {
    {{"extremes", "runs", columns}, {"units", "units", unit_columns}}, NULL, NULL};

thrum_status experiments_extremes(const experiments_request *request,
                                  const experiments_bodies *bodies, bool *flagged,
                                  thrum_error *error) {
  config_progress progress = config_progress_make(request->quiet);
  (void)bodies; // it has bodies of its own

  // the cases that are asked for
  experiment_extremes extremes = {
      .steps = request->steps,
      .threads = (int)request->threads,
      .progress = config_progress_show,
      .progress_context = &progress,
  };
  memcpy(extremes.subjects, request->subjects, sizeof extremes.subjects);
  memcpy(extremes.schemes, request->schemes, sizeof extremes.schemes);
  thrum_status status = experiment_extremes_run(&extremes, error);
  config_progress_end(&progress, status >= 0);

  // their tables, also where some are flagged
  if (status >= 0) {
    *flagged = experiment_extremes_flagged(&extremes);
    const experiments_outcome outcome = {
        .rows = {experiment_extremes_rows(&extremes), experiment_units_rows(&extremes)},
        .flagged = *flagged};
    status = experiments_publish(request, &outcome, error);
  }
  experiment_extremes_free(&extremes);
  return status;
}
