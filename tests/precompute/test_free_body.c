/* Free bodies: six rigid modes are kept apart, and the elastic part is independent of them
 * (design 2). SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include <lapacke.h>

#include "precompute/fem/rigid_modes.h"
#include "thrum/polynomial.h"
#include "thrum/rigid_frame.h"

// the matrices K and M of a small body in full, n x n
static void make_dense(const body *b, double **stiffness, double **mass, int *n) {
  thrum_fem fem = body_fem(b);
  thrum_sparse k = {0}, m = {0};
  assert_int_equal(thrum_fem_pattern(&fem, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&fem, NULL, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&fem, THRUM_MASS_CONSISTENT, &k, &m, NULL), THRUM_OK);

  // a product with the identity writes a sparse matrix out in full
  *n = (int)fem.free_count;
  double *unit = need((size_t)(*n * *n), sizeof *unit);
  for (int i = 0; i < *n; i++)
    unit[i * *n + i] = 1;
  *stiffness = need((size_t)(*n * *n), sizeof **stiffness);
  *mass = need((size_t)(*n * *n), sizeof **mass);
  thrum_sparse_product(&k, unit, *n, *stiffness);
  thrum_sparse_product(&m, unit, *n, *mass);

  free(unit);
  thrum_sparse_free(&k);
  thrum_sparse_free(&m);
  thrum_fem_free(&fem);
}

static void modes_are_the_whole_spectrum_behind_six_zeros(void **state) {
  (void)state;
  body b = body_make("beam:3x2x1@0.9x0.5x0.2", NULL);
  double *stiffness, *mass;
  int n;

  // the whole spectrum from a dense solver
  make_dense(&b, &stiffness, &mass, &n);
  double *values = need((size_t)n, sizeof *values);
  assert_int_equal(LAPACKE_dsygvd(LAPACK_COL_MAJOR, 1, 'N', 'U', n, stiffness, n, mass, n, values),
                   0);

  // six zeros, and then the model's values
  thrum_precomputed result = body_precompute(&b, 12, 12);
  for (int i = 0; i < 6; i++)
    assert_true(fabs(values[i]) < 1e-12 * values[n - 1]);
  for (int i = 0; i < 12; i++)
    assert_close(result.mode_omega2[i], values[6 + i], 1e-9);

  // the report states the rigid modes
  assert_int_equal(result.rigid_count, 6);
  assert_true(result.rigid_residual < 1e-14);

  // the inertia count includes the rigid modes
  assert_true(result.modes_complete);
  if (result.mode_counted)
    assert_int_equal(result.shift_count, 18);

  thrum_precomputed_free(&result);
  free(values);
  free(stiffness);
  free(mass);
  body_free(&b);
}

// largest |A^T M B - identity| or, without identity, |A^T M B|; rows x a and rows x b, row-major
static double gram_defect(const thrum_sparse *mass, const double *left, int64_t a,
                          const double *right, int64_t b, bool identity) {
  const int64_t n = mass->size;
  double *column = need((size_t)(2 * n), sizeof *column), worst = 0;

  // a column of M B at a time
  for (int64_t j = 0; j < b; j++) {
    for (int64_t i = 0; i < n; i++)
      column[i] = right[i * b + j];
    thrum_sparse_product(mass, column, 1, column + n);
    for (int64_t i = 0; i < a; i++) {
      double sum = identity && i == j ? -1 : 0;
      for (int64_t c = 0; c < n; c++)
        sum += left[c * a + i] * column[n + c];
      worst = fmax(worst, fabs(sum));
    }
  }
  free(column);
  return worst;
}

static void basis_is_mass_orthogonal_to_the_rigid_modes(void **state) {
  (void)state;
  body b = body_make("beam:8x3x2@1x0.3x0.2", NULL);

  // the consistent mass defines the scalar product
  thrum_fem fem = body_fem(&b);
  thrum_sparse k = {0}, m = {0};
  assert_int_equal(thrum_fem_pattern(&fem, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&fem, THRUM_MASS_CONSISTENT, &k, &m, NULL), THRUM_OK);

  // rigid modes and basis are orthonormal, and orthogonal to each other
  thrum_precomputed result = body_precompute(&b, 8, 30);
  const thrum_model *model = &result.model;
  assert_non_null(model->rigid);
  assert_true(gram_defect(&m, model->rigid, 6, model->rigid, 6, true) < 1e-13);
  assert_true(gram_defect(&m, model->basis, 30, model->basis, 30, true) < 1e-12);
  assert_true(gram_defect(&m, model->rigid, 6, model->basis, 30, false) < 1e-11);

  // so uniform acceleration moves no elastic coordinate
  for (int64_t i = 0; i < 3 * model->rank; i++)
    assert_true(fabs(model->axis_mass[i]) < 1e-11 * sqrt(result.mass));

  thrum_precomputed_free(&result);
  thrum_sparse_free(&k);
  thrum_sparse_free(&m);
  thrum_fem_free(&fem);
  body_free(&b);
}

static void it_turns_about_its_centre_with_its_inertia(void **state) {
  (void)state;
  const double side[3] = {1, 0.3, 0.2};
  body b = body_make("beam:8x3x2@1x0.3x0.2", NULL);
  thrum_precomputed result = body_precompute(&b, 3, 3);

  // the rigid frame of a box is known in closed form
  thrum_rigid_frame rigid_frame;
  assert_int_equal(thrum_rigid_frame_of(&result.model, &rigid_frame, NULL), THRUM_OK);
  for (int i = 0; i < 3; i++) {
    // its centre is the middle of the box
    double least = INFINITY, most = -INFINITY;
    for (int64_t v = 0; v < b.mesh.vertex_count; v++) {
      least = fmin(least, b.mesh.vertices[3 * v + i]);
      most = fmax(most, b.mesh.vertices[3 * v + i]);
    }
    assert_true(fabs(rigid_frame.centre[i] - 0.5 * (least + most)) <= 1e-12);

    // its inertia is a box's, without products of inertia
    const double y = side[(i + 1) % 3], z = side[(i + 2) % 3];
    assert_close(rigid_frame.inverse[4 * i], 12 / (result.mass * (y * y + z * z)), 1e-11);
    assert_true(fabs(rigid_frame.inverse[3 * i + (i + 1) % 3]) <=
                1e-11 * rigid_frame.inverse[4 * i]);
  }

  thrum_precomputed_free(&result);
  body_free(&b);
}

static void energy_is_that_of_the_whole_body_however_it_is_turned(void **state) {
  (void)state;
  body b = body_make("beam:6x2x2@1x0.3x0.2", NULL);
  thrum_fem fem = body_fem(&b);
  thrum_precomputed result = body_precompute(&b, 6, 12);
  const thrum_model *model = &result.model;
  const int64_t rows = 3 * model->vertex_count;

  // a large deformation along the basis
  double *q = random_vector(model->rank, 1);
  for (int64_t i = 0; i < model->rank; i++)
    q[i] *= 3 / sqrt(model->omega2[i]);
  double *u = need((size_t)rows, sizeof *u);
  for (int64_t c = 0; c < rows; c++)
    u[c] = dot_of(model->basis + c * model->rank, q, model->rank);

  // the reduced energy equals the full-order one
  double *work = need(thrum_work_count(model), sizeof *work);
  const double reduced = thrum_strain_energy(model, q, work);
  assert_close(reduced, thrum_fem_energy(&fem, u, NULL), 1e-11);

  // a finite rotation and a shift, x -> R (x + u) + d, leave the energy as it is
  const double c = cos(1.2), s = sin(1.2);
  for (int64_t v = 0; v < model->vertex_count; v++) {
    const double *rest = model->vertices + 3 * v;
    const double x = rest[0] + u[3 * v], y = rest[1] + u[3 * v + 1];
    u[3 * v] = c * x - s * y + 0.3 - rest[0];
    u[3 * v + 1] = s * x + c * y - 0.2 - rest[1];
  }

  assert_close(reduced, thrum_fem_energy(&fem, u, NULL), 1e-11);
  free(q);
  free(u);
  free(work);
  thrum_precomputed_free(&result);
  thrum_fem_free(&fem);
  body_free(&b);
}

static void derivatives_solve_the_singular_system(void **state) {
  (void)state;

  // a mode and its derivative: the second derivative of the force vanishes along the basis, so the
  // condensed quartic of a pair of rank 2 cannot exceed that of the mode alone
  body b = body_make("beam:10x2x2@1x0.1x0.08", NULL);
  thrum_precomputed one = body_precompute(&b, 1, 1), two = body_precompute(&b, 1, 2);
  const double locked = one.model.c4[0], w2 = two.model.omega2[1];

  // V = 1/2 w1^2 x^2 + 1/2 w2^2 y^2 + c x^2 y + d x^4 has, along its valley, d - c^2 / (2 w2^2)
  const double c = two.model.c3[thrum_c3_index(2, 0, 0, 1)];
  const double relaxed = two.model.c4[thrum_c4_index(2, 0, 0, 0, 0)] - c * c / (2 * w2);

  // a free beam bends freely: almost nothing of the locked quartic remains, nothing negative
  assert_true(locked > 0 && relaxed > -1e-9 * locked && relaxed < 0.02 * locked);
  thrum_precomputed_free(&one);
  thrum_precomputed_free(&two);
  body_free(&b);
}

// relative errors of the first two bending frequencies of a free-free beam of L/h = 20
static void beam_errors(int cells, double error[2]) {
  const double root[2] = {22.3732854481, 61.6728228686};
  char name[100];
  snprintf(name, sizeof name, "beam:%dx%dx%d@1x0.05x0.04", 20 * cells, cells, cells);
  body b = body_make(name, NULL);
  b.mesh.materials[0].poisson = 0;
  const thrum_material material = b.mesh.materials[0];
  thrum_precomputed result = body_precompute(&b, 4, 4);
  // bending across the thin side comes first and third
  const double unit = sqrt(material.young * 0.04 * 0.04 / 12 / material.density) / TWO_PI;
  for (int i = 0; i < 2; i++)
    error[i] = sqrt(result.mode_omega2[2 * i]) / TWO_PI / (root[i] * unit) - 1;
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void frequencies_approach_those_of_the_free_slender_beam(void **state) {
  (void)state;
  double coarse[2], fine[2];
  beam_errors(3, coarse);
  beam_errors(6, fine);
  for (int i = 0; i < 2; i++) {
    print_message("error of bending %d: %.2f %% with 3 cells, %.2f %% with 6\n", i + 1,
                  100 * coarse[i], 100 * fine[i]);
    assert_true(fine[i] > 0 && coarse[i] > 2.5 * fine[i]);
    assert_true(fine[i] < 0.08);
  }
}

// a ball of cells^3 cells: a cube whose shells are mapped to spheres
static body make_ball(int cells, double radius) {
  char name[100];
  snprintf(name, sizeof name, "beam:%dx%dx%d@2x2x2", cells, cells, cells);
  body ball = body_make(name, NULL);
  for (int64_t v = 0; v < ball.mesh.vertex_count; v++) {
    double *p = ball.mesh.vertices + 3 * v;
    const double x = p[0] - 1, y = p[1], z = p[2];
    p[0] = radius * x * sqrt(1 - y * y / 2 - z * z / 2 + y * y * z * z / 3);
    p[1] = radius * y * sqrt(1 - z * z / 2 - x * x / 2 + z * z * x * x / 3);
    p[2] = radius * z * sqrt(1 - x * x / 2 - y * y / 2 + x * x * y * y / 3);
  }
  ball.mesh.materials[0] = (thrum_material){1e8, 0.3, 1e4};
  return ball;
}

static void solid_sphere_has_the_published_clusters(void **state) {
  (void)state;

  // Code_Aster SDLV401: 2468.71 Hz five times, 2611.91 five times, 3484.23 three, 3814.60 seven
  const double hertz[] = {2468.71, 2611.91, 3484.23, 3814.60};
  const int times[] = {5, 5, 3, 7}, cells[] = {6, 12};
  double worst[2] = {0};

  // the errors of the twenty lowest elastic modes on two meshes
  for (int n = 0; n < 2; n++) {
    body ball = make_ball(cells[n], 0.01);
    thrum_precomputed result = body_precompute(&ball, 20, 20);
    for (int cluster = 0, mode = 0; cluster < 4; cluster++)
      for (int i = 0; i < times[cluster]; i++, mode++)
        worst[n] =
            fmax(worst[n], fabs(sqrt(result.mode_omega2[mode]) / TWO_PI / hertz[cluster] - 1));
    assert_true(result.modes_complete);
    thrum_precomputed_free(&result);
    body_free(&ball);
  }

  // the error falls with the refinement, as linear tetrahedra allow
  print_message("largest error: %.2f %% with 6 cells, %.2f %% with 12\n", 100 * worst[0],
                100 * worst[1]);
  assert_true(worst[0] > 2.3 * worst[1] && worst[1] < 0.08);
}

static void free_frequencies_of_a_real_mesh_agree_with_an_independent_program(void **state) {
  (void)state;
  const double hertz[] = {0.0110181, 0.0144112, 0.0189536, 0.0211656, 0.0258312, 0.0350256};
  if (!have_data("yeahright.veg")) {
    skip();
    return;
  }
  char path[1024];
  snprintf(path, sizeof path, "%s/yeahright.veg", THRUM_DATA);
  body b = body_make(path, NULL);
  thrum_precomputed result = body_precompute(&b, 6, 6);
  for (int i = 0; i < 6; i++)
    assert_close(sqrt(result.mode_omega2[i]) / TWO_PI, hertz[i], 5e-6);
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void expect_refusal(const body *b, thrum_status expected, const char *part) {
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = options.rank = 3;
  thrum_precomputed result = {.mass = 77};
  thrum_error error = {0};
  assert_int_equal(thrum_precompute(&b->mesh, b->fixed, &options, &result, &error), expected);
  assert_true(result.mass == 77);
  if (!strstr(error.message, part) || strchr(error.message, '\n'))
    fail_msg("'%s' does not say '%s' in one line", error.message, part);
}

// two cubes of one cell; the second is the first moved by (x, y), and they share equal vertices
static body make_pair(double x, double y) {
  body one = body_make("beam:1x1x1@1x1x1", NULL), pair = {.mesh = one.mesh};

  // room for both cubes; the mesh begins as the first one
  const int64_t v = one.mesh.vertex_count, t = one.mesh.tet_count;
  pair.mesh.vertices = need((size_t)(6 * v), sizeof(double));
  pair.mesh.tets = need((size_t)(8 * t), sizeof(int32_t));
  pair.mesh.tet_region = need((size_t)(2 * t), sizeof(int32_t));
  pair.mesh.materials = need(1, sizeof *pair.mesh.materials);
  pair.mesh.materials[0] = one.mesh.materials[0];
  pair.mesh.groups = NULL;
  pair.mesh.group_count = 0;
  pair.mesh.vertex_count = v;
  pair.mesh.tet_count = 2 * t;
  memcpy(pair.mesh.vertices, one.mesh.vertices, sizeof(double) * (size_t)(3 * v));

  // the second cube's vertices are the first's where they coincide, and new ones elsewhere
  int32_t index[8];
  for (int64_t i = 0; i < v; i++) {
    const double *p = one.mesh.vertices + 3 * i;
    const double moved[3] = {p[0] + x, p[1] + y, p[2]};
    index[i] = -1;
    for (int64_t j = 0; j < v; j++)
      if (memcmp(moved, one.mesh.vertices + 3 * j, sizeof moved) == 0)
        index[i] = (int32_t)j;
    if (index[i] < 0) {
      index[i] = (int32_t)pair.mesh.vertex_count;
      memcpy(pair.mesh.vertices + 3 * pair.mesh.vertex_count++, moved, sizeof moved);
    }
  }

  // the second cube's tetrahedra refer to those vertices
  for (int64_t i = 0; i < 4 * t; i++) {
    pair.mesh.tets[i] = one.mesh.tets[i];
    pair.mesh.tets[4 * t + i] = index[one.mesh.tets[i]];
  }
  pair.fixed = need((size_t)pair.mesh.vertex_count, 1);

  body_free(&one);
  return pair;
}

static void several_free_parts_and_hinges_are_refused(void **state) {
  (void)state;
  body apart = make_pair(3, 0), hinged = make_pair(1, 1), joined = make_pair(1, 0);

  // the cubes are apart
  expect_refusal(&apart, THRUM_UNSUPPORTED, "2 separate parts");

  // sharing an edge, the cubes are one part that can still fold
  expect_refusal(&hinged, THRUM_SINGULAR, "mend the mesh");

  // sharing a face, they are one body
  thrum_precomputed result = body_precompute(&joined, 3, 3);
  assert_int_equal(result.rigid_count, 6);
  thrum_precomputed_free(&result);

  // one part held, the other one free
  for (int64_t v = 0; v < 8; v++)
    apart.fixed[v] = apart.mesh.vertices[3 * v] < 0.5 ? 7 : 0;
  expect_refusal(&apart, THRUM_SINGULAR, "6 rigid motions");

  body_free(&apart);
  body_free(&hinged);
  body_free(&joined);
}

static void springs_leave_no_trace(void **state) {
  (void)state;
  body b = body_make("beam:3x2x2@1x0.3x0.2", NULL);
  thrum_fem fem = body_fem(&b);

  // the stiffness before any spring
  thrum_sparse k = {0};
  thrum_support_springs springs;
  assert_int_equal(thrum_fem_pattern(&fem, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&fem, NULL, &k, NULL), THRUM_OK);
  const size_t bytes = sizeof(double) * (size_t)k.begin[k.size];
  double *before = need((size_t)k.begin[k.size], sizeof *before);
  memcpy(before, k.value, bytes);

  // with springs at the supports a free body's stiffness has a Cholesky factor
  thrum_support_springs_add(&fem, &k, &springs);
  assert_memory_not_equal(before, k.value, bytes);
  thrum_factor *factor = NULL;
  assert_int_equal(thrum_factor_create(&k, &factor, NULL), THRUM_OK);
  thrum_factor_free(factor);

  // their removal restores the matrix to the bit
  thrum_support_springs_remove(&springs, &k);
  assert_memory_equal(before, k.value, bytes);

  free(before);
  thrum_sparse_free(&k);
  thrum_fem_free(&fem);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(modes_are_the_whole_spectrum_behind_six_zeros),
      cmocka_unit_test(basis_is_mass_orthogonal_to_the_rigid_modes),
      cmocka_unit_test(it_turns_about_its_centre_with_its_inertia),
      cmocka_unit_test(energy_is_that_of_the_whole_body_however_it_is_turned),
      cmocka_unit_test(derivatives_solve_the_singular_system),
      cmocka_unit_test(frequencies_approach_those_of_the_free_slender_beam),
      cmocka_unit_test(solid_sphere_has_the_published_clusters),
      cmocka_unit_test(free_frequencies_of_a_real_mesh_agree_with_an_independent_program),
      cmocka_unit_test(several_free_parts_and_hinges_are_refused),
      cmocka_unit_test(springs_leave_no_trace),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
