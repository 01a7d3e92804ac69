/* Dense linear systems of the implicit steps, in place: P A = L U with row exchanges, and the
 * inverse of a symmetric matrix by the sweep operator with diagonal pivots: in their order while
 * they are positive and not small, as where the matrix is positive definite, then the largest left.
 *
 * The matrices are 1 + h^2/4 T + h/2 D (design 5): symmetric, but T is indefinite in compression,
 * so Cholesky may fail where these do not. Cost 2/3 n^3 to factorise, 2 n^2 to solve; n^3 to
 * invert, which is faster than dpotrf and dpotri of OpenBLAS up to the largest rank: so no LAPACK
 * is called. Source of the sweep: Goodnight 1979, doi:10.1080/00031305.1979.10482685.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/linear_algebra/dense.h"

#include <float.h>
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

  // forward with L, whose diagonal is 1
  for (int32_t i = 1; i < n; i++) {
    const double *row = factors + (size_t)i * (size_t)n;
    double sum = x[i];
    for (int32_t j = 0; j < i; j++)
      sum -= row[j] * x[j];
    x[i] = sum;
  }

  // backward with U
  for (int32_t i = n - 1; i >= 0; i--) {
    const double *row = factors + (size_t)i * (size_t)n;
    double sum = x[i];
    for (int32_t j = i + 1; j < n; j++)
      sum -= row[j] * x[j];
    x[i] = sum / row[i];
  }
}

/* Scratch of an inverse: vectors of n. */
typedef struct pair {
  double *swept;             /* 1 where done */
  double *diagonal;          /* of what is not swept yet */
  double *first, *second;    /* columns of the pivots, the second's as the first leaves it */
  double *minus_1, *minus_2; /* the same over minus their pivots */
} pair;

/* The largest entry not yet swept, by size; -1 where there is none to divide by. */
static int32_t largest_left(const double *diagonal, int32_t n, const double *swept) {
  int32_t best = -1;
  double best_size = 0.0;
  for (int32_t i = 0; i < n; i++)
    if (swept[i] == 0.0 && fabs(diagonal[i]) > best_size) {
      best = i;
      best_size = fabs(diagonal[i]);
    }
  return best_size < INFINITY ? best : -1;
}

/* Column k of a symmetric matrix, of which the lower triangle counts. */
static void read_column(const double *matrix, int32_t n, int32_t k, double *column) {
  memcpy(column, matrix + (size_t)k * (size_t)n, (size_t)k * sizeof *column);
  for (int32_t i = k; i < n; i++)
    column[i] = matrix[(size_t)i * (size_t)n + (size_t)k];
}

static void write_column(double *matrix, int32_t n, int32_t k, const double *column) {
  memcpy(matrix + (size_t)k * (size_t)n, column, (size_t)k * sizeof *column);
  for (int32_t i = k; i < n; i++)
    matrix[(size_t)i * (size_t)n + (size_t)k] = column[i];
}

static void over_minus_pivot(const double *column, int32_t n, int32_t k, double *minus) {
  const double inverse = -1.0 / column[k];
  for (int32_t i = 0; i < n; i++)
    minus[i] = column[i] * inverse;
}

/* Sweeps pivots k and l, l < 0: none, from their columns: see `sweep`. */
static void finish_pair(const thrum_kernel *by, double *matrix, int32_t n, int32_t k, int32_t l,
                        const pair *p) {
  // the columns of both pivots change all the others
  const thrum_two both = {p->minus_1, p->first, p->minus_2, p->second, 1, 0};
  by->rank_two(n, true, &both, matrix);

  // what the pivots' own columns become
  const double corner = -1.0 / p->first[k], across = p->second[k];
  for (int32_t i = 0; i < n; i++)
    p->first[i] = p->minus_2[i] * across - p->minus_1[i];
  p->first[k] = corner + p->minus_2[k] * across;
  write_column(matrix, n, k, p->first);

  // the second pivot's column, where there is one
  if (l < 0)
    return;
  const double last = -1.0 / p->second[l];
  for (int32_t i = 0; i < n; i++)
    p->second[i] = -p->minus_2[i];
  p->second[l] = last;
  write_column(matrix, n, l, p->second);
}

/* The second column of a pair, as the first pivot leaves it. */
static void read_second(const double *matrix, int32_t n, int32_t k, int32_t l, const pair *p) {
  read_column(matrix, n, l, p->second);
  const double factor = p->minus_1[l];
  for (int32_t i = 0; i < n; i++)
    p->second[i] += factor * p->first[i];
  p->second[k] = -factor;
}

/* Sweeps pivot k, a_kk -> -1/a_kk, a_ik -> a_ik/a_kk, a_ij -> a_ij - a_ik a_jk/a_kk, and after it a
 * second one, if any is left: two at a time read the matrix half as often. False: the next pivot is
 * zero or no number. */
static bool sweep(const thrum_kernel *by, double *matrix, int32_t n, int32_t k, bool another,
                  const pair *p) {
  // the first pivot's column, and what is left of the diagonal after it
  read_column(matrix, n, k, p->first);
  over_minus_pivot(p->first, n, k, p->minus_1);
  for (int32_t i = 0; i < n; i++)
    p->diagonal[i] += p->minus_1[i] * p->first[i];

  // the second pivot is the largest that is left, and its column is read as the first sweep leaves
  // it
  const int32_t l = another ? largest_left(p->diagonal, n, p->swept) : -1;
  if (another) {
    if (l < 0)
      return false;
    p->swept[l] = 1.0;
    read_second(matrix, n, k, l, p);
    over_minus_pivot(p->second, n, l, p->minus_2);
    for (int32_t i = 0; i < n; i++)
      p->diagonal[i] += p->minus_2[i] * p->second[i];
  }

  finish_pair(by, matrix, n, k, l, p);
  return true;
}

/* The matrix in rows of whole vectors, zero beyond it but for a one where that makes it even. */
static void widen(const double *matrix, int32_t n, int32_t even, double *rows) {
  const size_t stride = (size_t)thrum_whole(even), taken = (size_t)n;
  for (int32_t i = 0; i < even; i++) {
    double *row = rows + (size_t)i * stride;
    if (i < n)
      memcpy(row, matrix + (size_t)i * taken, taken * sizeof *row);
    for (size_t j = i < n ? taken : 0; j < stride; j++)
      row[j] = 0.0;
  }
  if (even > n)
    rows[taken * stride + taken] = 1.0;
}

/* Sweeps the others, the largest first. */
static bool sweep_largest(const thrum_kernel *by, double *matrix, int32_t n, int32_t done,
                          double *work) {
  // the diagonal that is left to choose pivots from
  const pair p = {work, work + n, work + 2 * n, work + 3 * n, work + 4 * n, work + 5 * n};
  for (int32_t i = 0; i < n; i++) {
    p.swept[i] = i < done ? 1.0 : 0.0;
    p.diagonal[i] = matrix[(size_t)i * (size_t)n + (size_t)i];
  }

  // two pivots at a time
  for (; done < n; done += 2) {
    const int32_t k = largest_left(p.diagonal, n, p.swept);
    if (k < 0)
      return false;
    p.swept[k] = 1.0;
    const bool another = done + 1 < n;

    // the last one may be alone
    if (!another) {
      memset(p.second, 0, (size_t)n * sizeof *p.second);
      memset(p.minus_2, 0, (size_t)n * sizeof *p.minus_2);
    }

    if (!sweep(by, matrix, n, k, another, &p))
      return false;
  }
  return true;
}

size_t thrum_dense_work(int32_t n) {
  const size_t even = (size_t)n + (size_t)n % 2, stride = (size_t)thrum_whole((int64_t)even);
  return (even + THRUM_SWEEP_VECTORS) * stride;
}

/* The inverse from what is swept, which is minus its lower triangle. False where it is not finite.
 */
static bool take(const double *swept, size_t stride, int32_t n, double *matrix) {
  bool finite = true;
  for (int32_t i = 0; i < n; i++) {
    const double *from = swept + (size_t)i * stride;
    double *row = matrix + (size_t)i * (size_t)n;
    for (int32_t j = 0; j <= i; j++) {
      row[j] = -from[j];
      finite &= fabs(row[j]) <= DBL_MAX;
    }
    for (int32_t j = 0; j < i; j++)
      matrix[(size_t)j * (size_t)n + (size_t)i] = row[j];
  }
  return finite;
}

bool thrum_dense_invert(const thrum_kernel *by, double *matrix, int32_t n, double *work) {
  const int32_t even = n + n % 2;
  const size_t stride = (size_t)thrum_whole(even);
  double *rows = work + THRUM_SWEEP_VECTORS * stride;
  widen(matrix, n, even, rows);
  const int64_t done = by->sweep(even, rows, work);
  if (done >= n)
    return take(rows, stride, n, matrix);
  for (int32_t i = 0; i < n; i++)
    memcpy(matrix + (size_t)i * (size_t)n, rows + (size_t)i * stride, (size_t)n * sizeof *matrix);
  return sweep_largest(by, matrix, n, (int32_t)done, work) && take(matrix, (size_t)n, n, matrix);
}
