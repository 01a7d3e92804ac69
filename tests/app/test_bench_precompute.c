/* `thrum bench precompute` measures what it is asked for. No time is judged here.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/support/program_support.h"

static cJSON *bench(const char *a, const char *b, const char *c, const char *d) {
  program_result run =
      thrum_run(NULL, "bench", "precompute", "--json", "--modes", "4", a, b, c, d, NULL);
  assert_int_equal(run.exit_code, 0);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

static void a_run_is_made_for_every_size(void **state) {
  (void)state;
  cJSON *object = bench("--tets", "200,1000", "--rank", "5");
  const cJSON *runs = cJSON_GetObjectItem(object, "runs");
  assert_int_equal(cJSON_GetArraySize(runs), 2);

  const int wanted[] = {200, 1000};
  for (int n = 0; n < 2; n++) {
    const cJSON *run = cJSON_GetArrayItem(runs, n);
    assert_true(fabs(json_value(run, "tets") / wanted[n] - 1) < 0.3);
    assert_true(json_value(run, "rank") == 5);

    const cJSON *cpu = cJSON_GetObjectItem(run, "cpu_seconds");
    double sum = 0;
    const cJSON *item = NULL;
    cJSON_ArrayForEach(item, cpu) sum += item->valuedouble;

    // every stage and their total
    assert_int_equal(cJSON_GetArraySize(cpu), 7);
    assert_true(fabs(sum / 2 / json_value(cpu, "total") - 1) < 1e-9);

    assert_true(json_value(run, "polynomial_over_syrk") > 0);
    assert_true(json_value(run, "peak_mb") > 0);
  }

  // two sizes give an exponent of growth for each figure
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(object, "exponents")), 8);
  cJSON_Delete(object);
}

static void a_run_is_made_for_every_rank(void **state) {
  (void)state;
  cJSON *object = bench("--tets", "300", "--ranks", "3,6,9");
  const cJSON *runs = cJSON_GetObjectItem(object, "runs");
  assert_int_equal(cJSON_GetArraySize(runs), 3);
  for (int n = 0; n < 3; n++)
    assert_true(json_value(cJSON_GetArrayItem(runs, n), "rank") == 3 * (n + 1));
  cJSON_Delete(object);
}

static void refusals_and_wrong_usage_are_told_apart(void **state) {
  (void)state;

  // four modes and their derivatives span 14
  program_result run =
      thrum_run(NULL, "bench", "precompute", "--tets", "300", "--modes", "4", "--rank", "15", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "rank 15"));
  program_result_free(&run);

  // lists of sizes that are no numbers, or too long
  static const char *const bad[] = {"0", "10,", "ten", "1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17"};
  for (int n = 0; n < 4; n++) {
    run = thrum_run(NULL, "bench", "precompute", "--tets", bad[n], NULL);
    assert_int_equal(run.exit_code, 2);
    assert_non_null(strstr(run.err, "whole numbers"));
    program_result_free(&run);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_run_is_made_for_every_size),
      cmocka_unit_test(a_run_is_made_for_every_rank),
      cmocka_unit_test(refusals_and_wrong_usage_are_told_apart),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
