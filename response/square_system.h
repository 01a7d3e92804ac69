/* Dense linear systems with one or many right-hand sides, private to the library of responses; see
 * square_system.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RESPONSE_SQUARE_SYSTEM_H
#define THRUM_RESPONSE_SQUARE_SYSTEM_H

#include <stdbool.h>
#include <stdint.h>

#define THRUM_SQUARE_BEHIND 8 /* numbers of a row that are the solver's */

/* Numbers in a row of a system with so many right-hand sides beside it: both, up to a multiple of
 * eight, and the solver's. */
static inline int64_t thrum_square_width(int64_t n, int64_t count) {
  return (n + count + 7) / 8 * 8 + THRUM_SQUARE_BEHIND;
}

/* Overwrites `matrix` (n x n, rows thrum_square_width(n, 0) apart) with -L and U of A P = L U, and
 * the inverse of each pivot; columns: n, the exchanges. False where a pivot is zero or not finite:
 * the content is then useless. */
bool thrum_square_factor(double *matrix, int64_t n, int32_t *columns);

/* The sign of the determinant, 1 or -1, by such factors. */
int thrum_square_sign(const double *factors, int64_t n, const int32_t *columns);

/* Overwrites `x` (n), a right-hand side, with the solution. */
void thrum_square_solve(const double *factors, int64_t n, const int32_t *columns, double *x);

/* Solves a system whose factors are not wanted: a row of `system` (n x thrum_square_width) has n
 * numbers of the matrix and then the right-hand sides, which become the solutions. The rest is
 * destroyed; columns: n, scratch. False as of factors. */
bool thrum_square_eliminate(double *system, int64_t n, int64_t count, int32_t *columns);

#endif
