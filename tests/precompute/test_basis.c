/* The basis against its definition, design 2: all modes, and the dominant directions of what the
 * weighted derivatives show beside them in the norm of the stiffness, found here by the method of
 * snapshots with weights written out. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include <lapacke.h>
#include <sys/resource.h>

#include "platform/memory_return.h"
#include "precompute/basis/eigen.h"
#include "precompute/basis/modal_derivatives.h"
#include "precompute/basis/orthonormal.h"

enum { MODES = 4, PAIRS = MODES * (MODES + 1) / 2, MORE = 4, RANK = MODES + MORE };

/* A body with its matrices, its modes and, behind them, their derivatives; n x (MODES + PAIRS). */
typedef struct parts {
  body b;
  thrum_fem fem;
  thrum_sparse k, m;
  double w2[MODES], *columns;
} parts;

static parts parts_make(const char *mesh, const char *fix) {
  parts p = {.b = body_make(mesh, fix)};
  p.fem = body_fem(&p.b);
  assert_int_equal(thrum_fem_pattern(&p.fem, &p.k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&p.fem, NULL, &p.k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&p.fem, THRUM_MASS_CONSISTENT, &p.k, &p.m, NULL), THRUM_OK);
  const int64_t n = p.fem.free_count;
  double *c = p.columns = need((size_t)(n * (MODES + PAIRS)), sizeof *c);
  thrum_factor *factor = NULL;
  assert_int_equal(thrum_factor_create(&p.k, &factor, NULL), THRUM_OK);
  assert_int_equal(thrum_eigen_lowest(&p.k, &p.m, factor, MODES, p.w2, c, NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_derivatives(&p.fem, factor, MODES, c, c + MODES * n, NULL, NULL),
                   THRUM_OK);
  thrum_factor_free(factor);
  return p;
}

static void parts_free(parts *p) {
  free(p->columns);
  thrum_sparse_free(&p->k);
  thrum_sparse_free(&p->m);
  thrum_fem_free(&p->fem);
  body_free(&p->b);
}

/* x^T A y. */
static double product_in(const thrum_sparse *a, const double *x, const double *y) {
  double *image = need((size_t)a->size, sizeof *image);
  thrum_sparse_product(a, y, 1, image);
  const double sum = dot_of(x, image, a->size);
  free(image);
  return sum;
}

/* Takes the modes out of the derivatives, in the inner product of the mass, and weighs these. */
static void weigh_remainders(parts *p) {
  const int64_t n = p->fem.free_count;
  double *c = p->columns + MODES * n;
  for (int i = 0; i < MODES; i++)
    for (int j = i; j < MODES; j++, c += n) {
      for (int mode = 0; mode < MODES; mode++) {
        const double *psi = p->columns + mode * n, share = product_in(&p->m, psi, c);
        for (int64_t f = 0; f < n; f++)
          c[f] -= share * psi[f];
      }
      for (int64_t f = 0; f < n; f++)
        c[f] *= p->w2[0] * p->w2[0] / (p->w2[i] * p->w2[j]);
    }
}

/* Replaces the first remainders by the dominant directions of all, of unit strain energy. */
static void dominant(parts *p, double *values) {
  const int64_t n = p->fem.free_count;
  double *c = p->columns + MODES * n, gram[PAIRS * PAIRS];
  double *top = need((size_t)(n * MORE), sizeof *top);

  // the small Gram matrix of the snapshots has the directions in its eigenvectors, ascending
  for (int i = 0; i < PAIRS; i++)
    for (int j = 0; j < PAIRS; j++)
      gram[i + j * PAIRS] = product_in(&p->k, c + i * n, c + j * n);
  assert_int_equal(LAPACKE_dsyev(LAPACK_COL_MAJOR, 'V', 'U', PAIRS, gram, PAIRS, values), 0);
  for (int r = 0; r < MORE; r++) {
    const int from = PAIRS - 1 - r;
    for (int j = 0; j < PAIRS; j++)
      for (int64_t f = 0; f < n; f++)
        top[r * n + f] += c[j * n + f] * gram[j + from * PAIRS] / sqrt(values[from]);
  }
  memcpy(c, top, sizeof *top * (size_t)(n * MORE));
  free(top);
}

/* A column of a model's basis on the free components. */
static double *column_of(const parts *p, const thrum_model *model, int64_t i) {
  double *column = need((size_t)p->fem.free_count, sizeof *column);
  for (int64_t f = 0; f < p->fem.free_count; f++)
    column[f] = model->basis[p->fem.component[f] * model->rank + i];
  return column;
}

/* How much of a field of unit mass the columns of the basis, which are mass-orthonormal, show. */
static double shown_of(const parts *p, const thrum_model *model, const double *field) {
  double square = 0;
  for (int64_t i = 0; i < model->rank; i++) {
    double *column = column_of(p, model, i);
    square += pow(product_in(&p->m, column, field), 2);
    free(column);
  }
  return square / product_in(&p->m, field, field);
}

static void basis_spans_the_modes_and_the_dominant_remainders(void **state) {
  (void)state;
  parts p = parts_make("beam:6x2x2@1x0.2x0.15", "x<0.001");
  double values[PAIRS];
  weigh_remainders(&p);
  dominant(&p, values);

  // the kept values lie well above the first dropped one, or the span would not be well defined
  assert_true(values[PAIRS - MORE] > 1.5 * values[PAIRS - MORE - 1]);
  thrum_precomputed result = body_precompute(&p.b, MODES, RANK);
  for (int r = 0; r < RANK; r++) {
    const double shown = shown_of(&p, &result.model, p.columns + r * p.fem.free_count);
    if (!(fabs(shown - 1) < 1e-9))
      fail_msg("direction %d: %.3g of it is outside", r + 1, sqrt(fabs(1 - shown)));
  }
  thrum_precomputed_free(&result);
  parts_free(&p);
}

/* Every mode is a coordinate of its own, with its frequency, at any rank; a lower one has the first
 * of them. The second bending modes of a square section are as slow as the first ones. */
static void every_mode_is_a_coordinate(void **state) {
  (void)state;
  static const char *const meshes[] = {"beam:6x2x2@1x0.2x0.15", "beam:8x2x2@1x0.1x0.1"};
  for (int mesh = 0; mesh < 2; mesh++) {
    parts p = parts_make(meshes[mesh], "x<0.001");
    for (int64_t rank = 2; rank <= MODES + PAIRS - 1; rank += 3) {
      thrum_precomputed result = body_precompute(&p.b, MODES, rank);
      int64_t modes = 0;
      for (int64_t i = 0; i < rank; i++) {
        const thrum_coordinate *c = &result.coordinates[i];
        if (c->kind != THRUM_COORDINATE_MODE)
          continue;
        assert_int_equal(c->mode, ++modes);
        assert_true(fabs(result.model.omega2[i] / p.w2[c->mode - 1] - 1) < 1e-9);
        assert_true(fabs(c->share - 1) < 1e-9);
        double *column = column_of(&p, &result.model, i);
        const double *psi = p.columns + (c->mode - 1) * p.fem.free_count;
        assert_true(fabs(fabs(product_in(&p.m, column, psi)) - 1) < 1e-9);
        free(column);
      }
      assert_int_equal(modes, rank < MODES ? rank : MODES);
      assert_true(result.basis_orthonormality < 1e-12 && result.basis_diagonality < 1e-12);
      thrum_precomputed_free(&result);
    }
    parts_free(&p);
  }
}

/* What is said of a coordinate is what its column has of the strain energy of the derivatives. */
static void derivatives_of_a_coordinate_are_those_along_it(void **state) {
  (void)state;
  parts p = parts_make("beam:6x2x2@1x0.2x0.15", "x<0.001");
  thrum_precomputed result = body_precompute(&p.b, MODES, RANK);
  int64_t found = 0;
  weigh_remainders(&p);
  for (int64_t i = 0; i < RANK; i++) {
    const thrum_coordinate *c = &result.coordinates[i];
    if (c->kind != THRUM_COORDINATE_DERIVATIVE)
      continue;
    found++;

    // y^T K Phi of every pair, whose squares are what the coordinate may take
    double *column = column_of(&p, &result.model, i), energy[PAIRS], all = 0;
    for (int pair = 0; pair < PAIRS; pair++) {
      energy[pair] =
          pow(product_in(&p.k, column, p.columns + (MODES + pair) * p.fem.free_count), 2);
      all += energy[pair];
    }
    for (int n = 0; n < THRUM_COORDINATE_PAIRS; n++) {
      const int64_t a = c->pairs[n][0] - 1, b = c->pairs[n][1] - 1;
      const int64_t pair = a * MODES - a * (a - 1) / 2 + b - a;
      assert_true(fabs(energy[pair] / all - c->pair_shares[n]) < 1e-9);
      int larger = 0;
      for (int other = 0; other < PAIRS; other++)
        larger += energy[other] > energy[pair] * (1 + 1e-9);
      assert_true(larger <= n);
    }
    free(column);
  }
  assert_int_equal(found, MORE);
  thrum_precomputed_free(&result);
  parts_free(&p);
}

/* Q and R of a mass-QR give back the columns, also those that depend on others or nearly do. */
static void columns_are_the_orthonormal_ones_times_their_triangle(void **state) {
  (void)state;
  enum { COLUMNS = 8, SPAN = 6 };
  body b = body_make("beam:6x2x2@1x0.2x0.15", "x<0.001");
  thrum_fem fem = body_fem(&b);
  thrum_sparse k, m;
  assert_int_equal(thrum_fem_pattern(&fem, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&fem, THRUM_MASS_CONSISTENT, &k, &m, NULL), THRUM_OK);
  const int64_t n = fem.free_count;
  double *x = need((size_t)(n * COLUMNS), sizeof *x), *given = need((size_t)(n * COLUMNS), 8);
  double *work = need((size_t)(n * THRUM_GRAM_WORK), sizeof *work), *image = need((size_t)n, 8);

  // columns 1, 3 and 5 differ from the one before by 1e-2, 1e-4 and 1e-6; 6 is a sum, 7 is zero
  static const double apart[SPAN] = {1, 1e-2, 1, 1e-4, 1, 1e-6};
  for (int c = 0; c < SPAN; c++)
    for (int64_t i = 0; i < n; i++)
      x[c * n + i] = (c % 2 == 1 ? x[(c - 1) * n + i] : 0) +
                     apart[c] * sin(7.3 * c + (1.7 * c + 1) * (double)i);
  for (int64_t i = 0; i < n; i++)
    x[6 * n + i] = x[i] + x[4 * n + i];
  for (int c = 0; c < COLUMNS - 1; c++) {
    thrum_sparse_product(&m, x + c * n, 1, image);
    const double length = sqrt(dot_of(x + c * n, image, n));
    for (int64_t i = 0; i < n; i++)
      x[c * n + i] /= length;
  }
  memcpy(given, x, sizeof *x * (size_t)(n * COLUMNS));

  double entries[COLUMNS * COLUMNS];
  int32_t which[COLUMNS];
  int64_t rank = 0;
  assert_int_equal(thrum_mass_factor(&m, COLUMNS, x, 1e-8, &rank, entries, which, work, NULL),
                   THRUM_OK);
  assert_int_equal(rank, SPAN);

  // orthonormal, and every column is what the triangle says
  for (int c = 0; c < SPAN; c++) {
    thrum_sparse_product(&m, x + c * n, 1, image);
    for (int d = 0; d < SPAN; d++)
      assert_true(fabs(dot_of(x + d * n, image, n) - (c == d)) < 1e-13);
  }
  for (int c = 0; c < COLUMNS; c++)
    for (int64_t i = 0; i < n; i++) {
      double sum = 0;
      for (int d = 0; d < SPAN; d++)
        sum += x[d * n + i] * entries[d + c * COLUMNS];
      assert_true(fabs(sum - given[which[c] * n + i]) < 1e-12);
    }

  free(x);
  free(given);
  free(work);
  free(image);
  thrum_sparse_free(&k);
  thrum_sparse_free(&m);
  thrum_fem_free(&fem);
  body_free(&b);
}

/* A chain of springs: 2 on the diagonal, -1 beside it. */
static thrum_sparse chain(int64_t n) {
  thrum_sparse matrix = {0};
  assert_int_equal(thrum_sparse_create(n, 2 * n - 1, &matrix, NULL), THRUM_OK);
  for (int64_t j = 0, e = 0; j < n; j++) {
    matrix.row[e] = j;
    matrix.value[e++] = 2;
    if (j + 1 < n) {
      matrix.row[e] = j + 1;
      matrix.value[e++] = -1;
    }
    matrix.begin[j + 1] = e;
  }
  return matrix;
}

static void products_have_the_same_bits_in_any_memory(void **state) {
  (void)state;
  enum { N = 50, COLUMNS = 19 };
  thrum_sparse matrix = chain(N);
  double x[N * COLUMNS], wanted[N * COLUMNS], found[N * COLUMNS], work[N * THRUM_PRODUCT_WORK];
  for (int i = 0; i < N * COLUMNS; i++)
    x[i] = sin(3.7 * i);

  // what was in the memory does not matter, nor how many columns go together
  for (int columns = 1; columns <= COLUMNS; columns++) {
    for (int i = 0; i < N * THRUM_PRODUCT_WORK; i++)
      work[i] = NAN;
    thrum_sparse_product(&matrix, x, columns, wanted);
    thrum_sparse_product_in(&matrix, x, columns, found, work);
    assert_memory_equal(found, wanted, sizeof *x * (size_t)(N * columns));
    thrum_sparse_product_in(&matrix, x, columns, found, NULL);
    assert_memory_equal(found, wanted, sizeof *x * (size_t)(N * columns));
  }
  thrum_sparse_free(&matrix);
}

/* The pages that the system gave this process so far. */
static long pages_given(void) {
  struct rusage usage;
  assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
  return usage.ru_minflt;
}

/* Gram matrices took fresh memory for each eight columns, a quarter of the time of a basis where
 * that is given back to the system, as thrum-mpi has it. */
static void a_gram_matrix_takes_no_fresh_memory(void **state) {
  (void)state;
  enum { COLUMNS = 16 };
  const int64_t n = 70000;
  memory_return_begin();
  thrum_sparse matrix = chain(n);
  double *x = need((size_t)(n * COLUMNS), sizeof *x);
  double *work = need((size_t)(n * THRUM_GRAM_WORK), sizeof *work), gram[COLUMNS * COLUMNS];
  for (int64_t i = 0; i < n * COLUMNS; i++)
    x[i] = (double)(i % 7);

  // the first touches its memory; a copy of eight columns would be some 1,100 pages
  thrum_mass_gram(&matrix, x, COLUMNS, x, COLUMNS, gram, work);
  const long before = pages_given();
  thrum_mass_gram(&matrix, x, COLUMNS, x, COLUMNS, gram, work);
  assert_true(pages_given() - before < 500);
  free(x);
  free(work);
  thrum_sparse_free(&matrix);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(basis_spans_the_modes_and_the_dominant_remainders),
      cmocka_unit_test(every_mode_is_a_coordinate),
      cmocka_unit_test(derivatives_of_a_coordinate_are_those_along_it),
      cmocka_unit_test(columns_are_the_orthonormal_ones_times_their_triangle),
      cmocka_unit_test(products_have_the_same_bits_in_any_memory),
      cmocka_unit_test(a_gram_matrix_takes_no_fresh_memory),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
