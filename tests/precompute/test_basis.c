/* The basis against its definition, design 2: the dominant directions of the weighted candidates,
 * found here by the method of snapshots with weights written out.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include <lapacke.h>
#include <sys/resource.h>

#include "mesh/model_quality.h"
#include "platform/memory_return.h"
#include "precompute/basis/eigen.h"
#include "precompute/basis/modal_derivatives.h"
#include "precompute/basis/orthonormal.h"

enum { MODES = 4, CANDIDATES = MODES + MODES * (MODES + 1) / 2, RANK = 7 };

/* psi_i w_1^2/w_i^2, then Phi_ij a w_1^4/(w_i^2 w_j^2), i <= j; n x CANDIDATES. */
static double *weighted_candidates(const thrum_fem *fem, const thrum_sparse *mass,
                                   const thrum_sparse *stiffness, double diagonal) {
  const int64_t n = fem->free_count;
  double *c = need((size_t)(n * CANDIDATES), sizeof *c), w2[MODES], furthest = 0;
  double *u = need((size_t)(3 * fem->vertex_count), sizeof *u);

  // modes, then the derivatives of all pairs
  thrum_factor *factor = NULL;
  assert_int_equal(thrum_factor_create(stiffness, &factor, NULL), THRUM_OK);
  assert_int_equal(thrum_eigen_lowest(stiffness, mass, factor, MODES, w2, c, NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_derivatives(fem, factor, MODES, c, c + MODES * n, NULL, NULL), THRUM_OK);
  thrum_factor_free(factor);

  // the length by which a derivative counts against a mode
  thrum_fem_scatter(fem, c, u);
  for (int64_t v = 0; v < fem->vertex_count; v++)
    furthest = fmax(furthest, norm_of(u + 3 * v, 3));
  free(u);

  // the weights, in the order of the candidates
  const double a = 0.1 * diagonal / furthest;
  double weight[CANDIDATES];
  for (int i = 0, pair = MODES; i < MODES; i++) {
    weight[i] = w2[0] / w2[i];
    for (int j = i; j < MODES; j++)
      weight[pair++] = a * w2[0] * w2[0] / (w2[i] * w2[j]);
  }
  for (int64_t e = 0; e < n * CANDIDATES; e++)
    c[e] *= weight[e / n];
  return c;
}

/* Replaces the first columns of c by its `rank` dominant M-orthonormal directions. */
static void dominant(const thrum_sparse *mass, double *c, double *values) {
  const int64_t n = mass->size;
  double *product = need((size_t)(n * CANDIDATES), sizeof *product);
  double *top = need((size_t)(n * RANK), sizeof *top), gram[CANDIDATES * CANDIDATES];

  // the small Gram matrix of the snapshots has the directions in its eigenvectors
  thrum_sparse_product(mass, c, CANDIDATES, product);
  for (int i = 0; i < CANDIDATES; i++)
    for (int j = 0; j < CANDIDATES; j++)
      gram[i + j * CANDIDATES] = dot_of(c + i * n, product + j * n, n);
  assert_int_equal(LAPACKE_dsyev(LAPACK_COL_MAJOR, 'V', 'U', CANDIDATES, gram, CANDIDATES, values),
                   0);

  // each direction is the combination of candidates that its eigenvector names, at unit mass
  for (int r = 0; r < RANK; r++) {
    // LAPACK returns the values in ascending order
    const int from = CANDIDATES - 1 - r;
    for (int j = 0; j < CANDIDATES; j++)
      for (int64_t i = 0; i < n; i++)
        top[r * n + i] += c[j * n + i] * gram[j + from * CANDIDATES] / sqrt(values[from]);
  }
  memcpy(c, top, sizeof *top * (size_t)(n * RANK));

  free(product);
  free(top);
}

static void basis_spans_the_dominant_weighted_candidates(void **state) {
  (void)state;
  body b = body_make("beam:6x2x2@1x0.2x0.15", "x<0.001");
  thrum_fem fem = body_fem(&b);
  thrum_sparse k, m;
  assert_int_equal(thrum_fem_pattern(&fem, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&fem, NULL, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&fem, THRUM_MASS_CONSISTENT, &k, &m, NULL), THRUM_OK);

  // the candidates and their directions, computed here from the definition alone
  const int64_t n = fem.free_count;
  double values[CANDIDATES];
  double *expected = weighted_candidates(&fem, &m, &k, sqrt(1 + 0.04 + 0.0225));
  dominant(&m, expected, values);

  // the kept values lie well above the first dropped one, or the span would not be well defined
  assert_true(values[CANDIDATES - RANK] > 1.5 * values[CANDIDATES - RANK - 1]);

  // every vector of the model's basis lies in the expected span
  thrum_precomputed result = body_precompute(&b, MODES, RANK);
  double *column = need((size_t)n, sizeof *column), *product = need((size_t)n, sizeof *product);
  for (int r = 0; r < RANK; r++) {
    for (int64_t i = 0; i < n; i++)
      column[i] = result.model.basis[fem.component[i] * RANK + r];
    thrum_sparse_product(&m, column, 1, product);

    // a unit vector whose projection on the expected span has unit length lies in it
    double square = 0;
    for (int j = 0; j < RANK; j++)
      square += pow(dot_of(expected + j * n, product, n), 2);
    if (!(fabs(square - 1) < 1e-9))
      fail_msg("basis vector %d: %.3g of it is outside", r + 1, sqrt(fabs(1 - square)));
  }

  free(column);
  free(product);
  free(expected);
  thrum_precomputed_free(&result);
  thrum_sparse_free(&k);
  thrum_sparse_free(&m);
  thrum_fem_free(&fem);
  body_free(&b);
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

static void a_mode_that_the_basis_lacks_is_named(void **state) {
  (void)state;
  static const double modes[6] = {1, 4, 9, 16, 25, 36};
  // the second is missing, so the third stands in its place, and an alien in that of the third
  static const double missing[6] = {1, 9, 14, 17, 26, 400};
  static const double near[6] = {1.001, 4.1, 9, 400, 500, 600};
  assert_int_equal(thrum_basis_lacks(modes, 6, modes, 6), -1);
  assert_int_equal(thrum_basis_lacks(modes, 6, missing, 6), 1);
  // the upper half is what truncation is for
  assert_int_equal(thrum_basis_lacks(modes, 6, near, 6), -1);
  assert_int_equal(thrum_basis_lacks(modes, 6, modes, 2), 2);
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
      cmocka_unit_test(basis_spans_the_dominant_weighted_candidates),
      cmocka_unit_test(columns_are_the_orthonormal_ones_times_their_triangle),
      cmocka_unit_test(a_mode_that_the_basis_lacks_is_named),
      cmocka_unit_test(products_have_the_same_bits_in_any_memory),
      cmocka_unit_test(a_gram_matrix_takes_no_fresh_memory),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
