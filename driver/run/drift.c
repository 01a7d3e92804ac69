/* Drift of the total energy, see drift.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/drift.h"

#include <math.h>

driver_drift driver_drift_plan(int64_t first, int64_t rows, int64_t parts, int64_t least) {
  const int64_t width = first < rows ? (rows - first) / parts : 0;
  if (width < least || width < 1)
    return (driver_drift){0};
  return (driver_drift){.first_begin = first,
                        .first_end = first + width,
                        .last_begin = rows - width,
                        .last_end = rows};
}

void driver_drift_add(driver_drift *drift, int64_t row, double energy) {
  if (row >= drift->first_begin && row < drift->first_end) {
    if (row == drift->first_begin)
      drift->begin = energy;
    drift->first_sum += energy;
    drift->first_count++;
  }
  if (row >= drift->last_begin && row < drift->last_end) {
    drift->last_sum += energy;
    drift->last_count++;
  }
}

double driver_drift_value(const driver_drift *drift) {
  const int64_t width = drift->last_end - drift->last_begin;
  // a run that ended early has no last window, a body at rest no energy to compare with
  if (width == 0 || drift->first_count < width || drift->last_count < width ||
      !(drift->first_sum > 0))
    return NAN;
  return (drift->last_sum - drift->first_sum) / drift->first_sum;
}

void driver_drift_ends(const driver_drift *drift, double *from, double *to) {
  *from = fmin(drift->begin, drift->first_sum / (double)drift->first_count);
  *to = drift->last_sum / (double)drift->last_count;
}
