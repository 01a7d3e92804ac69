/* Block kernels of the reduced polynomial: products with a block of coefficients and its transpose.
 *
 * Plain C, the reference for any faster kernel. The order of every sum is fixed by the comment in
 * polynomial.h, so the result does not depend on compiler, optimisation or vector width.
 * Cost: every function reads its block once; 2 operations per entry and product.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "polynomial.h"

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#define LANES 8

/* Adds the lanes as a fixed tree. */
static double lanes_sum(const double lane[LANES]) {
  return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
}

double thrum_kernel_dot(int64_t count, const double *a, const double *b) {
  double lane[LANES] = {0};
  int64_t c = 0;
  for (; c + LANES <= count; c += LANES)
    for (int s = 0; s < LANES; s++)
      lane[s] += a[c + s] * b[c + s];
  for (int s = 0; c + s < count; s++)
    lane[s] += a[c + s] * b[c + s];
  return lanes_sum(lane);
}

void thrum_kernel_axpy(int64_t count, double s, const double *restrict a, double *restrict b) {
  for (int64_t c = 0; c < count; c++)
    b[c] += s * a[c];
}

void thrum_kernel_product(int64_t rows, int64_t columns, const double *block, const double *m,
                          double *y) {
  for (int64_t i = 0; i < rows; i++)
    y[i] += thrum_kernel_dot(columns, block + i * columns, m);
}

void thrum_kernel_transposed(int64_t rows, int64_t columns, const double *restrict block,
                             const double *restrict x, double *restrict w) {
  int64_t i = 0;
  // four rows at a time, added in ascending order, so that w is loaded and stored less often
  for (; i + 4 <= rows; i += 4) {
    const double *b0 = block + i * columns, *b1 = b0 + columns, *b2 = b1 + columns,
                 *b3 = b2 + columns;
    double x0 = x[i], x1 = x[i + 1], x2 = x[i + 2], x3 = x[i + 3];
    for (int64_t c = 0; c < columns; c++)
      w[c] = (((w[c] + x0 * b0[c]) + x1 * b1[c]) + x2 * b2[c]) + x3 * b3[c];
  }
  for (; i < rows; i++)
    thrum_kernel_axpy(columns, x[i], block + i * columns, w);
}

/* One row of thrum_kernel_both. */
static double row_both(int64_t columns, const double *restrict row, const double *restrict m,
                       double x, double *restrict w) {
  double lane[LANES] = {0};
  int64_t c = 0;
  for (; c + LANES <= columns; c += LANES)
    for (int s = 0; s < LANES; s++) {
      double b = row[c + s];
      lane[s] += b * m[c + s];
      w[c + s] += x * b;
    }
  for (int s = 0; c + s < columns; s++) {
    double b = row[c + s];
    lane[s] += b * m[c + s];
    w[c + s] += x * b;
  }
  return lanes_sum(lane);
}

void thrum_kernel_both(int64_t rows, int64_t columns, const double *block, const double *m,
                       const double *x, double *y, double *w) {
  for (int64_t i = 0; i < rows; i++)
    y[i] += row_both(columns, block + i * columns, m, x[i], w);
}

void thrum_kernel_both_twice(int64_t rows, int64_t columns, const double *block,
                             const double *const m[2], const double *const x[2], double *const y[2],
                             double *const w[2]) {
  // row by row, so that the second product finds the row in the cache
  for (int64_t i = 0; i < rows; i++)
    for (int e = 0; e < 2; e++)
      y[e][i] += row_both(columns, block + i * columns, m[e], x[e][i], w[e]);
}

void thrum_pair_monomials(int64_t n, const double *q, double *m) {
  for (int64_t k = 0; k < n; k++)
    for (int64_t l = k; l < n; l++)
      *m++ = q[k] * q[l];
}

void thrum_pair_gradient(int64_t n, const double *w, const double *q, double *gradient) {
  for (int64_t k = 0; k < n; k++) {
    gradient[k] += thrum_kernel_dot(n - k, w, q + k);
    thrum_kernel_axpy(n - k, q[k], w, gradient + k);
    w += n - k;
  }
}
