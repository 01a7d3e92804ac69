/* How much memory there is to be had, see memory_limit.h: read from /proc and from the control
 * group, of version 1 or 2, that the process is in. SPDX-License-Identifier: Apache-2.0 */
#include "platform/memory_limit.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

// a number that follows `key` in a small file of the system; the first one when key is ""
static double number_in(const char *path, const char *key) {
  FILE *file = fopen(path, "r");
  char line[512];
  double value = NAN;
  while (file && isnan(value) && fgets(line, sizeof line, file))
    if (strncmp(line, key, strlen(key)) == 0 && sscanf(line + strlen(key), "%lf", &value) != 1)
      value = NAN;
  if (file)
    fclose(file);
  return value;
}

// pages of statm: 0 the address space, 1 resident
static double pages_of(int which) {
  double pages[2] = {NAN, NAN};
  FILE *file = fopen("/proc/self/statm", "r");
  if (file && fscanf(file, "%lf %lf", &pages[0], &pages[1]) != 2)
    pages[0] = pages[1] = NAN;
  if (file)
    fclose(file);
  return pages[which] * (double)sysconf(_SC_PAGESIZE);
}

double thrum_memory_resident(void) {
  const double bytes = pages_of(1);
  return isnan(bytes) ? 0 : bytes;
}

// limit - usage of one group; what the kernel may drop at once is not in use
static double left_in_group(const char *folder, const char *limit, const char *usage,
                            const char *droppable) {
  char path[700];
  snprintf(path, sizeof path, "%s/%s", folder, limit);
  const double most = number_in(path, "");
  snprintf(path, sizeof path, "%s/%s", folder, usage);

  const double used = number_in(path, "");

  snprintf(path, sizeof path, "%s/memory.stat", folder);
  const double cache = number_in(path, droppable);

  // no limit is "max", or a number near 2^63
  if (isnan(most) || isnan(used) || most > 1e18)
    return INFINITY;
  return fmax(0, most - used + (isnan(cache) ? 0 : cache));
}

// the least of a group and of those it lies in; root: where its kind is mounted
static double left_in_groups(const char *root, const char *group, int version) {
  char folder[600];
  double least = INFINITY;
  snprintf(folder, sizeof folder, "%s%s", root, group);
  for (;;) {
    const double left =
        version == 2 ? left_in_group(folder, "memory.max", "memory.current", "inactive_file ")
                     : left_in_group(folder, "memory.limit_in_bytes", "memory.usage_in_bytes",
                                     "total_inactive_file ");
    least = fmin(least, left);
    char *slash = strrchr(folder, '/');
    if (slash == NULL || (size_t)(slash - folder) < strlen(root))
      return least;
    *slash = 0;
  }
}

static double left_in_control_group(void) {
  FILE *file = fopen("/proc/self/cgroup", "r");
  char line[512];
  double least = INFINITY;

  // a line is ID:CONTROLLERS:PATH; version 2 has the number 0 and no controllers
  while (file && fgets(line, sizeof line, file)) {
    line[strcspn(line, "\n")] = 0;
    const char *group = strrchr(line, ':');
    if (group == NULL)
      continue;
    if (strncmp(line, "0::", 3) == 0)
      least = fmin(least, left_in_groups("/sys/fs/cgroup", group + 1, 2));
    else if (strstr(line, ":memory:") != NULL)
      least = fmin(least, left_in_groups("/sys/fs/cgroup/memory", group + 1, 1));
  }

  if (file)
    fclose(file);
  return least;
}

double thrum_memory_available(const char **what) {
  const char *name = "of the machine";
  const double machine = 1024 * number_in("/proc/meminfo", "MemAvailable:");
  double least = isnan(machine) ? INFINITY : machine;

  const double group = left_in_control_group();
  if (group < least) {
    least = group;
    name = "of the control group";
  }

  // a limit of the address space counts less what is mapped already
  struct rlimit limit;
  const double space = pages_of(0);
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && !isnan(space) &&
      (double)limit.rlim_cur - space < least) {
    least = fmax(0, (double)limit.rlim_cur - space);
    name = "of the process's limit";
  }

  if (what)
    *what = name;
  return least;
}
