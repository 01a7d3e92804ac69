/* The committed documents that are generated from the option tables are up to date, and the shell
 * completes from them.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "tests/support/program_support.h"

static void the_committed_reference_is_that_of_the_program(void **state) {
  (void)state;
  static const char *const files[][2] = {{"--reference", "commands.md"},
                                         {"--scene-keys", "scene_keys.md"},
                                         {"--man", "thrum.1"},
                                         {"--bash", "thrum.bash"}};

  // each document as the program prints it now
  for (size_t n = 0; n < sizeof files / sizeof *files; n++) {
    char path[512];
    snprintf(path, sizeof path, THRUM_TEST_DATA "/../../docs/reference/%s", files[n][1]);
    char *committed = text_file_read(path);
    assert_non_null(committed);
    program_result made = thrum_run(".", "help", files[n][0], NULL);
    assert_int_equal(made.exit_code, 0);

    // if this fails: thrum help OPTION > docs/reference/FILE
    assert_string_equal(committed, made.out);
    program_result_free(&made);
    free(committed);
  }
}

static void help_names_what_it_can_print(void **state) {
  (void)state;
  program_result run = thrum_run(".", "help", "--rst", NULL);
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, "--reference, --scene-keys, --man or --bash"));
  program_result_free(&run);
}

/* The words that bash offers after `line`, whose last word is incomplete. */
static void completes(const char *line, const char *expected) {
  char command[1024], words[256] = "";
  snprintf(command, sizeof command,
           "bash -c 'source " THRUM_TEST_DATA "/../../docs/reference/thrum.bash; COMP_WORDS=(%s); "
           "COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _thrum; echo ${COMPREPLY[@]}'",
           line);
  FILE *pipe = popen(command, "r");
  assert_non_null(pipe);
  assert_non_null(fgets(words, sizeof words, pipe));
  assert_int_equal(pclose(pipe), 0);
  words[strcspn(words, "\n")] = 0;
  assert_string_equal(words, expected);
}

static void the_shell_completes_commands_options_and_choices(void **state) {
  (void)state;
  if (system("bash -c true") != 0)
    skip();
  completes("thrum sim", "simulate");
  completes("thrum simulate --integ", "--integrator");
  completes("thrum simulate --integrator new", "newmark");
  completes("thrum bench st", "step");
  completes("thrum bench step --sw", "--swing");
  completes("thrum simulate beam.n", "");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_committed_reference_is_that_of_the_program),
      cmocka_unit_test(help_names_what_it_can_print),
      cmocka_unit_test(the_shell_completes_commands_options_and_choices),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
