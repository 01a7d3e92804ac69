/* See clock.h. SPDX-License-Identifier: Apache-2.0 */
#include "platform/clock.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

static double seconds_of(clockid_t clock) {
  struct timespec now;
  clock_gettime(clock, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double clock_seconds(void) {
  return seconds_of(CLOCK_MONOTONIC);
}

double clock_process_seconds(void) {
  return seconds_of(CLOCK_PROCESS_CPUTIME_ID);
}

double clock_thread_seconds(void) {
  return seconds_of(CLOCK_THREAD_CPUTIME_ID);
}

double clock_peak_mb(void) {
  // the usage of a process counts what its parent had when it forked, this file does not
  FILE *file = fopen("/proc/self/status", "r");
  char line[128];
  double kib = 0;
  while (file != NULL && kib == 0 && fgets(line, sizeof line, file) != NULL)
    if (strncmp(line, "VmHWM:", 6) == 0)
      kib = strtod(line + 6, NULL);
  if (file != NULL)
    fclose(file);
  if (kib > 0)
    return kib / 1024.0;

  struct rusage usage;
  if (getrusage(RUSAGE_SELF, &usage) != 0)
    return 0;
  // Linux counts in units of 1024 bytes
  return (double)usage.ru_maxrss / 1024.0;
}
