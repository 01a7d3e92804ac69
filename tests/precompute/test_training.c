/* Shapes of snapshots that a basis lacks, and bases that contain them.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "precompute/basis/orthonormal.h"
#include "precompute/model/snapshots.h"

enum { MODES = 4, RANK = 8, EACH = 6, SHAPES = 3 };

/* A body, a model of it, and its matrices. */
typedef struct fixture {
  body b;
  thrum_precomputed made;
  thrum_model_fem full;
  int64_t all;
} fixture;

static fixture fixture_make(void) {
  fixture f = {.b = body_make("beam:6x2x2@1x0.2x0.15", "x<0.001")};
  f.made = body_precompute(&f.b, MODES, RANK);
  f.all = 3 * f.made.model.vertex_count;
  assert_int_equal(thrum_model_fem_create(&f.made.model, &f.full, NULL), THRUM_OK);
  return f;
}

static void fixture_free(fixture *f) {
  thrum_model_fem_free(&f->full);
  thrum_precomputed_free(&f->made);
  body_free(&f->b);
}

/* Snapshots: random sums of the basis, and of `extra` fixed random fields with falling sizes. */
static double *snapshots_make(const fixture *f, int64_t count, int64_t extra,
                              const double *fields) {
  const thrum_model *model = &f->made.model;
  double *u = need((size_t)(count * f->all), sizeof *u);
  for (int64_t s = 0; s < count; s++) {
    double *q = random_vector(RANK, 1);
    for (int64_t c = 0; c < f->all; c++)
      u[s * f->all + c] = dot_of(model->basis + c * RANK, q, RANK);
    for (int64_t e = 0; e < extra; e++) {
      const double share = random_number() / (double)(1 + e);
      for (int64_t c = 0; c < f->all; c++)
        u[s * f->all + c] += share * fields[e * f->all + c];
    }
    free(q);
  }
  return u;
}

/* Random fields that vanish where the body is held. */
static double *fields_make(const fixture *f, int64_t count) {
  double *fields = random_vector(count * f->all, 0.05);
  for (int64_t n = 0; n < count * f->all; n++)
    if (f->full.fem.dof[n % f->all] < 0)
      fields[n] = 0;
  return fields;
}

/* a^T A b of two fields, A the mass or the stiffness. */
static double product_in(const fixture *f, const thrum_sparse *norm, const double *a,
                         const double *b) {
  const int64_t n = f->full.fem.free_count;
  double *x = need((size_t)n, sizeof *x), *y = need((size_t)n, sizeof *y),
         *my = need((size_t)n, sizeof *my);
  thrum_fem_gather(&f->full.fem, a, x);
  thrum_fem_gather(&f->full.fem, b, y);
  thrum_sparse_product(norm, y, 1, my);
  const double sum = dot_of(x, my, n);
  free(x);
  free(y);
  free(my);
  return sum;
}

static double product(const fixture *f, const double *a, const double *b) {
  return product_in(f, &f->full.mass, a, b);
}

/* The part of a field that U U^T M u leaves, relative in the norm of the mass. */
static double left_of(const fixture *f, const thrum_model *model, const double *u) {
  double *column = need((size_t)f->all, sizeof *column), shown = 0;
  for (int64_t i = 0; i < model->rank; i++) {
    for (int64_t c = 0; c < f->all; c++)
      column[c] = model->basis[c * model->rank + i];
    const double share = product(f, column, u);
    shown += share * share;
  }
  free(column);
  const double whole = product(f, u, u);
  return sqrt(fmax(0, 1 - shown / whole));
}

static void shapes_are_orthonormal_and_what_the_basis_lacks(void **state) {
  (void)state;
  fixture f = fixture_make();
  double *extra = fields_make(&f, SHAPES), *u = snapshots_make(&f, 2 * EACH, SHAPES, extra);
  double *shapes = need((size_t)(RANK * f.all), sizeof *shapes);
  int64_t found = 0;
  assert_int_equal(
      thrum_snapshot_shapes(&f.made.model, &f.full, u, 2, EACH, RANK, shapes, &found, NULL),
      THRUM_OK);

  // as many as there were directions outside the basis
  assert_int_equal(found, SHAPES);
  for (int64_t i = 0; i < found; i++) {
    for (int64_t j = 0; j <= i; j++)
      assert_true(fabs(product_in(&f, &f.full.stiffness, shapes + i * f.all, shapes + j * f.all) -
                       (i == j)) < 1e-9);
    assert_true(left_of(&f, &f.made.model, shapes + i * f.all) > 1 - 1e-9);
  }
  free(extra);
  free(u);
  free(shapes);
  fixture_free(&f);
}

static void what_the_basis_shows_gives_no_shape(void **state) {
  (void)state;
  fixture f = fixture_make();
  double *u = snapshots_make(&f, EACH, 0, NULL);
  double *shapes = need((size_t)(RANK * f.all), sizeof *shapes);
  int64_t found = -1;
  assert_int_equal(
      thrum_snapshot_shapes(&f.made.model, &f.full, u, 1, EACH, RANK, shapes, &found, NULL),
      THRUM_OK);
  assert_int_equal(found, 0);
  free(u);
  free(shapes);
  fixture_free(&f);
}

static void a_large_run_counts_no_more_than_a_small_one(void **state) {
  (void)state;
  fixture f = fixture_make();

  // two runs in two directions, one a million times as large
  double *extra = fields_make(&f, 2), *u = need((size_t)(2 * f.all), sizeof *u);
  memcpy(u, extra, (size_t)(2 * f.all) * sizeof *u);
  for (int64_t c = 0; c < f.all; c++)
    u[c] *= 1e6;
  double *shapes = need((size_t)(2 * f.all), sizeof *shapes);
  int64_t found = 0;
  assert_int_equal(thrum_snapshot_shapes(&f.made.model, &f.full, u, 2, 1, 2, shapes, &found, NULL),
                   THRUM_OK);
  assert_int_equal(found, 2);
  free(extra);
  free(u);
  free(shapes);
  fixture_free(&f);
}

static void a_basis_contains_the_shapes_it_is_given(void **state) {
  (void)state;
  fixture f = fixture_make();
  double *extra = fields_make(&f, SHAPES);
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = MODES;
  options.rank = RANK + SHAPES;
  options.trained = extra;
  options.trained_count = SHAPES;
  thrum_precomputed trained = {0};
  thrum_error error = {0};
  if (thrum_precompute(&f.b.mesh, f.b.fixed, &options, &trained, &error) != THRUM_OK)
    fail_msg("%s", error.message);

  // the shapes, all that the basis showed without them, and a model in Thrum's form
  double *column = need((size_t)f.all, sizeof *column);
  for (int64_t e = 0; e < SHAPES; e++) {
    assert_true(left_of(&f, &f.made.model, extra + e * f.all) > 0.1);
    assert_true(left_of(&f, &trained.model, extra + e * f.all) < 1e-6);
  }
  for (int64_t i = 0; i < RANK; i++) {
    for (int64_t c = 0; c < f.all; c++)
      column[c] = f.made.model.basis[c * RANK + i];
    assert_true(left_of(&f, &trained.model, column) < 1e-6);
  }
  assert_int_equal(trained.model.rank, RANK + SHAPES);
  assert_true(trained.basis_orthonormality < 1e-10);
  assert_true(trained.basis_diagonality < 1e-10);

  // shapes that the basis has already are refused
  for (int64_t c = 0; c < f.all; c++)
    extra[c] = trained.mode_omega2 ? f.made.model.basis[c * RANK] : 0;
  thrum_precomputed none = {0};
  assert_int_equal(thrum_precompute(&f.b.mesh, f.b.fixed, &options, &none, &error),
                   THRUM_INVALID_ARGUMENT);
  free(column);
  free(extra);
  thrum_precomputed_free(&trained);
  fixture_free(&f);
}

static void shares_choose_the_derivatives_and_all_modes_stay(void **state) {
  (void)state;
  fixture f = fixture_make();

  // a motion in which the derivative of the second mode by itself alone does anything
  double shares[MODES + MODES * (MODES + 1) / 2] = {0};
  shares[MODES + MODES] = 1;
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = MODES;
  options.rank = MODES + 1;
  options.shares = shares;
  options.keep_modes = true;
  thrum_precomputed made = {0};
  thrum_error error = {0};
  if (thrum_precompute(&f.b.mesh, f.b.fixed, &options, &made, &error) != THRUM_OK)
    fail_msg("%s", error.message);

  for (int64_t i = 0; i < MODES; i++)
    assert_true(left_of(&f, &made.model, made.mode_vectors + i * f.all) < 1e-6);
  int64_t found = 0;
  for (int64_t i = 0; i <= MODES; i++) {
    const thrum_coordinate *c = &made.coordinates[i];
    if (c->kind == THRUM_COORDINATE_MODE)
      continue;
    found++;
    assert_int_equal(c->kind, THRUM_COORDINATE_DERIVATIVE);
    assert_true(c->pairs[0][0] == 2 && c->pairs[0][1] == 2);
    assert_true(fabs(c->pair_shares[0] - 1) < 1e-9);
  }
  assert_int_equal(found, 1);
  thrum_precomputed_free(&made);
  fixture_free(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(shapes_are_orthonormal_and_what_the_basis_lacks),
      cmocka_unit_test(what_the_basis_shows_gives_no_shape),
      cmocka_unit_test(a_large_run_counts_no_more_than_a_small_one),
      cmocka_unit_test(a_basis_contains_the_shapes_it_is_given),
      cmocka_unit_test(shares_choose_the_derivatives_and_all_modes_stay),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
