/* Tasks over threads: each is done once, and the first that fails ends the others. Under a thread
 * sanitizer this also shows that the threads of a pool share nothing that is not guarded.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "platform/thread_pool.h"

typedef struct tally {
  int counts[1000];
  int64_t fail_at;
} tally;

static thrum_status count_task(void *context, int64_t index, thrum_error *error) {
  tally *all = context;
  all->counts[index]++;
  if (index == all->fail_at)
    return thrum_error_set(error, THRUM_IO, "task %d", (int)index);
  return THRUM_OK;
}

static bool stop_at_half(void *context, double fraction) {
  *(double *)context = fraction;
  return fraction < 0.5;
}

static void each_task_is_done_once(void **state) {
  (void)state;
  tally all = {.fail_at = -1};
  thrum_thread_pool pool = {.threads = 4, .count = 1000, .task = count_task, .context = &all};
  thrum_error error = {0};
  assert_int_equal(thrum_thread_pool_run(&pool, &error), THRUM_OK);
  for (int n = 0; n < 1000; n++)
    assert_int_equal(all.counts[n], 1);
}

static void a_failed_task_ends_the_others(void **state) {
  (void)state;
  thrum_error error = {0};

  // on one thread no later task begins
  tally all = {.fail_at = 3};
  thrum_thread_pool pool = {.threads = 1, .count = 1000, .task = count_task, .context = &all};
  assert_int_equal(thrum_thread_pool_run(&pool, &error), THRUM_IO);
  assert_string_equal(error.message, "task 3");
  assert_int_equal(all.counts[4], 0);

  // nor after the caller's progress has said so
  double fraction = 0;
  all.fail_at = -1;
  pool.progress = stop_at_half;
  pool.progress_context = &fraction;
  assert_int_equal(thrum_thread_pool_run(&pool, &error), THRUM_INTERRUPTED);
  assert_true(fraction == 0.5);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_task_is_done_once),
      cmocka_unit_test(a_failed_task_ends_the_others),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
