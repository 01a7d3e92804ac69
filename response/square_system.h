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

#endif
