/* Single-precision coefficients: the guarantees of precompute --precision single.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <float.h>

#include "precompute/model/single_precision.h"
#include "tests/support/random_model.h"
#include "thrum/polynomial.h"

static void coefficients_become_single_and_frequencies_stay(void **state) {
  (void)state;
  random_model m;
  random_model_make(&m, 3, 12, 5, 300, 1.0);
  double omega2[12], worst = -1.0;
  memcpy(omega2, m.omega2, sizeof omega2);

  // every coefficient is a single-precision number; the frequencies are not touched
  assert_int_equal(thrum_single_precision_round(&m.model, &worst, NULL), THRUM_OK);
  for (int64_t k = 0; k < m.model.c3_count; k++)
    assert_true((double)(float)m.c3[k] == m.c3[k]);
  for (int64_t k = 0; k < m.model.c4_count; k++)
    assert_true((double)(float)m.c4[k] == m.c4[k]);
  assert_memory_equal(m.omega2, omega2, sizeof omega2);

  // the error is near the unit roundoff of 24 bits, grown by cancellation in the force
  assert_true(worst > 1e-10 && worst < 1e-6);

  // rounding a second time changes nothing
  assert_int_equal(thrum_single_precision_round(&m.model, &worst, NULL), THRUM_OK);
  assert_true(worst == 0.0);

  random_model_free(&m);
}

static void the_error_said_bounds_that_of_the_force_at_such_amplitudes(void **state) {
  (void)state;

  // the same random model twice, one of them rounded
  random_model exact, rounded;
  random_model_make(&exact, 9, 8, 5, 60, 1.0);
  random_model_make(&rounded, 9, 8, 5, 60, 1.0);
  double worst = 0.0;
  assert_int_equal(thrum_single_precision_round(&rounded.model, &worst, NULL), THRUM_OK);

  // the relative error of the force at random states
  double *work = random_alloc((int64_t)thrum_work_count(&exact.model), sizeof(double));
  random_state random = {4};
  for (int s = 0; s < 50; s++) {
    double q[8], a[8], b[8], difference = 0.0, size = 0.0;
    random_vector(&random, 8, 0.3, q);
    thrum_internal_force(&exact.model, q, a, work);
    thrum_internal_force(&rounded.model, q, b, work);
    for (int i = 0; i < 8; i++) {
      difference += (a[i] - b[i]) * (a[i] - b[i]);
      size += a[i] * a[i];
    }

    // the bound was sampled in other directions, hence the margin
    assert_true(sqrt(difference) <= 8.0 * worst * sqrt(size));
  }

  free(work);
  random_model_free(&exact);
  random_model_free(&rounded);
}

static void a_linear_model_has_nothing_to_round(void **state) {
  (void)state;
  random_model m;
  random_model_make(&m, 3, 4, 5, 30, INFINITY);
  double worst = -1.0;
  assert_int_equal(thrum_single_precision_round(&m.model, &worst, NULL), THRUM_OK);
  assert_true(worst == 0.0);
  random_model_free(&m);
}

static void coefficients_beyond_single_precision_are_refused_and_kept(void **state) {
  (void)state;
  random_model m;
  random_model_make(&m, 3, 4, 5, 30, 1.0);
  m.c3[2] = 0.1;
  m.c4[5] = -2.0 * FLT_MAX;
  double worst = 0.0;
  thrum_error error;
  assert_int_equal(thrum_single_precision_round(&m.model, &worst, &error), THRUM_UNSUPPORTED);
  assert_non_null(strstr(error.message, "single precision"));
  assert_true(m.c3[2] == 0.1);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(coefficients_become_single_and_frequencies_stay),
      cmocka_unit_test(the_error_said_bounds_that_of_the_force_at_such_amplitudes),
      cmocka_unit_test(a_linear_model_has_nothing_to_round),
      cmocka_unit_test(coefficients_beyond_single_precision_are_refused_and_kept),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
