/* Small dense systems in place, private to libthrum; see dense.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_LINEAR_ALGEBRA_DENSE_H
#define THRUM_CORE_LINEAR_ALGEBRA_DENSE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/polynomial/kernel_private.h"

/* The scalar product of two vectors, summed in their order. */
static inline double thrum_dense_dot(const double *a, const double *b, int64_t count) {
  double sum = 0.0;
  for (int64_t i = 0; i < count; i++)
    sum += a[i] * b[i];
  return sum;
}

/* Overwrites `matrix` (n x n, row-major) with L and U of P A = L U; pivots: n. False when a pivot
 * is zero or not finite: the content is then useless. */
bool thrum_dense_factor(double *matrix, int32_t n, int32_t *pivots);

/* Overwrites `x` (n), a right-hand side, with the solution, from a factorisation made above. */
void thrum_dense_solve(const double *factors, int32_t n, const int32_t *pivots, double *x);

/* Doubles that an inverse needs of scratch: no more than any pass of a model of that rank. */
size_t thrum_dense_work(int32_t n);

/* Overwrites the symmetric `matrix` (n x n, both triangles) with its inverse. False where all
 * diagonal pivots left are zero, as may be in an indefinite matrix that is not singular, or the
 * result is not finite: the content is then useless. work: thrum_dense_work(n). */
bool thrum_dense_invert(const thrum_kernel *by, double *matrix, int32_t n, double *work);

#endif
