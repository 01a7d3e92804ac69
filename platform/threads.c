/* How many threads the numerical libraries may start, see threads.h.
 *
 * CHOLMOD has no setting for its OpenMP threads at run time. OpenMP has one, reached here without
 * linking to any of its implementations: whichever CHOLMOD brought along is asked, if any.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "platform/threads.h"

#include <cblas.h>
#include <dlfcn.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

// OpenBLAS takes 128 MiB a thread at its first call and keeps it; it tries for ever when there is
// none
#define BUFFER ((size_t)160 << 20)

// the function called `name` of whatever the process has loaded, into *function
static void find_function(const char *name, void *function, size_t size) {
  void *process = dlopen(NULL, RTLD_LAZY);
  void *found = process ? dlsym(process, name) : NULL;
  // POSIX lets a function's address pass through a void pointer, C asks for the copy
  memcpy(function, &found, size);
  if (process)
    dlclose(process);
}

static int parallel_levels(void) {
  int (*get)(void);
  find_function("omp_get_max_active_levels", &get, sizeof get);
  return get ? get() : -1;
}

static void set_parallel_levels(int levels) {
  void (*set)(int);
  find_function("omp_set_max_active_levels", &set, sizeof set);
  if (set && levels >= 0)
    set(levels);
}

thrum_threads thrum_threads_set(int threads) {
  const thrum_threads before = {openblas_get_num_threads(), parallel_levels()};
  openblas_set_num_threads(threads);
  if (threads == 1)
    set_parallel_levels(0);
  return before;
}

void thrum_threads_restore(thrum_threads before) {
  openblas_set_num_threads(before.blas);
  set_parallel_levels(before.parallel_levels);
}

// bytes of address space that `threads` threads and this one may take beyond what they have
static size_t buffers(int threads) {
  struct rlimit limit;
  const int more = threads - openblas_get_num_threads();
  if (more <= 0 || getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
    return BUFFER;
  return (size_t)(more + 1) * BUFFER;
}

thrum_status thrum_threads_ready(int threads, thrum_error *error) {
  static atomic_bool ready;
  if (threads <= 1 && atomic_load(&ready))
    return THRUM_OK;

  // the memory that OpenBLAS will take must be there, else it would try for ever
  const size_t size = buffers(threads);
  void *volatile probe = malloc(size);
  free(probe);

  // BLAS takes its buffer in the first call
  const double one = 1, in = 1;
  double out = 0;
  if (probe)
    cblas_dsymv(CblasColMajor, CblasUpper, 1, 1, &one, 1, &in, 1, 0, &out, 1);

  if (probe && out == 1) {
    atomic_store(&ready, true);

    return THRUM_OK;
  }
  return thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                         "no memory for the numerical libraries (%zu MB)", size >> 20);
}
