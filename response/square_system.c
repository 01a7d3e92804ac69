/* Dense linear systems in place: A P = L U, row by row, with the largest entry of a row as its
 * pivot.
 *
 * A row is reduced by the rows above it, eight of them at a time: first within the eight columns of
 * their pivots, which gives the multipliers, then in all columns behind in one pass, so that the
 * row is loaded and stored once for eight. -L is stored in place of L, for the passes add. Cost:
 * 2/3 n^3 operations, 2 n^2 for each right-hand side. Source: Golub and Van Loan 2013, Matrix
 * computations, section 3.2.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "response/square_system.h"

#include <math.h>

#include "core/base/matrix_product.h"
#include "response/wide.h"

#define ROWS_AT_ONCE 8

/* Reduces `row` by the finished rows first .. last - 1 of `matrix`. */
WIDE static void reduce(const double *matrix, int64_t n, int64_t first, int64_t last,
                        double *restrict row) {
  // the multipliers, each of which depends on those before it
  for (int64_t k = first; k < last; k++) {
    const double *above = matrix + k * n;
    const double multiplier = -row[k] / above[k];
    row[k] = multiplier;
    for (int64_t j = k + 1; j < last; j++)
      row[j] += multiplier * above[j];
  }

  // all that is behind these columns; the rows of the matrix are n apart
  int64_t k = first;
  for (; k + 4 <= last; k += 4) {
    const double *a = matrix + k * n, *b = a + n, *c = b + n, *d = c + n;
    const double wa = row[k], wb = row[k + 1], wc = row[k + 2], wd = row[k + 3];
    for (int64_t j = last; j < n; j++)
      row[j] = (((row[j] + wa * a[j]) + wb * b[j]) + wc * c[j]) + wd * d[j];
  }
  for (; k < last; k++) {
    const double *above = matrix + k * n;
    for (int64_t j = last; j < n; j++)
      row[j] += row[k] * above[j];
  }
}

static void swap_columns(double *matrix, int64_t n, int64_t a, int64_t b) {
  for (int64_t i = 0; i < n; i++) {
    double *row = matrix + i * n;
    const double kept = row[a];
    row[a] = row[b];
    row[b] = kept;
  }
}

bool thrum_square_factor(double *matrix, int64_t n, int32_t *columns) {
  for (int64_t i = 0; i < n; i++) {
    double *row = matrix + i * n;
    for (int64_t k = 0; k < i; k += ROWS_AT_ONCE)
      reduce(matrix, n, k, k + ROWS_AT_ONCE < i ? k + ROWS_AT_ONCE : i, row);

    // the largest entry that is left becomes the pivot
    int64_t best = i;
    for (int64_t j = i + 1; j < n; j++)
      if (fabs(row[j]) > fabs(row[best]))
        best = j;
    columns[i] = (int32_t)best;
    if (best != i)
      swap_columns(matrix, n, i, best);
    if (row[i] == 0 || !isfinite(row[i]))
      return false;
  }
  return true;
}

int thrum_square_sign(const double *factors, int64_t n, const int32_t *columns) {
  int sign = 1;
  for (int64_t i = 0; i < n; i++)
    if ((factors[i * n + i] < 0) != (columns[i] != i))
      sign = -sign;
  return sign;
}

/* y (count) += sign times the sum of `rows` rows of x times their weights. */
WIDE static void add_rows(int64_t rows, int64_t count, double sign, const double *weights,
                          const double *x, double *restrict y) {
  int64_t j = 0;
  for (; j + 4 <= rows; j += 4) {
    const double *a = x + j * count, *b = a + count, *c = b + count, *d = c + count;
    const double wa = sign * weights[j], wb = sign * weights[j + 1], wc = sign * weights[j + 2],
                 wd = sign * weights[j + 3];
    for (int64_t k = 0; k < count; k++)
      y[k] = (((y[k] + wa * a[k]) + wb * b[k]) + wc * c[k]) + wd * d[k];
  }
  for (; j < rows; j++)
    for (int64_t k = 0; k < count; k++)
      y[k] += sign * weights[j] * x[j * count + k];
}

/* The same for one column, where the sum is in lanes. */
static void add_weighted(int64_t rows, int64_t count, double sign, const double *weights,
                         const double *x, double *y) {
  double sum = 0;
  if (count > 1) {
    add_rows(rows, count, sign, weights, x, y);
    return;
  }
  thrum_matrix_product(1, rows, weights, x, &sum);
  *y += sign * sum;
}

void thrum_square_solve(const double *factors, int64_t n, const int32_t *columns, int64_t count,
                        double *x) {
  // forward with L, whose diagonal is 1 and of which -L is stored
  for (int64_t i = 1; i < n; i++)
    add_weighted(i, count, 1, factors + i * n, x, x + i * count);

  // backward with U
  for (int64_t i = n - 1; i >= 0; i--) {
    const double *row = factors + i * n;
    double *own = x + i * count;
    add_weighted(n - 1 - i, count, -1, row + i + 1, x + (i + 1) * count, own);
    for (int64_t c = 0; c < count; c++)
      own[c] /= row[i];
  }

  // the unknowns return to the order of their columns
  for (int64_t i = n - 1; i >= 0; i--)
    for (int64_t c = 0; c < count && columns[i] != i; c++) {
      const double kept = x[i * count + c];
      x[i * count + c] = x[columns[i] * count + c];
      x[columns[i] * count + c] = kept;
    }
}

/* a += weight b, from a multiple of eight to another. */
static inline void add_row(int64_t from, int64_t to, double weight, const double *restrict b,
                           double *restrict a) {
  for (int64_t block = from; block < to; block += 8)
    for (int64_t k = block; k < block + 8; k++)
      a[k] += weight * b[k];
}

static inline void swap_rows(int64_t width, double *restrict a, double *restrict b) {
  for (int64_t k = 0; k < width; k++) {
    const double kept = a[k];
    a[k] = b[k];
    b[k] = kept;
  }
}

/* Elimination by rows, with the largest entry of a column as its pivot, and back. Rows are added in
 * eights, which touches entries before the pivot that are not read again. */
WIDE static bool eliminate(double *system, int64_t n, int64_t width) {
  for (int64_t k = 0; k < n; k++) {
    int64_t best = k;
    for (int64_t i = k + 1; i < n; i++)
      if (fabs(system[i * width + k]) > fabs(system[best * width + k]))
        best = i;
    double *row = system + k * width;
    if (best != k)
      swap_rows(width, row, system + best * width);
    if (row[k] == 0 || !isfinite(row[k]))
      return false;
    const double inverse = 1 / row[k];
    for (int64_t i = k + 1; i < n; i++)
      add_row(k / 8 * 8, width, -system[i * width + k] * inverse, row, system + i * width);
  }

  // the right-hand sides begin in the block of the last columns at most
  const int64_t from = n / 8 * 8;
  for (int64_t k = n - 1; k >= 0; k--) {
    double *row = system + k * width;
    const double inverse = 1 / row[k];
    for (int64_t c = n; c < width; c++)
      row[c] *= inverse;
    for (int64_t i = 0; i < k; i++)
      add_row(from, width, -system[i * width + k], row, system + i * width);
  }
  return true;
}

bool thrum_square_eliminate(double *system, int64_t n, int64_t count) {
  return eliminate(system, n, thrum_square_width(n, count));
}
