/* `thrum precompute` goes on as thrum-mpi where conjugate gradients are wanted and thrum-mpi is
 * there. A script stands in for that, which says what it was started with; what the real one makes
 * is compared in tests/mpi. SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/support/test_folder.h"

#define BEAM "beam:8x2x2@1x0.1x0.1"
#define COMMAND "precompute", BEAM, "--fix", "x<0.001", "-o", "made.npz"

/* A thrum-mpi that prints its arguments and its place among the processes of a launcher. */
static int make_program(void **state) {
  static const char script[] = "#!/bin/sh\necho \"as $*\" \"<$OMPI_COMM_WORLD_RANK>\"\nexit 3\n";
  if (make_folder(state) != 0 || !text_file_write(in_folder("program"), script) ||
      chmod(in_folder("program"), 0777) != 0)
    return -1;
  return setenv("THRUM_MPI", in_folder("program"), 1);
}

/* Asserts that this run of thrum became that program with the arguments of COMMAND, whose options
 * come first by then, and these; and that these words were in its warning. */
static void assert_gone_on(program_result run, const char *arguments, const char *warning) {
  char said[256];
  snprintf(said, sizeof said, "as precompute --fix x<0.001 -o made.npz %s %s <>\n", arguments,
           BEAM);
  assert_string_equal(run.out, said);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.err, warning));
  program_result_free(&run);
}

static void assert_refused(program_result run, int code, const char *words) {
  if (run.exit_code != code || strstr(run.err, words) == NULL)
    fail_msg("exit %d, %s", run.exit_code, run.err);
  program_result_free(&run);
  assert_false(file_exists(in_folder("made.npz")));
}

static void cg_is_that_of_the_other_program(void **state) {
  (void)state;
  assert_gone_on(thrum_run(folder, COMMAND, "--solver", "cg", NULL), "--solver cg", "");

  // a job that mpirun or srun started is one process all the same
  setenv("OMPI_COMM_WORLD_RANK", "1", 1);
  setenv("PMIX_RANK", "1", 1);
  assert_gone_on(thrum_run(folder, COMMAND, "--solver", "cg", NULL), "--solver cg", "");
  unsetenv("OMPI_COMM_WORLD_RANK");
  unsetenv("PMIX_RANK");
}

static void a_factor_without_room_gives_way_to_the_other_program(void **state) {
  (void)state;
  assert_gone_on(thrum_run(folder, COMMAND, "--memory", "2", NULL), "--memory 2",
                 "the factor does not fit");
  assert_gone_on(thrum_run(folder, COMMAND, "--memory", "2", "--dry-run", NULL),
                 "--memory 2 --dry-run", "the factor does not fit");

  // but not where the factor itself was asked for
  assert_refused(thrum_run(folder, COMMAND, "--memory", "2", "--solver", "factor", NULL), 1,
                 "this takes about");
}

static void what_the_other_program_has_not_stays_here(void **state) {
  (void)state;
  assert_refused(thrum_run(folder, COMMAND, "--memory", "2", "--handles", "tip", NULL), 1,
                 "this takes about");
  assert_refused(thrum_run(folder, COMMAND, "--solver", "cg", "--handles", "tip", NULL), 1,
                 "--handles is of thrum precompute with a factor");
}

static void without_the_other_program_it_is_said_how_it_is_built(void **state) {
  (void)state;
  setenv("THRUM_MPI", in_folder("nothing"), 1);
  assert_refused(thrum_run(folder, COMMAND, "--solver", "cg", NULL), 1, "./run mpi");
  assert_refused(thrum_run(folder, COMMAND, "--memory", "2", NULL), 1, "this takes about");
  setenv("THRUM_MPI", in_folder("program"), 1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cg_is_that_of_the_other_program),
      cmocka_unit_test(a_factor_without_room_gives_way_to_the_other_program),
      cmocka_unit_test(what_the_other_program_has_not_stays_here),
      cmocka_unit_test(without_the_other_program_it_is_said_how_it_is_built),
  };
  return cmocka_run_group_tests(tests, make_program, remove_folder);
}
