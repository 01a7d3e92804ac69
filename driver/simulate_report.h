/* The figures of a run and how they are shown. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SIMULATE_REPORT_H
#define THRUM_DRIVER_SIMULATE_REPORT_H

#include "driver/run_output.h"
#include "driver/simulate_measures.h"
#include "driver/simulate_options.h"
#include "precompute/full/full.h"

/* Mean total energy over the first and the last tenth of the rows that no load acts on. */
typedef struct simulate_drift {
  int64_t first_begin, first_end; /* rows [begin, end) */
  int64_t last_begin, last_end;
  double first_sum, last_sum;
  int64_t first_count, last_count;
} simulate_drift;

typedef struct simulate_figures {
  const simulate_request *request;
  const thrum_model *model;
  uint64_t model_hash; /* 64-bit FNV-1a of the file's bytes */
  thrum_status status; /* THRUM_OK, or how the run ended */
  bool energy_grew;
  thrum_error stop; /* why it ended early; empty message: it did not */
  thrum_state_report report;
  thrum_full_report full; /* of --full */
  int64_t fallback_steps;
  thrum_energies first, last;
  double energy_min, energy_max;
  double work_load, work_base, dissipated; /* [J]; the last NaN for the tangent form of damping */
  simulate_drift windows;
  double drift; /* NaN where it says nothing */
  double peak;  /* largest displacement of the recorded states [m]; NaN without a basis */
  int64_t peak_vertex;
  double seconds_read, seconds_step, seconds_output, seconds_plot, seconds_total;
} simulate_figures;

/* Plans the windows of the drift. */
void simulate_figures_begin(simulate_figures *figures);

/* Takes in the energies of row `row`; row -1: those of the last step, which may have no row. */
void simulate_figures_add(simulate_figures *figures, int64_t row, const thrum_energies *energies);

/* Sets drift and energy_grew. */
void simulate_figures_end(simulate_figures *figures);

/* "done", or what flags the run: "fell_back", "not_converged", "interrupted", ... */
const char *simulate_status_name(const simulate_figures *figures);

/* What the object of a run or of a scene's run begins with: the report of `thrum simulate`, and why
 * the run ended early where `stop` says so. */
cJSON *simulate_report_begin(const char *status, const thrum_error *stop);

/* The object of --json and run.json. */
cJSON *simulate_report_json(const simulate_figures *figures, const cli_run_output *output,
                            const simulate_measures *measures);

void simulate_report_table(const simulate_figures *figures, const cli_run_output *output,
                           const simulate_measures *measures);

#endif
