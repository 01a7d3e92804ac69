/* The least eigenpair of a small symmetric matrix, private to libthrum; see symmetric.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_LINEAR_ALGEBRA_SYMMETRIC_H
#define THRUM_CORE_LINEAR_ALGEBRA_SYMMETRIC_H

#include <stdint.h>

/* Least eigenvalue of `matrix` (n x n, row-major, both triangles), exact to rounding beside the
 * largest. Overwrites the matrix. work: 3 n. */
double thrum_symmetric_least(double *matrix, int32_t n, double *work);

/* The eigenvector that belongs to the eigenvalue `value` of `matrix`: of length 1, its largest
 * entry positive. `factors` (n x n) and `pivots` (n) are scratch. */
void thrum_symmetric_vector(const double *matrix, int32_t n, double value, double *factors,
                            int32_t *pivots, double *vector);

#endif
