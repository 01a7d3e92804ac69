/* Tests of the inverse of a symmetric matrix: it is right, it is refused where there is none, and
 * it has the same bits with every kernel that this machine has.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "core/linear_algebra/dense.h"
#include "core/polynomial/packed.h"
#include "tests/support/random_model.h"

typedef enum matrix_kind {
  ANY_SIGN,
  DEFINITE,
  ONE_NEGATIVE,
  UNCOUPLED,
  HUGE_ONES,
  TINY_ONES
} matrix_kind;

#ifndef RANK_LIMIT
#define RANK_LIMIT 100
#endif
enum { MOST = RANK_LIMIT, KINDS = TINY_ONES + 1 };

static double matrix[MOST * MOST], inverses[2][MOST * MOST], work[(MOST + 10) * (MOST + 8)];

/* Makes an n x n matrix: of any sign; definite; definite but for one pivot in the middle; definite
 * and diagonal with zeros of both signs beside it; definite and near the ends of the range of
 * numbers. */
static void make_kind(random_state *random, matrix_kind which, int n, double *to) {
  const double scale = which == HUGE_ONES ? 1e200 : which == TINY_ONES ? 1e-200 : 1;
  random_vector(random, n * n, 1, to);
  for (int i = 0; i < n; i++) {
    to[n * i + i] = scale * (to[n * i + i] + (which == ANY_SIGN ? 0 : n));
    for (int j = 0; j < i; j++)
      to[n * j + i] = to[n * i + j] *= which == UNCOUPLED ? 0 : scale;
  }
  if (which == ONE_NEGATIVE)
    to[n / 2 * (n + 1)] = -n;
}

/* Asserts how many pivots a sweep takes in order. */
static void expect_swept(const thrum_kernel *by, matrix_kind which, int n) {
  const int even = n + n % 2, stride = (int)thrum_whole(even);
  double *rows = work + THRUM_SWEEP_VECTORS * stride;
  memset(rows, 0, (size_t)(even * stride) * sizeof *rows);
  for (int i = 0; i < n; i++)
    memcpy(rows + i * stride, matrix + i * n, (size_t)n * sizeof *rows);
  if (n % 2 != 0)
    rows[n * stride + n] = 1;
  const int expected = which == ONE_NEGATIVE ? n / 2 / 2 * 2 : even;
  assert_int_equal(by->sweep(even, rows, work), expected);
}

static void every_kernel_gives_the_same_inverse(void **context) {
  (void)context;
  random_state random = {6};
  for (int n = 1; n <= MOST; n++)

    for (int kind = 0; kind < KINDS; kind++) {
      // a random matrix of this kind and vectors for a product
      double s[2 * MOST], w[2 * MOST], products[2][MOST];
      random_vector(&random, 2 * MOST, 1, s);
      random_vector(&random, 2 * MOST, 1, w);
      make_kind(&random, (matrix_kind)kind, n, matrix);

      // the work space fits into that of the tangent
      assert_true(thrum_dense_work(n) * sizeof *work <= sizeof work);
      assert_true((int64_t)thrum_dense_work(n) <= thrum_pack_work_tangent(n));

      // every kernel inverts a copy of the matrix
      for (int id = THRUM_KERNEL_REFERENCE; id <= THRUM_KERNEL_WASM; id++) {
        const int k = id != THRUM_KERNEL_REFERENCE;
        const thrum_kernel *by = thrum_kernel_get(id);
        memcpy(inverses[k], matrix, sizeof matrix);
        // the result does not depend on the previous content of the work space
        memset(work, 0xff, sizeof work);
        assert_true(thrum_dense_invert(by, inverses[k], n, work));

        // an update of rank two and a product with the inverse
        const thrum_two two = {s, w, w, s, 2, MOST};
        by->rank_two(n, false, &two, inverses[k]);
        by->product(n, n, inverses[k], s, products[k]);
        if (kind != ANY_SIGN)
          expect_swept(by, (matrix_kind)kind, n);

        // the reference comes first; every other kernel has its bits
        if (k) {
          assert_memory_equal(products[0], products[1], (size_t)n * sizeof(double));
          assert_memory_equal(inverses[0], inverses[1], (size_t)(n * n) * sizeof(double));
        }
      }
    }
}

/* Returns the largest entry of A A^-1 - 1 relative to the sum of its absolute terms. */
static double worst_residual(int n, const double *inverse) {
  double worst = 0;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      double sum = 0, size = 0;
      for (int k = 0; k < n; k++) {
        sum += matrix[n * i + k] * inverse[n * k + j];
        size += fabs(matrix[n * i + k] * inverse[n * k + j]);
      }
      worst = fmax(worst, fabs(sum - (i == j)) / size);
    }
  return worst;
}

static void an_inverse_is_symmetric_and_undoes_its_matrix(void **state) {
  (void)state;
  random_state random = {3};
  for (int n = 1; n <= MOST; n++)
    for (int kind = 0; kind < KINDS; kind++) {
      double *inverse = inverses[0];
      make_kind(&random, (matrix_kind)kind, n, matrix);
      memcpy(inverse, matrix, sizeof matrix);
      assert_true(thrum_dense_invert(&thrum_kernel_reference, inverse, n, work));
      for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++)
          assert_true(inverse[n * i + j] == inverse[n * j + i]);
      // pivots on the diagonal alone leave larger errors in an indefinite matrix
      assert_true(worst_residual(n, inverse) <= (kind == ANY_SIGN ? 1e-9 : 1e-14 * n));
    }
}

/* A matrix as ill-conditioned as stiff modes beside soft ones make it: A A^-1 = 1 to rounding. */
static void the_inverse_of_a_stiff_matrix_is_good_to_rounding(void **context) {
  (void)context;
  double *inverse = inverses[0];
  random_state random = {8};
  for (int n = 1; n <= MOST; n++) {
    make_kind(&random, DEFINITE, n, matrix);
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n; j++)
        matrix[n * i + j] *= pow(10, 0.04 * (i + j));
    memcpy(inverse, matrix, sizeof matrix);
    assert_true(thrum_dense_invert(thrum_kernel_get(THRUM_KERNEL_BEST), inverse, n, work));
    assert_true(worst_residual(n, inverse) <= 1e-14 * n);
  }
}

static void a_matrix_without_a_diagonal_pivot_or_a_number_is_refused(void **context) {
  (void)context;
  const thrum_kernel *by = &thrum_kernel_reference;
  double zero[4] = {0, 0, 0, 0}, singular[4] = {1, 2, 2, 4}, turn[4] = {0, 1, 1, 0};
  double nan[4] = {1, NAN, NAN, 1}, infinite[4] = {INFINITY, 0, 0, 1};
  assert_false(thrum_dense_invert(by, zero, 2, work));
  assert_false(thrum_dense_invert(by, singular, 2, work));
  assert_false(thrum_dense_invert(by, turn, 2, work));
  assert_false(thrum_dense_invert(by, nan, 2, work));
  assert_false(thrum_dense_invert(by, infinite, 2, work));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_inverse_is_symmetric_and_undoes_its_matrix),
      cmocka_unit_test(the_inverse_of_a_stiff_matrix_is_good_to_rounding),
      cmocka_unit_test(every_kernel_gives_the_same_inverse),
      cmocka_unit_test(a_matrix_without_a_diagonal_pivot_or_a_number_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
