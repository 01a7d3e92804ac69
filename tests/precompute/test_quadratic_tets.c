/* Ten-node tetrahedra, design 1 and 3: their integrals, the patch test, derivatives of the energy,
 * the mass of a body, the reduced model against the full order, and what beam theory says of one
 * and two of them over a thickness. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "core/base/quadratic_tet.h"
#include "precompute/fem/quadrature.h"
#include "precompute/model/model_fem.h"
#include "thrum/polynomial.h"

static double factorial(int n) {
  return n < 2 ? 1 : n * factorial(n - 1);
}

/* That a rule is exact to its degree, and its points inside with positive weights. */
static void check_rule(const thrum_quadratic_point *rule, int points, int degree) {
  // 6 i! j! k! / (i + j + k + 3)! over the mean of a tet
  for (int i = 0; i <= degree; i++)
    for (int j = 0; i + j <= degree; j++)
      for (int k = 0; i + j + k <= degree; k++) {
        double sum = 0;
        for (int p = 0; p < points; p++)
          sum += rule[p].weight * pow(rule[p].place[1], i) * pow(rule[p].place[2], j) *
                 pow(rule[p].place[3], k);
        assert_close(sum, 6 * factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 3),
                     degree < 6 ? 2e-14 : 2e-12);
      }

  for (int p = 0; p < points; p++) {
    assert_true(rule[p].weight > 0);
    for (int a = 0; a < 4; a++)
      assert_true(rule[p].place[a] > 0);
  }
}

static void rules_integrate_every_monomial_of_their_degree(void **state) {
  (void)state;
  int points;
  for (int curved = 0; curved < 2; curved++) {
    const thrum_quadratic_point *rule = thrum_quadratic_rule(curved != 0, &points);
    check_rule(rule, points, curved ? 5 : 4);
  }

  // those that are asked for
  thrum_quadratic_point *rule;
  for (int order = THRUM_QUADRATURE_ORDER_MIN; order <= THRUM_QUADRATURE_ORDER_MAX; order++) {
    assert_int_equal(thrum_quadrature(order, true, &rule, &points, NULL), THRUM_OK);
    const int n = order / 2 + 1;
    assert_int_equal(points, order == 4 ? 11 : order == 5 ? 14 : order == 6 ? 24 : n * n * n);
    check_rule(rule, points, order);
    free(rule);
  }
  assert_int_equal(thrum_quadrature(3, true, &rule, &points, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_quadrature(21, true, &rule, &points, NULL), THRUM_INVALID_ARGUMENT);
}

/* The first frequency^2 of a strongly curved body, by points of an order; 0: the usual one. */
static double curved_frequency(const body *b, int order) {
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = 4;
  options.rank = 8;
  options.quadrature_order = order;
  thrum_precomputed result = {0};
  assert_int_equal(thrum_precompute(&b->mesh, b->fixed, &options, &result, NULL), THRUM_OK);
  assert_int_equal(result.quadrature_order, order > 0 ? order : 5);
  const double omega2 = result.mode_omega2[0];
  thrum_precomputed_free(&result);
  return omega2;
}

static void curved_bodies_converge_with_the_order_of_their_points(void **state) {
  (void)state;
  body b = body_quadratic("beam:3x1x1@1x0.4x0.4", "x<0.001", 0, 0.04);
  const double exact = curved_frequency(&b, 14), usual = curved_frequency(&b, 0);
  assert_true(curved_frequency(&b, 5) == usual);
  double before = fabs(usual / exact - 1);
  print_message("order 5 errs by %.1e", before);
  for (int order = 8; order <= 12; order += 2) {
    const double error = fabs(curved_frequency(&b, order) / exact - 1);
    print_message(", %d by %.1e", order, error);
    assert_true(error < before / 2);
    before = error;
  }
  print_message("\n");
  body_free(&b);
}

static void full_order_takes_the_points_that_the_model_was_made_with(void **state) {
  (void)state;
  body b = body_quadratic("beam:3x1x1@1x0.4x0.4", "x<0.001", 0, 0.02);
  thrum_precomputed result = body_precompute(&b, 2, 4);
  thrum_model model = result.model;

  // the order is read from the record; what is no order, or no record, gives the default
  static const char *const metas[] = {"{}", "{\"options\":{\"quadrature_order\":8}}",
                                      "{\"options\":{\"quadrature_order\":1e9}}", "{\"opt"};
  static const int points[] = {14, 125, 14, 14};

  for (int n = 0; n < 4; n++) {
    model.meta = (const thrum_u1 *)metas[n];
    model.meta_bytes = (int64_t)strlen(metas[n]);
    thrum_model_fem full = {0};
    assert_int_equal(thrum_model_fem_create(&model, &full, NULL), THRUM_OK);
    assert_int_equal(full.fem.point_count, points[n]);
    thrum_model_fem_free(&full);
  }
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void shape_functions_are_one_at_their_node_and_add_up_to_one(void **state) {
  (void)state;
  for (int a = 0; a < THRUM_QUADRATIC_NODES; a++) {
    double place[4] = {0}, shape[THRUM_QUADRATIC_NODES];
    if (a < 4)
      place[a] = 1;
    for (int end = 0; end < 2 && a >= 4; end++)
      place[thrum_quadratic_edges[a - 4][end]] = 0.5;
    thrum_quadratic_shape(place, shape);
    for (int b = 0; b < THRUM_QUADRATIC_NODES; b++)
      assert_true(shape[b] == (a == b));
  }

  // slopes are those of differences
  const double l[3] = {0.2, 0.3, 0.1}, step = 1e-6;
  double slopes[THRUM_QUADRATIC_NODES][3];
  thrum_quadratic_slopes((double[]){1 - l[0] - l[1] - l[2], l[0], l[1], l[2]}, slopes);
  for (int k = 0; k < 3; k++) {
    double ends[2][THRUM_QUADRATIC_NODES], sum = 0;
    for (int side = 0; side < 2; side++) {
      double at[4] = {0, l[0], l[1], l[2]};
      at[k + 1] += side ? step : -step;
      at[0] = 1 - at[1] - at[2] - at[3];
      thrum_quadratic_shape(at, ends[side]);
    }
    for (int a = 0; a < THRUM_QUADRATIC_NODES; a++) {
      assert_true(fabs((ends[1][a] - ends[0][a]) / (2 * step) - slopes[a][k]) < 1e-9);
      sum += slopes[a][k];
    }
    assert_true(fabs(sum) < 1e-14);
  }
}

static bool on_surface(const double *x) {
  return x[0] < 0.03 || x[0] > 0.97 || fabs(x[1]) > 0.47 || fabs(x[2]) > 0.47;
}

/* A linear displacement gives a constant stress, so inner nodes carry no force, whatever the shape
 * of the elements; the energy is that of the volume. */
static void patch_test(double corner, double middle) {
  body b = body_quadratic("beam:4x3x3@1x1x1", NULL, corner, middle);
  thrum_fem fem = body_fem(&b);
  static const double a[3][3] = {{0.2, 0.3, -0.1}, {0.05, -0.1, 0.2}, {-0.15, 0.1, 0.1}};
  double *u = need((size_t)(3 * fem.vertex_count), sizeof *u);
  double *force = need((size_t)(3 * fem.vertex_count), sizeof *force);
  for (int64_t v = 0; v < fem.vertex_count; v++)
    for (int c = 0; c < 3; c++)
      u[3 * v + c] = 0.1 + dot_of(a[c], fem.vertices + 3 * v, 3);
  const double energy = thrum_fem_energy(&fem, u, force);

  double largest = 0, inside = 0, volume = 0, trace = 0, square = 0;
  int64_t inner = 0;
  for (int64_t v = 0; v < fem.vertex_count; v++) {
    const double size = norm_of(force + 3 * v, 3);
    const bool outer = on_surface(fem.vertices + 3 * v);
    largest = fmax(largest, size);
    inside = outer ? inside : fmax(inside, size);
    inner += !outer;
  }
  assert_true(inner > 50);
  print_message("patch test: forces inside are %.1e of those on the surface\n", inside / largest);
  assert_true(inside < 1e-12 * largest);

  // V = vol (lambda/2 tr(E)^2 + mu E:E)
  for (int64_t t = 0; t < fem.tet_count; t++)
    volume += fem.volume[t];
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      double strain = (a[c][d] + a[d][c]) / 2;
      for (int k = 0; k < 3; k++)
        strain += a[k][c] * a[k][d] / 2;
      square += strain * strain;
      trace += c == d ? strain : 0;
    }
  assert_close(energy, volume * (fem.lambda[0] / 2 * trace * trace + fem.mu[0] * square), 1e-12);

  free(u);
  free(force);
  thrum_fem_free(&fem);
  body_free(&b);
}

static void linear_displacements_pass_the_patch_test_on_distorted_meshes(void **state) {
  (void)state;
  patch_test(0.02, 0);
  patch_test(0.02, 0.01);
}

static void force_and_tangent_are_derivatives_of_the_energy(void **state) {
  (void)state;
  for (int curved = 0; curved < 2; curved++) {
    body b = body_quadratic("beam:2x1x1@1x0.4x0.4", "x<0.001", 0, curved ? 0.02 : 0);
    thrum_fem fem = body_fem(&b);
    assert_int_equal(fem.point_count, curved ? 14 : 11);
    const int64_t count = 3 * fem.vertex_count, n = fem.free_count;
    double *u = random_vector(count, 0.05), *d = random_vector(n, 1);
    double *moved = need((size_t)count, sizeof *moved), *all = need((size_t)count, sizeof *all);
    double *force[3], energy[3];
    thrum_fem_scatter(&fem, d, all);

    // both by differences along d
    const double step = 1e-5;
    for (int side = 0; side < 3; side++) {
      force[side] = need((size_t)count, sizeof(double));
      for (int64_t c = 0; c < count; c++)
        moved[c] = u[c] + (side - 1) * step * all[c];
      energy[side] = thrum_fem_energy(&fem, moved, force[side]);
    }
    assert_close(dot_of(force[1], all, count), (energy[2] - energy[0]) / (2 * step), 1e-7);

    thrum_sparse tangent;
    assert_int_equal(thrum_fem_pattern(&fem, &tangent, NULL), THRUM_OK);
    assert_int_equal(thrum_fem_stiffness(&fem, u, &tangent, NULL), THRUM_OK);
    double *product = need((size_t)n, sizeof *product), *change = need((size_t)n, sizeof *change);
    thrum_sparse_product(&tangent, d, 1, product);
    for (int64_t i = 0; i < n; i++)
      change[i] = (force[2][fem.component[i]] - force[0][fem.component[i]]) / (2 * step);
    assert_near(product, change, n, 1e-7);

    for (int side = 0; side < 3; side++)
      free(force[side]);
    free(u);
    free(d);
    free(moved);
    free(all);
    free(product);
    free(change);
    thrum_sparse_free(&tangent);
    thrum_fem_free(&fem);
    body_free(&b);
  }
}

static void mass_of_either_kind_weighs_the_body_and_is_positive(void **state) {
  (void)state;
  for (int kind = 0; kind < 2; kind++) {
    body b = body_quadratic("beam:3x2x1@1x0.4x0.3", NULL, 0, 0);
    thrum_fem fem = body_fem(&b);
    thrum_sparse pattern, mass;
    assert_int_equal(thrum_fem_pattern(&fem, &pattern, NULL), THRUM_OK);
    assert_int_equal(thrum_fem_mass(&fem, (thrum_mass)kind, &pattern, &mass, NULL), THRUM_OK);

    // 1 M 1 along an axis is the mass, and the row sums are those that gravity takes
    const int64_t n = fem.free_count;
    double *one = need((size_t)n, sizeof *one), *product = need((size_t)n, sizeof *product);
    double *rows = need((size_t)fem.vertex_count, sizeof *rows);
    for (int64_t i = 0; i < n; i++)
      one[i] = fem.component[i] % 3 == 1;
    thrum_sparse_product(&mass, one, 1, product);
    assert_close(dot_of(one, product, n), 1000 * 0.12, 1e-13);
    thrum_fem_vertex_mass(&fem, (thrum_mass)kind, rows);
    for (int64_t i = 0; i < n; i++)
      if (fem.component[i] % 3 == 1)
        assert_true(fabs(product[i] - rows[fem.component[i] / 3]) < 1e-14 * 120);

    // consistent: the square of a quadratic field, x^2, over 0..1
    if (kind == THRUM_MASS_CONSISTENT) {
      for (int64_t i = 0; i < n; i++) {
        const double x = fem.vertices[3 * (int64_t)(fem.component[i] / 3)];
        one[i] *= x * x;
      }
      thrum_sparse_product(&mass, one, 1, product);
      assert_close(dot_of(one, product, n), 120.0 / 5, 1e-13);
    }

    // lumped: diagonal, and no node is without mass
    for (int64_t j = 0; j < n && kind == THRUM_MASS_LUMPED; j++)
      assert_true(mass.begin[j + 1] - mass.begin[j] == 1 && mass.value[mass.begin[j]] > 0);

    free(one);
    free(product);
    free(rows);
    thrum_sparse_free(&pattern);
    thrum_sparse_free(&mass);
    thrum_fem_free(&fem);
    body_free(&b);
  }
}

/* V_r(q) = V(U q), R = U^T R_full, T = U^T K_full U. */
static void compare_with_full_order(body b, int64_t modes, int64_t rank) {
  thrum_precomputed result = body_precompute(&b, modes, rank);
  const thrum_model *model = &result.model;
  thrum_fem fem = body_fem(&b);
  const int64_t count = 3 * fem.vertex_count, n = fem.free_count;
  double *u = need((size_t)count, sizeof *u), *full = need((size_t)count, sizeof *full);
  double *force = need((size_t)rank, sizeof *force), *wanted = need((size_t)rank, sizeof *wanted);
  double *tangent = need((size_t)(rank * rank), sizeof *tangent);
  double *wanted_tangent = need((size_t)(rank * rank), sizeof *wanted_tangent);
  double *columns = need((size_t)(n * rank), sizeof *columns);
  double *product = need((size_t)(n * rank), sizeof *product);
  double *work = need(thrum_work_count(model), sizeof *work);
  thrum_sparse stiffness;
  assert_int_equal(thrum_fem_pattern(&fem, &stiffness, NULL), THRUM_OK);
  for (int64_t i = 0; i < rank; i++)
    for (int64_t c = 0; c < n; c++)
      columns[i * n + c] = model->basis[fem.component[c] * rank + i];

  // from nearly linear to far beyond, where the cubic and quartic parts dominate
  for (double size = 1e-4; size < 1e7; size *= 1e3) {
    double *q = random_vector(rank, 1);
    for (int64_t i = 0; i < rank; i++)
      q[i] *= sqrt(2 * size / model->omega2[i]);
    for (int64_t c = 0; c < count; c++)
      u[c] = dot_of(model->basis + c * rank, q, rank);
    const double energy = thrum_fem_energy(&fem, u, full);
    memset(wanted, 0, sizeof *wanted * (size_t)rank);
    for (int64_t c = 0; c < count; c++)
      for (int64_t i = 0; i < rank; i++)
        wanted[i] += model->basis[c * rank + i] * full[c];

    assert_close(thrum_internal_force(model, q, force, work), energy, 1e-12);
    assert_near(force, wanted, rank, 1e-12);
    thrum_tangent_stiffness(model, q, tangent, work);
    assert_int_equal(thrum_fem_stiffness(&fem, u, &stiffness, NULL), THRUM_OK);
    thrum_sparse_product(&stiffness, columns, rank, product);
    for (int64_t i = 0; i < rank; i++)
      for (int64_t j = 0; j < rank; j++)
        wanted_tangent[i * rank + j] = dot_of(columns + i * n, product + j * n, n);
    assert_near(tangent, wanted_tangent, rank * rank, 1e-12);
    free(q);
  }

  free(u);
  free(full);
  free(force);
  free(wanted);
  free(tangent);
  free(wanted_tangent);
  free(columns);
  free(product);
  free(work);
  thrum_sparse_free(&stiffness);
  thrum_fem_free(&fem);
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void reduced_energy_force_and_tangent_are_those_of_the_full_order(void **state) {
  (void)state;
  compare_with_full_order(body_quadratic("beam:6x2x1@1x0.2x0.15", "x<0.001", 0, 0), 6, 14);
  compare_with_full_order(body_quadratic("beam:6x2x1@1x0.2x0.15", "x<0.02", 0.004, 0.008), 6, 14);
  compare_with_full_order(body_quadratic("beam:4x2x1@1x0.3x0.2", NULL, 0, 0.01), 6, 14);
}

/* The first two frequencies of bending [Hz] of a cantilever of length 1 and thickness 0.1, clamped
 * against axial motion only at its end's middle line, so that nu = 0 beam theory is exact. */
static void cantilever(int cells, double found[2]) {
  char name[100];
  snprintf(name, sizeof name, "beam:%dx%dx%d@1x0.1x0.1", 10 * cells, cells, cells);
  body b = body_quadratic(name, "x<0.0001", 0, 0);
  b.mesh.materials[0].poisson = 0;
  thrum_precomputed result = body_precompute(&b, 4, 4);
  found[0] = sqrt(result.mode_omega2[0]) / TWO_PI;
  found[1] = sqrt(result.mode_omega2[2]) / TWO_PI;
  thrum_precomputed_free(&result);
  body_free(&b);
}

/* Timoshenko's cantilever: u = (w, phi) solved by shooting. With k the wave numbers the determinant
 * of the end conditions vanishes; here by bisection around the frequency of Euler's beam. */
static double timoshenko_determinant(double omega) {
  // E = 5e6 Pa, nu = 0, rho = 1000, square section h = 0.1, L = 1; kappa = 5/6
  const double young = 5e6, shear = young / 2, rho = 1000, h = 0.1, length = 1;
  const double area = h * h, inertia = h * h * h * h / 12, kappa = 5.0 / 6;

  // y = (w, phi, moment, force), y' = A y, by small steps of the classical Runge-Kutta scheme
  enum { STEPS = 2000 };
  double y[2][4] = {{0, 0, 1, 0}, {0, 0, 0, 1}};
  for (int s = 0; s < 2; s++)
    for (int n = 0; n < STEPS; n++) {
      double slope[4][4], at[4];
      for (int stage = 0; stage < 4; stage++) {
        const double part = stage == 0 ? 0 : stage == 3 ? 1 : 0.5;
        for (int c = 0; c < 4; c++)
          at[c] = y[s][c] + (stage > 0 ? part * length / STEPS * slope[stage - 1][c] : 0);
        slope[stage][0] = at[1] + at[3] / (kappa * shear * area);
        slope[stage][1] = at[2] / (young * inertia);
        slope[stage][2] = -at[3] - rho * inertia * omega * omega * at[1];
        slope[stage][3] = -rho * area * omega * omega * at[0];
      }
      for (int c = 0; c < 4; c++)
        y[s][c] +=
            length / STEPS / 6 * (slope[0][c] + 2 * slope[1][c] + 2 * slope[2][c] + slope[3][c]);
    }
  return y[0][2] * y[1][3] - y[0][3] * y[1][2];
}

static double timoshenko(double low, double high) {
  const double begin = timoshenko_determinant(TWO_PI * low);
  for (int n = 0; n < 60; n++) {
    const double middle = (low + high) / 2;
    if (timoshenko_determinant(TWO_PI * middle) * begin > 0)
      low = middle;
    else
      high = middle;
  }
  return (low + high) / 2;
}

static void cantilever_has_the_frequencies_of_timoshenko(void **state) {
  (void)state;
  const double exact[2] = {timoshenko(1, 1.3), timoshenko(6, 7.5)};
  static const double allowed[2] = {0.015, 0.002};
  for (int cells = 1; cells <= 2; cells++) {
    double found[2];
    cantilever(cells, found);
    for (int n = 0; n < 2; n++) {
      const double error = found[n] / exact[n] - 1;
      print_message("f%d %.5f Hz, Timoshenko %.5f Hz: %+.3f %% with %d cells over the thickness\n",
                    n + 1, found[n], exact[n], 100 * error, cells);
      assert_true(fabs(error) < allowed[cells - 1]);
    }
  }
}

/* The axial frequencies of a bar that slides in frictionless sides have no singularity: omega =
 * pi/2 sqrt(E/rho)/L with nu = 0, and the error falls with the fourth power of the size. */
static void error_of_a_smooth_mode_falls_with_the_fourth_power(void **state) {
  (void)state;
  double error[3];

  // each mesh halves the size of the one before
  for (int n = 0; n < 3; n++) {
    char name[100];
    const int cells = 1 << n;
    snprintf(name, sizeof name, "beam:%dx%dx%d@1x0.5x0.5", 2 * cells, cells, cells);
    body b = body_quadratic(name, "x<0.0001", 0, 0);
    b.mesh.materials[0].poisson = 0;
    for (int64_t v = 0; v < b.mesh.vertex_count; v++)
      b.fixed[v] |= 6; // only x is free
    thrum_precomputed result = body_precompute(&b, 1, 1);
    const double exact = TWO_PI / 4 * sqrt(5e6 / 1000);
    error[n] = sqrt(result.mode_omega2[0]) / exact - 1;
    thrum_precomputed_free(&result);
    body_free(&b);
  }
  print_message("orders %.2f and %.2f\n", log2(error[0] / error[1]), log2(error[1] / error[2]));
  assert_true(log2(error[1] / error[2]) > 3.8);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rules_integrate_every_monomial_of_their_degree),
      cmocka_unit_test(curved_bodies_converge_with_the_order_of_their_points),
      cmocka_unit_test(full_order_takes_the_points_that_the_model_was_made_with),
      cmocka_unit_test(shape_functions_are_one_at_their_node_and_add_up_to_one),
      cmocka_unit_test(linear_displacements_pass_the_patch_test_on_distorted_meshes),
      cmocka_unit_test(force_and_tangent_are_derivatives_of_the_energy),
      cmocka_unit_test(mass_of_either_kind_weighs_the_body_and_is_positive),
      cmocka_unit_test(reduced_energy_force_and_tangent_are_those_of_the_full_order),
      cmocka_unit_test(cantilever_has_the_frequencies_of_timoshenko),
      cmocka_unit_test(error_of_a_smooth_mode_falls_with_the_fourth_power),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
