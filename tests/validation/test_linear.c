/* Tests of the comparison of linear and nonlinear solutions on an oscillator with known solutions:
 * at rest w^2 q + 4 c4 q^3 = f, so the linear solution f/w^2 has the relative error 4 c4 q^2/w^2.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "validation/experiments/linear_free_vibration.h"

static void the_deflection_at_an_error_is_that_of_the_closed_form(void **state) {
  (void)state;

  // an oscillator with omega^2 = 9 and c4 = 20
  random_model m;
  random_model_make(&m, 1, 1, 3, 3, INFINITY);
  m.c4[0] = 20;
  double push[1] = {1}, tip[3] = {0, 0, 1};
  const experiment_body body = {"duffing", &m.model, 1, {0, 0, 1}, 1.0 / 9, push, tip};

  // the comparison over its levels of error
  experiment_linear_result result;
  thrum_error error;
  if (experiment_linear_compare(&body, &result, &error) != THRUM_OK)
    fail_msg("%s", error.message);

  // deflection, load and error of each level follow from the closed form
  for (int level = 0; level < EXPERIMENT_LINEAR_LEVELS; level++) {
    const double wrong = experiment_linear_levels[level], q = sqrt(wrong * 9 / 80);
    assert_true(fabs(result.statics.at[level].amplitude / q - 1) < 1e-3);
    assert_true(fabs(result.statics.at[level].load / (9 * q * (1 + wrong)) - 1) < 1e-3);
    assert_true(fabs(result.statics.at[level].error / wrong - 1) < 2e-3);

    // in motion the phases differ: the error is larger at the same deflection
    assert_true(result.dynamics.at[level].amplitude < q);
    assert_true(fabs(result.dynamics.at[level].error / wrong - 1) < 1e-2);
  }

  // every point of the curve lies on the closed form
  for (int64_t n = 0; n < result.statics.count; n++) {
    const experiment_linear_point *point = &result.statics.points[n];
    const double q = point->amplitude;
    assert_true(fabs(point->error - 80 * q * q / 9) < 1e-6 * point->error + 1e-9);
  }

  // times are measured; their values depend on the machine
  assert_true(result.force_us > 0 && result.step_us > 0 && result.linear_us > 0);
  random_model_free(&m);
}

static void a_linear_body_is_never_wrong(void **state) {
  (void)state;

  // a model without cubic and quartic coefficients
  random_model m;
  random_model_make(&m, 1, 3, 3, 8, INFINITY);
  double push[3] = {1, 0.5, -0.2}, tip[9] = {0, 0, 0, 0, 0, 0, 1, 0.5, -0.2};

  // the compliance along the push follows from the frequencies
  double compliance = 0;
  for (int i = 0; i < 3; i++)
    compliance += push[i] * push[i] / m.omega2[i];
  const experiment_body body = {"linear", &m.model, 1, {0, 0, 1}, compliance, push, tip};
  experiment_linear_result result;
  assert_int_equal(experiment_linear_compare(&body, &result, NULL), THRUM_OK);

  // no level of error is reached
  assert_int_equal(result.statics.count, EXPERIMENT_LINEAR_POINTS);
  assert_int_equal(result.dynamics.count, EXPERIMENT_LINEAR_POINTS);
  for (int level = 0; level < EXPERIMENT_LINEAR_LEVELS; level++)
    assert_true(isnan(result.statics.at[level].amplitude) &&
                isnan(result.dynamics.at[level].amplitude));

  // the error is zero at every point
  for (int64_t n = 0; n < EXPERIMENT_LINEAR_POINTS; n++) {
    assert_true(result.statics.points[n].error < 1e-9);
    assert_true(result.dynamics.points[n].error == 0);
  }

  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_deflection_at_an_error_is_that_of_the_closed_form),
      cmocka_unit_test(a_linear_body_is_never_wrong),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
