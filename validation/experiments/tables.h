/* Results as comma-separated tables, one row a run. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_TABLES_H
#define THRUM_VALIDATION_EXPERIMENTS_TABLES_H

#include "validation/experiments/extremes.h"
#include "validation/experiments/linear_free_vibration.h"
#include "validation/experiments/long_run.h"
#include "validation/experiments/matrix.h"
#include "validation/experiments/sweep.h"
#include "io/string_builder.h"

/* Steps that needed more than quasi-Newton, and what the watch did (thrum_state_report).
 * X(name, field, heading for people) */
#define STUDY_RUNG_LIST(X)                                                                         \
  X(newton, newton_steps, "full Newton")                                                           \
  X(energy, energy_steps, "energy step")                                                           \
  X(substep, substep_steps, "sub-steps")                                                           \
  X(handed, handed_steps, "handed over")                                                           \
  X(switches, switches, "switches")                                                                \
  X(handovers, handovers, "handovers")                                                             \
  X(corrections, corrections, "corrections")

enum {
#define X(name, field, heading) STUDY_RUNG_##name,
  STUDY_RUNG_LIST(X)
#undef X
      STUDY_RUNG_COUNT
};

extern const char *const study_rung_names[STUDY_RUNG_COUNT];
extern const char *const study_rung_headings[STUDY_RUNG_COUNT];
int64_t study_rung(const thrum_state_report *report, int rung);

/* "done", or why a run ended early; static storage. */
const char *study_status_name(thrum_status status);

void study_matrix_csv(study_text *text, const study_run *runs, int64_t count);

/* The recorded rows of all runs. */
void study_curves_csv(study_text *text, const study_run *runs, int64_t count);

void study_long_csv(study_text *text, const study_long_case *cases,
                    const study_long_result *results, int64_t count);

/* The means of all windows. */
void study_windows_csv(study_text *text, const study_long_case *cases,
                       const study_long_result *results, int64_t count);

/* Takes a case from the two tables of an earlier run, when they hold it whole and it came to its
 * end: fills what the case lacks and the result. */
bool study_long_read(const char *table, const char *windows, study_long_case *run,
                     study_long_result *result);

void study_sweep_csv(study_text *text, const study_sweep_case *cases,
                     const study_sweep_result *results, int64_t count);

void study_extremes_csv(study_text *text, const study_extreme_case *cases,
                        const study_extreme_result *results, int64_t count);

void study_units_csv(study_text *text, const study_unit_case *cases,
                     const study_unit_result *results, int64_t count);

/* A row a body; and the curves, a row a point. */
void study_linear_csv(study_text *text, const study_body *bodies,
                      const study_linear_result *results, int64_t count);
void study_linear_curves_csv(study_text *text, const study_body *bodies,
                             const study_linear_result *results, int64_t count);

#endif
