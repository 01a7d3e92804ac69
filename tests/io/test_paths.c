/* Where the program's data is looked for, with and without /proc. SPDX-License-Identifier:
 * Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/types.h>

#include "io/paths.h"

ssize_t __wrap_readlink(const char *path, char *buffer, size_t size);

/* Where the system says that the program lies; NULL: it has no /proc. */
static const char *told;

ssize_t __wrap_readlink(const char *path, char *buffer, size_t size) {
  assert_string_equal(path, "/proc/self/exe");
  if (told == NULL) {
    errno = ENOENT;
    return -1;
  }

  // readlink cuts the text as well, and puts no 0 at the end
  const size_t length = strlen(told) < size ? strlen(told) : size;
  memcpy(buffer, told, length);
  return (ssize_t)length;
}

static void the_data_lies_beside_the_program(void **state) {
  (void)state;
  char path[64];
  told = "/somewhere/bin/thrum";
  assert_true(path_share("models", path, sizeof path));
  assert_string_equal(path, "/somewhere/share/thrum/models");

  // a program in a folder of the root has the root as its prefix
  told = "/bin/thrum";
  assert_true(path_share("viewer.html", path, sizeof path));
  assert_string_equal(path, "/share/thrum/viewer.html");
}

static void a_program_of_the_same_build_lies_beside_it(void **state) {
  (void)state;
  char path[64];
  told = "/somewhere/bin/thrum";
  assert_true(path_beside("thrum-mpi", path, sizeof path));
  assert_string_equal(path, "/somewhere/bin/thrum-mpi");

  // neither without a place, nor where its path has no room
  assert_false(path_beside("thrum-mpi", path, strlen("/somewhere/bin/thrum-mpi")));
  told = NULL;
  assert_false(path_beside("thrum-mpi", path, sizeof path));
}

static void without_proc_it_lies_where_it_was_to_be_installed(void **state) {
  (void)state;
  char path[sizeof THRUM_PREFIX + 32];
  told = NULL;
  assert_true(path_share("models", path, sizeof path));
  assert_string_equal(path, THRUM_PREFIX "/share/thrum/models");
}

static void a_path_that_is_too_short_is_none(void **state) {
  (void)state;
  char path[64];
  const char *programs[] = {"/somewhere/bin/thrum", NULL};
  const size_t lengths[] = {strlen("/somewhere/share/thrum/models"),
                            strlen(THRUM_PREFIX "/share/thrum/models")};
  for (int k = 0; k < 2; k++) {
    told = programs[k];
    for (size_t size = 2; size <= lengths[k]; size++)
      assert_false(path_share("models", path, size));
    assert_true(path_share("models", path, lengths[k] + 1));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_data_lies_beside_the_program),
      cmocka_unit_test(a_program_of_the_same_build_lies_beside_it),
      cmocka_unit_test(without_proc_it_lies_where_it_was_to_be_installed),
      cmocka_unit_test(a_path_that_is_too_short_is_none),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
