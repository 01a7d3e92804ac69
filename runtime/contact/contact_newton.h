/* What the Newton methods of contact have in common: the step and the search along it. Private to
 * the runtime.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_NEWTON_H
#define THRUM_RUNTIME_CONTACT_CONTACT_NEWTON_H

#include <stdbool.h>
#include <stdint.h>

/* Solves matrix step = -gradient (m) for a symmetric positive matrix (m x m, upper triangle by
 * rows), which its Cholesky factor overwrites; false where it has none, or the step is not finite.
 */
bool thrum_newton_step(int64_t m, double *matrix, const double *gradient, double *step);

/* The slope of a function along a step at a share of the step, from 0 to 1. */
typedef double (*thrum_newton_slope)(const void *of, double share);

/* The share of a step to take of a convex function that falls by `start` < 0 where the step begins:
 * the whole, or one near the minimum along it. */
double thrum_newton_search(thrum_newton_slope slope_at, const void *of, double start);

#endif
