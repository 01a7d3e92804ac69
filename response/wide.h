/* Loops for wider vectors, private to the library of responses: the compiler makes several forms of
 * a function, and the C library chooses between them. They have the same bits: each number is
 * multiplied and added by itself, in the same order. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RESPONSE_WIDE_H
#define THRUM_RESPONSE_WIDE_H

#include <stdint.h>

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__GLIBC__)
#define WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define WIDE
#endif

/* y (columns) += A^T x, A rows x columns, x rows: the numbers of thrum_matrix_product_transposed.
 */
void thrum_wide_product(int64_t rows, int64_t columns, const double *matrix, const double *x,
                        double *y);

/* Sums of even[m] cosines[m] + odd[m] sines[m] over m < count, odd, at four places of a period:
 * tau, of which the waves are given, pi + tau, -tau and pi - tau, whose waves are the same but for
 * signs. even and odd: count x columns; out: columns each, times `by`. */
void thrum_wide_waves(int64_t count, int64_t columns, const double *even, const double *odd,
                      const double *cosines, const double *sines, double by, double *const out[4]);

#endif
