/* Energy drift: the one definition of it in Thrum.
 *
 * Rows of the total energy E_0, E_1, ... are split into equal parts from the first row that no load
 * acts on; drift is (mean of the last part - mean of the first part) / mean of the first part. It
 * should be zero in a free motion without damping, and it says nothing elsewhere.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_DRIFT_H
#define THRUM_DRIVER_RUN_DRIFT_H

#include <stdint.h>

/* The two windows and the sums of the energies in them. Zeroed: no windows, so no drift. */
typedef struct driver_drift {
  int64_t first_begin, first_end; /* rows [begin, end) */
  int64_t last_begin, last_end;
  double begin; /* energy of the row first_begin */
  double first_sum, last_sum;
  int64_t first_count, last_count;
} driver_drift;

/* The windows of rows [first, rows) in `parts` equal parts (a remainder lies between the two); none
 * where a part has fewer than `least` rows. */
driver_drift driver_drift_plan(int64_t first, int64_t rows, int64_t parts, int64_t least);

/* Takes in the energy of a row; rows outside the windows are ignored. */
void driver_drift_add(driver_drift *drift, int64_t row, double energy);

/* The energy that a free motion grew from and the mean that it grew to, where there is a drift: the
 * first is that of the first row, unless the mean of the first part is lower. */
void driver_drift_ends(const driver_drift *drift, double *from, double *to);

/* The drift; NaN without windows, while a window lacks rows, and for a body without energy. */
double driver_drift_value(const driver_drift *drift);

#endif
