/* How many threads the numerical libraries may start. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_THREADS_H
#define THRUM_PLATFORM_THREADS_H

#include "thrum/status.h"

typedef struct thrum_threads {
  int blas;
  int parallel_levels; /* of OpenMP, -1 where there is none */
} thrum_threads;

/* Gives BLAS `threads` threads; 1 also keeps CHOLMOD from starting the four OpenMP threads that its
 * build fixes. Settings of the process: returns what was set before, for thrum_threads_restore. */
thrum_threads thrum_threads_set(int threads);
void thrum_threads_restore(thrum_threads before);

/* Call it before thrum_threads_set. Returns THRUM_OUT_OF_MEMORY when there is no memory for the
 * work buffers of BLAS, which BLAS would otherwise wait for without end. */
thrum_status thrum_threads_ready(int threads, thrum_error *error);

#endif
