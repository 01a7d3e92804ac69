/* The basis and the exact reduced polynomial (design 2 and 3): the model's energy, force and
 * tangent at q equal those of the full-order body at U q. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "mesh/mesh_fix.h"
#include "precompute/polynomial/polynomial_reduce.h"
#include "thrum/polynomial.h"

// u = U q over all components
static void lift(const thrum_model *model, const double *q, double *u) {
  for (int64_t c = 0; c < 3 * model->vertex_count; c++)
    u[c] = dot_of(model->basis + c * model->rank, q, model->rank);
}

// U^T f
static void restrict_force(const thrum_model *model, const double *force, double *reduced) {
  memset(reduced, 0, sizeof *reduced * (size_t)model->rank);
  for (int64_t c = 0; c < 3 * model->vertex_count; c++)
    for (int64_t i = 0; i < model->rank; i++)
      reduced[i] += model->basis[c * model->rank + i] * force[c];
}

// the columns of the basis over the free components
static double *free_columns(const thrum_fem *fem, const thrum_model *model) {
  double *columns = need((size_t)(fem->free_count * model->rank), sizeof *columns);
  for (int64_t i = 0; i < model->rank; i++)
    for (int64_t c = 0; c < fem->free_count; c++)
      columns[i * fem->free_count + c] = model->basis[fem->component[c] * model->rank + i];
  return columns;
}

// random coordinates that move the body by about `size` in all modes alike in energy
static double *random_coordinates(const thrum_model *model, double energy) {
  double *q = random_vector(model->rank, 1);
  for (int64_t i = 0; i < model->rank; i++)
    q[i] *= sqrt(2 * energy / model->omega2[i]);
  return q;
}

static void compare_tangent(const thrum_fem *fem, const thrum_model *model, const double *u,
                            const double *tangent) {
  const int64_t n = fem->free_count, rank = model->rank;
  thrum_sparse full;
  assert_int_equal(thrum_fem_pattern(fem, &full, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(fem, u, &full, NULL), THRUM_OK);

  // U^T T(u) U is what the reduced tangent must be
  double *columns = free_columns(fem, model);
  double *product = need((size_t)(n * rank), sizeof *product);
  double *expected = need((size_t)(rank * rank), sizeof *expected);
  thrum_sparse_product(&full, columns, rank, product);
  for (int64_t i = 0; i < rank; i++)
    for (int64_t j = 0; j < rank; j++)
      expected[i * rank + j] = dot_of(columns + i * n, product + j * n, n);
  assert_near(tangent, expected, rank * rank, 1e-12);
  thrum_sparse_free(&full);
  free(columns);
  free(product);
  free(expected);
}

static void compare_with_full_order(body b, int64_t modes, int64_t rank) {
  thrum_precomputed result = body_precompute(&b, modes, rank);
  const thrum_model *model = &result.model;
  thrum_fem fem = body_fem(&b);

  // displacements and forces of both descriptions
  double *u = need((size_t)(3 * fem.vertex_count), sizeof *u);
  double *full = need((size_t)(3 * fem.vertex_count), sizeof *full);
  double *force = need((size_t)rank, sizeof *force),
         *expected = need((size_t)rank, sizeof *expected);
  double *tangent = need((size_t)(rank * rank), sizeof *tangent);
  double *work = need(thrum_work_count(model), sizeof *work);

  // amplitudes from nearly linear to far beyond, where the cubic and quartic parts dominate
  for (double size = 1e-4; size < 1e7; size *= 1e3) {
    double *q = random_coordinates(model, size);

    // energy and restricted force of the full-order body at U q
    lift(model, q, u);
    const double energy = thrum_fem_energy(&fem, u, full);
    restrict_force(model, full, expected);

    // the polynomial has the same energy, force and tangent
    assert_close(thrum_strain_energy(model, q, work), energy, 1e-12);
    assert_close(thrum_internal_force(model, q, force, work), energy, 1e-12);
    assert_near(force, expected, rank, 1e-12);
    thrum_tangent_stiffness(model, q, tangent, work);
    compare_tangent(&fem, model, u, tangent);
    free(q);
  }

  free(u);
  free(full);
  free(force);
  free(expected);
  free(tangent);
  free(work);
  thrum_fem_free(&fem);
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void reduced_energy_force_and_tangent_are_those_of_the_full_order_beam(void **state) {
  (void)state;
  compare_with_full_order(body_beam1k(), 10, 20);
}

static void reduced_energy_force_and_tangent_are_those_of_full_order_real_meshes(void **state) {
  (void)state;
  if (!have_data("beam3_tet.veg")) {
    skip();
    return;
  }
  compare_with_full_order(body_data("beam3_tet.veg", "beam3.bou"), 8, 20);
  compare_with_full_order(body_data("simpleBridge.veg", "simpleBridge.bou"), 10, 20);
}

static void reduced_energy_is_exact_for_several_and_auxetic_materials(void **state) {
  (void)state;
  body b = body_make("beam:6x2x2@1x0.2x0.15", "x<0.001");

  // nearly incompressible, auxetic and without lateral strain, alternating over the mesh
  thrum_material *materials = need(3, sizeof *materials);
  materials[0] = (thrum_material){5e6, 0.45, 1000};
  materials[1] = (thrum_material){2e5, -0.8, 300};
  materials[2] = (thrum_material){1e7, 0, 2000};
  free(b.mesh.materials);
  b.mesh.materials = materials;
  b.mesh.region_count = 3;
  for (int64_t t = 0; t < b.mesh.tet_count; t++)
    b.mesh.tet_region[t] = (int32_t)(t % 3);

  // one component of one vertex is held as well
  b.fixed[b.mesh.vertex_count - 1] = 2;
  compare_with_full_order(b, 6, 27);
}

static void *read_file(const char *path, size_t *size) {
  FILE *stream = fopen(path, "rb");
  assert_non_null(stream);
  fseek(stream, 0, SEEK_END);
  *size = (size_t)ftell(stream);
  rewind(stream);
  void *data = need(*size, 1);
  assert_int_equal(fread(data, 1, *size, stream), *size);
  fclose(stream);
  return data;
}

static void sort_up(int64_t *index, int count) {
  for (int a = 1; a < count; a++)
    for (int c = a; c > 0 && index[c] < index[c - 1]; c--) {
      const int64_t swap = index[c];
      index[c] = index[c - 1];
      index[c - 1] = swap;
    }
}

// d/dq_a of a monomial: its coefficient times the number of times that a occurs
static double derived(const double *coefficients, int64_t rank, int64_t a, const int64_t *others,
                      int count) {
  int64_t index[4] = {a};
  int times = 1;
  for (int i = 0; i < count; i++) {
    index[i + 1] = others[i];
    times += others[i] == a;
  }
  sort_up(index, count + 1);
  const int64_t at = count == 2 ? thrum_c3_index(rank, index[0], index[1], index[2])
                                : thrum_c4_index(rank, index[0], index[1], index[2], index[3]);
  return times * coefficients[at];
}

// the largest difference of n coefficients over the largest of them, as they come
typedef struct difference {
  double worst, largest;
} difference;

static void compare(difference *of, double found, double expected) {
  of->worst = fmax(of->worst, fabs(found - expected));
  of->largest = fmax(of->largest, fabs(expected));
}

// what is made for condensing: monomials of the first coordinates, those of two of them and
// another, and nothing else
static void first_alone_agree(const thrum_fem *fem, int64_t r, const double *basis,
                              const double *c3, const double *c4) {
  const int64_t first = r / 2;
  double *linear = need((size_t)(r * r), sizeof *linear);
  double *few3 = need((size_t)thrum_c3_count(r), sizeof *few3);
  double *few4 = need((size_t)thrum_c4_count(r), sizeof *few4);
  assert_int_equal(thrum_polynomial_reduce(fem, r, first, basis, linear, few3, few4, NULL, NULL),
                   THRUM_OK);

  difference cubic = {0}, mixed = {0}, quartic = {0};
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = i; j < r; j++)
      for (int64_t k = j; k < r; k++) {
        const int64_t n = thrum_c3_index(r, i, j, k);
        if (j < first)
          compare(k < first ? &cubic : &mixed, few3[n], c3[n]);
        else
          assert_true(few3[n] == 0);
        for (int64_t l = k; l < r; l++) {
          const int64_t m = thrum_c4_index(r, i, j, k, l);
          if (l < first)
            compare(&quartic, few4[m], c4[m]);
          else
            assert_true(few4[m] == 0);
        }
      }

  assert_true(cubic.largest > 0 && cubic.worst <= 1e-13 * cubic.largest);
  assert_true(mixed.largest > 0 && mixed.worst <= 1e-13 * mixed.largest);
  assert_true(quartic.largest > 0 && quartic.worst <= 1e-13 * quartic.largest);
  free(linear);
  free(few3);
  free(few4);
}

static void coefficients_agree_with_an_independent_program(void **state) {
  (void)state;
  body b = body_beam1k();
  thrum_fem fem = body_fem(&b);

  // basis and polynomial of VegaFEM, written by its tools
  size_t u_size, cub_size;
  char *u_file = read_file(THRUM_TEST_DATA "/beam1k.r15.U", &u_size);
  char *cub_file = read_file(THRUM_TEST_DATA "/beam1k.r15.cub", &cub_size);

  // the headers give the sizes of both files
  int32_t shape[2], sizes[4];
  memcpy(shape, u_file, sizeof shape);
  memcpy(sizes, cub_file, sizeof sizes);
  const int64_t rows = 3 * fem.vertex_count, r = shape[1], quadratic = sizes[2], cubic = sizes[3];
  assert_int_equal(shape[0], rows);
  assert_int_equal(sizes[0], r);
  assert_int_equal(quadratic, r * (r + 1) / 2);
  assert_int_equal(cubic, r * (r + 1) * (r + 2) / 6);
  assert_int_equal(cub_size, 16 + 8 * r * (r + quadratic + cubic));

  // VegaFEM stores the basis by columns, the library by rows
  double *columns = need((size_t)(rows * r), sizeof *columns);
  double *basis = need((size_t)(rows * r), sizeof *basis);
  memcpy(columns, u_file + 8, sizeof *columns * (size_t)(rows * r));
  for (int64_t c = 0; c < rows; c++)
    for (int64_t i = 0; i < r; i++)
      basis[c * r + i] = columns[i * rows + c];

  // the polynomial of that basis, from the library
  double *linear = need((size_t)(r * r), sizeof *linear);
  double *c3 = need((size_t)thrum_c3_count(r), sizeof *c3);
  double *c4 = need((size_t)thrum_c4_count(r), sizeof *c4);
  assert_int_equal(thrum_polynomial_reduce(&fem, r, r, basis, linear, c3, c4, NULL, NULL),
                   THRUM_OK);

  double *expected = need((size_t)(r * (r + quadratic + cubic)), sizeof *expected);
  double *found = need((size_t)(r * (r + quadratic + cubic)), sizeof *found);
  memcpy(expected, cub_file + 16, cub_size - 16);

  first_alone_agree(&fem, r, basis, c3, c4);

  // linear, quadratic and cubic part of the force, in the file's order
  int64_t next = 0;
  for (; next < r * r; next++)
    found[next] = linear[next];
  for (int64_t a = 0; a < r; a++)
    for (int64_t i = 0; i < r; i++)
      for (int64_t j = i; j < r; j++)
        found[next++] = derived(c3, r, a, (int64_t[]){i, j}, 2);
  for (int64_t a = 0; a < r; a++)
    for (int64_t i = 0; i < r; i++)
      for (int64_t j = i; j < r; j++)
        for (int64_t k = j; k < r; k++)
          found[next++] = derived(c4, r, a, (int64_t[]){i, j, k}, 3);

  // each part agrees relative to its own largest coefficient
  assert_near(found, expected, r * r, 1e-12);
  assert_near(found + r * r, expected + r * r, r * quadratic, 1e-12);
  assert_near(found + r * (r + quadratic), expected + r * (r + quadratic), r * cubic, 1e-12);

  free(u_file);
  free(cub_file);
  free(columns);
  free(basis);
  free(linear);
  free(c3);
  free(c4);
  free(expected);
  free(found);
  thrum_fem_free(&fem);
  body_free(&b);
}

static void basis_is_mass_orthonormal_and_diagonalises_the_stiffness(void **state) {
  (void)state;

  // it holds with both kinds of mass
  for (int kind = 0; kind < 2; kind++) {
    body b = body_beam1k();
    thrum_precompute_options options = thrum_default_precompute_options();
    options.rank = 60;
    options.mass = (thrum_mass)kind;
    thrum_precomputed result = {0};
    assert_int_equal(thrum_precompute(&b.mesh, b.fixed, &options, &result, NULL), THRUM_OK);

    // the matrices the basis has to be orthonormal in
    const thrum_model *model = &result.model;
    thrum_fem fem = body_fem(&b);
    thrum_sparse k, m;
    assert_int_equal(thrum_fem_pattern(&fem, &k, NULL), THRUM_OK);
    assert_int_equal(thrum_fem_mass(&fem, options.mass, &k, &m, NULL), THRUM_OK);
    assert_int_equal(thrum_fem_stiffness(&fem, NULL, &k, NULL), THRUM_OK);

    // U^T M U is the identity
    const int64_t n = fem.free_count, r = model->rank;
    double *columns = free_columns(&fem, model), *product = need((size_t)(n * r), sizeof *product);
    thrum_sparse_product(&m, columns, r, product);
    double worst = 0;
    for (int64_t i = 0; i < r; i++)
      for (int64_t j = 0; j < r; j++)
        worst = fmax(worst, fabs(dot_of(columns + i * n, product + j * n, n) - (i == j)));
    assert_true(worst < 1e-12 && result.basis_orthonormality < 1e-12);

    // U^T K U is diagonal, with the squared frequencies
    thrum_sparse_product(&k, columns, r, product);
    for (int64_t i = 0; i < r; i++)
      for (int64_t j = 0; j < r; j++)
        assert_true(fabs(dot_of(columns + i * n, product + j * n, n) -
                         (i == j ? model->omega2[i] : 0)) < 1e-12 * model->omega2[r - 1]);
    assert_true(result.basis_diagonality < 1e-12);

    // held components do not move
    for (int64_t c = 0; c < 3 * fem.vertex_count; c++)
      if (fem.dof[c] < 0)
        assert_true(norm_of(model->basis + c * r, r) == 0);

    // the basis contains the modes and more, so its frequencies are no lower than theirs
    for (int64_t i = 0; i < result.mode_count; i++)
      assert_true(model->omega2[i] > result.mode_omega2[i] * (1 - 1e-9));
    thrum_sparse_free(&k);
    thrum_sparse_free(&m);
    free(columns);
    free(product);
    thrum_fem_free(&fem);
    thrum_precomputed_free(&result);
    body_free(&b);
  }
}

static void uniform_acceleration_acts_through_the_whole_mass(void **state) {
  (void)state;

  // the same body with and without supports
  body b = body_beam1k(), loose = body_make(THRUM_TEST_DATA "/beam1k.veg", NULL);
  thrum_precomputed result = body_precompute(&b, 5, 10);
  const thrum_model *model = &result.model;
  thrum_fem whole = body_fem(&loose);
  const int64_t all = 3 * whole.vertex_count;

  // the mass of all components, the held ones included
  thrum_sparse pattern, mass;
  assert_int_equal(thrum_fem_pattern(&whole, &pattern, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&whole, THRUM_MASS_CONSISTENT, &pattern, &mass, NULL), THRUM_OK);
  double *ones = need((size_t)all, sizeof *ones), *product = need((size_t)all, sizeof *product);
  double expected[10];

  // a unit acceleration along each axis gives the model's own coupling
  for (int axis = 0; axis < 3; axis++) {
    for (int64_t c = 0; c < all; c++)
      ones[c] = c % 3 == axis;
    thrum_sparse_product(&mass, ones, 1, product);
    restrict_force(model, product, expected);
    assert_near(model->axis_mass + axis * model->rank, expected, model->rank, 1e-12);
  }

  thrum_sparse_free(&pattern);
  thrum_sparse_free(&mass);
  free(ones);
  free(product);
  thrum_fem_free(&whole);
  thrum_precomputed_free(&result);
  body_free(&b);
  body_free(&loose);
}

static void unit_of_length_leaves_the_frequencies_alone(void **state) {
  (void)state;
  body metres = body_beam1k(), millimetres = body_beam1k();
  for (int64_t i = 0; i < 3 * millimetres.mesh.vertex_count; i++)
    millimetres.mesh.vertices[i] *= 1000;

  // the unit of pressure kg/(m s^2) and that of the density kg/m^3 change with the length
  millimetres.mesh.materials[0].young /= 1e3;
  millimetres.mesh.materials[0].density /= 1e9;

  // frequencies in rad/s do not depend on the unit
  thrum_precomputed one = body_precompute(&metres, 5, 15);
  thrum_precomputed other = body_precompute(&millimetres, 5, 15);
  for (int64_t i = 0; i < one.mode_count; i++)
    assert_close(other.mode_omega2[i], one.mode_omega2[i], 1e-9);
  for (int64_t i = 0; i < one.model.rank; i++)
    assert_close(other.model.omega2[i], one.model.omega2[i], 1e-9);

  // displacements are in the unit of length: U [kg^-1/2] stays, V [J] in kg mm^2/s^2 is 1e6 times
  double *q = random_vector(one.model.rank, 0.01), *scaled = need(15, sizeof *scaled);
  double *work = need(thrum_work_count(&one.model), sizeof *work);
  for (int64_t i = 0; i < one.model.rank; i++)
    scaled[i] = 1000 * q[i];
  assert_close(thrum_strain_energy(&other.model, scaled, work),
               1e6 * thrum_strain_energy(&one.model, q, work), 1e-6);

  free(q);
  free(scaled);
  free(work);
  thrum_precomputed_free(&one);
  thrum_precomputed_free(&other);
  body_free(&metres);
  body_free(&millimetres);
}

// the coefficient of p^4 in the energy of the deformed mode p psi + p^2 y, y relaxed statically
static double reduced_hardening(const thrum_precomputed *result) {
  const thrum_model *model = &result->model;
  const double coupling = model->c3[thrum_c3_index(2, 0, 0, 1)];
  return model->c4[thrum_c4_index(2, 0, 0, 0, 0)] - coupling * coupling / (2 * model->omega2[1]);
}

// the same from the full-order body: energy and force are even and odd parts of polynomials in p,
// so differences are exact; `stretch` gets the p^4 of the unrelaxed mode
static double full_hardening(const body *b, const thrum_model *model, double *stretch) {
  thrum_fem fem = body_fem(b);
  const int64_t n = fem.free_count, all = 3 * fem.vertex_count;
  thrum_sparse k, m;
  thrum_factor *factor;

  // linear stiffness, mass, and a factor to solve with
  assert_int_equal(thrum_fem_pattern(&fem, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&fem, NULL, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&fem, THRUM_MASS_CONSISTENT, &k, &m, NULL), THRUM_OK);
  assert_int_equal(thrum_factor_create(&k, &factor, NULL), THRUM_OK);
  double *mode = free_columns(&fem, model), *y = need((size_t)n, sizeof *y);
  double *u = need((size_t)all, sizeof *u), *force = need((size_t)all, sizeof *force);
  double *product = need((size_t)n, sizeof *product);

  // the even part of the energy has p^2 and p^4, that of the force p^2 alone
  const double p = 10;
  double even = 0;
  for (int sign = -1; sign < 2; sign += 2) {
    for (int64_t c = 0; c < n; c++)
      product[c] = sign * p * mode[c];
    thrum_fem_scatter(&fem, product, u);
    even += thrum_fem_energy(&fem, u, force) / 2;
    thrum_fem_gather(&fem, force, product);
    for (int64_t c = 0; c < n; c++)
      y[c] -= product[c] / (2 * p * p);
  }

  // the p^4 of the mode by itself
  *stretch = (even - model->omega2[0] * p * p / 2) / (p * p * p * p);

  // the response y, with its share along the mode removed
  assert_int_equal(thrum_factor_solve(factor, y, 1, y, NULL), THRUM_OK);
  thrum_sparse_product(&m, y, 1, product);
  const double along = dot_of(mode, product, n);
  for (int64_t c = 0; c < n; c++)
    y[c] -= along * mode[c];

  // relaxing along y lowers the coefficient
  thrum_sparse_product(&k, y, 1, product);
  const double relaxed = *stretch - dot_of(y, product, n) / 2;

  thrum_factor_free(factor);
  thrum_sparse_free(&k);
  thrum_sparse_free(&m);
  free(mode);
  free(y);
  free(u);
  free(force);
  free(product);
  thrum_fem_free(&fem);
  return relaxed;
}

static void mode_and_its_derivative_harden_as_the_full_order_body(void **state) {
  (void)state;
  // a slender cantilever's free end relieves the stretch, so almost all of its p^4 vanishes
  body b = body_make("beam:40x2x2@1x0.02x0.02", "x<0.001");
  thrum_precomputed result = body_precompute(&b, 1, 2);
  double stretch;
  const double full = full_hardening(&b, &result.model, &stretch);
  assert_true(fabs(full) < 1e-3 * stretch);
  // this is rounding, relative to the terms that cancel
  assert_true(fabs(reduced_hardening(&result) - full) < 1e-12 * stretch);
  assert_close(reduced_hardening(&result), full, 1e-8);
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void clamped_beam_hardens_as_beam_theory_says(void **state) {
  (void)state;
  const double length = 1, thickness = 0.02;

  // a slender beam between two clamps
  body b = body_make("beam:80x2x2@1x0.02x0.02", "x<0.001");
  int64_t count;
  assert_int_equal(thrum_mesh_fix(&b.mesh, "x>0.999", b.fixed, &count, NULL), THRUM_OK);
  b.mesh.materials[0].poisson = 0;
  thrum_precomputed result = body_precompute(&b, 1, 2);
  const thrum_model *model = &result.model;

  // the mode's amplitude at midspan
  double middle = 0;
  for (int64_t v = 0; v < model->vertex_count; v++)
    middle = fmax(middle, norm_of((double[]){model->basis[6 * v], model->basis[6 * v + 2],
                                             model->basis[6 * v + 4]},
                                  3));

  // linear stiffness 198.463 E I/L^3 and cubic over linear force 0.7193 (a/h)^2; linear tets lock
  // in the first, not in the second
  const double linear =
      198.463 * b.mesh.materials[0].young * pow(thickness, 4) / 12 / pow(length, 3);
  const double cubic = 0.7193 * linear / (thickness * thickness);

  // the mode's hardening is the theory's, although its linear stiffness is too large
  assert_close(4 * reduced_hardening(&result) / pow(middle, 4), cubic, 0.01);
  assert_true(model->omega2[0] / (middle * middle) > 1.2 * linear);

  thrum_precomputed_free(&result);
  body_free(&b);
}

static size_t size_of_array(const thrum_model *model, const char *name) {
  // bytes of each array of a model
  const struct {
    const char *name;
    int64_t bytes;
  } sizes[] = {{"format", 8},
               {"omega2", 8 * model->rank},
               {"c3", 8 * model->c3_count},
               {"c4", 8 * model->c4_count},
               {"axis_mass", 24 * model->rank},
               {"vertices", 24 * model->vertex_count},
               {"tets", 16 * model->tet_count},
               {"tet_region", 4 * model->tet_count},
               {"material", 24 * model->region_count},
               {"fixed", model->vertex_count},
               {"basis", 24 * model->vertex_count * model->rank},
               {"group_names", model->group_name_bytes},
               {"group_ends", 4 * model->group_count},
               {"group_vertices", 4 * model->group_vertex_count}};

  // the table must know every array of the format
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
    if (strcmp(sizes[i].name, name) == 0)
      return (size_t)sizes[i].bytes;
  fail_msg("no size for %s", name);
  return 0;
}

static void two_runs_give_the_same_bits(void **state) {
  (void)state;

  // the bending modes of a square beam come in nearly equal pairs, the hardest case for determinism
  body b = body_make("beam:10x2x2@1x0.1x0.1", "x<0.001");
  thrum_precomputed first = body_precompute(&b, 6, 20);

  // another body in between would reveal state that a solver keeps
  body other = body_beam1k();
  thrum_precomputed between = body_precompute(&other, 7, 9);
  thrum_precomputed second = body_precompute(&b, 6, 20);

#define X(type, name, rows, columns, presence, meaning)                                            \
  assert_true((first.model.name == NULL) == (second.model.name == NULL));                          \
  if (first.model.name)                                                                            \
    assert_memory_equal(first.model.name, second.model.name, size_of_array(&first.model, #name));
  THRUM_MODEL_ARRAYS(X)
#undef X

  thrum_precomputed_free(&first);
  thrum_precomputed_free(&between);
  thrum_precomputed_free(&second);
  body_free(&b);
  body_free(&other);
}

static void model_carries_the_mesh_it_was_made_from(void **state) {
  (void)state;
  body b = body_beam1k();
  thrum_precomputed result = body_precompute(&b, 4, 6);

  // the model is valid by itself
  const thrum_model *model = &result.model;
  thrum_error error = {0};
  assert_int_equal(thrum_model_check(model, &error), THRUM_OK);

  // mesh, supports and material are the given ones
  assert_int_equal(model->vertex_count, b.mesh.vertex_count);
  assert_memory_equal(model->vertices, b.mesh.vertices, 24 * (size_t)model->vertex_count);
  assert_memory_equal(model->tets, b.mesh.tets, 16 * (size_t)model->tet_count);
  assert_memory_equal(model->fixed, b.fixed, (size_t)model->vertex_count);
  assert_true(model->material[0] == 5e6 && model->material[1] == 0.4 && model->material[2] == 1000);
  assert_null(model->meta);

  // the groups, by name
  assert_int_equal(model->group_count, b.mesh.group_count);
  for (int64_t g = 0; g < b.mesh.group_count; g++) {
    const int32_t *vertices;
    int64_t count;
    const thrum_group *group = &b.mesh.groups[g];
    assert_int_equal(thrum_model_group(model, group->name, &vertices, &count, &error), THRUM_OK);
    assert_int_equal(count, group->count);
    assert_memory_equal(vertices, group->vertices, 4 * (size_t)count);
  }

  // volume [m^3], mass [kg] and free components as computed by hand
  assert_close(result.volume, 0.0225, 1e-12);
  assert_close(result.mass, 22.5, 1e-12);
  assert_int_equal(result.free_dofs, 960);

  thrum_precomputed_free(&result);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(reduced_energy_force_and_tangent_are_those_of_the_full_order_beam),
      cmocka_unit_test(reduced_energy_force_and_tangent_are_those_of_full_order_real_meshes),
      cmocka_unit_test(reduced_energy_is_exact_for_several_and_auxetic_materials),
      cmocka_unit_test(coefficients_agree_with_an_independent_program),
      cmocka_unit_test(basis_is_mass_orthonormal_and_diagonalises_the_stiffness),
      cmocka_unit_test(uniform_acceleration_acts_through_the_whole_mass),
      cmocka_unit_test(unit_of_length_leaves_the_frequencies_alone),
      cmocka_unit_test(mode_and_its_derivative_harden_as_the_full_order_body),
      cmocka_unit_test(clamped_beam_hardens_as_beam_theory_says),
      cmocka_unit_test(two_runs_give_the_same_bits),
      cmocka_unit_test(model_carries_the_mesh_it_was_made_from),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
