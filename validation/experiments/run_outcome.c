/* Names and counters of the outcome of a run. SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/run_outcome.h"

#include <stddef.h>

const char *const experiment_level_names[EXPERIMENT_LEVEL_COUNT] = {
#define X(name, field) #name,
    EXPERIMENT_LEVEL_LIST(X)
#undef X
};

static const size_t offsets[EXPERIMENT_LEVEL_COUNT] = {
#define X(name, field) offsetof(thrum_state_report, field),
    EXPERIMENT_LEVEL_LIST(X)
#undef X
};

int64_t experiment_level(const thrum_state_report *report, int level) {
  return *(const int64_t *)((const char *)report + offsets[level]);
}

void experiment_level_set(thrum_state_report *report, int level, int64_t count) {
  *(int64_t *)((char *)report + offsets[level]) = count;
}

int64_t experiment_own_steps(const thrum_state_report *report) {
  return report->steps - report->switched_steps - report->energy_steps - report->substep_steps;
}

const char *experiment_status_name(thrum_status status, bool lost) {
  return status < 0 || lost ? "lost" : "done";
}

const char *experiment_reason(thrum_status status, bool lost) {
  if (lost)
    return "energy";
  switch (status) {
  case THRUM_NOT_CONVERGED:
    return "not converged";
  case THRUM_NOT_FINITE:
    return "not finite";
  default:
    return status < 0 ? "failed" : "";
  }
}
