/* The Newton methods of contact have this in common: the step and the search along it. Private to
 * the runtime.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_NEWTON_H
#define THRUM_RUNTIME_CONTACT_CONTACT_NEWTON_H

#include <stdbool.h>
#include <stdint.h>

/* Rows of matrices and of B are so long: a multiple of four, so that no lane is left over. */
#define THRUM_NEWTON_STRIDE(m) (((m) + 3) / 4 * 4)

/* The columns of a row: those of one body, or of two, of which the second lie further on. Counts
 * are multiples of four, so that no lane is left over; the second may be 0. */
typedef struct thrum_newton_columns {
  int64_t first[2], count[2];
} thrum_newton_columns;

/* matrix += B^T change B, of which the upper triangle counts; its rows are `stride` long. ways: the
 * columns of B that are not 0, three rows of all of them; change: 3 x 3, symmetric; pushed: room of
 * the size of ways. */
void thrum_newton_add(const thrum_newton_columns *at, const double *ways, const double change[9],
                      double *pushed, int64_t stride, double *matrix);

/* Solves matrix step = -gradient (m) for a symmetric positive matrix, of which the upper triangle
 * counts and is overwritten; false where it has no Cholesky factor, or the step is not finite. */
bool thrum_newton_step(int64_t m, double *matrix, const double *gradient, double *step);

/* The lower triangle with root root^T = weight, of an inverse inertia; false where it has none. */
bool thrum_newton_root(const double weight[9], double root[9]);

/* The slope of a function along a step at a share of the step, from 0 to 1. */
typedef double (*thrum_newton_slope)(const void *of, double share);

/* The share of a step to take of a convex function that falls by `start` < 0 where the step begins:
 * the whole, or one near the minimum along it. */
double thrum_newton_search(thrum_newton_slope slope_at, const void *of, double start);

#endif
