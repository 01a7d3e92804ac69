/* How much too high the frequencies of ten-node tetrahedra are: the estimate against a finer mesh.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

enum { MODES = 2 };

static thrum_precomputed precompute(const char *beam, double poisson, body *b) {
  *b = body_quadratic(beam, "x<0.001", 0, 0);
  for (int64_t i = 0; i < b->mesh.region_count; i++)
    b->mesh.materials[i].poisson = poisson;
  return body_precompute(b, MODES, MODES);
}

/* The estimate is at least two thirds of what the first modes are too high by, and not more. */
static void check(const char *coarse, const char *fine, double poisson) {
  body one, two;
  thrum_precomputed rough = precompute(coarse, poisson, &one),
                    near = precompute(fine, poisson, &two);
  assert_int_equal(rough.cubic_error_count, MODES);
  assert_int_equal(rough.order_error_count, 0);
  for (int i = 0; i < MODES; i++) {
    const double error = sqrt(rough.mode_omega2[i] / near.mode_omega2[i]) - 1;
    print_message("%s, nu %g: mode %d %.4f, estimated as %.2f of that\n", coarse, poisson, i + 1,
                  error, rough.cubic_error[i] / error);
    assert_true(rough.cubic_error[i] > 0.67 * error && rough.cubic_error[i] < 1.1 * error);
  }
  thrum_precomputed_free(&rough);
  thrum_precomputed_free(&near);
  body_free(&one);
  body_free(&two);
}

static void the_error_is_that_of_a_finer_mesh_within_a_third(void **state) {
  (void)state;
  static const double ratios[] = {0, 0.45, 0.499};
  for (size_t i = 0; i < sizeof ratios / sizeof *ratios; i++) {
    check("beam:3x1x1@1x0.2x0.2", "beam:9x3x3@1x0.2x0.2", ratios[i]);
    check("beam:2x2x2@1x1x1", "beam:5x5x5@1x1x1", ratios[i]);
  }
}

/* Where the mesh is fine there is nothing to be told. */
static void a_fine_mesh_has_a_small_error(void **state) {
  (void)state;
  body b;
  thrum_precomputed fine = precompute("beam:12x3x3@1x0.25x0.25", 0.3, &b);
  assert_true(fine.cubic_error[0] > 0 && fine.cubic_error[0] < 0.01);
  thrum_precomputed_free(&fine);
  body_free(&b);
}

/* Rigid motion has no frequency that could be wrong, and a free body's modes have. */
static void free_bodies_are_estimated_too(void **state) {
  (void)state;
  body coarse = body_quadratic("beam:4x1x1@1x0.2x0.2", NULL, 0, 0),
       fine = body_quadratic("beam:8x2x2@1x0.2x0.2", NULL, 0, 0);
  thrum_precomputed rough = body_precompute(&coarse, MODES, MODES),
                    near = body_precompute(&fine, MODES, MODES);
  const double error = sqrt(rough.mode_omega2[0] / near.mode_omega2[0]) - 1;
  print_message("free: %.4f, estimated as %.4f\n", error, rough.cubic_error[0]);
  assert_true(rough.cubic_error[0] > 0.67 * error && rough.cubic_error[0] < 1.4 * error);
  thrum_precomputed_free(&rough);
  thrum_precomputed_free(&near);
  body_free(&coarse);
  body_free(&fine);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_error_is_that_of_a_finer_mesh_within_a_third),
      cmocka_unit_test(a_fine_mesh_has_a_small_error),
      cmocka_unit_test(free_bodies_are_estimated_too),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
