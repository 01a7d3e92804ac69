/* Results as comma-separated tables, one row a run. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_TABLES_H
#define THRUM_VALIDATION_EXPERIMENTS_TABLES_H

#include "io/string_builder.h"
#include "validation/experiments/extremes.h"
#include "validation/experiments/linear_free_vibration.h"
#include "validation/experiments/long_run.h"
#include "validation/experiments/matrix.h"
#include "validation/experiments/sweep.h"

/* Steps that needed more than quasi-Newton, and what the watch did (thrum_state_report).
 * X(name, field, heading for people) */
#define EXPERIMENT_LEVEL_LIST(X)                                                                   \
  X(newton, newton_steps, "full Newton")                                                           \
  X(energy, energy_steps, "energy step")                                                           \
  X(substep, substep_steps, "sub-steps")                                                           \
  X(switched, switched_steps, "switched to the energy integrator")                                 \
  X(split_changes, split_changes, "split changes")                                                 \
  X(scheme_switches, scheme_switches, "scheme switches")                                           \
  X(corrections, corrections, "corrections")

enum {
#define X(name, field, heading) EXPERIMENT_LEVEL_##name,
  EXPERIMENT_LEVEL_LIST(X)
#undef X
      EXPERIMENT_LEVEL_COUNT
};

extern const char *const experiment_level_names[EXPERIMENT_LEVEL_COUNT];
extern const char *const experiment_level_headings[EXPERIMENT_LEVEL_COUNT];
int64_t experiment_level(const thrum_state_report *report, int fallback_level);

/* "done", or why a run ended early; static storage. */
const char *experiment_status_name(thrum_status status);

void experiment_matrix_csv(experiment_text *text, const experiment_run *runs, int64_t count);

/* The recorded rows of all runs. */
void experiment_curves_csv(experiment_text *text, const experiment_run *runs, int64_t count);

void experiment_long_csv(experiment_text *text, const experiment_long_case *cases,
                         const experiment_long_result *results, int64_t count);

/* The means of all windows. */
void experiment_windows_csv(experiment_text *text, const experiment_long_case *cases,
                            const experiment_long_result *results, int64_t count);

/* Takes a case from the two tables of an earlier run, when they hold it whole and it came to its
 * end: fills what the case lacks and the result. */
bool experiment_long_read(const char *table, const char *windows, experiment_long_case *run,
                          experiment_long_result *result);

void experiment_sweep_csv(experiment_text *text, const experiment_sweep_case *cases,
                          const experiment_sweep_result *results, int64_t count);

void experiment_extremes_csv(experiment_text *text, const experiment_extreme_case *cases,
                             const experiment_extreme_result *results, int64_t count);

void experiment_units_csv(experiment_text *text, const experiment_unit_case *cases,
                          const experiment_unit_result *results, int64_t count);

/* A row a body; and the curves, a row a point. */
void experiment_linear_csv(experiment_text *text, const experiment_body *bodies,
                           const experiment_linear_result *results, int64_t count);
void experiment_linear_curves_csv(experiment_text *text, const experiment_body *bodies,
                                  const experiment_linear_result *results, int64_t count);

#endif
