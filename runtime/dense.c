/* Dense linear systems of the implicit steps: P A = L U with row exchanges, in place.
 *
 * The matrices are 1 + h^2/4 T + h/2 D (design 5): symmetric, but T is indefinite in compression,
 * so Cholesky may fail where this does not. Cost 2/3 n^3 to factorise, 2 n^2 to solve.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#include "dense.h"

#include <math.h>
#include <stddef.h>

static int32_t largest_below(const double *matrix, int32_t n, int32_t column) {
  int32_t best = column;
  double best_size = fabs(matrix[(size_t)column * (size_t)n + (size_t)column]);
  for (int32_t i = column + 1; i < n; i++) {
    const double size = fabs(matrix[(size_t)i * (size_t)n + (size_t)column]);
    if (size > best_size) {
      best = i;
      best_size = size;
    }
  }
  return best;
}

static void swap_rows(double *a, double *b, int32_t n) {
  for (int32_t j = 0; j < n; j++) {
    const double kept = a[j];
    a[j] = b[j];
    b[j] = kept;
  }
}

bool thrum_dense_factor(double *matrix, int32_t n, int32_t *pivots) {
  for (int32_t k = 0; k < n; k++) {
    // the largest entry of the column becomes the pivot, so that the multipliers stay below one
    double *top = matrix + (size_t)k * (size_t)n;
    const int32_t chosen = largest_below(matrix, n, k);
    pivots[k] = chosen;
    if (chosen != k)
      swap_rows(top, matrix + (size_t)chosen * (size_t)n, n);
    const double pivot = top[k];
    if (pivot == 0.0 || !isfinite(pivot))
      return false;
    // eliminate the column below, row by row
    for (int32_t i = k + 1; i < n; i++) {
      double *row = matrix + (size_t)i * (size_t)n;
      const double factor = row[k] / pivot;
      row[k] = factor;
      for (int32_t j = k + 1; j < n; j++)
        row[j] -= factor * top[j];
    }
  }
  return true;
}

void thrum_dense_solve(const double *factors, int32_t n, const int32_t *pivots, double *x) {
  // the same row exchanges, all of them first: the stored multipliers moved with their rows
  for (int32_t k = 0; k < n; k++) {
    const double kept = x[k];
    x[k] = x[pivots[k]];
    x[pivots[k]] = kept;
  }
  for (int32_t i = 1; i < n; i++) {
    const double *row = factors + (size_t)i * (size_t)n;
    double sum = x[i];
    for (int32_t j = 0; j < i; j++)
      sum -= row[j] * x[j];
    x[i] = sum;
  }
  for (int32_t i = n - 1; i >= 0; i--) {
    const double *row = factors + (size_t)i * (size_t)n;
    double sum = x[i];
    for (int32_t j = i + 1; j < n; j++)
      sum -= row[j] * x[j];
    x[i] = sum / row[i];
  }
}
