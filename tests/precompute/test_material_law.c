/* Laws of materials: energy, stress and tangent belong together, closed forms of tension and shear,
 * the rotation of any deformation, and the discrete gradient. SPDX-License-Identifier: Apache-2.0
 */
#include "runtime/material/material_law.h"

#include "precompute/material/material_law_mean.h"

#include "runtime/material/jacobi.h"
#include "runtime/material/plastic_flow.h"
#include "runtime/material/polar.h"
#include "runtime/material/principal.h"
#include "tests/support/closed_forms.h"
#include "tests/support/precompute_support.h"

static const double LAMBDA = 1.5, MU = 0.8;
static const thrum_law laws[] = {THRUM_LAW_STVK, THRUM_LAW_COROTATIONAL, THRUM_LAW_NEO_HOOKEAN};
enum { LAW_COUNT = 3 };

static void random_gradient(double size, double g[3][3]) {
  for (int i = 0; i < 9; i++)
    g[i / 3][i % 3] = size * random_number();
}

/* The same, where det(1 + G) has the sign asked for. */
static void random_gradient_of_sign(double size, bool inverted, double g[3][3]) {
  double determinant;
  do {
    random_gradient(size, g);
    const double f[3][3] = {{1 + g[0][0], g[0][1], g[0][2]},
                            {g[1][0], 1 + g[1][1], g[1][2]},
                            {g[2][0], g[2][1], 1 + g[2][2]}};
    determinant = f[0][0] * (f[1][1] * f[2][2] - f[1][2] * f[2][1]) -
                  f[0][1] * (f[1][0] * f[2][2] - f[1][2] * f[2][0]) +
                  f[0][2] * (f[1][0] * f[2][1] - f[1][1] * f[2][0]);
  } while (inverted ? determinant > -0.2 : determinant < 0.2);
}

static void multiply(double a[3][3], double b[3][3], double product[3][3]) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      product[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
}

/* R is orthogonal and right-handed, S = R^T F symmetric, and tr(S) 1 - S positive semidefinite,
 * which says that no other rotation is nearer. */
static void check_polar(double f[3][3]) {
  double g[3][3], r[3][3], matrix[3][3], trace = 0;
  memcpy(g, f, sizeof g);
  for (int i = 0; i < 3; i++)
    g[i][i] -= 1;
  thrum_polar_rotation(g, r);
  for (int i = 0; i < 3; i++)
    r[i][i] += 1;

  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const double *a = r[i], *b = r[j];
      const double product = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
      assert_true(fabs(product - (i == j)) <= 1e-14);
      matrix[i][j] = -(r[0][i] * f[0][j] + r[1][i] * f[1][j] + r[2][i] * f[2][j]);
      trace -= i == j ? matrix[i][j] : 0;
    }
  assert_true(fabs(r[0][0] * r[1][1] - r[0][1] * r[1][0] - r[2][2]) <= 1e-14);

  // symmetric, with principal minors that are not negative
  for (int i = 0; i < 3; i++)
    matrix[i][i] += trace;
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3;
    assert_true(fabs(matrix[i][j] - matrix[j][i]) <= 1e-13);
    assert_true(matrix[i][i] >= -1e-13);
    assert_true(matrix[i][i] * matrix[j][j] - matrix[i][j] * matrix[j][i] >= -1e-13);
  }
}

static void the_rotation_of_any_deformation_is_the_nearest_one(void **state) {
  (void)state;
  double f[3][3];
  for (int n = 0; n < 300; n++) {
    random_gradient(2, f);
    check_polar(f);
  }

  // singular and inverted ones, where iterations for the orthogonal factor give up
  double singular[][3][3] = {{{0}},
                             {{1, 0, 0}, {0, 1, 0}, {0, 0, 0}},
                             {{1, 0, 0}, {0, 0, 0}, {0, 0, 0}},
                             {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                             {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}},
                             {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}}};
  for (size_t n = 0; n < sizeof singular / sizeof singular[0]; n++)
    check_polar(singular[n]);

  // a small displacement turns by its skew part, with all digits
  double g[3][3], turned[3][3];
  random_gradient(1e-12, g);
  thrum_polar_rotation(g, turned);
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3;
    const double skew = (g[i][j] - g[j][i]) / 2;
    assert_true(fabs(turned[i][j] - skew) <= 1e-10 * fabs(skew));
  }
}

/* Fourth-order central differences: weights of +-h and +-2h. */
static const double weights[] = {1.0 / 12, -2.0 / 3, 0, 2.0 / 3, -1.0 / 12};

static void stress_and_tangent_are_the_derivatives_of_the_energy(void **state) {
  (void)state;
  const double h = 1e-3;
  for (int n = 0; n < 40; n++) {
    const thrum_law law = laws[n % LAW_COUNT];
    double g[3][3], stress[3][3], other[3][3], tangent[9][9];
    random_gradient_of_sign(0.7, n % 4 >= 2, g);
    thrum_law_stress(law, LAMBDA, MU, g, stress);
    thrum_law_tangent(law, LAMBDA, MU, g, tangent);

    // beside the moduli, which set the scale of all
    for (int column = 0; column < 9; column++) {
      double *entry = &g[column / 3][column % 3], middle = *entry, slope = 0, slopes[9] = {0};
      for (int k = -2; k <= 2; k++) {
        *entry = middle + k * h;
        slope += weights[k + 2] / h * thrum_law_stress(law, LAMBDA, MU, g, other);
        for (int row = 0; row < 9; row++)
          slopes[row] += weights[k + 2] / h * other[row / 3][row % 3];
      }
      *entry = middle;
      assert_true(fabs(slope - stress[column / 3][column % 3]) <= 1e-8);
      for (int row = 0; row < 9; row++) {
        assert_true(fabs(slopes[row] - tangent[row][column]) <= 1e-6);
        assert_true(fabs(tangent[row][column] - tangent[column][row]) <= 1e-12);
      }
    }
  }
}

static void a_tangent_made_positive_loses_its_negative_part_alone(void **state) {
  (void)state;
  int changed = 0;
  for (int n = 0; n < 20; n++) {
    double g[3][3], tangent[9][9], positive[9][9];
    random_gradient(0.8, g);
    thrum_law_tangent(laws[n % LAW_COUNT], LAMBDA, MU, g, tangent);
    memcpy(positive, tangent, sizeof positive);
    thrum_law_make_positive(positive);

    // no eigenvalue is negative, and none that was positive is another: the part that was taken
    // away and the part that is left have no eigenvector in common
    double taken[9][9], vectors[9][9];
    for (int i = 0; i < 81; i++)
      taken[i / 9][i % 9] = positive[i / 9][i % 9] - tangent[i / 9][i % 9];
    for (int i = 0; i < 81; i++) {
      double product = 0;
      for (int k = 0; k < 9; k++)
        product += taken[i / 9][k] * positive[k][i % 9];
      assert_true(fabs(product) <= 1e-12);
      changed += fabs(taken[i / 9][i % 9]) > 1e-3;
    }
    for (int half = 0; half < 2; half++) {
      double(*matrix)[9] = half == 0 ? positive : taken;
      thrum_jacobi(9, matrix[0], vectors[0]);
      for (int k = 0; k < 9; k++)
        assert_true(matrix[k][k] >= -1e-12);
    }
  }
  assert_true(changed > 0);
}

static void a_rotation_turns_the_stress_and_keeps_the_energy(void **state) {
  (void)state;
  for (int n = 0; n < 20; n++) {
    const thrum_law law = laws[n % LAW_COUNT];
    double g[3][3], f[3][3], q[3][3], turned[3][3], stress[3][3], expected[3][3], found[3][3];
    random_gradient(1, f);
    thrum_polar_rotation(f, q);
    for (int i = 0; i < 3; i++)
      q[i][i] += 1;
    random_gradient(0.7, g);
    memcpy(f, g, sizeof f);
    for (int i = 0; i < 3; i++)
      f[i][i] += 1;

    // P(Q F) = Q P(F)
    multiply(q, f, turned);
    for (int i = 0; i < 3; i++)
      turned[i][i] -= 1;
    const double energy = thrum_law_stress(law, LAMBDA, MU, g, stress);
    const double same = thrum_law_stress(law, LAMBDA, MU, turned, found);
    multiply(q, stress, expected);
    assert_true(fabs(energy - same) <= 1e-13 * (1 + energy));
    for (int i = 0; i < 9; i++)
      assert_true(fabs(expected[i / 3][i % 3] - found[i / 3][i % 3]) <= 1e-12);
  }
}

/* The energy of linear elasticity: what all laws are of small strains. */
static double linear_energy(double g[3][3]) {
  double square = 0, trace = g[0][0] + g[1][1] + g[2][2];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      square += (g[i][j] + g[j][i]) * (g[i][j] + g[j][i]) / 4;
  return MU * square + LAMBDA / 2 * trace * trace;
}

static void at_rest_all_laws_are_linear_elasticity(void **state) {
  (void)state;
  for (int n = 0; n < LAW_COUNT; n++) {
    double g[3][3] = {{0}}, stress[3][3], tangent[9][9];
    assert_true(thrum_law_stress(laws[n], LAMBDA, MU, g, stress) == 0);
    thrum_law_tangent(laws[n], LAMBDA, MU, g, tangent);
    for (int row = 0; row < 9; row++)
      for (int column = 0; column < 9; column++) {
        const int i = row / 3, j = row % 3, k = column / 3, l = column % 3;
        const double linear =
            (i == j && k == l ? LAMBDA : 0) + MU * ((i == k && j == l) + (i == l && j == k));
        assert_true(fabs(stress[i][j]) <= 1e-15 && fabs(tangent[row][column] - linear) <= 1e-14);
      }

    // small strains lose no digits: what is left differs by their size
    random_gradient(1e-10, g);
    const double energy = thrum_law_stress(laws[n], LAMBDA, MU, g, stress);
    assert_true(fabs(energy - linear_energy(g)) <= 1e-9 * linear_energy(g));
    const double shear = MU * (g[0][1] + g[1][0]);
    assert_true(fabs(stress[0][1] - shear) <= 1e-18);
  }
}

/* The mean of P over a box of length 1 under u(X) = G X, from the forces on two of its faces: the
 * columns of P for the normals x and y. */
static void stress_of_body(const body *b, thrum_fem *fem, double g[3][3], double columns[2][3]) {
  double *u = need((size_t)(3 * fem->vertex_count), sizeof *u);
  double *force = need((size_t)(3 * fem->vertex_count), sizeof *force);
  for (int64_t v = 0; v < fem->vertex_count; v++)
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        u[3 * v + i] += g[i][j] * b->mesh.vertices[3 * v + j];
  thrum_fem_energy(fem, u, force);

  // the moments of the forces are the stress: sum f x^T = P volume, as the body is in equilibrium
  memset(columns, 0, 2 * sizeof *columns);
  for (int64_t v = 0; v < fem->vertex_count; v++)
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 2; j++)
        columns[j][i] += force[3 * v + i] * b->mesh.vertices[3 * v + j];
  free(u);
  free(force);
}

static void tension_and_shear_of_a_body_are_the_closed_forms(void **state) {
  (void)state;
  body b = body_make("beam:2x2x2@1x1x1", NULL);
  thrum_fem fem = body_fem(&b);
  const double lambda = fem.lambda[0], mu = fem.mu[0];

  for (int law = THRUM_LAW_STVK; law <= THRUM_LAW_NEO_HOOKEAN; law++) {
    fem.law = (thrum_law)law;
    double columns[2][3], t;

    // pulled and pressed along x, free across
    for (double s = 0.6; s < 1.5; s += 0.3) {
      const double along = tension_form(fem.law, lambda, mu, s, &t);
      double g[3][3] = {{s - 1, 0, 0}, {0, t - 1, 0}, {0, 0, t - 1}};
      stress_of_body(&b, &fem, g, columns);
      assert_true(fabs(columns[0][0] - along) <= 1e-10 * mu);
      assert_true(fabs(columns[1][1]) <= 1e-10 * mu);
    }

    // x moves by k y: P_xy and P_yx
    for (double k = 0.2; k < 2; k += 0.6) {
      double g[3][3] = {{0, k, 0}, {0, 0, 0}, {0, 0, 0}};
      const shear_stress shear = shear_form(fem.law, lambda, mu, k);
      stress_of_body(&b, &fem, g, columns);
      assert_true(fabs(columns[1][0] - shear.xy) <= 1e-10 * mu);
      assert_true(fabs(columns[0][1] - shear.yx) <= 1e-10 * mu);
    }
  }

  thrum_fem_free(&fem);
  body_free(&b);
}

/* K v against differences of the force along v. */
static void check_stiffness(body *b, thrum_law law) {
  thrum_fem fem = body_fem(b);
  const int64_t n = fem.free_count, all = 3 * fem.vertex_count;
  double *u = need((size_t)all, sizeof *u), *v = need((size_t)n, sizeof *v);
  double *place = need((size_t)all, sizeof *place), *force = need((size_t)all, sizeof *force);
  double *product = need((size_t)n, sizeof *product), *slope = need((size_t)n, sizeof *slope);
  fem.law = law;

  // a displaced shape, and a direction that moves no held vertex
  for (int64_t c = 0; c < all; c++)
    u[c] = fem.dof[c] < 0 ? 0 : 0.02 * random_number();
  for (int64_t i = 0; i < n; i++)
    v[i] = random_number();

  thrum_sparse stiffness;
  thrum_error error;
  assert_int_equal(thrum_fem_pattern(&fem, &stiffness, &error), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&fem, u, &stiffness, &error), THRUM_OK);
  thrum_sparse_product(&stiffness, v, 1, product);

  const double h = 1e-4;
  for (int k = -2; k <= 2; k++) {
    for (int64_t c = 0; c < all; c++)
      place[c] = u[c] + (fem.dof[c] < 0 ? 0 : k * h * v[fem.dof[c]]);
    thrum_fem_energy(&fem, place, force);
    for (int64_t i = 0; i < n; i++)
      slope[i] += weights[k + 2] / h * force[fem.component[i]];
  }
  for (int64_t i = 0; i < n; i++)
    slope[i] -= product[i];
  assert_true(norm_of(slope, n) <= 1e-7 * norm_of(product, n));

  thrum_sparse_free(&stiffness);
  thrum_fem_free(&fem);
  free(u);
  free(v);
  free(place);
  free(force);
  free(product);
  free(slope);
}

static void the_stiffness_is_the_derivative_of_the_force(void **state) {
  (void)state;
  body linear = body_make("beam:3x1x1@1x0.4x0.4", "x<0.001");
  body quadratic = body_quadratic("beam:2x1x1@1x0.5x0.5", "x<0.001", 0, 0.01);
  for (int n = 0; n < LAW_COUNT; n++) {
    check_stiffness(&linear, laws[n]);
    check_stiffness(&quadratic, laws[n]);
  }

  // also where regions have laws of their own
  body_divide(&linear, 1);
  body_divide(&quadratic, 1);
  check_stiffness(&linear, THRUM_LAW_BY_REGION);
  check_stiffness(&quadratic, THRUM_LAW_BY_REGION);
  body_free(&linear);
  body_free(&quadratic);
}

/* Large and small changes, on either side of where the bracket turns to quadrature. */
static void the_mean_stress_keeps_energy_and_angular_momentum(void **state) {
  (void)state;
  static const double sizes[] = {0.5, 1e-2, 1e-3, 1e-4, 1e-6};
  for (int n = 0; n < 50; n++) {
    const thrum_law law = laws[n % LAW_COUNT];
    double from[3][3], to[3][3], stress[3][3], other[3][3];
    random_gradient(0.3, from);
    random_gradient(sizes[n / 2 % 5], to);
    for (int i = 0; i < 9; i++)
      to[i / 3][i % 3] += from[i / 3][i % 3];

    // P-bar:D is the change of the density
    const double change = thrum_law_stress(law, LAMBDA, MU, to, other) -
                          thrum_law_stress(law, LAMBDA, MU, from, other);
    double work = 0;
    thrum_law_mean_stress(law, LAMBDA, MU, from, to, stress);
    for (int i = 0; i < 9; i++)
      work += stress[i / 3][i % 3] * (to[i / 3][i % 3] - from[i / 3][i % 3]);
    assert_true(fabs(work - change) <= 1e-14);

    // P-bar F-bar^T is symmetric
    double mean[3][3], moment[3][3];
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        mean[j][i] = (i == j) + (from[i][j] + to[i][j]) / 2;
    multiply(stress, mean, moment);
    for (int i = 0; i < 3; i++)
      assert_true(fabs(moment[i][(i + 1) % 3] - moment[(i + 1) % 3][i]) <= 1e-14);
  }
}

/* A rotation leaves E as it is, and S with it: P-bar is F-bar S, of compressed bodies too. */
static void a_rotation_leaves_the_stress_of_the_stretch(void **state) {
  (void)state;
  static const double stretch[3] = {0.8, 0.7, 1.1};
  const double c = cos(0.9), s = sin(0.9);
  const double rotation[3][3] = {{c, -s, 0}, {s, c, 0}, {0, 0, 1}};
  for (int n = 0; n < LAW_COUNT; n++) {
    double from[3][3] = {{0}}, to[3][3], first[3][3], stress[3][3];
    for (int i = 0; i < 3; i++)
      from[i][i] = stretch[i] - 1;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        to[i][j] = rotation[i][j] * stretch[j] - (i == j);
    thrum_law_stress(laws[n], LAMBDA, MU, from, first);
    thrum_law_mean_stress(laws[n], LAMBDA, MU, from, to, stress);
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) {
        const double mean = 0.5 * ((i == j) + rotation[i][j]) * stretch[j];
        assert_true(fabs(stress[i][j] - mean * first[j][j] / stretch[j]) <= 1e-12 * MU);
      }
  }
}

/* The work of the mean stress between two principal deformations is the change of the density. */
static void assert_mean_stress_keeps(thrum_law law, const double from_stretch[3],
                                     const double to_stretch[3]) {
  double from[3][3] = {{0}}, to[3][3] = {{0}}, stress[3][3], other[3][3], work = 0;
  for (int k = 0; k < 3; k++) {
    from[k][k] = from_stretch[k] - 1;
    to[k][k] = to_stretch[k] - 1;
  }
  thrum_law_mean_stress(law, LAMBDA, MU, from, to, stress);
  for (int k = 0; k < 3; k++)
    work += stress[k][k] * (to[k][k] - from[k][k]);

  // relative to densities that are no small ones
  const double before = thrum_law_stress(law, LAMBDA, MU, from, other);
  const double after = thrum_law_stress(law, LAMBDA, MU, to, other);
  assert_true(fabs(work - (after - before)) <= 1e-13 * (before + after));
}

/* Small changes where quadrature is wrong: beside a flat element, where S has a pole, and across
 * the jump of the corotational stress, where the two least stretches are opposite. */
static void the_mean_stress_keeps_energy_beside_its_poles_and_jumps(void **state) {
  (void)state;
  static const double thin[3] = {1, 1, 0.07}, flat[3] = {1, 1, 0.01}, thinner[3] = {1, 1, 1e-3};
  static const double above[3] = {1.2, 0.3, -0.2996}, below[3] = {1.2, 0.2996, -0.3};
  for (int n = 0; n < LAW_COUNT; n++) {
    assert_mean_stress_keeps(laws[n], thin, flat);
    assert_mean_stress_keeps(laws[n], flat, thinner);
    assert_mean_stress_keeps(laws[n], above, below);
  }
}

/* A small strain beyond the yield, whose directions are no axes. */
static void flow_brings_a_strain_back_to_the_yield_and_keeps_the_volume(void **state) {
  (void)state;
  const thrum_plastic material = {.yield = 1e-4, .creep = 5, .largest = INFINITY};
  double plastic[3][3] = {{0}}, flowed[3][3], elastic[3][3], green[3][3], grown[3], axes[3][3];
  double g[3][3] = {{2e-3, 1e-3, 0}, {5e-4, -1e-3, 2e-4}, {0, -7e-4, 1e-3}};

  // what is beyond the yield falls as exp(-creep t), whatever the steps
  double deviator = 0, before = 0, elapsed = 0;
  for (int k = 0; k < 40; k++) {
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        elastic[i][j] = g[i][j] + plastic[i][j] + g[i][0] * plastic[0][j] +
                        g[i][1] * plastic[1][j] + g[i][2] * plastic[2][j];
    thrum_green_strain(elastic, green);
    thrum_principal_stretches(green, grown, axes);
    const double mean = (grown[0] + grown[1] + grown[2]) / 3;
    deviator = sqrt((grown[0] - mean) * (grown[0] - mean) + (grown[1] - mean) * (grown[1] - mean) +
                    (grown[2] - mean) * (grown[2] - mean));
    before = k == 0 ? deviator : before;
    const double expected = material.yield + (before - material.yield) * exp(-5 * elapsed);
    assert_true(fabs(deviator - expected) <= 0.01 * expected);

    // the step grows, so that the last ones leave nothing
    const double dt = 0.02 * (1 + k);
    elapsed += dt;
    if (!thrum_plastic_flow(&material, dt, elastic, plastic, 1, flowed))
      break;
    memcpy(plastic, flowed, sizeof flowed);
  }
  assert_true(fabs(deviator - material.yield) <= 1e-6 * before);

  // no volume has flowed
  double f[3][3];
  for (int i = 0; i < 9; i++)
    f[i / 3][i % 3] = plastic[i / 3][i % 3] + (i % 4 == 0);
  const double volume = f[0][0] * (f[1][1] * f[2][2] - f[1][2] * f[2][1]) -
                        f[0][1] * (f[1][0] * f[2][2] - f[1][2] * f[2][0]) +
                        f[0][2] * (f[1][0] * f[2][1] - f[1][1] * f[2][0]);
  assert_true(fabs(volume - 1) <= 1e-15);
  assert_true(thrum_plastic_strain(plastic) > 1e-3);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_rotation_of_any_deformation_is_the_nearest_one),
      cmocka_unit_test(stress_and_tangent_are_the_derivatives_of_the_energy),
      cmocka_unit_test(a_tangent_made_positive_loses_its_negative_part_alone),
      cmocka_unit_test(a_rotation_turns_the_stress_and_keeps_the_energy),
      cmocka_unit_test(at_rest_all_laws_are_linear_elasticity),
      cmocka_unit_test(tension_and_shear_of_a_body_are_the_closed_forms),
      cmocka_unit_test(the_stiffness_is_the_derivative_of_the_force),
      cmocka_unit_test(the_mean_stress_keeps_energy_and_angular_momentum),
      cmocka_unit_test(a_rotation_leaves_the_stress_of_the_stretch),
      cmocka_unit_test(the_mean_stress_keeps_energy_beside_its_poles_and_jumps),
      cmocka_unit_test(flow_brings_a_strain_back_to_the_yield_and_keeps_the_volume),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
