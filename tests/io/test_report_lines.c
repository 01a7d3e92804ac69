/* Tables that are made from reports. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "io/json.h"
#include "io/report.h"

static cJSON *report;

static int make(void **state) {
  (void)state;
  report = cJSON_Parse("{\"status\": \"done\", \"steps\": 100, \"one\": 1, \"nothing\": 0, "
                       "\"left\": null, \"no\": false,"
                       " \"none\": [], \"at\": {\"x\": [1, 2.5], \"share\": 0.0123}}");
  json_number(report, "energy", 0.1);
  json_number(report, "lost", NAN);
  return report == NULL;
}

static int drop(void **state) {
  (void)state;
  cJSON_Delete(report);
  return 0;
}

/* The text must become `wanted`, or lack a value where that is NULL. */
static void expect(const char *text, const char *wanted) {
  char made[200];
  const bool whole = report_text(report, NULL, text, made, sizeof made);
  assert_int_equal(whole, wanted != NULL);
  if (wanted != NULL)
    assert_string_equal(made, wanted);
}

static void values_have_their_own_form_or_that_of_printf(void **state) {
  (void)state;
  expect("{status}, {steps} of {energy}", "done, 100 of 0.1");
  expect("{steps:.2e} {status:6s}|{status:-6s}|", "1.00e+02   done|done  |");
  expect("{at.x.1} of {at.x} and {at.x:.1f}", "2.5 of 1, 2.5 and 1.0, 2.5");
  expect("{at.share:%}, {at.share:.3g%}", "1.2 %, 1.23 %");
}

static void a_missing_value_leaves_out_its_bracket_or_its_line(void **state) {
  (void)state;
  expect("{steps}[, {left} left][, {energy} J]", "100, 0.1 J");
  expect("{steps} of {left}", NULL);
  expect("{lost}", NULL);
  expect("{at.x.7}", NULL);
  expect("{status.of}", NULL);
  expect("{left|none}, {left:.3g|-}, {energy:.3g|-}", "none, -, 0.1");
  expect("[[{steps}]]", "[100]");
}

static void conditions_choose_between_texts_that_have_values(void **state) {
  (void)state;
  expect("{status=done?{steps} steps|lost}", "100 steps");
  expect("{status=lost?{steps} steps|at {energy}}", "at 0.1");
  expect("{!no?yes}{nothing?a}{none?b}{left?c}{at?d}", "yesd");
  expect("{left=null?none|{left}}{one=null?x|{one}}", "none1");
  expect("{one?{no?a|{steps?{at.x.0}|b}}|c}", "1");
  expect("[{one?{left}}]{one?{steps}}", "100");
}

static void one_is_not_many(void **state) {
  (void)state;
  expect("{one} bod{one#y|ies}, {steps} bod{steps#y|ies}", "1 body, 100 bodies");
  expect("place{one#|s}, place{nothing#|s}", "place, places");
}

static void values_of_the_table_go_before_those_of_the_report(void **state) {
  (void)state;
  char made[20];
  cJSON *more = cJSON_CreateObject();
  json_number(more, "steps", 7);
  assert_true(report_text(report, more, "{steps} {one}", made, sizeof made));
  assert_string_equal(made, "7 1");
  cJSON_Delete(more);
}

static void a_long_text_is_cut_to_its_room(void **state) {
  (void)state;
  char made[6];
  assert_true(report_text(report, NULL, "{status} {status}", made, sizeof made));
  assert_string_equal(made, "done ");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(values_have_their_own_form_or_that_of_printf),
      cmocka_unit_test(a_missing_value_leaves_out_its_bracket_or_its_line),
      cmocka_unit_test(conditions_choose_between_texts_that_have_values),
      cmocka_unit_test(one_is_not_many),
      cmocka_unit_test(values_of_the_table_go_before_those_of_the_report),
      cmocka_unit_test(a_long_text_is_cut_to_its_room),
  };
  return cmocka_run_group_tests(tests, make, drop);
}
