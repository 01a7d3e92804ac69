/* The least eigenpair of a small symmetric matrix: Householder reflections make it tridiagonal,
 * Sturm's count of the eigenvalues below x is bisected, and inverse iteration gives the vector.
 *
 * Cost 4/3 n^3 for the value, 2/3 n^3 for the vector. Source: Wilkinson 1962, Householder's method
 * for symmetric matrices, doi:10.1007/BF01386333.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/linear_algebra/symmetric.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "core/linear_algebra/dense.h"

/* One reflection: zeroes column k below its second entry, the same from both sides. `v` and `w`: n
 * each. Returns the entry that remains off the diagonal. */
static double reflect(double *matrix, size_t n, size_t k, double *v, double *w) {
  double largest = 0.0, norm = 0.0;
  for (size_t i = k + 1; i < n; i++)
    largest = fmax(largest, fabs(matrix[i * n + k]));
  if (!(largest > 0.0))
    return 0.0;

  // the column in units of its largest entry, so that no square overflows
  for (size_t i = k + 1; i < n; i++) {
    v[i] = matrix[i * n + k] / largest;
    norm += v[i] * v[i];
  }
  norm = sqrt(norm);
  const double first = v[k + 1], turned = first > 0.0 ? -norm : norm;
  v[k + 1] = first - turned;

  // H = 1 - v v^T / half, half = |v|^2 / 2
  const double half = norm * norm - turned * first;
  double inner = 0.0;
  for (size_t i = k + 1; i < n; i++) {
    w[i] = 0.0;
    for (size_t j = k + 1; j < n; j++)
      w[i] += matrix[i * n + j] * v[j];
    w[i] /= half;
    inner += w[i] * v[i];
  }
  for (size_t i = k + 1; i < n; i++)
    w[i] -= 0.5 * inner / half * v[i];
  for (size_t i = k + 1; i < n; i++)
    for (size_t j = k + 1; j < n; j++)
      matrix[i * n + j] -= v[i] * w[j] + w[i] * v[j];

  return turned * largest;
}

/* Is an eigenvalue of the tridiagonal matrix (diagonal, beside[k] between k and k + 1) below x? */
static int below(const double *diagonal, const double *beside, size_t n, double x, double tiny) {
  double pivot = diagonal[0] - x;
  for (size_t k = 1; k < n; k++) {
    if (pivot < 0.0)
      return 1;
    if (pivot < tiny)
      pivot = tiny;
    pivot = diagonal[k] - x - beside[k - 1] / pivot * beside[k - 1];
  }
  return pivot < 0.0;
}

double thrum_symmetric_least(double *matrix, int32_t size, double *work) {
  const size_t n = (size_t)size;
  double *beside = work, *v = work + n, *w = v + n;
  memset(work, 0, 3 * n * sizeof *work);

  // to tridiagonal form by reflections
  for (size_t k = 0; k + 1 < n; k++)
    beside[k] = reflect(matrix, n, k, v, w);
  double *diagonal = v, low = INFINITY, high = INFINITY, largest = 0.0;
  for (size_t k = 0; k < n; k++)
    diagonal[k] = matrix[k * n + k];

  // Gershgorin's discs bound it below, the least diagonal entry above
  for (size_t k = 0; k < n; k++) {
    const double radius = fabs(beside[k]) + (k > 0 ? fabs(beside[k - 1]) : 0.0);
    low = fmin(low, diagonal[k] - radius);
    high = fmin(high, diagonal[k]);
    largest = fmax(largest, fabs(diagonal[k]) + radius);
  }
  if (!isfinite(largest))
    return -INFINITY;

  // bisection by the signs of the pivots (Sturm sequence), down to rounding
  const double tiny = DBL_EPSILON * DBL_EPSILON * largest + DBL_MIN;
  while (high - low > 0.25 * DBL_EPSILON * largest) {
    const double middle = low + 0.5 * (high - low);
    if (!(middle > low && middle < high))
      break;
    if (below(diagonal, beside, n, middle, tiny))
      high = middle;
    else
      low = middle;
  }
  return low + 0.5 * (high - low);
}

/* Makes the largest entry positive and the length 1. */
static void normalise(double *vector, size_t n) {
  double largest = 0.0, sum = 0.0;
  for (size_t i = 0; i < n; i++)
    if (fabs(vector[i]) > fabs(largest))
      largest = vector[i];
  if (largest == 0.0 || !isfinite(largest))
    return;
  for (size_t i = 0; i < n; i++) {
    vector[i] /= largest;
    sum += vector[i] * vector[i];
  }
  for (size_t i = 0; i < n; i++)
    vector[i] /= sqrt(sum);
}

void thrum_symmetric_vector(const double *matrix, int32_t size, double value, double *factors,
                            int32_t *pivots, double *vector) {
  // the size of the entries says how far beside the eigenvalue a factor exists
  const size_t n = (size_t)size;
  double largest = 0.0;
  for (size_t i = 0; i < n; i++)
    largest = fmax(largest, fabs(matrix[i * n + i]));

  // the shift is a little beside the eigenvalue, so that no pivot is zero
  for (double off = 4.0 * DBL_EPSILON * largest + DBL_MIN; off < INFINITY; off *= 16.0) {
    memcpy(factors, matrix, n * n * sizeof *factors);
    for (size_t i = 0; i < n; i++) {
      factors[i * n + i] -= value - off;
      vector[i] = 1.0 + 1.0 / (double)(i + 2);
    }
    if (thrum_dense_factor(factors, size, pivots))
      break;
  }

  // inverse iteration: each solve multiplies the share of the wanted vector
  for (int k = 0; k < 4; k++) {
    thrum_dense_solve(factors, size, pivots, vector);
    normalise(vector, n);
  }
}
