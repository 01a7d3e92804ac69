/* Elasticity with directions: energy, forces and the reduced polynomial of orthotropic elements of
 * every kind, laminates against their series solutions, files, and what is refused.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/monomials.h"
#include "tests/support/precompute_support.h"

#include <unistd.h>

#include "core/base/vec3.h"
#include "driver/model/mesh_of_model.h"
#include "driver/spec/region_material.h"
#include "io/npz.h"
#include "mesh/elastic.h"
#include "mesh/mesh_beam.h"
#include "precompute/fem/fem_solids.h"
#include "precompute/fem/solid_stress.h"
#include "precompute/polynomial/polynomial_reduce.h"
#include "thrum/polynomial.h"

static const char ORTHO[] = "1:ortho,9e3,4e3,2e3,0.3,0.25,0.35,1500,1200,800,2,along,1,2,0.5,0,1,1";

/* Tetrahedra of 4 and 10 nodes, those of a mean dilatation, hexahedra, and solid-shells. */
typedef enum kind { TET4, TET10, MEAN, HEX, SHELL, KINDS } kind;

static void give(body *b, const char *text) {
  thrum_error error = {0};
  thrum_law law = THRUM_LAW_STVK;
  int64_t lacking = 0;
  if (region_materials_apply(&text, 1, &b->mesh, &law, &lacking, &error) < 0 ||
      thrum_mesh_make_solids(&b->mesh, &error) < 0)
    fail_msg("%s", error.message);
}

/* Hexahedra of one form, held where x is below `held`. */
static body hexahedra(const char *name, thrum_solid_form form, double held) {
  body b = {0};
  assert_int_equal(thrum_mesh_beam(name, &b.mesh, NULL), THRUM_OK);
  b.fixed = need((size_t)b.mesh.vertex_count, 1);
  for (int64_t v = 0; v < b.mesh.vertex_count; v++)
    b.fixed[v] = b.mesh.vertices[3 * v] < held ? 7 : 0;
  memset(b.mesh.solid_form, (int)form, (size_t)b.mesh.solid_count);
  return b;
}

static body make(kind of, const char *text) {
  body b;
  if (of == TET10 || of == MEAN)
    b = body_quadratic("beam:2x1x1@1x0.4x0.5", "x<0.1", 0.03, 0.01);
  else if (of == TET4)
    b = body_make("beam:3x2x2@1x0.4x0.5", "x<0.1");
  else
    b = hexahedra("beam:3x2x1@1x0.4x0.1,hex", of == SHELL ? THRUM_FORM_SHELL8 : THRUM_FORM_HEX8,
                  0.1);
  give(&b, text);
  if (of == MEAN)
    memset(b.mesh.solid_form, THRUM_FORM_MEAN10, (size_t)b.mesh.solid_count);
  return b;
}

/* F with F^T F = 1 + 2 E, upper triangular, less 1. */
static void gradient_of(double e[3][3], double g[3][3]) {
  memset(g, 0, 9 * sizeof(double));
  for (int i = 0; i < 3; i++)
    for (int j = i; j < 3; j++) {
      double sum = 2 * e[i][j] + (i == j);
      for (int k = 0; k < i; k++)
        sum -= (g[k][i] + (k == i)) * (g[k][j] + (k == j));
      g[i][j] = i == j ? sqrt(sum) - 1 : sum / (1 + g[i][i]);
    }
}

/* A stress along the directions of the material strains it by the nine constants; the same strain,
 * turned into space, has the energy of that in every element. */
static void uniform_strain_has_the_energy_of_the_nine_constants(void **state) {
  (void)state;
  static const double stress[6] = {300, -200, 100, 70, 50, -60}; /* 11, 22, 33, 23, 13, 12 */
  for (int of = 0; of < KINDS; of++) {
    body b = make((kind)of, ORTHO);
    const double *row = b.mesh.elastic, *young = row + THRUM_ELASTIC_YOUNG;
    const double *nu = row + THRUM_ELASTIC_POISSON, *shear = row + THRUM_ELASTIC_SHEAR;
    const double strain[6] = {
        stress[0] / young[0] - nu[0] * stress[1] / young[0] - nu[1] * stress[2] / young[0],
        stress[1] / young[1] - nu[0] * stress[0] / young[0] - nu[2] * stress[2] / young[1],
        stress[2] / young[2] - nu[1] * stress[0] / young[0] - nu[2] * stress[1] / young[1],
        stress[3] / shear[2],
        stress[4] / shear[1],
        stress[5] / shear[0]};
    const double own[3][3] = {{strain[0], strain[5] / 2, strain[4] / 2},
                              {strain[5] / 2, strain[1], strain[3] / 2},
                              {strain[4] / 2, strain[3] / 2, strain[2]}};
    double axes[3][3], e[3][3] = {{0}}, g[3][3], density = 0, volume = 0, mass = 0;
    assert_true(thrum_elastic_axes(row, NULL, axes));
    for (int k = 0; k < 6; k++)
      density += stress[k] * strain[k] / 2;
    for (int c = 0; c < 9; c++)
      for (int k = 0; k < 9; k++)
        e[c / 3][c % 3] += axes[k / 3][c / 3] * own[k / 3][k % 3] * axes[k % 3][c % 3];
    gradient_of(e, g);

    thrum_fem fem = body_fem(&b);
    double *u = need(3 * (size_t)fem.vertex_count, sizeof *u);
    for (int64_t c = 0; c < 3 * fem.vertex_count; c++)
      u[c] = thrum_dot3(g[c % 3], fem.vertices + c / 3 * 3);
    thrum_fem_weigh(&fem, &volume, &mass);
    assert_close(thrum_fem_energy(&fem, u, NULL), density * volume, 1e-12);
    assert_close(mass, 2 * volume, 1e-12);

    // and the stress of it, S = F^-1 (J sigma) F^-T along the directions
    thrum_solid_stresses read = {0};
    assert_int_equal(thrum_solid_stresses_make(&fem, &read, NULL), THRUM_OK);
    double *cauchy = need(6 * (size_t)read.count, sizeof *cauchy), f[3][3], pushed[3][3] = {{0}};
    thrum_solid_stresses_read(&read, u, cauchy);
    const double s[3][3] = {{stress[0], stress[5], stress[4]},
                            {stress[5], stress[1], stress[3]},
                            {stress[4], stress[3], stress[2]}};
    memcpy(f, g, sizeof f);
    for (int c = 0; c < 3; c++)
      f[c][c] += 1;
    for (int c = 0; c < 3; c++)
      for (int d = 0; d < 3; d++)
        for (int k = 0; k < 9; k++) {
          const double left = thrum_dot3(f[c], axes[k / 3]), right = thrum_dot3(f[d], axes[k % 3]);
          pushed[c][d] += left * s[k / 3][k % 3] * right / (f[0][0] * f[1][1] * f[2][2]);
        }
    const double expected[6] = {pushed[0][0], pushed[1][1], pushed[2][2],
                                pushed[0][1], pushed[1][2], pushed[0][2]};
    for (int64_t n = 0; n < read.count; n++)
      assert_near(cauchy + 6 * n, expected, 6, 1e-10);
    thrum_solid_stresses_free(&read);
    free(cauchy);
    free(u);
    thrum_fem_free(&fem);
    body_free(&b);
  }
}

static void force_is_the_slope_of_energy_and_stiffness_that_of_force(void **state) {
  (void)state;
  for (int of = 0; of < KINDS; of++) {
    body b = make((kind)of,
                  of == SHELL ? "1:transverse,9e3,1e3,0.3,0.4,500,2,layers,30@1/-45@2" : ORTHO);
    thrum_fem fem = body_fem(&b);
    const int64_t all = 3 * fem.vertex_count, n = fem.free_count;
    thrum_sparse stiffness = {0};
    const double h = 1e-6;
    double *u = random_vector(all, 0.02), *d = random_vector(n, 1), energy[3], *force[3];
    double *along = need((size_t)all, sizeof *along), *at = need((size_t)all, sizeof *at);
    double *slope = need((size_t)n, sizeof *slope), *kd = need((size_t)n, sizeof *kd);
    thrum_fem_scatter(&fem, d, along);
    for (int k = 0; k < 3; k++) {
      force[k] = need((size_t)all, sizeof **force);
      for (int64_t i = 0; i < all; i++)
        at[i] = u[i] + (k - 1) * h * along[i];
      energy[k] = thrum_fem_energy(&fem, at, force[k]);
    }
    assert_close((energy[2] - energy[0]) / (2 * h), dot_of(force[1], along, all), 1e-6);
    assert_int_equal(thrum_fem_pattern(&fem, &stiffness, NULL), THRUM_OK);
    assert_int_equal(thrum_fem_stiffness(&fem, u, &stiffness, NULL), THRUM_OK);
    thrum_sparse_product(&stiffness, d, 1, kd);
    for (int64_t i = 0; i < n; i++)
      slope[i] = (force[2][fem.component[i]] - force[0][fem.component[i]]) / (2 * h);
    assert_near(slope, kd, n, 1e-6);
    for (int k = 0; k < 3; k++)
      free(force[k]);
    free(u);
    free(d);
    free(along);
    free(at);
    free(slope);
    free(kd);
    thrum_sparse_free(&stiffness);
    thrum_fem_free(&fem);
    body_free(&b);
  }
}

/* V(q) is that of the mesh at U q, with derivatives of modes in the basis; where only the first
 * vectors have products, the monomials of two of them and another one are the same. */
static void reduced_polynomial_is_the_energy_of_the_mesh(void **state) {
  (void)state;
  enum { R = 8, FIRST = 4 };
  for (int of = 0; of < KINDS; of++) {
    body b = make((kind)of, ORTHO);
    thrum_precomputed result = body_precompute(&b, FIRST, R);
    thrum_fem fem = body_fem(&b);
    const thrum_model *model = &result.model;
    double q[R], *u = need(3 * (size_t)fem.vertex_count, sizeof *u);
    for (int i = 0; i < R; i++)
      q[i] = 0.05 * random_number();
    for (int64_t c = 0; c < 3 * fem.vertex_count; c++)
      u[c] = dot_of(model->basis + R * c, q, R);
    assert_close(polynomial_of(model, q), thrum_fem_energy(&fem, u, NULL), 1e-10);
    assert_int_equal(model->format[0], THRUM_MODEL_FORMAT_MAJOR_SOLIDS);
    assert_int_equal(model->format[1], THRUM_MODEL_FORMAT_MINOR_ELASTIC);

    double linear[R * R], *c3 = need((size_t)thrum_c3_count(R), sizeof *c3);
    double *c4 = need((size_t)thrum_c4_count(R), sizeof *c4), most = 0;
    assert_int_equal(
        thrum_polynomial_reduce(&fem, R, FIRST, model->basis, linear, c3, c4, NULL, NULL),
        THRUM_OK);
    for (int64_t i = 0; i < model->c3_count; i++)
      most = fmax(most, fabs(model->c3[i]));
    for (int64_t i = 0; i < FIRST; i++)
      for (int64_t j = i; j < FIRST; j++)
        for (int64_t h = FIRST; h < R; h++) {
          const int64_t at = thrum_c3_index(R, i, j, h);
          if (!(fabs(c3[at] - model->c3[at]) <= 1e-11 * most))
            fail_msg("c3 is %g, and %g condensed", model->c3[at], c3[at]);
        }
    free(c3);
    free(c4);
    free(u);
    thrum_fem_free(&fem);
    thrum_precomputed_free(&result);
    body_free(&b);
  }
}

/* Isotropic constants along any directions are the isotropic body, and a laminate of equal layers
 * is one layer, but for the points through its thickness. */
static void constants_that_are_isotropic_are_that_body(void **state) {
  (void)state;
  for (int of = 0; of < KINDS; of++) {
    body plain = make((kind)of, "1:5e6,0.3,1000");
    body b = make((kind)of,
                  of == SHELL ? "1:transverse,5e6,5e6,0.3,0.3,1923076.9230769231,1000,layers,30"
                              : "1:transverse,5e6,5e6,0.3,0.3,1923076.9230769231,1000,along,1,2,3");
    assert_close(b.mesh.materials[0].young, 5e6, 1e-9);
    assert_close(b.mesh.materials[0].poisson, 0.3, 1e-9);
    memcpy(b.mesh.vertices, plain.mesh.vertices,
           3 * (size_t)b.mesh.vertex_count * sizeof *b.mesh.vertices);
    if (of < HEX)
      assert_int_equal(thrum_mesh_make_solids(&plain.mesh, NULL), THRUM_OK);
    thrum_fem one = body_fem(&plain), other = body_fem(&b);
    const int64_t all = 3 * one.vertex_count;
    double *u = random_vector(all, 0.02), *f = need((size_t)all, sizeof *f),
           *g = need((size_t)all, sizeof *g);
    assert_close(thrum_fem_energy(&one, u, f), thrum_fem_energy(&other, u, g), 1e-9);
    assert_near(f, g, all, 1e-9);
    free(u);
    free(f);
    free(g);
    thrum_fem_free(&one);
    thrum_fem_free(&other);
    body_free(&plain);
    body_free(&b);
  }
}

/* Simply supported plates of h/a = 1/200: omega^2 = (pi^4 / (rho h)) (D_11 (m/a)^4 + 2 (D_12 + 2
 * D_66) (m n / a b)^2 + D_22 (n/b)^4), Jones 1999, Mechanics of composite materials, 5.5, of the
 * D of layers at 0 and 90 degrees. */
static void laminates_have_the_frequencies_of_the_series(void **state) {
  (void)state;
  static const struct {
    const char *layers;
    int count, turned[4];
  } cases[] = {{"0", 1, {0}}, {"0/90/90/0", 4, {0, 1, 1, 0}}, {"90/0/0/90", 4, {1, 0, 0, 1}}};
  const double a = 0.4, wide = 0.3, h = 0.002, density = 1600;
  const double young[2] = {140e9, 10e9}, nu = 0.3, shear = 5e9;
  const double share = 1 - nu * nu * young[1] / young[0];
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    char text[200];
    body b = hexahedra("beam:16x12x1@0.4x0.3x0.002,hex", THRUM_FORM_SHELL8, -1);
    snprintf(text, sizeof text, "1:transverse,140e9,10e9,0.3,0.4,5e9,1600,layers,%s",
             cases[n].layers);
    give(&b, text);

    // the long sides hold x and z, the short ones y and z
    for (int64_t v = 0; v < b.mesh.vertex_count; v++) {
      const double *x = b.mesh.vertices + 3 * v;
      if (x[0] < 1e-9 || x[0] > a - 1e-9)
        b.fixed[v] |= 6;
      if (fabs(x[1]) > wide / 2 - 1e-9)
        b.fixed[v] |= 5;
    }
    double d[2] = {0, 0};
    for (int l = 0; l < cases[n].count; l++) {
      const double low = h * l / cases[n].count - h / 2, high = low + h / cases[n].count;
      for (int axis = 0; axis < 2; axis++)
        d[axis] +=
            young[axis ^ cases[n].turned[l]] / share * (high * high * high - low * low * low) / 3;
    }
    const double mixed = (nu * young[1] / share + 2 * shear) * h * h * h / 12;
    const double both = 1 / (a * a * wide * wide);
    const double first = pow(TWO_PI / 2, 4) / (density * h) *
                         (d[0] / pow(a, 4) + 2 * mixed * both + d[1] / pow(wide, 4));
    thrum_precomputed result = body_precompute(&b, 1, 1);
    assert_close(sqrt(result.mode_omega2[0]), sqrt(first), 0.01);
    thrum_precomputed_free(&result);
    body_free(&b);
  }
}

/* The first frequency of a rubber beam is 1.0137 Hz by ten-node tetrahedra and hexahedra of ever
 * finer meshes; of few tetrahedra it is 5 % above that, and with a mean dilatation within 1 %. */
static void a_mean_dilatation_does_not_lock(void **state) {
  (void)state;
  for (int mean = 0; mean < 2; mean++) {
    body b = body_quadratic("beam:8x2x2@1x0.2x0.2", "x<0.001", 0, 0);
    give(&b, "1:1e6,0.499,1000");
    if (mean)
      memset(b.mesh.solid_form, THRUM_FORM_MEAN10, (size_t)b.mesh.solid_count);
    thrum_precomputed result = body_precompute(&b, 1, 1);
    const double off = sqrt(result.mode_omega2[0]) / TWO_PI / 1.0137 - 1;
    if (mean ? !(fabs(off) < 0.01) : !(off > 0.04))
      fail_msg("off by %g", off);
    thrum_precomputed_free(&result);
    body_free(&b);
  }
}

/* The nine constants come back from C, and a file keeps them. */
static void constants_are_kept(void **state) {
  (void)state;
  body b = make(SHELL, "1:transverse,9e3,1e3,0.3,0.4,500,2,along,0,1,0,layers,30@1/-45@2");
  thrum_elastic_matrix root, stiffness;
  double row[THRUM_ELASTIC_NUMBERS];
  memcpy(row, b.mesh.elastic, sizeof row);
  assert_true(thrum_elastic_root(row, root));
  thrum_elastic_stiffness(root, stiffness);
  assert_true(thrum_elastic_constants(stiffness, row));
  for (int k = 0; k < THRUM_ELASTIC_NUMBERS; k++)
    if (!(fabs(row[k] - b.mesh.elastic[k]) <= 1e-12 * fabs(row[k])))
      fail_msg("number %d is %g, not %g", k, row[k], b.mesh.elastic[k]);

  // written and read again, from the file of the model
  thrum_precomputed result = body_precompute(&b, 2, 3);
  char folder[] = "/tmp/thrum-elastic-XXXXXX", path[64];
  thrum_error error = {0};
  assert_non_null(mkdtemp(folder));
  snprintf(path, sizeof path, "%s/model.npz", folder);
  if (thrum_model_save(path, &result.model, &error) < 0)
    fail_msg("%s", error.message);
  body again = {0};
  assert_int_equal(mesh_of_model_read(path, &again.mesh, &again.fixed, &error), THRUM_OK);
  unlink(path);
  rmdir(folder);
  assert_int_equal(again.mesh.elastic_count, 2);
  assert_memory_equal(again.mesh.elastic, b.mesh.elastic, 2 * sizeof row);
  body_free(&again);
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void assert_refused(const char *text, thrum_status status, const char *part) {
  thrum_error error = {0};
  assert_int_equal(region_material_check(text, &error), status);
  if (!strstr(error.message, part))
    fail_msg("'%s' is not in '%s'", part, error.message);
}

static void bad_constants_are_refused(void **state) {
  (void)state;
  assert_refused("1:ortho,1e9,1e9,1e9,0.6,0.6,0.6,1e8,1e8,1e8,1", THRUM_BAD_VALUE,
                 "no positive energy");
  assert_refused("1:transverse,1e9,1e9,0.2,0.2,-1,1", THRUM_BAD_VALUE, "no positive energy");
  assert_refused("1:transverse,1e9,1e9,0.2,0.2,1e8,0", THRUM_BAD_VALUE, "RHO");
  static const char *const bad[] = {"1:ortho,1,2",
                                    "1:transverse,1e9,1e9,0.2,0.2,1e8,1,",
                                    "1:transverse,1e9,1e9,0.2,0.2,1e8,1,along",
                                    "1:transverse,1e9,1e9,0.2,0.2,1e8,1,along,1,2",
                                    "1:transverse,1e9,1e9,0.2,0.2,1e8,1,layers,",
                                    "1:transverse,1e9,1e9,0.2,0.2,1e8,1,layers,0/",
                                    "1:transverse,1e9,1e9,0.2,0.2,1e8,1,layers,0@-1",
                                    "1:transverse,1e9,1e9,0.2,0.2,1e8,1,layers,400"};
  for (size_t n = 0; n < sizeof bad / sizeof *bad; n++)
    assert_refused(bad[n], THRUM_BAD_FORMAT, "REGION:ortho");

  // directions that are parallel, layers of what is no sheet, and a normal along direction 1
  body b = body_make("beam:2x1x1@1x1x1", NULL);
  thrum_error error = {0};
  thrum_law law = THRUM_LAW_STVK;
  int64_t lacking = 0;
  const char *text = "1:transverse,1e9,1e9,0.2,0.2,1e8,1,along,1,0,0,2,0,0";
  assert_int_equal(region_materials_apply(&text, 1, &b.mesh, &law, &lacking, &error),
                   THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "parallel"));
  give(&b, "1:transverse,1e9,1e9,0.2,0.2,1e8,1,layers,0");
  thrum_fem fem = {0};
  assert_int_equal(thrum_fem_create(&b.mesh, b.fixed, &fem, &error), THRUM_UNSUPPORTED);
  assert_non_null(strstr(error.message, "laminate"));
  body_free(&b);
  b = make(SHELL, "1:transverse,1e9,1e9,0.2,0.2,1e8,1,along,0,0,1,layers,0");
  assert_int_equal(thrum_fem_create(&b.mesh, b.fixed, &fem, &error), THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "stands on the sheet"));
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(uniform_strain_has_the_energy_of_the_nine_constants),
      cmocka_unit_test(force_is_the_slope_of_energy_and_stiffness_that_of_force),
      cmocka_unit_test(reduced_polynomial_is_the_energy_of_the_mesh),
      cmocka_unit_test(constants_that_are_isotropic_are_that_body),
      cmocka_unit_test(laminates_have_the_frequencies_of_the_series),
      cmocka_unit_test(a_mean_dilatation_does_not_lock),
      cmocka_unit_test(constants_are_kept),
      cmocka_unit_test(bad_constants_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
