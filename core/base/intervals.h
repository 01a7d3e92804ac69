/* Tables of times. Header only; private to Thrum's own libraries.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_INTERVALS_H
#define THRUM_CORE_BASE_INTERVALS_H

#include <stdint.h>

/* The last interval between ascending times (count, 1 or more) that begins at `time` or before; 0
 * when none does. */
static inline int64_t thrum_interval_at(const double *times, int64_t count, double time) {
  int64_t low = 0, high = count - 1;
  while (high - low > 1) {
    const int64_t middle = low + (high - low) / 2;
    if (times[middle] <= time)
      low = middle;
    else
      high = middle;
  }
  return low;
}

#endif
