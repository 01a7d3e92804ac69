/* How much too high the frequencies of linear tetrahedra are: the estimate against the same mesh
 * with ten nodes. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/order_find.h"
#include "tests/support/precompute_support.h"
#include "tests/support/sanitized.h"

enum { MODES = 5 };

/* The same Poisson's ratio in all regions. */
static void set_poisson(body *b, double poisson) {
  for (int64_t i = 0; i < b->mesh.region_count; i++)
    b->mesh.materials[i].poisson = poisson;
}

/* The estimate over the true error lies between `least` and 1.02 for the first `each` modes, before
 * those of the two meshes change their order. */
static void check(const char *beam, const char *fix, double poisson, int each, double least) {
  body linear = body_make(beam, fix), quadratic = body_quadratic(beam, fix, 0, 0);
  set_poisson(&linear, poisson);
  set_poisson(&quadratic, poisson);
  thrum_precomputed one = body_precompute(&linear, MODES, MODES),
                    two = body_precompute(&quadratic, MODES, MODES);
  assert_int_equal(one.order_error_count, MODES);
  assert_int_equal(two.order_error_count, 0);

  // frequencies go with the root of omega^2
  double lowest = INFINITY, highest = 0, largest = 0;
  for (int i = 0; i < each; i++) {
    const double error = sqrt(one.mode_omega2[i] / two.mode_omega2[i]) - 1;
    lowest = fmin(lowest, one.order_error[i] / error);
    highest = fmax(highest, one.order_error[i] / error);
    largest = fmax(largest, error);
  }
  print_message("%s, nu %g: errors of up to %.3f, estimated as %.2f to %.2f of that\n", beam,
                poisson, largest, lowest, highest);
  assert_true(lowest > least && highest < 1.02);

  // alone it is the same as within a precompute
  thrum_fem fem = body_fem(&linear);
  double found[MODES];
  int64_t count = MODES;
  assert_int_equal(thrum_order_find(&linear.mesh, &fem, INFINITY, &count, found, NULL), THRUM_OK);
  assert_int_equal(count, MODES);
  for (int i = 0; i < each; i++)
    assert_close(found[i], one.order_error[i], 1e-3);

  thrum_fem_free(&fem);
  thrum_precomputed_free(&one);
  thrum_precomputed_free(&two);
  body_free(&linear);
  body_free(&quadratic);
}

static void estimate_is_the_error_from_below(void **state) {
  (void)state;
  check("beam:10x1x1@1x0.1x0.1", "x<0.001", 0.4, 3, 0.97);
  check("beam:20x2x2@1x0.1x0.1", "x<0.001", 0.4, 4, 0.97);

  // finer meshes are the same to the sanitizers
  if (LENGTH_OF_RUN(false, true))
    return;
  check("beam:40x4x4@1x0.1x0.1", "x<0.001", 0.4, 5, 0.97);
}

static void estimate_holds_for_every_poisson_ratio(void **state) {
  (void)state;
  static const double ratios[] = {0, 0.3, 0.45, 0.49, 0.499};
  for (size_t i = 0; i < sizeof ratios / sizeof *ratios; i++) {
    check("beam:12x1x1@1x0.1x0.1", "x<0.001", ratios[i], 2, 0.97);
    check("beam:10x10x1@1x1x0.05", "x<0.001", ratios[i], 2, 0.97);

    // a compact body, where near 1/2 it is the volume that locks
    check("beam:4x4x4@1x1x1", "x<0.001", ratios[i], 2, 0.96);
  }
}

static void cells_as_slender_as_a_wire_are_no_exception(void **state) {
  (void)state;
  check("beam:50x1x1@10x0.01x0.01", "x<0.001", 0.3, 3, 0.97);
}

static void free_bodies_are_estimated_too(void **state) {
  (void)state;
  check("beam:20x2x2@1x0.1x0.1", NULL, 0.4, 4, 0.97);
  check("beam:12x1x1@1x0.1x0.1", NULL, 0.49, 1, 0.97);
}

static void a_mesh_of_few_components_has_few_modes(void **state) {
  (void)state;
  // two components are free
  body b = body_make("beam:1x1x1@1x1x1", NULL);
  memset(b.fixed, 7, (size_t)b.mesh.vertex_count);
  b.fixed[b.mesh.vertex_count - 1] = 1;
  thrum_fem fem = body_fem(&b);
  double found[THRUM_ORDER_MODES_MAX];
  int64_t count = THRUM_ORDER_MODES_MAX;
  assert_int_equal(thrum_order_find(&b.mesh, &fem, INFINITY, &count, found, NULL), THRUM_OK);
  assert_int_equal(count, 1);
  for (int64_t i = 0; i < count; i++)
    assert_true(found[i] >= 0 && isfinite(found[i]));
  thrum_fem_free(&fem);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(estimate_is_the_error_from_below),
      cmocka_unit_test(estimate_holds_for_every_poisson_ratio),
      cmocka_unit_test(cells_as_slender_as_a_wire_are_no_exception),
      cmocka_unit_test(free_bodies_are_estimated_too),
      cmocka_unit_test(a_mesh_of_few_components_has_few_modes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
