/* Tests of the program with streams and files that are not as usual: standard output closed or
 * full, pipes as files, bytes that are no UTF-8, a parent with much memory.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

static int make_models(void **state) {
  (void)state;
  return test_folder_make(folder) == NULL || !save_particle(in_folder("particle.npz"), 100, 400) ||
         !save_oscillator(in_folder("huge.npz"), 400, 1e308);
}

/* Runs a line of the shell in the folder, with the program as $THRUM. */
static program_result shell(const char *line) {
  char sh[] = "/bin/sh", option[] = "-c", text[600];
  snprintf(text, sizeof text, "THRUM=%s; %s", THRUM_PROGRAM, line);
  char *argv[] = {sh, option, text, NULL};
  return program_execute(folder, argv);
}

static void expect_code(const char *line, int code, const char *says) {
  program_result run = shell(line);
  if (run.exit_code != code || strstr(run.err, says) == NULL)
    fail_msg("%s: exit code %d, %s", line, run.exit_code, run.err);
  program_result_free(&run);
}

static void output_that_cannot_be_written_is_no_success(void **state) {
  (void)state;
  const char *says = "standard output could not be written";

  // a mesh that is flagged, too
  expect_code("$THRUM convert beam:2x1x1@2x1x1 m.veg", 0, "");
  expect_code("$THRUM check m.veg >/dev/full", 1, says);
  expect_code("$THRUM info particle.npz >/dev/full", 1, says);
}

static void closed_streams_do_not_lead_into_files(void **state) {
  (void)state;
  expect_code("$THRUM simulate particle.npz -o open --time 0.03 --start mode:1,0.1", 0, "");
  expect_code("$THRUM simulate particle.npz -o closed --time 0.03 --start mode:1,0.1 <&- 2>&-", 0,
              "");

  // what was printed did not go into the first files of the run
  expect_code("cmp open/energy.csv closed/energy.csv && cmp open/q.npy closed/q.npy", 0, "");
}

static void without_standard_output_nothing_is_begun(void **state) {
  (void)state;
  const char *says = "standard output is closed: send it to /dev/null";
  expect_code("$THRUM simulate particle.npz -o kept --time 0.03 --start mode:1,0.1", 0, "");
  expect_code("cp -r kept before", 0, "");

  // an earlier run stays, a new one does not come, and no file is left beside them
  expect_code("$THRUM simulate particle.npz -o kept --time 0.06 --start mode:1,0.2 >&-", 1, says);
  expect_code("diff -r kept before", 0, "");
  expect_code("$THRUM simulate particle.npz -o none --time 0.03 <&- >&-", 1, says);
  expect_code("$THRUM simulate particle.npz -o none --time 0.03 >&- 2>&-", 1, "");
  expect_code("$THRUM --version >&-", 1, says);
  expect_code("ls -d none*", 2, "");
}

static void a_pipe_as_a_model_is_refused_and_not_waited_for(void **state) {
  (void)state;
  expect_code("mkfifo pipe.npz", 0, "");
  expect_code("timeout 20 $THRUM info pipe.npz", 1, "pipe.npz: is not a regular file");
  expect_code("timeout 20 $THRUM simulate pipe.npz -o piped", 1, "is not a regular file");
}

static void coefficients_beyond_numbers_are_not_written(void **state) {
  (void)state;
  expect_code("$THRUM export huge.npz --vega-cubic huge.cub", 1, "beyond the range");
  assert_false(file_exists(in_folder("huge.cub")));
}

static void names_that_are_no_utf8_make_json_that_is(void **state) {
  (void)state;
  expect_code("cp particle.npz \"$(printf 'p\\377\\300.npz')\"", 0, "");
  program_result run = shell("$THRUM info \"$(printf 'p\\377\\300.npz')\" --json");
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.out, "p??.npz"));
  for (const char *at = run.out; *at != 0; at++)
    assert_true((unsigned char)*at < 128);
  program_result_free(&run);
}

static void the_peak_of_memory_is_not_that_of_the_parent(void **state) {
  (void)state;
  const size_t size = (size_t)400 << 20;
  char *memory = malloc(size);
  assert_non_null(memory);
  for (size_t n = 0; n < size; n += 4096)
    memory[n] = 1;
  program_result run = thrum_run(folder, "simulate", "particle.npz", "-o", "peak", "--time", "0.03",
                                 "--start", "mode:1,0.1", "--json", NULL);
  free(memory);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  assert_true(json_value(object, "peak_mb") > 1 && json_value(object, "peak_mb") < 300);
  cJSON_Delete(object);
  program_result_free(&run);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(output_that_cannot_be_written_is_no_success),
      cmocka_unit_test(closed_streams_do_not_lead_into_files),
      cmocka_unit_test(without_standard_output_nothing_is_begun),
      cmocka_unit_test(a_pipe_as_a_model_is_refused_and_not_waited_for),
      cmocka_unit_test(coefficients_beyond_numbers_are_not_written),
      cmocka_unit_test(names_that_are_no_utf8_make_json_that_is),
      cmocka_unit_test(the_peak_of_memory_is_not_that_of_the_parent),
  };
  return cmocka_run_group_tests(tests, make_models, remove_folder);
}
