/* Tests of bodies far outside the usual range: nothing crashes, nothing is NaN, what cannot be done
 * is refused with a reason, and other units change no significant digit.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "validation/experiments/extremes.h"

#define STEPS 60
#define UNIT_STEPS 100

/* Finds the extreme of this name. */
static const experiment_extreme *extreme_called(const char *name) {
  for (int64_t n = 0; n < experiment_extreme_count(); n++) {
    if (strcmp(experiment_extreme_list[n].name, name) == 0)
      return &experiment_extreme_list[n];
  }
  fail_msg("there is no extreme called %s", name);
  return NULL;
}

static experiment_extreme_body body_called(const char *name) {
  thrum_error error = {0};
  experiment_extreme_body body;
  assert_int_equal(experiment_extreme_make(extreme_called(name), &body, &error), THRUM_OK);

  // the array that the model lies in has moved with the struct
  body.body.model = NULL;
  return body;
}

static bool is_refused(const experiment_extreme *extreme) {
  static const char *const refused[] = {"E = 0", "nu = -1", "nu = 0.5", "0",
                                        "as many modes as it can move"};
  for (size_t n = 0; n < sizeof refused / sizeof refused[0]; n++) {
    if (strcmp(extreme->name, refused[n]) == 0)
      return true;
  }
  return false;
}

/* The schemes that must not stop, and Newmark. */
static const experiment_scheme robust[] = {EXPERIMENT_SCHEME_IMEXV, EXPERIMENT_SCHEME_NEWMARK,
                                           EXPERIMENT_SCHEME_ENERGY};
enum { ROBUST_COUNT = sizeof robust / sizeof robust[0] };

/* Runs one body with them. */
static void check_runs(const experiment_extreme_body *body) {
  const char *name = body->extreme->name;
  thrum_error error = {0};
  for (int n = 0; n < ROBUST_COUNT; n++) {
    const experiment_scheme i = robust[n];
    const experiment_extreme_case run = {body, i, STEPS};
    experiment_extreme_result result;
    assert_int_equal(experiment_extreme_run(&run, &result, &error), THRUM_OK);

    // every step is made, with finite numbers
    const char *outcome = experiment_extreme_outcome(&run, &result);
    if (result.not_finite || strcmp(outcome, "stopped") == 0)
      fail_msg("%s, %s: %s %s", name, experiment_scheme_names[i], outcome, result.stop.message);
    assert_int_equal(result.report.steps, STEPS);

    // Newmark may lose its energy in such runs; these two may not
    const double bound = i == EXPERIMENT_SCHEME_ENERGY  ? 1e-5
                         : i == EXPERIMENT_SCHEME_IMEXV ? 0.5
                                                        : INFINITY;
    if (!(result.energy_error <= bound) && body->extreme->load > 0)
      fail_msg("%s, %s: the balance errs by %g", name, experiment_scheme_names[i],
               result.energy_error);

    // nothing moves without a load
    if (body->extreme->load == 0)
      assert_true(result.peak_amplitude == 0 && isnan(result.energy_error));
  }
}

static void every_extreme_runs_or_says_why_not(void **state) {
  (void)state;
  thrum_error error = {0};
  for (int64_t n = 0; n < experiment_extreme_count(); n++) {
    const experiment_extreme *extreme = &experiment_extreme_list[n];
    experiment_extreme_body body;

    // the body of rank 100 takes too long for a test
    if (extreme->rank > 50)
      continue;
    assert_int_equal(experiment_extreme_make(extreme, &body, &error), THRUM_OK);

    // a body is refused where its material or rank makes no sense, and with a reason
    if ((body.status < 0) != is_refused(extreme))
      fail_msg("%s: %s", extreme->name, body.status < 0 ? body.refusal.message : "not refused");

    if (body.status >= 0)
      check_runs(&body);
    else
      assert_true(strlen(body.refusal.message) > 20);

    experiment_extreme_free(&body);
  }
}

static void other_units_change_no_digit_that_matters(void **state) {
  (void)state;
  thrum_error error = {0};
  for (int64_t u = 1; u < experiment_unit_count(); u++) {
    for (int n = 0; n < ROBUST_COUNT; n++) {
      const experiment_scheme i = robust[n];
      const experiment_unit_case run = {&experiment_unit_extremes[0], &experiment_unit_systems[u],
                                        i, UNIT_STEPS};
      experiment_unit_result result;
      assert_int_equal(experiment_units_run(&run, &result, &error), THRUM_OK);
      if (!(result.difference < 1e-9) || !result.same_levels)
        fail_msg("in %s %s differs by %g", run.units->name, experiment_scheme_names[i],
                 result.difference);
    }
  }
}

static void the_arch_snaps_through_under_its_load_and_not_before(void **state) {
  (void)state;
  static const char *const names[2] = {"before it snaps", "snaps through"};
  thrum_error error = {0};
  double peaks[2];
  for (int n = 0; n < 2; n++) {
    experiment_extreme_body body;
    experiment_extreme_result result;
    assert_int_equal(experiment_extreme_make(extreme_called(names[n]), &body, &error), THRUM_OK);

    const experiment_extreme_case run = {&body, EXPERIMENT_SCHEME_ENERGY, 400};
    assert_int_equal(experiment_extreme_run(&run, &result, &error), THRUM_OK);
    peaks[n] = result.peak_amplitude;
    experiment_extreme_free(&body);
  }

  // it rises by 4 % of its span: beyond 8 % it hangs the other way
  assert_true(peaks[0] < 0.01);
  assert_true(peaks[1] > 0.08);
}

static void a_mirrored_square_section_has_equal_frequencies(void **state) {
  (void)state;
  experiment_extreme_body square = body_called("square section"), plain = body_called("1 m");
  const double *a = square.made.model.omega2, *b = plain.made.model.omega2;
  assert_true(fabs(a[1] - a[0]) < 1e-10 * a[0]);
  assert_true(fabs(b[1] - b[0]) > 1e-3 * b[0]);
  experiment_extreme_free(&square);
  experiment_extreme_free(&plain);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_extreme_runs_or_says_why_not),
      cmocka_unit_test(other_units_change_no_digit_that_matters),
      cmocka_unit_test(the_arch_snaps_through_under_its_load_and_not_before),
      cmocka_unit_test(a_mirrored_square_section_has_equal_frequencies),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
