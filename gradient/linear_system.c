/* Dense linear systems and their transposes: P A = L U with the largest entry of a column as its
 * pivot, in place. A Jacobian of the trapezoidal discrete gradient is not symmetric, and that of no
 * step need be positive definite. Both triangles are read by rows, also for the transpose, so that
 * all loops run along memory.
 * Cost: 2/3 n^3 operations, 2 n^2 for each right-hand side.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "gradient/linear_system.h"

#include <math.h>

static void swap_rows(double *restrict a, double *restrict b, int64_t n) {
  for (int64_t j = 0; j < n; j++) {
    const double kept = a[j];
    a[j] = b[j];
    b[j] = kept;
  }
}

/* to[from..n-1] += by times the same of `row` */
static void add_row(const double *restrict row, double by, int64_t from, int64_t n,
                    double *restrict to) {
  for (int64_t j = from; j < n; j++)
    to[j] += by * row[j];
}

bool thrum_linear_factor(double *matrix, int64_t n, int32_t *rows) {
  for (int64_t k = 0; k < n; k++) {
    // the largest entry of the column becomes the pivot
    int64_t best = k;
    for (int64_t i = k + 1; i < n; i++)
      if (fabs(matrix[i * n + k]) > fabs(matrix[best * n + k]))
        best = i;
    rows[k] = (int32_t)best;
    double *pivot = matrix + k * n;
    if (best != k)
      swap_rows(pivot, matrix + best * n, n);
    if (pivot[k] == 0.0 || !isfinite(pivot[k]))
      return false;

    // the column below it is eliminated
    const double inverse = 1.0 / pivot[k];
    for (int64_t i = k + 1; i < n; i++) {
      double *row = matrix + i * n;
      row[k] *= inverse;
      add_row(pivot, -row[k], k + 1, n, row);
    }
  }
  return true;
}

static void exchange(double *x, int64_t a, int64_t b) {
  const double kept = x[a];
  x[a] = x[b];
  x[b] = kept;
}

void thrum_linear_solve(const double *factors, int64_t n, const int32_t *rows, double *x) {
  // all exchanges come first: the multipliers moved with their rows
  for (int64_t k = 0; k < n; k++)
    exchange(x, k, rows[k]);

  // L, whose diagonal is 1, then U
  for (int64_t i = 1; i < n; i++)
    for (int64_t j = 0; j < i; j++)
      x[i] -= factors[i * n + j] * x[j];
  for (int64_t i = n - 1; i >= 0; i--) {
    for (int64_t j = i + 1; j < n; j++)
      x[i] -= factors[i * n + j] * x[j];
    x[i] /= factors[i * n + i];
  }
}

void thrum_linear_solve_transposed(const double *factors, int64_t n, const int32_t *rows,
                                   double *x) {
  // U^T by its columns, which are rows of U, then L^T
  for (int64_t i = 0; i < n; i++) {
    x[i] /= factors[i * n + i];
    add_row(factors + i * n, -x[i], i + 1, n, x);
  }
  for (int64_t i = n - 1; i > 0; i--)
    add_row(factors + i * n, -x[i], 0, i, x);

  // the exchanges in the opposite order
  for (int64_t k = n - 1; k >= 0; k--)
    exchange(x, k, rows[k]);
}
