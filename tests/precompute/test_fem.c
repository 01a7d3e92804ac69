/* The full-order body, design 1: theorems of continuum mechanics that its force, energy, stiffness
 * and mass must obey. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include <lapacke.h>

#include "precompute/fem/fem_forces.h"

// u(X) = (A - 1) X + shift
static double *linear_displacement(const thrum_mesh *mesh, double a[3][3], const double shift[3]) {
  double *u = need((size_t)(3 * mesh->vertex_count), sizeof *u);
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    for (int c = 0; c < 3; c++) {
      u[3 * v + c] = shift[c] - mesh->vertices[3 * v + c];
      for (int d = 0; d < 3; d++)
        u[3 * v + c] += a[c][d] * mesh->vertices[3 * v + d];
    }
  return u;
}

static void rotation(double angle, double r[3][3]) {
  // about (1, 2, 3), by Rodrigues' formula
  const double length = sqrt(14), x = 1 / length, y = 2 / length, z = 3 / length;
  const double cross[3][3] = {{0, -z, y}, {z, 0, -x}, {-y, x, 0}};
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      double square = 0;
      for (int e = 0; e < 3; e++)
        square += cross[c][e] * cross[e][d];
      r[c][d] = (c == d) + sin(angle) * cross[c][d] + (1 - cos(angle)) * square;
    }
}

static void rigid_rotation_gives_zero_force(void **state) {
  (void)state;
  body b = body_beam1k();
  thrum_fem fem = body_fem(&b);
  const int64_t count = 3 * fem.vertex_count;

  // a finite rotation and a shift
  double r[3][3];
  rotation(1.1, r);
  double *u = linear_displacement(&b.mesh, r, (double[]){0.3, -0.2, 5});
  double *force = need((size_t)count, sizeof *force);
  const double energy = thrum_fem_energy(&fem, u, force);

  // half of that displacement is no rotation: its force and energy set the scale
  double *scale = need((size_t)count, sizeof *scale);
  for (int64_t i = 0; i < count; i++)
    u[i] *= 0.5;
  const double energy_scale = thrum_fem_energy(&fem, u, scale);
  assert_true(norm_of(force, count) < 1e-12 * norm_of(scale, count));
  assert_true(energy < 1e-24 * energy_scale + 1e-20);

  free(u);
  free(force);
  free(scale);
  thrum_fem_free(&fem);
  body_free(&b);
}

static bool on_surface(const double *x) {
  return x[0] < 1e-9 || x[0] > 1 - 1e-9 || fabs(x[1]) > 0.5 - 1e-9 || fabs(x[2]) > 0.5 - 1e-9;
}

static void linear_displacement_has_constant_stress_and_no_interior_force(void **state) {
  (void)state;
  body b = body_make("beam:4x3x3@1x1x1", NULL);

  // the inner vertices are moved off the grid, so that the tetrahedra differ
  for (int64_t v = 0; v < b.mesh.vertex_count; v++)
    for (int c = 0; c < 3; c++)
      if (!on_surface(b.mesh.vertices + 3 * (v)))
        b.mesh.vertices[3 * v + c] += 0.02 * random_number();

  // force and energy of one displacement gradient
  thrum_fem fem = body_fem(&b);
  double a[3][3] = {{1.2, 0.3, -0.1}, {0.05, 0.9, 0.2}, {-0.15, 0.1, 1.1}};
  double *u = linear_displacement(&b.mesh, a, (double[]){0.1, 0.2, 0.3});
  double *force = need((size_t)(3 * fem.vertex_count), sizeof *force);
  const double energy = thrum_fem_energy(&fem, u, force);

  // a constant stress leaves forces on the surface alone
  double largest = 0, inside = 0;
  int64_t inner = 0;
  for (int64_t v = 0; v < fem.vertex_count; v++) {
    const double size = norm_of(force + 3 * v, 3);
    if (on_surface(b.mesh.vertices + 3 * v)) {
      largest = fmax(largest, size);
    } else {
      inside = fmax(inside, size);
      inner++;
    }
  }
  assert_true(inner > 0);
  assert_true(inside < 1e-12 * largest);

  // the energy density of St. Venant-Kirchhoff, E = (A^T A - 1)/2, over a volume of 1
  double trace = 0, square = 0;
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      const double strain =
          (a[0][c] * a[0][d] + a[1][c] * a[1][d] + a[2][c] * a[2][d] - (c == d)) / 2;
      trace += c == d ? strain : 0;
      square += strain * strain;
    }
  assert_close(energy, fem.lambda[0] / 2 * trace * trace + fem.mu[0] * square, 1e-13);

  free(u);
  free(force);
  thrum_fem_free(&fem);
  body_free(&b);
}

static void uniaxial_stretch_meets_the_exact_force(void **state) {
  (void)state;
  body b = body_make("beam:5x2x2@2x1x1", NULL);
  b.mesh.materials[0].poisson = 0;
  thrum_fem fem = body_fem(&b);
  double *force = need((size_t)(3 * fem.vertex_count), sizeof *force);

  // compression and extension; nu = 0 keeps the cross-section
  for (double l = 0.4; l < 1.7; l += 0.2) {
    double a[3][3] = {{l, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double *u = linear_displacement(&b.mesh, a, (double[]){0, 0, 0});
    thrum_fem_energy(&fem, u, force);

    // P = E l (l^2 - 1)/2 on a cross-section of 1
    double pull = 0;
    for (int64_t v = 0; v < fem.vertex_count; v++)
      pull += b.mesh.vertices[3 * v] > 2 - 1e-9 ? force[3 * v] : 0;
    const double exact = b.mesh.materials[0].young * l * (l * l - 1) / 2;
    assert_true(fabs(pull - exact) < 1e-12 * b.mesh.materials[0].young);
    free(u);
  }

  free(force);
  thrum_fem_free(&fem);
  body_free(&b);
}

static double order_of(double error_coarse, double error_fine) {
  return log2(error_coarse / error_fine);
}

static void force_and_tangent_are_derivatives_of_the_energy(void **state) {
  (void)state;
  body b = body_make("beam:6x2x2@1x0.2x0.2", NULL);
  thrum_fem fem = body_fem(&b);
  const int64_t count = 3 * fem.vertex_count;

  // a displacement u and a direction d
  double *u = random_vector(count, 0.01), *d = random_vector(count, 0.01);
  double *at = need((size_t)count, sizeof *at), *force = need((size_t)count, sizeof *force);
  double *moved = need((size_t)count, sizeof *moved),
         *product = need((size_t)count, sizeof *product);

  // energy, force and tangent at u
  thrum_sparse tangent;
  assert_int_equal(thrum_fem_pattern(&fem, &tangent, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&fem, u, &tangent, NULL), THRUM_OK);
  thrum_sparse_product(&tangent, d, 1, product);
  const double energy = thrum_fem_energy(&fem, u, force);

  // the remainders of the Taylor series of energy and force along d
  double energy_error[4], force_error[4];
  for (int level = 0; level < 4; level++) {
    const double step = ldexp(1, -4 - level);
    for (int64_t i = 0; i < count; i++)
      at[i] = u[i] + step * d[i];
    energy_error[level] =
        fabs(thrum_fem_energy(&fem, at, moved) - energy - step * dot_of(force, d, count));
    for (int64_t i = 0; i < count; i++)
      moved[i] -= force[i] + step * product[i];
    force_error[level] = norm_of(moved, count);
  }

  // they must fall with the square of the step, three times in a row
  for (int level = 0; level < 3; level++) {
    assert_true(fabs(order_of(energy_error[level], energy_error[level + 1]) - 2) < 0.1);
    assert_true(fabs(order_of(force_error[level], force_error[level + 1]) - 2) < 0.1);
  }

  thrum_sparse_free(&tangent);
  free(u);
  free(d);
  free(at);
  free(force);
  free(moved);
  free(product);
  thrum_fem_free(&fem);
  body_free(&b);
}

static void to_dense(const thrum_sparse *matrix, double *dense) {
  memset(dense, 0, sizeof *dense * (size_t)(matrix->size * matrix->size));
  for (int64_t j = 0; j < matrix->size; j++)
    for (int64_t e = matrix->begin[j]; e < matrix->begin[j + 1]; e++)
      dense[j * matrix->size + matrix->row[e]] = dense[matrix->row[e] * matrix->size + j] =
          matrix->value[e];
}

static void regular_tetrahedron_has_its_exact_frequencies(void **state) {
  (void)state;

  // a regular tetrahedron of edge a, whose spectrum is known in closed form
  const double a = 0.37, young = 3e6, poisson = 0.31, density = 1200;
  const double height = a / sqrt(2);
  double vertices[] = {0, 0, 0, height, height, 0, height, 0, height, 0, height, height};
  int32_t tets[] = {0, 2, 1, 3}, regions[] = {0};
  thrum_material material = {young, poisson, density};
  thrum_mesh mesh = {.vertex_count = 4,
                     .vertices = vertices,
                     .tet_count = 1,
                     .tets = tets,
                     .tet_region = regions,
                     .region_count = 1,
                     .materials = &material,
                     .has_material = true};

  // assemble its matrices
  thrum_fem fem;
  thrum_sparse stiffness, mass;
  thrum_error error = {0};
  if (thrum_fem_create(&mesh, NULL, &fem, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  assert_int_equal(thrum_fem_pattern(&fem, &stiffness, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&fem, NULL, &stiffness, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&fem, THRUM_MASS_LUMPED, &stiffness, &mass, NULL), THRUM_OK);

  // all of its frequencies from a dense solver
  double k[144], m[144], values[12];
  to_dense(&stiffness, k);
  to_dense(&mass, m);
  assert_int_equal(LAPACKE_dsygv(LAPACK_COL_MAJOR, 1, 'N', 'U', 12, k, 12, m, 12, values), 0);

  // six rigid motions, five shear modes and one breathing mode
  const double shear = young / (2 * (1 + poisson)), bulk = young / (3 * (1 - 2 * poisson));
  for (int i = 0; i < 6; i++)
    assert_true(fabs(values[i]) < 1e-12 * values[11]);
  for (int i = 6; i < 11; i++)
    assert_close(values[i], 16 * shear / (density * a * a), 1e-13);

  assert_close(values[11], 24 * bulk / (density * a * a), 1e-13);
  thrum_sparse_free(&stiffness);
  thrum_sparse_free(&mass);
  thrum_fem_free(&fem);
}

static void mass_of_either_kind_weighs_the_body(void **state) {
  (void)state;
  body b = body_make("beam:4x3x2@1x0.5x0.25", NULL);
  thrum_fem fem = body_fem(&b);
  const int64_t count = 3 * fem.vertex_count;

  // the lumped masses, which both kinds must sum to
  double *axis = need((size_t)count, sizeof *axis), *product = need((size_t)count, sizeof *product);
  double *lumps = need((size_t)fem.vertex_count, sizeof *lumps);
  thrum_sparse pattern, mass;
  assert_int_equal(thrum_fem_pattern(&fem, &pattern, NULL), THRUM_OK);
  thrum_fem_vertex_mass(&fem, THRUM_MASS_CONSISTENT, lumps);

  // a unit acceleration along each axis meets the whole mass and each vertex's share
  for (int kind = 0; kind < 2; kind++) {
    assert_int_equal(thrum_fem_mass(&fem, (thrum_mass)kind, &pattern, &mass, NULL), THRUM_OK);
    for (int c = 0; c < 3; c++) {
      for (int64_t i = 0; i < count; i++)
        axis[i] = i % 3 == c;
      thrum_sparse_product(&mass, axis, 1, product);
      assert_close(dot_of(axis, product, count), 125, 1e-13);
      for (int64_t i = 0; i < count; i++)
        assert_true(fabs(product[i] - (i % 3 == c ? lumps[i / 3] : 0)) < 1e-13);
    }
    thrum_sparse_free(&mass);
  }

  thrum_sparse_free(&pattern);
  free(axis);
  free(product);
  free(lumps);
  thrum_fem_free(&fem);
  body_free(&b);
}

static void consistent_mass_integrates_the_square_of_a_linear_field(void **state) {
  (void)state;
  body b = body_make("beam:3x2x2@1x0.5x0.25", NULL);
  thrum_fem fem = body_fem(&b);
  const int64_t count = 3 * fem.vertex_count;
  double *x = need((size_t)count, sizeof *x), *product = need((size_t)count, sizeof *product);
  thrum_sparse pattern, mass;

  // the displacement u_y = x
  assert_int_equal(thrum_fem_pattern(&fem, &pattern, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&fem, THRUM_MASS_CONSISTENT, &pattern, &mass, NULL), THRUM_OK);
  for (int64_t v = 0; v < fem.vertex_count; v++)
    x[3 * v + 1] = b.mesh.vertices[3 * v];
  thrum_sparse_product(&mass, x, 1, product);

  // rho times the integral of x^2 over [0, 1] x 0.5 x 0.25
  assert_close(dot_of(x, product, count), 1000 * 0.125 / 3, 1e-13);
  thrum_sparse_free(&pattern);
  thrum_sparse_free(&mass);
  free(x);
  free(product);
  thrum_fem_free(&fem);
  body_free(&b);
}

static void held_components_leave_the_matrices_of_the_others_alone(void **state) {
  (void)state;

  // the same body twice, once with components held in every combination
  body free_body = body_make("beam:3x2x2@1x0.5x0.5", NULL);
  body held_body = body_make("beam:3x2x2@1x0.5x0.5", NULL);
  for (int64_t v = 0; v < held_body.mesh.vertex_count; v++)
    held_body.fixed[v] = (uint8_t)(v * 5 % 8);
  thrum_fem whole = body_fem(&free_body), part = body_fem(&held_body);

  // stiffness at a deformed state, and consistent mass, of both
  thrum_sparse k[2], m[2];
  double *u = random_vector(3 * whole.vertex_count, 0.05);
  assert_int_equal(thrum_fem_pattern(&whole, &k[0], NULL), THRUM_OK);
  assert_int_equal(thrum_fem_pattern(&part, &k[1], NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&whole, THRUM_MASS_CONSISTENT, &k[0], &m[0], NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&part, THRUM_MASS_CONSISTENT, &k[1], &m[1], NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&whole, u, &k[0], NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&part, u, &k[1], NULL), THRUM_OK);

  // each entry of the smaller matrices equals the larger ones' entry, to the bit
  const int64_t n = whole.free_count, s = part.free_count;
  assert_true(s > 0 && s < n);
  double *dense = need((size_t)(n * n), sizeof *dense),
         *small = need((size_t)(s * s), sizeof *small);
  for (int matrix = 0; matrix < 2; matrix++) {
    to_dense(matrix ? &m[0] : &k[0], dense);
    to_dense(matrix ? &m[1] : &k[1], small);
    for (int64_t i = 0; i < s; i++)
      for (int64_t j = 0; j < s; j++)
        assert_true(small[i * s + j] == dense[part.component[i] * n + part.component[j]]);
  }
  for (int i = 0; i < 2; i++) {
    thrum_sparse_free(&k[i]);
    thrum_sparse_free(&m[i]);
  }

  free(u);
  free(dense);
  free(small);
  thrum_fem_free(&whole);
  thrum_fem_free(&part);
  body_free(&free_body);
  body_free(&held_body);
}

static void refuse(const thrum_mesh *mesh, thrum_status expected, const char *part) {
  thrum_fem fem = {0};
  thrum_error error = {0};
  assert_int_equal(thrum_fem_create(mesh, NULL, &fem, &error), expected);
  assert_null(fem.dof);
  if (!strstr(error.message, part))
    fail_msg("'%s' does not say '%s'", error.message, part);
}

static void impossible_materials_and_tets_are_refused_by_name(void **state) {
  (void)state;
  body b = body_make("beam:1x1x1@1x1x1", NULL);

  // Poisson's ratio outside of (-1, 0.5)
  const thrum_material good = b.mesh.materials[0];
  const double ratios[] = {0.5, 0.7, -1, -3, NAN};
  for (int i = 0; i < 5; i++) {
    b.mesh.materials[0].poisson = ratios[i];
    refuse(&b.mesh, THRUM_BAD_VALUE, "Poisson's ratio of region 1");
  }

  // moduli and densities that are not positive and finite
  const double sizes[] = {0, -1, NAN, INFINITY};
  for (int i = 0; i < 4; i++) {
    b.mesh.materials[0] = good;
    b.mesh.materials[0].young = sizes[i];
    refuse(&b.mesh, THRUM_BAD_VALUE, "Young's modulus of region 1");
    b.mesh.materials[0] = good;
    b.mesh.materials[0].density = sizes[i];
    refuse(&b.mesh, THRUM_BAD_VALUE, "density of region 1");
  }

  // a flat tetrahedron, and one that names a missing vertex
  b.mesh.materials[0] = good;
  const int32_t corner = b.mesh.tets[4];
  b.mesh.tets[4] = b.mesh.tets[5];
  refuse(&b.mesh, THRUM_BAD_VALUE, "tet 2 has volume 0");
  b.mesh.tets[4] = 1000;
  refuse(&b.mesh, THRUM_BAD_VALUE, "tet 2 refers to a vertex");
  b.mesh.tets[4] = corner;

  // auxetic materials are possible
  b.mesh.materials[0].poisson = -0.9;
  thrum_fem fem = body_fem(&b);

  thrum_fem_free(&fem);
  body_free(&b);
}

/* The bodies have one law, three laws, and ten nodes in each tetrahedron. */
static void forces_of_several_displacements_are_those_of_each(void **state) {
  (void)state;
  enum { LANES = THRUM_FEM_LANES };
  for (int which = 0; which < 3; which++) {
    body b = which < 2 ? body_make("beam:6x2x1@1x0.3x0.4", "x<0.001")
                       : body_quadratic("beam:2x1x1@1x0.3x0.4", "x<0.001", 0.02, 0.01);
    if (which == 1)
      body_divide(&b, 1);
    thrum_fem fem = body_fem(&b);
    if (which == 1)
      fem.law = THRUM_LAW_BY_REGION;
    const int64_t count = 3 * fem.vertex_count;
    double *u = random_vector(LANES * count, 0.02), *one = need((size_t)count, sizeof *one);
    double *together = need((size_t)(LANES * count), sizeof *together),
           *alone = need((size_t)count, sizeof *alone);
    thrum_fem_forces(&fem, u, together);

    // each displacement by itself
    for (int k = 0; k < LANES; k++) {
      double size = 0, off = 0;
      for (int64_t i = 0; i < count; i++)
        one[i] = u[LANES * i + k];
      thrum_fem_energy(&fem, one, alone);
      for (int64_t i = 0; i < count; i++) {
        size = fmax(size, fabs(alone[i]));
        off = fmax(off, fabs(alone[i] - together[LANES * i + k]));
      }
      assert_true(size > 0 && off < 1e-12 * size);
    }
    free(u);
    free(one);
    free(together);
    free(alone);
    thrum_fem_free(&fem);
    body_free(&b);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rigid_rotation_gives_zero_force),
      cmocka_unit_test(linear_displacement_has_constant_stress_and_no_interior_force),
      cmocka_unit_test(uniaxial_stretch_meets_the_exact_force),
      cmocka_unit_test(force_and_tangent_are_derivatives_of_the_energy),
      cmocka_unit_test(forces_of_several_displacements_are_those_of_each),
      cmocka_unit_test(regular_tetrahedron_has_its_exact_frequencies),
      cmocka_unit_test(mass_of_either_kind_weighs_the_body),
      cmocka_unit_test(consistent_mass_integrates_the_square_of_a_linear_field),
      cmocka_unit_test(held_components_leave_the_matrices_of_the_others_alone),
      cmocka_unit_test(impossible_materials_and_tets_are_refused_by_name),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
