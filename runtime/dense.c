/* Dense linear systems of the implicit steps, in place: P A = L U with row exchanges, and the
 * inverse of a symmetric matrix by the sweep operator with diagonal pivots.
 *
 * The matrices are 1 + h^2/4 T + h/2 D (design 5): symmetric, but T is indefinite in compression,
 * so Cholesky may fail where these do not. Cost 2/3 n^3 to factorise, 2 n^2 to solve; n^3 to
 * invert. Source of the sweep: Goodnight 1979, doi:10.1080/00031305.1979.10482685.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#include "dense.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

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

/* The largest diagonal entry not yet swept, by size; -1 where there is none worth dividing by. */
static int32_t largest_left(const double *matrix, int32_t n, const double *swept) {
  int32_t best = -1;
  double best_size = 0.0;
  for (int32_t i = 0; i < n; i++) {
    const double size = fabs(matrix[(size_t)i * (size_t)n + (size_t)i]);
    if (swept[i] == 0.0 && size > best_size) {
      best = i;
      best_size = size;
    }
  }
  return best_size < INFINITY ? best : -1;
}

/* Sweeps the pivot k: a_kk -> -1/a_kk, a_ik -> a_ik/a_kk, a_ij -> a_ij - a_ik a_jk/a_kk.
 * Works on the lower triangle; `column` holds that of k. */
static void sweep(double *matrix, int32_t n, int32_t k, double *column) {
  for (int32_t i = 0; i < n; i++)
    column[i] = i < k ? matrix[(size_t)k * (size_t)n + (size_t)i]
                      : matrix[(size_t)i * (size_t)n + (size_t)k];
  const double inverse = 1.0 / column[k];
  for (int32_t i = 0; i < n; i++) {
    double *row = matrix + (size_t)i * (size_t)n;
    const double factor = column[i] * inverse;
    for (int32_t j = 0; j <= i; j++)
      row[j] -= factor * column[j];
  }
  for (int32_t i = 0; i < n; i++) {
    double *at = i < k ? matrix + (size_t)k * (size_t)n + (size_t)i
                       : matrix + (size_t)i * (size_t)n + (size_t)k;
    *at = i == k ? -inverse : column[i] * inverse;
  }
}

bool thrum_dense_invert(double *matrix, int32_t n, double *work) {
  double *swept = work, *column = work + n;
  memset(swept, 0, (size_t)n * sizeof *swept);
  for (int32_t turn = 0; turn < n; turn++) {
    const int32_t k = largest_left(matrix, n, swept);
    if (k < 0)
      return false;
    swept[k] = 1.0;
    sweep(matrix, n, k, column);
  }
  // all swept is minus the inverse; both triangles alike
  for (int32_t i = 0; i < n; i++)
    for (int32_t j = 0; j <= i; j++) {
      const double entry = -matrix[(size_t)i * (size_t)n + (size_t)j];
      if (!isfinite(entry))
        return false;
      matrix[(size_t)i * (size_t)n + (size_t)j] = entry;
      matrix[(size_t)j * (size_t)n + (size_t)i] = entry;
    }
  return true;
}
