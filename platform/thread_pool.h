/* Tasks over threads. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_THREAD_POOL_H
#define THRUM_PLATFORM_THREAD_POOL_H

#include <stdbool.h>
#include <stdint.h>

#include "thrum/status.h"

/* A pool does `task` once for each index below `count`, on any thread. The first failure
 * ends it: no further task starts. `progress`, which may be NULL, is called on one thread at a time
 * with the share of tasks done; it returns false to stop. */
typedef struct thrum_thread_pool {
  int threads;
  int64_t count;
  thrum_status (*task)(void *context, int64_t index, thrum_error *error);
  bool (*progress)(void *context, double fraction);
  void *context;          /* of task */
  void *progress_context; /* of progress */
} thrum_thread_pool;

/* THRUM_INTERRUPTED when progress said so; else the status of the task that failed first. */
thrum_status thrum_thread_pool_run(const thrum_thread_pool *pool, thrum_error *error);

#endif
