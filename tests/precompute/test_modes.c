/* Linear modes and modal derivatives (design 2), and the requests that a precompute refuses.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include <lapacke.h>

#include "precompute/basis/eigen.h"
#include "precompute/basis/modal_derivatives.h"

typedef struct discrete {
  thrum_fem fem;
  thrum_sparse stiffness, mass;
  thrum_factor *factor;
} discrete;

static discrete discrete_make(const body *b) {
  discrete s = {.fem = body_fem(b)};
  assert_int_equal(thrum_fem_pattern(&s.fem, &s.stiffness, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&s.fem, NULL, &s.stiffness, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&s.fem, THRUM_MASS_CONSISTENT, &s.stiffness, &s.mass, NULL),
                   THRUM_OK);
  assert_int_equal(thrum_factor_create(&s.stiffness, &s.factor, NULL), THRUM_OK);
  return s;
}

static void discrete_free(discrete *s) {
  thrum_factor_free(s->factor);
  thrum_sparse_free(&s->stiffness);
  thrum_sparse_free(&s->mass);
  thrum_fem_free(&s->fem);
}

static void expect_frequencies(body b, const double *hertz) {
  thrum_precomputed result = body_precompute(&b, 10, 10);
  for (int i = 0; i < 10; i++)
    assert_close(sqrt(result.mode_omega2[i]) / TWO_PI, hertz[i], 1e-6);
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void frequencies_agree_with_an_independent_program(void **state) {
  (void)state;
  const double beam1k[] = {2.0523651, 2.3862844, 11.455826, 12.438815, 12.935337,
                           18.029483, 28.139917, 30.994754, 37.387197, 48.071742};
  expect_frequencies(body_beam1k(), beam1k);
}

static void frequencies_of_real_meshes_agree_with_an_independent_program(void **state) {
  (void)state;
  const double beam3[] = {1.5828528, 2.4169867, 9.5597511, 13.858554, 18.633136,
                          25.213077, 25.741618, 34.899530, 46.948461, 55.680014};
  const double bridge[] = {0.21721066, 0.47888777, 0.68005677, 0.79582191, 0.84150860,
                           1.5337472,  1.6325996,  1.9931969,  2.0735874,  2.2590357};
  if (!have_data("beam3_tet.veg")) {
    skip();
    return;
  }
  expect_frequencies(body_data("beam3_tet.veg", "beam3.bou"), beam3);
  expect_frequencies(body_data("simpleBridge.veg", "simpleBridge.bou"), bridge);
}

static void to_dense(const thrum_sparse *matrix, double *dense) {
  memset(dense, 0, sizeof *dense * (size_t)(matrix->size * matrix->size));
  for (int64_t j = 0; j < matrix->size; j++)
    for (int64_t e = matrix->begin[j]; e < matrix->begin[j + 1]; e++)
      dense[j * matrix->size + matrix->row[e]] = dense[matrix->row[e] * matrix->size + j] =
          matrix->value[e];
}

static void modes_are_those_of_a_dense_solver(void **state) {
  (void)state;
  body b = body_make("beam:8x2x2@1x0.2x0.15", "x<0.001");
  discrete s = discrete_make(&b);

  // room for the full matrices and their whole spectrum
  const int64_t n = s.fem.free_count, count = 40;
  double *k = need((size_t)(n * n), sizeof *k), *m = need((size_t)(n * n), sizeof *m);
  double *all = need((size_t)n, sizeof *all), *values = need((size_t)count, sizeof *values);
  double *vectors = need((size_t)(n * count), sizeof *vectors);
  double *product = need((size_t)(n * count), sizeof *product);

  // the whole spectrum from a dense solver
  to_dense(&s.stiffness, k);
  to_dense(&s.mass, m);
  assert_int_equal(LAPACKE_dsygv(LAPACK_COL_MAJOR, 1, 'N', 'U', (int)n, k, (int)n, m, (int)n, all),
                   0);

  // the same lowest values from the sparse one, and vectors orthonormal in the mass
  assert_int_equal(
      thrum_eigen_lowest(&s.stiffness, &s.mass, s.factor, count, values, vectors, NULL, NULL),
      THRUM_OK);
  for (int64_t i = 0; i < count; i++)
    assert_true(fabs(values[i] - all[i]) < 1e-13 * all[n - 1] + 1e-10 * all[i]);
  thrum_sparse_product(&s.mass, vectors, count, product);
  for (int64_t i = 0; i < count; i++)
    for (int64_t j = 0; j < count; j++)
      assert_true(fabs(dot_of(vectors + i * n, product + j * n, n) - (i == j)) < 1e-12);

  free(k);
  free(m);
  free(all);
  free(values);
  free(vectors);
  free(product);
  discrete_free(&s);
  body_free(&b);
}

static void modes_leave_no_residual(void **state) {
  (void)state;
  body b = body_beam1k();
  discrete s = discrete_make(&b);
  const int64_t n = s.fem.free_count, count = 20;
  double *values = need((size_t)count, sizeof *values),
         *residual = need((size_t)n, sizeof *residual);
  double *vectors = need((size_t)(n * count), sizeof *vectors);
  double *inertia = need((size_t)n, sizeof *inertia),
         *reported = need((size_t)count, sizeof(double));

  // the modes and the residuals that the library reports for them
  assert_int_equal(
      thrum_eigen_lowest(&s.stiffness, &s.mass, s.factor, count, values, vectors, NULL, NULL),
      THRUM_OK);
  assert_int_equal(
      thrum_eigen_residuals(&s.stiffness, &s.mass, count, values, vectors, reported, NULL),
      THRUM_OK);

  // the residual K psi - omega^2 M psi, computed here
  for (int64_t i = 0; i < count; i++) {
    thrum_sparse_product(&s.stiffness, vectors + i * n, 1, residual);
    thrum_sparse_product(&s.mass, vectors + i * n, 1, inertia);
    for (int64_t c = 0; c < n; c++)
      residual[c] -= values[i] * inertia[c];

    // relative to the mode's own inertia force, a sharper scale than |K||psi|
    assert_true(norm_of(residual, n) < 1e-9 * values[i] * norm_of(inertia, n));
    assert_true(reported[i] < 1e-14);
  }

  free(values);
  free(residual);
  free(vectors);
  free(inertia);
  free(reported);
  discrete_free(&s);
  body_free(&b);
}

static void a_cluster_is_the_same_however_it_was_found(void **state) {
  (void)state;

  // two pairs of equal values and a single one keep their canonical form when rotated or reflected
  enum { ROWS = 50, COUNT = 5 };
  const double values[COUNT] = {1, 1, 2, 3, 3};
  double *vectors = random_vector(ROWS * COUNT, 1), turned[ROWS * COUNT];

  // each pair is mixed by an orthogonal map, the single vector changes its sign
  for (int row = 0; row < ROWS; row++) {
    const double *v = vectors + row;
    turned[row] = 0.6 * v[0] - 0.8 * v[ROWS];
    turned[row + ROWS] = -0.8 * v[0] - 0.6 * v[ROWS];
    turned[row + 2 * ROWS] = -v[2 * ROWS];
    turned[row + 3 * ROWS] = v[4 * ROWS];
    turned[row + 4 * ROWS] = -v[3 * ROWS];
  }

  // the canonical form is the same
  thrum_eigen_canonicalise(ROWS, COUNT, values, 1e-9, vectors, 1, ROWS);
  thrum_eigen_canonicalise(ROWS, COUNT, values, 1e-9, turned, 1, ROWS);
  for (int column = 0; column < COUNT; column++) {
    double largest = 0;
    for (int row = 0; row < ROWS; row++) {
      const double x = vectors[row + column * ROWS];
      largest = fabs(x) > fabs(largest) ? x : largest;
    }

    // the second of a pair gets its sign from its own largest entry
    assert_true(largest > 0);
  }
  assert_near(turned, vectors, ROWS * COUNT, 1e-14);

  free(vectors);
}

/* Derivatives of `count` modes against differences of the force at `step` times these. */
static void check_derivatives(const body *b, thrum_law law, int64_t count, double step,
                              double tolerance) {
  discrete s = discrete_make(b);
  s.fem.law = law;

  // room for the modes, their derivatives and the check of each pair
  const int64_t n = s.fem.free_count, all = 3 * s.fem.vertex_count;
  const int64_t pairs = count * (count + 1) / 2;
  double *values = need((size_t)count, sizeof *values);
  double *modes = need((size_t)(n * count), sizeof *modes);
  double *phi = need((size_t)(n * pairs), sizeof *phi), *product = need((size_t)n, sizeof *product);
  double *free_u = need((size_t)n, sizeof *free_u), *u = need((size_t)all, sizeof *u);
  double *force = need((size_t)all, sizeof *force), *second = need((size_t)n, sizeof *second);

  // modes, and the derivative of every pair of modes
  assert_int_equal(
      thrum_eigen_lowest(&s.stiffness, &s.mass, s.factor, count, values, modes, NULL, NULL),
      THRUM_OK);
  assert_int_equal(thrum_derivatives(&s.fem, s.factor, count, modes, phi, NULL, NULL), THRUM_OK);

  // each derivative is the static response to the mixed second derivative of the force
  for (int64_t i = 0, pair = 0; i < count; i++)
    for (int64_t j = i; j < count; j++, pair++) {
      // differences over the four sign choices give the mixed second derivative
      memset(second, 0, sizeof *second * (size_t)n);
      for (int choice = 0; choice < 4; choice++) {
        const double p = choice & 1 ? -1 : 1, q = choice & 2 ? -1 : 1;
        for (int64_t c = 0; c < n; c++)
          free_u[c] = step * (p * modes[i * n + c] + q * modes[j * n + c]);
        thrum_fem_scatter(&s.fem, free_u, u);
        thrum_fem_energy(&s.fem, u, force);
        thrum_fem_gather(&s.fem, force, free_u);
        for (int64_t c = 0; c < n; c++)
          second[c] -= p * q * free_u[c] / (4 * step * step);
      }

      // K Phi_ij = -d^2 R / dq_i dq_j
      thrum_sparse_product(&s.stiffness, phi + pair * n, 1, product);
      assert_near(product, second, n, tolerance);
    }

  free(values);
  free(modes);
  free(phi);
  free(product);
  free(free_u);
  free(u);
  free(force);
  free(second);
  discrete_free(&s);
}

static void derivatives_balance_the_second_derivative_of_the_force(void **state) {
  (void)state;
  body b = body_make("beam:6x2x2@1x0.2x0.15", "x<0.001");
  body quadratic = body_quadratic("beam:3x1x1@1x0.2x0.2", "x<0.02", 0.003, 0.003);
  b.mesh.materials[0].poisson = 0.3;

  // R of Saint Venant-Kirchhoff material is a cubic, so differences are exact at any step
  check_derivatives(&b, THRUM_LAW_STVK, 9, 1, 1e-9);
  for (int law = THRUM_LAW_COROTATIONAL; law <= THRUM_LAW_NEO_HOOKEAN; law++) {
    check_derivatives(&b, (thrum_law)law, 3, 1e-3, 1e-4);
    check_derivatives(&quadratic, (thrum_law)law, 3, 1e-3, 1e-4);
  }

  // each region has its own
  body_divide(&b, 1);
  body_divide(&quadratic, 1);
  check_derivatives(&b, THRUM_LAW_BY_REGION, 3, 1e-3, 1e-4);
  check_derivatives(&quadratic, THRUM_LAW_BY_REGION, 3, 1e-3, 1e-4);
  body_free(&b);
  body_free(&quadratic);
}

static void expect_refusal(const body *b, int64_t modes, int64_t rank, thrum_status expected,
                           const char *part) {
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = modes;
  options.rank = rank;
  thrum_precomputed result = {.mass = 77};
  thrum_error error = {0};
  assert_int_equal(thrum_precompute(&b->mesh, b->fixed, &options, &result, &error), expected);
  assert_int_equal(error.status, expected);
  assert_true(result.mass == 77);
  if (!strstr(error.message, part) || strchr(error.message, '\n'))
    fail_msg("'%s' does not say '%s' in one line", error.message, part);
}

static void a_body_that_can_move_rigidly_is_refused(void **state) {
  (void)state;
  body b = body_make("beam:3x1x1@3x1x1", NULL);

  // a held vertex leaves three rotations, a held edge one; sliding in a plane leaves two shifts and
  // one rotation
  b.fixed[0] = 7;
  expect_refusal(&b, 3, 3, THRUM_SINGULAR, "3 rigid motions");
  b.fixed[1] = 7;
  expect_refusal(&b, 3, 3, THRUM_SINGULAR, "1 rigid motions");
  b.fixed[0] = b.fixed[1] = b.fixed[2] = b.fixed[3] = 1;
  expect_refusal(&b, 3, 3, THRUM_SINGULAR, "3 rigid motions");

  // one clamped face is enough
  b.fixed[0] = b.fixed[1] = b.fixed[2] = b.fixed[3] = 7;
  thrum_precomputed result = body_precompute(&b, 3, 3);
  thrum_precomputed_free(&result);

  // nothing is free to move
  memset(b.fixed, 7, (size_t)b.mesh.vertex_count);
  expect_refusal(&b, 3, 3, THRUM_INVALID_ARGUMENT, "every vertex is fixed");

  body_free(&b);
}

// a body and its copy, shifted along y, that shares no vertex with it; only the first is fixed
static body make_twin(const body *one) {
  const int64_t v = one->mesh.vertex_count, t = one->mesh.tet_count;

  // arrays of twice the size, one region, no groups
  body two = {.mesh = one->mesh};
  two.mesh.vertex_count = 2 * v;
  two.mesh.tet_count = 2 * t;
  two.mesh.vertices = need((size_t)(6 * v), sizeof(double));
  two.mesh.tets = need((size_t)(8 * t), sizeof(int32_t));
  two.mesh.tet_region = need((size_t)(2 * t), sizeof(int32_t));
  two.mesh.group_count = 0;
  two.fixed = need((size_t)(2 * v), 1);

  // the copy is the body shifted along y, with its own vertices
  for (int64_t i = 0; i < 6 * v; i++)
    two.mesh.vertices[i] = one->mesh.vertices[i % (3 * v)] + (i >= 3 * v && i % 3 == 1 ? 4 : 0);
  for (int64_t i = 0; i < 8 * t; i++)
    two.mesh.tets[i] = one->mesh.tets[i % (4 * t)] + (i >= 4 * t ? (int32_t)v : 0);
  memcpy(two.fixed, one->fixed, (size_t)v);
  return two;
}

static void free_twin(body *two) {
  free(two->mesh.vertices);
  free(two->mesh.tets);
  free(two->mesh.tet_region);
  free(two->fixed);
}

static void every_part_of_a_mesh_must_be_held(void **state) {
  (void)state;
  body one = body_make("beam:2x1x1@1x0.2x0.2", "x<0.01"), two = make_twin(&one);
  expect_refusal(&two, 3, 3, THRUM_SINGULAR, "6 rigid motions of the part around (0.5, 4, ");

  // with both parts held alike, every frequency occurs twice
  memcpy(two.fixed + one.mesh.vertex_count, one.fixed, (size_t)one.mesh.vertex_count);
  thrum_precomputed single = body_precompute(&one, 3, 3), twin = body_precompute(&two, 6, 6);
  for (int i = 0; i < 6; i++)
    assert_close(twin.mode_omega2[i], single.mode_omega2[i / 2], 1e-10);
  thrum_precomputed_free(&single);
  thrum_precomputed_free(&twin);
  free_twin(&two);
  body_free(&one);
}

static void modes_of_twin_bodies_are_those_of_each(void **state) {
  (void)state;

  // every value comes twice; the canonical pair has one mode in each body
  body one = body_make("beam:4x1x2@1x0.1x0.2", "x<0.01"), two = make_twin(&one);
  memcpy(two.fixed + one.mesh.vertex_count, one.fixed, (size_t)one.mesh.vertex_count);

  // the modes of both bodies together
  discrete s = discrete_make(&two);
  const int64_t n = s.fem.free_count, half = n / 2, count = 8;
  double *values = need((size_t)count, sizeof *values);
  double *vectors = need((size_t)(n * count), sizeof *vectors);
  assert_int_equal(
      thrum_eigen_lowest(&s.stiffness, &s.mass, s.factor, count, values, vectors, NULL, NULL),
      THRUM_OK);

  // each mode moves one of the bodies alone, the first body's mode first
  for (int64_t i = 0; i < count; i++) {
    const double *mode = vectors + i * n;
    const double first = norm_of(mode, half), second = norm_of(mode + half, half);
    assert_true(fmin(first, second) < 1e-6 * fmax(first, second));
    assert_true((first > second) == (i % 2 == 0));
  }

  free(values);
  free(vectors);
  discrete_free(&s);
  free_twin(&two);
  body_free(&one);
}

static void rank_beyond_the_span_is_refused_with_the_rank_to_be_had(void **state) {
  (void)state;
  // each part contributes its lowest mode and that mode's derivative; mixed derivatives vanish
  body one = body_make("beam:4x1x2@1x0.1x0.2", "x<0.01"), two = make_twin(&one);
  memcpy(two.fixed + one.mesh.vertex_count, one.fixed, (size_t)one.mesh.vertex_count);
  expect_refusal(&two, 2, 5, THRUM_INVALID_ARGUMENT, "they have rank 4");
  thrum_precomputed result = body_precompute(&two, 2, 4);
  assert_true(result.basis_orthonormality < 1e-12);
  thrum_precomputed_free(&result);
  free_twin(&two);
  body_free(&one);
}

static void a_hinge_is_refused(void **state) {
  (void)state;

  // a second tetrahedron is attached to the held first one by an edge and can rotate about it
  double vertices[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.3, -1, -0.1, 0.8, -0.9, -0.8};
  int32_t tets[] = {0, 1, 2, 3, 0, 1, 4, 5}, regions[] = {0, 0};
  thrum_material material = {1e6, 0.3, 1000};
  thrum_mesh mesh = {.vertex_count = 6,
                     .vertices = vertices,
                     .tet_count = 2,
                     .tets = tets,
                     .tet_region = regions,
                     .region_count = 1,
                     .materials = &material,
                     .has_material = true};

  // two corners are exchanged if the second tetrahedron is inverted
  if (thrum_mesh_tet_volume(&mesh, 1) < 0) {
    tets[6] = 5;
    tets[7] = 4;
  }

  // the first tetrahedron is held; the second can still rotate
  uint8_t fixed[6] = {0, 7, 7, 7, 0, 0};
  const body b = {.mesh = mesh, .fixed = fixed};
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = options.rank = 2;
  thrum_precomputed result = {0};
  thrum_error error = {0};
  assert_int_equal(thrum_precompute(&b.mesh, b.fixed, &options, &result, &error), THRUM_SINGULAR);
  assert_non_null(strstr(error.message, "--fix"));
}

/* Near 1/2 the shear stiffness is lost in the rounding of the other; no support would mend that. */
static void a_poisson_ratio_that_hides_the_shear_is_named(void **state) {
  (void)state;
  body b = body_make("beam:8x2x2@1x0.1x0.1", "x<0.001");
  b.mesh.materials[0].poisson = 0.4999999999999999;
  expect_refusal(&b, 3, 3, THRUM_SINGULAR, "so near 1/2");
  b.mesh.materials[0].poisson = 0.49999999999999;
  expect_refusal(&b, 3, 3, THRUM_SINGULAR, "so near 1/2");
  body_free(&b);
}

static void more_modes_or_rank_than_there_are_is_refused(void **state) {
  (void)state;
  body b = body_make("beam:1x1x1@1x1x1", "x<0.01");

  // numbers out of range, and more modes than the mesh has components
  expect_refusal(&b, 0, 1, THRUM_INVALID_ARGUMENT, "modes is 0");
  expect_refusal(&b, 3, -1, THRUM_INVALID_ARGUMENT, "rank is -1");
  expect_refusal(&b, 3, 10, THRUM_INVALID_ARGUMENT, "give (9)");
  expect_refusal(&b, 12, 3, THRUM_INVALID_ARGUMENT, "12 free components");
  expect_refusal(&b, 100, 3, THRUM_INVALID_ARGUMENT, "12 free components");
  expect_refusal(&b, 5, 13, THRUM_INVALID_ARGUMENT, "12 free components");

  // 9 modes and 45 derivatives span no more than the 12 components of the mesh
  thrum_precomputed result = body_precompute(&b, 9, 12);
  assert_true(result.basis_orthonormality < 1e-12);
  thrum_precomputed_free(&result);

  // without a material there is no stiffness
  b.mesh.has_material = false;
  expect_refusal(&b, 3, 3, THRUM_MISSING, "--young");

  body_free(&b);
}

typedef struct progress_log {
  int64_t calls;
  thrum_stage stop_stage;
  thrum_stage last_stage;
  double last_fraction;
  bool orderly;
} progress_log;

static bool look(void *context, thrum_stage stage, double fraction) {
  progress_log *w = context;
  w->calls++;
  if (stage < w->last_stage || (stage == w->last_stage && fraction < w->last_fraction) ||
      !(fraction >= 0 && fraction <= 1))
    w->orderly = false;
  w->last_stage = stage;
  w->last_fraction = fraction;
  return stage != w->stop_stage;
}

static void progress_goes_forward_and_stops_on_request(void **state) {
  (void)state;
  body b = body_beam1k();

  // the run is stopped at each stage in turn, and not at all in the last round
  for (int stop = 0; stop <= THRUM_STAGE_COUNT; stop++) {
    progress_log w = {.stop_stage = (thrum_stage)stop, .orderly = true};
    thrum_precompute_options options = thrum_default_precompute_options();
    options.progress = look;
    options.progress_context = &w;
    thrum_precomputed result = {0};
    const thrum_status status = thrum_precompute(&b.mesh, b.fixed, &options, &result, NULL);

    // it stops where it was asked to, or runs to its end, with progress in order
    assert_int_equal(status, stop < THRUM_STAGE_COUNT ? THRUM_INTERRUPTED : THRUM_OK);
    assert_true(w.orderly);
    assert_int_equal(w.last_stage, stop < THRUM_STAGE_COUNT ? stop : THRUM_STAGE_COUNT - 1);
    if (status == THRUM_OK)
      assert_true(w.last_fraction == 1);
    thrum_precomputed_free(&result);
  }

  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      // modes and derivatives
      cmocka_unit_test(frequencies_agree_with_an_independent_program),
      cmocka_unit_test(frequencies_of_real_meshes_agree_with_an_independent_program),
      cmocka_unit_test(modes_are_those_of_a_dense_solver),
      cmocka_unit_test(modes_leave_no_residual),
      cmocka_unit_test(a_cluster_is_the_same_however_it_was_found),
      cmocka_unit_test(derivatives_balance_the_second_derivative_of_the_force),

      // refused requests
      cmocka_unit_test(a_body_that_can_move_rigidly_is_refused),
      cmocka_unit_test(every_part_of_a_mesh_must_be_held),
      cmocka_unit_test(a_hinge_is_refused),
      cmocka_unit_test(a_poisson_ratio_that_hides_the_shear_is_named),
      cmocka_unit_test(more_modes_or_rank_than_there_are_is_refused),

      // bodies of equal parts
      cmocka_unit_test(modes_of_twin_bodies_are_those_of_each),
      cmocka_unit_test(rank_beyond_the_span_is_refused_with_the_rank_to_be_had),

      // progress
      cmocka_unit_test(progress_goes_forward_and_stops_on_request),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
