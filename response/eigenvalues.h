/* Eigenvalues of a real matrix, private to the library of responses; see eigenvalues.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RESPONSE_EIGENVALUES_H
#define THRUM_RESPONSE_EIGENVALUES_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* values: n pairs of real and imaginary part of the eigenvalues of `matrix` (n x n, row-major), by
 * falling magnitude, conjugate pairs side by side. The matrix is destroyed. False where the
 * iteration does not end or a number is not finite; the values are then useless. */
bool thrum_eigenvalues(double *matrix, int64_t n, double *values);

/* sqrt(a^2 + b^2), which does not overflow: hypot of the C library asks for a new one. */
static inline double thrum_magnitude(double a, double b) {
  const double most = fmax(fabs(a), fabs(b)), least = fmin(fabs(a), fabs(b));
  return most > 0 ? most * sqrt(1 + (least / most) * (least / most)) : most;
}

#endif
