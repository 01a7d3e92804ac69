/* Dense linear systems with one or many right-hand sides, private to the library of responses; see
 * square_system.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RESPONSE_SQUARE_SYSTEM_H
#define THRUM_RESPONSE_SQUARE_SYSTEM_H

#include <stdbool.h>
#include <stdint.h>

/* Overwrites `matrix` (n x n, row-major) with -L and U of A P = L U; columns: n, the exchanges.
 * False where a pivot is zero or not finite: the content is then useless. */
bool thrum_square_factor(double *matrix, int64_t n, int32_t *columns);

/* The sign of the determinant, 1 or -1, by such factors. */
int thrum_square_sign(const double *factors, int64_t n, const int32_t *columns);

/* Overwrites `x` (n x count, row-major), right-hand sides, with the solutions. */
void thrum_square_solve(const double *factors, int64_t n, const int32_t *columns, int64_t count,
                        double *x);

/* Numbers in a row of a small system with so many right-hand sides: both, and zeros up to a
 * multiple of eight. */
static inline int64_t thrum_square_width(int64_t n, int64_t count) {
  return (n + count + 7) / 8 * 8;
}

/* Solves a small system whose factors are not wanted: a row of `system` (n x thrum_square_width)
 * has n numbers of the matrix, the right-hand sides, which become the solutions, and zeros. The
 * rest is destroyed. False as of factors. */
bool thrum_square_eliminate(double *system, int64_t n, int64_t count);

#endif
