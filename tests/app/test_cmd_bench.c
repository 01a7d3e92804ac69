/* `thrum bench step` and `thrum bench kernels` measure what was asked for. Times are not tested, as
 * they are as noisy as the machine.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "tests/support/program_support.h"
#include "thrum/kernel.h"

#define SHORT "--no-machine", "--batches", "2", "--json", "-q"

static void a_step_is_measured_with_exactly_the_implicit_modes_asked_for(void **state) {
  (void)state;
  static const char *const counts[] = {"0", "1", "3", "6"};
  for (int n = 0; n < 4; n++) {
    program_result result = thrum_run(".", "bench", "step", "--rank", "6", "--implicit", counts[n],
                                      "--steps", "5", "--swing", "0.01", SHORT, NULL);
    assert_int_equal(result.exit_code, 0);

    // rank, steps and implicit modes are those that were asked for
    cJSON *object = json_line(result.out);
    assert_true(json_value(object, "implicit_modes") == strtod(counts[n], NULL));
    assert_true(json_value(object, "rank") == 6);
    assert_true(json_value(object, "steps") == 5);

    // the figures fit together: only implicit modes need iterations
    const double least = json_value(object, "us_per_step");
    assert_true(least > 0 && json_value(object, "us_per_step_median") >= least);
    assert_true(json_value(object, "h") > 0);
    assert_true((json_value(object, "mean_iterations") > 0) == (n > 0));

    cJSON_Delete(object);
    program_result_free(&result);
  }
}

/* A swing so wide that the Jacobian changes too much from step to step to be kept: every other one
 * is extrapolated from the three before, and serves nearly as well. Energy plans one in eight steps
 * and makes few more, as it needs no more than one evaluation in many of them. */
static void a_wide_swing_makes_its_jacobian_in_every_other_step_at_most(void **state) {
  (void)state;
  static const char *const integrators[] = {"imexv", "newmark", "midpoint", "energy"};
  for (int n = 0; n < 4; n++) {
    program_result result = thrum_run(".", "bench", "step", "--rank", "15", "--integrator",
                                      integrators[n], "--steps", "400", SHORT, NULL);
    assert_int_equal(result.exit_code, 0);

    cJSON *object = json_line(result.out);
    const double made = json_value(object, "mean_factorisations");
    const double iterations = json_value(object, "mean_iterations");

    // extrapolated from two Jacobians only, Newmark's iterations would be 2.5
    const bool energy = n == 3;
    const double most = energy ? 0.7 : n == 0 ? 2.9 : 2.49;
    if (!(made > (energy ? 0.12 : 0.25) && made < (energy ? 0.25 : 0.55) && iterations < most))
      fail_msg("%s: %g Jacobians and %g iterations a step", integrators[n], made, iterations);
    cJSON_Delete(object);
    program_result_free(&result);
  }
}

static void several_ranks_give_rows_a_table_and_a_file(void **state) {
  (void)state;
  char folder[64], path[128];
  test_folder_make(folder);
  program_result result = thrum_run(folder, "bench", "kernels", "--rank", "4,7", "--kernel",
                                    "reference", "-o", "bench", SHORT, NULL);
  assert_int_equal(result.exit_code, 0);

  // a row for each rank
  cJSON *object = json_line(result.out);
  const cJSON *rows = cJSON_GetObjectItem(object, "rows");
  assert_int_equal(cJSON_GetArraySize(rows), 2);
  assert_true(json_value(cJSON_GetArrayItem(rows, 1), "rank") == 7);
  assert_true(json_value(cJSON_GetArrayItem(rows, 1), "us_force") > 0);
  assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(rows->child, "kernel")),
                      "reference");

  // a row has the rate of every pass
  static const char *const passes[] = {"energy",         "force",    "tangent",
                                       "tangent_vector", "restrict", "restricted_tangent"};
  for (int n = 0; n < 6; n++) {
    char rate[40];
    snprintf(rate, sizeof rate, "%s_gflops", passes[n]);
    assert_true(json_value(rows->child, rate) > 0);
  }

  cJSON_Delete(object);
  program_result_free(&result);

  snprintf(path, sizeof path, "%s/bench/kernels.csv", folder);

  char *text = text_file_read(path);
  assert_non_null(text);

  // a line about the machine, one of names, and one a rank
  assert_true(line_count_is(text, 4));
  assert_non_null(strstr(text, "\nrank,kernel,"));

  free(text);
  test_folder_remove(folder);
}

/* The plot is drawn by a child, which must not print again what was not yet printed. */
static void the_table_is_printed_once(void **state) {
  (void)state;
  char folder[64];
  test_folder_make(folder);
  unsetenv("THRUM_GNUPLOT");
  program_result result = thrum_run(folder, "bench", "step", "--rank", "4", "--no-machine",
                                    "--batches", "2", "--steps", "5", "-q", "-o", "bench", NULL);
  assert_int_equal(result.exit_code, 0);
  const char *first = strstr(result.out, "us/step");
  assert_non_null(first);
  assert_null(strstr(first + 1, "us/step"));
  program_result_free(&result);
  test_folder_remove(folder);
}

static void the_same_steps_take_the_same_iterations_with_every_kernel(void **state) {
  (void)state;
  double expected = NAN;
  for (int id = 0; thrum_kernel_name((thrum_kernel_id)id); id++) {
    if (!thrum_kernel_usable((thrum_kernel_id)id))
      continue;

    program_result result =
        thrum_run(".", "bench", "step", "--rank", "8", "--steps", "40", "--kernel",
                  thrum_kernel_name((thrum_kernel_id)id), "--integrator", "midpoint", SHORT, NULL);
    assert_int_equal(result.exit_code, 0);

    // kernels differ by rounding, which the iterations do not feel
    cJSON *object = json_line(result.out);
    const double iterations = json_value(object, "mean_iterations");
    assert_true(isnan(expected) || iterations == expected);
    expected = iterations;

    cJSON_Delete(object);
    program_result_free(&result);
  }
}

/* Two small blocks lie on each other, and the same bodies are apart; more pairs than bodies, and
 * held bodies, are refused. */
static void contact_is_measured_with_bodies_that_touch(void **state) {
  (void)state;
  char folder[64];
  test_folder_make(folder);
  program_result result = thrum_run(folder, "precompute", "beam:2x2x2@0.2x0.2x0.2", "--order", "1",
                                    "--modes", "4", "--rank", "8", "-q", "-o", "block.npz", NULL);
  assert_int_equal(result.exit_code, 0);
  program_result_free(&result);
  result = thrum_run(folder, "bench", "contact", "block.npz", "--bodies", "4", "--pairs", "2",
                     "--steps", "5", "--threads", "2", "--json", NULL);
  assert_int_equal(result.exit_code, 0);
  cJSON *object = json_line(result.out);
  assert_true(json_value(object, "rank") == 8 && json_value(object, "triangles") == 48);
  assert_true(json_value(object, "without_us") > 0 && json_value(object, "apart_us") > 0);
  assert_true(json_value(object, "touching_us_median") >= json_value(object, "touching_us"));
  assert_true(json_value(object, "touches") >= 8);
  cJSON_Delete(object);
  program_result_free(&result);

  // nothing is measured
  result =
      thrum_run(folder, "bench", "contact", "block.npz", "--bodies", "3", "--pairs", "2", NULL);
  assert_int_equal(result.exit_code, 1);
  assert_non_null(strstr(result.err, "2 pairs need 4 bodies"));
  program_result_free(&result);
  test_folder_remove(folder);
}

static void wrong_options_are_refused_with_one_line(void **state) {
  (void)state;
  static const char *const wrong[][2] = {{"--rank", "0"},       {"--rank", "5,,x"},
                                         {"--kernel", "sse9"},  {"--integrator", "euler"},
                                         {"--batches", "none"}, {"--dt", "-1"}};

  for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
    // more implicit modes than the rank, in either benchmark
    program_result result = thrum_run(".", "bench", "step", wrong[n][0], wrong[n][1], NULL);
    assert_int_equal(result.exit_code, 2);
    assert_true(line_count_is(result.err, 1));
    assert_non_null(strstr(result.err, wrong[n][0]));
    program_result_free(&result);
  }
  program_result result =
      thrum_run(".", "bench", "step", "--rank", "5", "--implicit", "6", SHORT, NULL);
  assert_int_equal(result.exit_code, 1);
  assert_non_null(strstr(result.err, "only 5"));
  program_result_free(&result);
  result = thrum_run(".", "bench", "kernels", "--rank", "5", "--implicit", "6", SHORT, NULL);
  assert_int_equal(result.exit_code, 1);
  assert_non_null(strstr(result.err, "only 5"));
  program_result_free(&result);

  // the time step follows from the implicit modes, so both cannot be given
  result = thrum_run(".", "bench", "step", "--implicit", "2", "--dt", "0.001", SHORT, NULL);
  assert_int_equal(result.exit_code, 2);
  assert_non_null(strstr(result.err, "without --dt"));
  program_result_free(&result);
}

/* The refusal comes before the machine is measured, which takes a while. */
static void missing_models_and_ranks_beyond_them_are_refused_and_nothing_printed(void **state) {
  (void)state;
  static const char *const wrong[][4] = {{"step", "no/such.npz", NULL, NULL},
                                         {"step", "--implicit", "99", NULL},
                                         {"kernels", "--implicit", "99", NULL}};
  for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
    program_result result =
        thrum_run(".", "bench", wrong[n][0], wrong[n][1], wrong[n][2], wrong[n][3], NULL);
    assert_int_equal(result.exit_code, 1);
    assert_string_equal(result.out, "");
    assert_true(line_count_is(result.err, 1));
    program_result_free(&result);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_step_is_measured_with_exactly_the_implicit_modes_asked_for),
      cmocka_unit_test(a_wide_swing_makes_its_jacobian_in_every_other_step_at_most),
      cmocka_unit_test(several_ranks_give_rows_a_table_and_a_file),
      cmocka_unit_test(the_table_is_printed_once),
      cmocka_unit_test(the_same_steps_take_the_same_iterations_with_every_kernel),
      cmocka_unit_test(contact_is_measured_with_bodies_that_touch),
      cmocka_unit_test(wrong_options_are_refused_with_one_line),
      cmocka_unit_test(missing_models_and_ranks_beyond_them_are_refused_and_nothing_printed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
