/* As much of cmocka as test_kernel.c and test_inverse.c need, for machines that have no cmocka.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_CROSS_CMOCKA_H
#define THRUM_TESTS_CROSS_CMOCKA_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define assert_true(x)                                                                             \
  do {                                                                                             \
    if (!(x)) {                                                                                    \
      printf("%s:%d: %s is false\n", __FILE__, __LINE__, #x);                                      \
      exit(1);                                                                                     \
    }                                                                                              \
  } while (0)
#define assert_false(x) assert_true(!(x))
#define assert_null(x) assert_true((x) == NULL)
#define assert_int_equal(a, b) assert_true((a) == (b))
#define assert_ptr_equal(a, b) assert_true((a) == (b))
#define assert_memory_equal(a, b, size) assert_true(memcmp(a, b, size) == 0)
#define cmocka_unit_test(function)                                                                 \
  { #function, function }
#define cmocka_run_group_tests(tests, setup, teardown)                                             \
  run_tests(tests, sizeof tests / sizeof tests[0], setup, teardown)

struct CMUnitTest {
  const char *name;
  void (*function)(void **state);
};

static int run_tests(const struct CMUnitTest *tests, size_t count, int (*setup)(void **),
                     int (*teardown)(void **)) {
  void *state = NULL;
  if (setup)
    setup(&state);
  for (size_t n = 0; n < count; n++) {
    tests[n].function(&state);
    printf("ok %s\n", tests[n].name);
  }
  return teardown ? teardown(&state) : 0;
}

#endif
