/* How a run ended: its status by name, and the steps that needed more than quasi-Newton.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_RUN_OUTCOME_H
#define THRUM_VALIDATION_EXPERIMENTS_RUN_OUTCOME_H

#include <stdbool.h>

#include "thrum/thrum.h"

/* Counters of thrum_state_report: the fallback levels, and the actions of the stability monitor.
 * X(name of the column, field) */
#define EXPERIMENT_LEVEL_LIST(X)                                                                   \
  X(newton, newton_steps)                                                                          \
  X(energy, energy_steps)                                                                          \
  X(substep, substep_steps)                                                                        \
  X(switched, switched_steps)                                                                      \
  X(split_changes, split_changes)                                                                  \
  X(scheme_switches, scheme_switches)                                                              \
  X(corrections, corrections)

enum {
#define X(name, field) EXPERIMENT_LEVEL_##name,
  EXPERIMENT_LEVEL_LIST(X)
#undef X
      EXPERIMENT_LEVEL_COUNT
};

extern const char *const experiment_level_names[EXPERIMENT_LEVEL_COUNT];

/* The counter with this index. */
int64_t experiment_level(const thrum_state_report *report, int level);
void experiment_level_set(thrum_state_report *report, int level, int64_t count);

/* A run is lost when its energy is this many times what it is known to be. */
#define EXPERIMENT_LOST 10.0

/* How many steps the scheme itself took: all but those of `energy` and of shorter steps. */
int64_t experiment_own_steps(const thrum_state_report *report);

/* "done" or "lost": its energy was lost, or a step could not be made. Static storage. */
const char *experiment_status_name(thrum_status status, bool lost);

/* Why it was lost: "energy", or what the step said; "" for a run that is done. Static storage. */
const char *experiment_reason(thrum_status status, bool lost);

#endif
