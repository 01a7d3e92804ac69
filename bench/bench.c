/* Statistics and the processor's name (bench/bench.h). SPDX-License-Identifier: Apache-2.0
 */
#include "bench/bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

bench_time bench_summary(double *samples, int64_t count) {
  qsort(samples, (size_t)count, sizeof *samples, ascending);
  const bench_time time = {samples[0], samples[count / 2]};
  return time;
}

const char *bench_processor(void) {
  static char name[128] = "unknown";
  FILE *file = fopen("/proc/cpuinfo", "r");
  char line[256];
  while (file && fgets(line, sizeof line, file)) {
    const char *colon = strchr(line, ':');
    if (strncmp(line, "model name", 10) != 0 || !colon)
      continue;
    snprintf(name, sizeof name, "%s", colon + 2);
    name[strcspn(name, "\n")] = 0;
    break;
  }
  if (file)
    fclose(file);
  return name;
}
