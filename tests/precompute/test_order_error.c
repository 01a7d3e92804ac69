/* How much too high the frequencies of linear tetrahedra are: the estimate against the same mesh
 * with ten nodes. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"
#include "tests/support/sanitized.h"

/* The estimate over the true error lies between `least` and 1.02 for the first `count` modes. */
static void check(const char *beam, const char *fix, int count, double least) {
  body linear = body_make(beam, fix), quadratic = body_quadratic(beam, fix, 0, 0);
  thrum_precomputed one = body_precompute(&linear, 5, 5), two = body_precompute(&quadratic, 5, 5);
  assert_int_equal(one.order_error_count, 5);
  assert_int_equal(two.order_error_count, 0);

  // frequencies go with the root of omega^2
  double lowest = INFINITY, highest = 0, largest = 0;
  for (int i = 0; i < count; i++) {
    const double error = sqrt(one.mode_omega2[i] / two.mode_omega2[i]) - 1;
    lowest = fmin(lowest, one.order_error[i] / error);
    highest = fmax(highest, one.order_error[i] / error);
    largest = fmax(largest, error);
  }
  print_message("%s: errors of up to %.3f, estimated as %.2f to %.2f of that\n", beam, largest,
                lowest, highest);
  assert_true(lowest > least && highest < 1.02);

  thrum_precomputed_free(&one);
  thrum_precomputed_free(&two);
  body_free(&linear);
  body_free(&quadratic);
}

static void estimate_is_a_little_below_the_error_and_tends_to_it(void **state) {
  (void)state;
  check("beam:10x1x1@1x0.1x0.1", "x<0.001", 3, 0.6);
  check("beam:20x2x2@1x0.1x0.1", "x<0.001", 4, 0.7);

  // finer meshes are the same to the sanitizers
  if (LENGTH_OF_RUN(false, true))
    return;
  check("beam:40x4x4@1x0.1x0.1", "x<0.001", 5, 0.85);
  check("beam:48x5x5@1x0.1x0.1", "x<0.001", 5, 0.9);
}

static void free_bodies_are_estimated_too(void **state) {
  (void)state;
  check("beam:20x2x2@1x0.1x0.1", NULL, 4, 0.6);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(estimate_is_a_little_below_the_error_and_tends_to_it),
      cmocka_unit_test(free_bodies_are_estimated_too),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
