/* Tests of the cache's bound: the oldest files go, and only as many as must.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include <utime.h>

#include "driver/model/cache_trim.h"
#include "tests/support/test_folder.h"

/* A file of 100 bytes that is `age` seconds old. */
static void put(const char *name, int age) {
  const char *path = in_folder(name);
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  for (int n = 0; n < 100; n++)
    fputc('x', file);
  assert_int_equal(fclose(file), 0);
  const struct utimbuf times = {time(NULL) - age, time(NULL) - age};
  assert_int_equal(utime(path, &times), 0);
}

static int there(const char *name) {
  return access(in_folder(name), F_OK) == 0;
}

static void the_oldest_go_until_the_rest_fits(void **context) {
  (void)context;
  put("mesh-b", 5000);
  put("mesh-a", 7000);
  put("mesh-d", 4000);
  put("mesh-c", 6000);
  put("mesh-e", 10);
  cache_trim(folder, "mesh-", 300, 3600);
  assert_true(!there("mesh-a") && !there("mesh-c"));
  assert_true(there("mesh-b") && there("mesh-d") && there("mesh-e"));

  // what fits stays
  cache_trim(folder, "mesh-", 300, 3600);
  assert_true(there("mesh-b") && there("mesh-d") && there("mesh-e"));
}

static void new_files_and_those_of_others_stay(void **context) {
  (void)context;
  put("mesh-new", 10);
  put("mesh-old", 7000);
  put("beam-old", 9000);
  assert_int_equal(mkdir(in_folder("mesh-folder"), 0777), 0);
  assert_int_equal(symlink("beam-old", in_folder("mesh-link")), 0);
  cache_trim(folder, "mesh-", 0, 3600);
  assert_true(there("mesh-new") && !there("mesh-old"));
  assert_true(there("beam-old") && there("mesh-folder") && there("mesh-link"));
}

static void a_folder_that_is_not_there_is_no_matter(void **context) {
  (void)context;
  cache_trim(in_folder("missing"), "mesh-", 0, 0);
  cache_trim(folder, "mesh-", 0, 0);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, make_folder, remove_folder)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(the_oldest_go_until_the_rest_fits),
      TEST(new_files_and_those_of_others_stay),
      TEST(a_folder_that_is_not_there_is_no_matter),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
