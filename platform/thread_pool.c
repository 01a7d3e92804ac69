/* Tasks over threads: each takes the next index that is left. SPDX-License-Identifier: Apache-2.0
 */
#include "platform/thread_pool.h"

#include <pthread.h>

#define THREADS_MAX 256

typedef struct pool_run {
  const thrum_thread_pool *pool;
  pthread_mutex_t mutex; /* of all below */
  int64_t next;
  int64_t done;
  thrum_status status;
  thrum_error error;
} pool_run;

/* The next index, or -1 when there is none or the pool is to end. */
static int64_t take(pool_run *run) {
  pthread_mutex_lock(&run->mutex);
  const int64_t index = run->status >= 0 && run->next < run->pool->count ? run->next++ : -1;
  pthread_mutex_unlock(&run->mutex);
  return index;
}

static void note(pool_run *run, thrum_status status, const thrum_error *error) {
  const thrum_thread_pool *pool = run->pool;
  pthread_mutex_lock(&run->mutex);
  run->done++;
  if (status < 0 && run->status >= 0) {
    run->status = status;
    run->error = *error;
  }
  if (run->status >= 0 && pool->progress != NULL &&
      !pool->progress(pool->progress_context, (double)run->done / (double)pool->count))
    run->status = thrum_error_set(&run->error, THRUM_INTERRUPTED, "interrupted");
  pthread_mutex_unlock(&run->mutex);
}

static void *work(void *context) {
  pool_run *run = context;
  for (int64_t index = take(run); index >= 0; index = take(run)) {
    thrum_error error = {0};
    const thrum_status status = run->pool->task(run->pool->context, index, &error);
    note(run, status, &error);
  }
  return NULL;
}

thrum_status thrum_thread_pool_run(const thrum_thread_pool *pool, thrum_error *error) {
  pthread_t threads[THREADS_MAX];
  pool_run run = {.pool = pool, .status = THRUM_OK};
  int started = 0;
  pthread_mutex_init(&run.mutex, NULL);

  // this thread works too, so a thread that cannot be had costs time and nothing else
  for (int n = 1; n < pool->threads && n < THREADS_MAX && n < pool->count; n++)
    if (pthread_create(&threads[started], NULL, work, &run) == 0)
      started++;

  work(&run);
  for (int n = 0; n < started; n++)
    pthread_join(threads[n], NULL);
  pthread_mutex_destroy(&run.mutex);

  if (run.status < 0 && error != NULL)
    *error = run.error;
  return run.status;
}
