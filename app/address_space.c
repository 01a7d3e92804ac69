/* Starting under a limit of the address space (ulimit -v). OpenBLAS starts a thread a core before
 * main, each of which takes 128 MiB and, where there is none, tries again for ever; the program
 * would then not even end. The number of threads is read from the environment when the library is
 * loaded, so the program starts itself again with one. SPDX-License-Identifier: Apache-2.0 */
#include "app/address_space.h"

#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#define THREADS "OPENBLAS_NUM_THREADS"

void address_space_begin(char **argv) {
  struct rlimit limit;
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || getenv(THREADS))
    return;
  // --threads starts more of them later, where there is room
  if (setenv(THREADS, "1", 1) == 0)
    execv("/proc/self/exe", argv);
}
