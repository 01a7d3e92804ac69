/* See clock.h. SPDX-License-Identifier: Apache-2.0 */
#include "platform/clock.h"

#include <sys/resource.h>
#include <time.h>

double clock_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double clock_peak_mb(void) {
  struct rusage usage;
  if (getrusage(RUSAGE_SELF, &usage) != 0)
    return 0;
  // Linux counts in units of 1024 bytes
  return (double)usage.ru_maxrss / 1024.0;
}
