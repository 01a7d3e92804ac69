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

#endif
