/* Dense linear systems and their transposes, private to the library of gradients; see
 * linear_system.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_GRADIENT_LINEAR_SYSTEM_H
#define THRUM_GRADIENT_LINEAR_SYSTEM_H

#include <stdbool.h>
#include <stdint.h>

/* Overwrites `matrix` (n x n, row-major) with L and U of P A = L U; rows: n, the exchanges. False
 * where a pivot is zero or not finite: the content is then useless. */
bool thrum_linear_factor(double *matrix, int64_t n, int32_t *rows);

/* Overwrites x (n) with A^-1 x or A^-T x, by such factors. */
void thrum_linear_solve(const double *factors, int64_t n, const int32_t *rows, double *x);
void thrum_linear_solve_transposed(const double *factors, int64_t n, const int32_t *rows,
                                   double *x);

#endif
