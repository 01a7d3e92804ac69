/* The first frequency of a slender cantilever is compared with Euler-Bernoulli theory,
 * f1 = (1.8751^2 / 2 pi) sqrt(E I / (rho A L^4)). Linear tetrahedra are too stiff in thin bending,
 * so the error falls with the mesh size but does not vanish; nu = 0, because the theory neglects
 * the transverse strain. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

// relative error of f1 with `cells` cubic cells over the thickness of a beam of L/h = 20
static double error_with(int cells) {
  const double length = 1, thickness = 0.05;
  char name[100];

  // cubic cells, so that refinement keeps the shape of the tetrahedra
  snprintf(name, sizeof name, "beam:%dx%dx%d@1x0.05x0.05", 20 * cells, cells, cells);
  body b = body_make(name, "x<0.0001");
  b.mesh.materials[0].poisson = 0;
  const thrum_material material = b.mesh.materials[0];
  thrum_precomputed result = body_precompute(&b, 2, 2);

  // the theory's frequency of the same section and material
  const double second_moment = pow(thickness, 4) / 12, area = thickness * thickness;
  const double exact =
      1.875104068711961 * 1.875104068711961 / TWO_PI *
      sqrt(material.young * second_moment / (material.density * area * pow(length, 4)));
  const double error = sqrt(result.mode_omega2[0]) / TWO_PI / exact - 1;

  thrum_precomputed_free(&result);
  body_free(&b);
  return error;
}

static void first_frequency_approaches_that_of_the_slender_beam(void **state) {
  (void)state;
  const double coarse = error_with(4), fine = error_with(6);
  print_message("error of f1: %.2f %% with 4 cells, %.2f %% with 6\n", 100 * coarse, 100 * fine);
  // every mesh is too stiff, and the error falls at nearly the square of the cell's size
  assert_true(coarse > fine && fine > 0);
  assert_true(coarse > 1.8 * fine);
  assert_true(fine < 0.04);
}

/* Cells that are mirror images give a square section the symmetry of the square where their number
 * is even, and nearly so where it is odd. Cells that are all the same have one stiff diagonal. */
static void a_square_beam_bends_alike_in_all_directions(void **state) {
  (void)state;
  static const struct {
    const char *beam;
    double apart; /* the second frequency over the first, less 1, at most */
  } cases[] = {{"beam:10x2x2@1x0.15x0.15", 1e-10},
               {"beam:10x4x4@1x0.15x0.15", 1e-10},
               {"beam:10x3x3@1x0.15x0.15", 0.02},
               {"beam:10x3x3@1x0.15x0.15,split=5", 0.01}};
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    body b = body_make(cases[n].beam, "x<0.001");
    thrum_precomputed result = body_precompute(&b, 2, 2);
    const double apart = sqrt(result.mode_omega2[1] / result.mode_omega2[0]) - 1;
    print_message("%s: %.2g\n", cases[n].beam, apart);
    assert_true(apart >= 0 && apart < cases[n].apart);
    thrum_precomputed_free(&result);
    body_free(&b);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(first_frequency_approaches_that_of_the_slender_beam),
      cmocka_unit_test(a_square_beam_bends_alike_in_all_directions),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
