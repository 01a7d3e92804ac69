/* Exchange with VegaFEM and with programs that read Matrix Market: the model that is read describes
 * the same body, and a round trip loses nothing. SPDX-License-Identifier: Apache-2.0 */
#include <unistd.h>

#include "io/file.h"
#include "io/text.h"
#include "precompute/fem/matrix_market.h"
#include "precompute/model/model_fem.h"
#include "precompute/polynomial/change_of_basis.h"
#include "precompute/vega_reduced.h"
#include "tests/support/precompute_support.h"
#include "thrum/polynomial.h"

static char folder[] = "/tmp/thrum-exchange-XXXXXX";

static int make_folder(void **state) {
  (void)state;
  return mkdtemp(folder) == NULL;
}

static int remove_folder(void **state) {
  (void)state;
  return rmdir(folder);
}

static const char *in_folder(const char *name) {
  static char path[128];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  return path;
}

static thrum_imported_basis read_sample(bool cubic) {
  thrum_imported_basis imported = {0};
  assert_int_equal(thrum_vega_basis_read(THRUM_TEST_DATA "/beam1k.r15.U", &imported, NULL),
                   THRUM_OK);
  if (cubic)
    assert_int_equal(thrum_vega_cubic_read(THRUM_TEST_DATA "/beam1k.r15.cub", &imported, NULL),
                     THRUM_OK);
  return imported;
}

static thrum_status import(const body *b, const thrum_imported_basis *imported,
                           thrum_precomputed *result, thrum_error *error) {
  thrum_precompute_options options = thrum_default_precompute_options();
  options.imported = imported;
  return thrum_precompute(&b->mesh, b->fixed, &options, result, error);
}

static thrum_precomputed import_well(const body *b, const thrum_imported_basis *imported) {
  thrum_precomputed result = {0};
  thrum_error error = {0};
  if (import(b, imported, &result, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return result;
}

// q = U^T M u of a displacement in the span of U
static void project(const thrum_model_fem *full, const thrum_model *model, const double *u,
                    double *q) {
  const int64_t n = full->fem.free_count;
  double *inside = need((size_t)n, sizeof *inside), *product = need((size_t)n, sizeof *product);
  thrum_fem_gather(&full->fem, u, inside);
  thrum_sparse_product(&full->mass, inside, 1, product);
  for (int64_t i = 0; i < model->rank; i++) {
    q[i] = 0;
    for (int64_t f = 0; f < n; f++)
      q[i] += model->basis[full->fem.component[f] * model->rank + i] * product[f];
  }
  free(inside);
  free(product);
}

static void an_imported_model_has_the_energy_of_the_body_it_was_made_from(void **state) {
  (void)state;
  body b = body_beam1k();
  for (int cubic = 0; cubic < 2; cubic++) {
    // the foreign basis is not orthonormal; the import makes it so
    thrum_imported_basis imported = read_sample(cubic);
    thrum_precomputed result = import_well(&b, &imported);
    const thrum_model *model = &result.model;
    assert_true(result.imported.changed);
    assert_true(result.imported.orthonormality > 0.2 && result.imported.orthonormality < 0.3);
    assert_true(result.basis_orthonormality < 1e-13 && result.basis_diagonality < 1e-13);

    // the full-order body of the imported model, for comparison
    thrum_model_fem full = {0};
    assert_int_equal(thrum_model_fem_create(model, &full, NULL), THRUM_OK);
    assert_int_equal(full.kind, THRUM_MASS_CONSISTENT);
    double *u = need((size_t)imported.rows, sizeof *u), *work = need(thrum_work_count(model), 8);
    double *again = need((size_t)imported.rows, sizeof *again);

    // displacements in the imported basis: the model reproduces them and their energy
    for (double size = 1e-3; size < 10; size *= 10) {
      double *old = random_vector(imported.rank, size), q[15];
      for (int64_t c = 0; c < imported.rows; c++)
        u[c] = dot_of(imported.basis + c * imported.rank, old, imported.rank);
      project(&full, model, u, q);
      for (int64_t c = 0; c < imported.rows; c++)
        again[c] = dot_of(model->basis + c * imported.rank, q, imported.rank);
      assert_near(again, u, imported.rows, 1e-12);
      assert_close(thrum_strain_energy(model, q, work), thrum_fem_energy(&full.fem, u, NULL),
                   1e-12);
      free(old);
    }
    thrum_model_fem_free(&full);
    free(u);
    free(again);
    free(work);
    thrum_precomputed_free(&result);
    thrum_imported_basis_free(&imported);
  }

  body_free(&b);
}

static void compare_models(const thrum_model *found, const thrum_model *wanted, double tolerance) {
  assert_int_equal(found->rank, wanted->rank);
  assert_near(found->omega2, wanted->omega2, wanted->rank, tolerance);
  assert_near(found->c3, wanted->c3, wanted->c3_count, tolerance);
  assert_near(found->c4, wanted->c4, wanted->c4_count, tolerance);
  assert_near(found->axis_mass, wanted->axis_mass, 3 * wanted->rank, tolerance);
  assert_near(found->basis, wanted->basis, 3 * wanted->vertex_count * wanted->rank, tolerance);
}

static void export_and_import_give_the_same_model(void **state) {
  (void)state;
  body bodies[] = {body_beam1k(), body_make("beam:8x2x2@1x0.2x0.15", NULL)};
  for (int n = 0; n < 2; n++) {
    thrum_precomputed made = body_precompute(&bodies[n], 8, 20);

    // export, and read the files as a foreign program's
    thrum_imported_basis imported = {0};
    assert_int_equal(thrum_vega_basis_write(in_folder("m.U"), &made.model, false, NULL), THRUM_OK);
    assert_int_equal(thrum_vega_basis_read(in_folder("m.U"), &imported, NULL), THRUM_OK);
    unlink(in_folder("m.U"));
    assert_int_equal(thrum_vega_cubic_write(in_folder("m.cub"), &made.model, NULL), THRUM_OK);
    assert_int_equal(thrum_vega_cubic_read(in_folder("m.cub"), &imported, NULL), THRUM_OK);
    unlink(in_folder("m.cub"));

    // the basis passes unchanged, and the polynomial is the gradient of an energy
    assert_memory_equal(imported.basis, made.model.basis,
                        sizeof(double) * (size_t)(imported.rows * imported.rank));
    assert_true(imported.defect < 1e-15);

    // the import has nothing to change, and the model is the same
    thrum_precomputed again = import_well(&bodies[n], &imported);
    assert_false(again.imported.changed);
    compare_models(&again.model, &made.model, 1e-13);
    thrum_imported_basis_free(&imported);
    thrum_precomputed_free(&made);
    thrum_precomputed_free(&again);
    body_free(&bodies[n]);
  }
}

static void expect_equal_files(const char *left, const char *right) {
  void *data[2] = {NULL, NULL};
  size_t size[2] = {0, 0};
  assert_int_equal(thrum_file_read(in_folder(left), &data[0], &size[0], NULL), THRUM_OK);
  assert_int_equal(thrum_file_read(in_folder(right), &data[1], &size[1], NULL), THRUM_OK);
  assert_int_equal(size[0], size[1]);
  assert_memory_equal(data[0], data[1], size[0]);
  free(data[0]);
  free(data[1]);
}

/* Negative zeros of held vertices and coefficients with factors of 3 return to the bit. */
static void an_imported_export_is_exported_again_to_the_bit(void **state) {
  (void)state;
  body bodies[] = {body_beam1k(), body_make("beam:8x2x2@1x0.2x0.15", NULL)};
  for (int n = 0; n < 2; n++) {
    thrum_precomputed made = body_precompute(&bodies[n], 8, 20);

    // export and import
    thrum_imported_basis imported = {0};
    assert_int_equal(thrum_vega_basis_write(in_folder("m.U"), &made.model, false, NULL), THRUM_OK);
    assert_int_equal(thrum_vega_cubic_write(in_folder("m.cub"), &made.model, NULL), THRUM_OK);
    assert_int_equal(thrum_vega_basis_read(in_folder("m.U"), &imported, NULL), THRUM_OK);
    assert_int_equal(thrum_vega_cubic_read(in_folder("m.cub"), &imported, NULL), THRUM_OK);

    // the second export equals the first, byte for byte
    thrum_precomputed again = import_well(&bodies[n], &imported);
    assert_int_equal(thrum_vega_basis_write(in_folder("a.U"), &again.model, false, NULL), THRUM_OK);
    assert_int_equal(thrum_vega_cubic_write(in_folder("a.cub"), &again.model, NULL), THRUM_OK);
    expect_equal_files("m.U", "a.U");
    expect_equal_files("m.cub", "a.cub");
    assert_memory_equal(again.model.c4, made.model.c4,
                        sizeof(double) * (size_t)made.model.c4_count);
    static const char *const files[] = {"m.U", "m.cub", "a.U", "a.cub"};
    for (int f = 0; f < 4; f++)
      unlink(in_folder(files[f]));
    thrum_imported_basis_free(&imported);
    thrum_precomputed_free(&made);
    thrum_precomputed_free(&again);
    body_free(&bodies[n]);
  }
}

static void a_mixed_and_scaled_basis_becomes_the_model_again(void **state) {
  (void)state;
  body b = body_beam1k();
  thrum_precomputed made = body_precompute(&b, 6, 12);
  const thrum_model *model = &made.model;
  const int64_t r = model->rank, rows = 3 * model->vertex_count;

  // the foreign basis is U A for some A, the energy V(A q), in another unit of the coordinates
  double *mix = random_vector(r * r, 0.3);
  for (int64_t i = 0; i < r; i++)
    mix[i * r + i] += 1;
  for (int64_t n = 0; n < r * r; n++)
    mix[n] *= 1e-3;

  // basis and linear part in the mixed coordinates
  thrum_imported_basis imported = {.rows = rows, .rank = r};
  imported.basis = need((size_t)(rows * r), 8);
  imported.linear = need((size_t)(r * r), 8);
  imported.c3 = need((size_t)model->c3_count, 8);
  imported.c4 = need((size_t)model->c4_count, 8);
  for (int64_t j = 0; j < r; j++) {
    for (int64_t c = 0; c < rows; c++)
      for (int64_t i = 0; i < r; i++)
        imported.basis[c * r + j] += model->basis[c * r + i] * mix[i * r + j];
    for (int64_t k = 0; k < r; k++)
      for (int64_t i = 0; i < r; i++)
        imported.linear[j * r + k] += mix[i * r + j] * model->omega2[i] * mix[i * r + k];
  }

  // the cubic and quartic parts transform with the same matrix
  assert_int_equal(
      thrum_polynomial_change_basis(r, mix, model->c3, model->c4, imported.c3, imported.c4, NULL),
      THRUM_OK);

  // the import undoes the mixture
  thrum_precomputed again = import_well(&b, &imported);
  assert_true(again.imported.changed);
  compare_models(&again.model, model, 1e-9);

  free(mix);
  thrum_imported_basis_free(&imported);
  thrum_precomputed_free(&made);
  thrum_precomputed_free(&again);
  body_free(&b);
}

static void single_precision_keeps_its_seven_digits(void **state) {
  (void)state;
  body b = body_beam1k();
  thrum_precomputed made = body_precompute(&b, 5, 10);

  // through a file in single precision
  thrum_imported_basis imported = {0};
  assert_int_equal(thrum_vega_basis_write(in_folder("f.U"), &made.model, true, NULL), THRUM_OK);
  assert_int_equal(thrum_vega_basis_read(in_folder("f.U"), &imported, NULL), THRUM_OK);
  unlink(in_folder("f.U"));
  assert_near(imported.basis, made.model.basis, imported.rows * imported.rank, 1e-7);

  // the import makes the basis exactly orthonormal again
  thrum_precomputed again = import_well(&b, &imported);
  assert_true(again.basis_orthonormality < 1e-13);
  assert_near(again.model.omega2, made.model.omega2, 10, 1e-6);

  thrum_imported_basis_free(&imported);
  thrum_precomputed_free(&made);
  thrum_precomputed_free(&again);
  body_free(&b);
}

static char *sample_bytes(const char *path, size_t *size) {
  void *data = NULL;
  assert_int_equal(thrum_file_read(path, &data, size, NULL), THRUM_OK);
  return data;
}

static void a_force_without_energy_is_refused_by_its_component(void **state) {
  (void)state;

  // one coefficient of the force changes, so that the force is no gradient any more
  size_t size;
  char *file = sample_bytes(THRUM_TEST_DATA "/beam1k.r15.cub", &size);
  double *force = (double *)(file + 16), largest = 0;
  for (int n = 225; n < 225 + 15 * 120; n++)
    largest = fmax(largest, fabs(force[n]));

  // component 2, coefficient of q_1 q_3
  force[225 + 120 + 2] += largest;
  assert_int_equal(thrum_file_write_atomic(in_folder("bad.cub"), file, size, NULL), THRUM_OK);

  // the refusal names the part of the polynomial and leaves the data as they were
  thrum_imported_basis imported = read_sample(false);
  thrum_error error = {0};
  assert_int_equal(thrum_vega_cubic_read(in_folder("bad.cub"), &imported, &error), THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "quadratic"));
  assert_non_null(strstr(error.message, "gradient"));
  assert_null(imported.linear);

  // files that are cut short are refused as well
  assert_int_equal(thrum_file_write_atomic(in_folder("bad.cub"), file, size - 8, NULL), THRUM_OK);
  assert_int_equal(thrum_vega_cubic_read(in_folder("bad.cub"), &imported, NULL), THRUM_BAD_FORMAT);
  assert_int_equal(thrum_file_write_atomic(in_folder("bad.cub"), file, 7, NULL), THRUM_OK);
  assert_int_equal(thrum_vega_cubic_read(in_folder("bad.cub"), &imported, NULL), THRUM_BAD_FORMAT);
  assert_int_equal(thrum_vega_basis_read(in_folder("bad.cub"), &imported, NULL), THRUM_BAD_FORMAT);
  unlink(in_folder("bad.cub"));
  assert_int_equal(imported.rank, 15);

  thrum_imported_basis_free(&imported);
  free(file);
}

static void a_basis_of_another_body_is_refused(void **state) {
  (void)state;
  body b = body_beam1k(), other = body_make("beam:6x2x2@1x0.2x0.15", "x<0.001");

  // a mesh with another number of vertices
  thrum_imported_basis imported = read_sample(true);
  thrum_precomputed result = {0};
  thrum_error error = {0};
  assert_int_equal(import(&other, &imported, &result, &error), THRUM_BAD_SHAPE);

  // one more vertex is held than in the imported basis
  b.fixed[200] = 2;
  assert_int_equal(import(&b, &imported, &result, &error), THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "vertex 201 along y"));
  b.fixed[200] = 0;

  // the stiffness differs
  b.mesh.materials[0].young *= 1.001;
  assert_int_equal(import(&b, &imported, &result, &error), THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "linear part"));
  b.mesh.materials[0].young /= 1.001;

  // the quartic part differs
  for (int64_t n = 0; n < thrum_c4_count(15); n++)
    imported.c4[n] *= 1.001;
  assert_int_equal(import(&b, &imported, &result, &error), THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "energy"));

  // the columns are dependent
  for (int64_t c = 0; c < imported.rows; c++)
    imported.basis[c * 15 + 4] = 2 * imported.basis[c * 15];
  assert_int_equal(import(&b, &imported, &result, &error), THRUM_SINGULAR);

  // a free body's basis contains a rigid motion
  memset(b.fixed, 0, (size_t)b.mesh.vertex_count);
  assert_int_equal(import(&b, &imported, &result, &error), THRUM_UNSUPPORTED);
  assert_null(result.model.basis);

  thrum_imported_basis_free(&imported);
  body_free(&b);
  body_free(&other);
}

static void matrix_market_holds_every_digit(void **state) {
  (void)state;
  body b = body_make("beam:4x2x2@1x0.2x0.15", "x<0.001");
  for (int kind = 0; kind < 2; kind++) {
    // the matrices of both kinds of mass
    thrum_precompute_options options = thrum_default_precompute_options();
    options.modes = 4;
    options.mass = (thrum_mass)kind;
    thrum_precomputed made = {0};
    assert_int_equal(thrum_precompute(&b.mesh, b.fixed, &options, &made, NULL), THRUM_OK);
    thrum_model_fem full = {0};
    assert_int_equal(thrum_model_fem_create(&made.model, &full, NULL), THRUM_OK);

    // the kind of mass is recovered from the basis
    assert_int_equal(full.kind, kind);

    const thrum_sparse *m = &full.mass;
    assert_int_equal(thrum_matrix_market_write(in_folder("m.mtx"), m, "mass", NULL), THRUM_OK);

    // the header of the file has the matrix's sizes
    thrum_text text;
    assert_int_equal(thrum_text_open(in_folder("m.mtx"), '%', 0, &text, NULL), THRUM_OK);
    unlink(in_folder("m.mtx"));
    int64_t sizes[3];
    assert_true(thrum_text_next_line(&text));
    for (int n = 0; n < 3; n++)
      assert_int_equal(thrum_text_integer(&text, "size", 0, 1000000, &sizes[n]), THRUM_OK);
    assert_int_equal(sizes[0], m->size);
    assert_int_equal(sizes[1], m->size);
    assert_int_equal(sizes[2], m->begin[m->size]);

    // every entry returns exactly, in the order of the columns
    for (int64_t column = 0; column < m->size; column++)
      for (int64_t n = m->begin[column]; n < m->begin[column + 1]; n++) {
        int64_t at[2];
        double value;
        assert_true(thrum_text_next_line(&text));
        assert_int_equal(thrum_text_integer(&text, "row", 1, m->size, &at[0]), THRUM_OK);
        assert_int_equal(thrum_text_integer(&text, "column", 1, m->size, &at[1]), THRUM_OK);
        assert_int_equal(thrum_text_number(&text, "value", &value), THRUM_OK);
        assert_true(at[0] == m->row[n] + 1 && at[1] == column + 1 && value == m->value[n]);
      }
    assert_false(thrum_text_next_line(&text));
    thrum_text_close(&text);
    thrum_model_fem_free(&full);
    thrum_precomputed_free(&made);
  }

  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_imported_model_has_the_energy_of_the_body_it_was_made_from),
      cmocka_unit_test(export_and_import_give_the_same_model),
      cmocka_unit_test(an_imported_export_is_exported_again_to_the_bit),
      cmocka_unit_test(a_mixed_and_scaled_basis_becomes_the_model_again),
      cmocka_unit_test(single_precision_keeps_its_seven_digits),
      cmocka_unit_test(a_force_without_energy_is_refused_by_its_component),
      cmocka_unit_test(a_basis_of_another_body_is_refused),
      cmocka_unit_test(matrix_market_holds_every_digit),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
