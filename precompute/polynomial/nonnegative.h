/* Least squares of few unknowns >= 0. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_POLYNOMIAL_NONNEGATIVE_H
#define THRUM_PRECOMPUTE_POLYNOMIAL_NONNEGATIVE_H

#include <stdbool.h>
#include <stdint.h>

#include "thrum/status.h"

/* |A x - b|^2 by its normal equations: count x count products A^T A (both triangles),
 * A^T b, and b^T b. */
typedef struct thrum_squares {
  int64_t count;
  const double *products, *projections;
  double target;
} thrum_squares;

/* |A x - b|^2 of an x whose entries are zero but for `used` of them, at `places`; 0 where rounding
 * makes it negative. */
double thrum_squares_of(const thrum_squares *squares, int64_t used, const int64_t *places,
                        const double *x);

/* Grows a set of unknowns one by one, each time by the one that lowers |A x - b|^2 most steeply in
 * units of its own column, and keeps the x >= 0 that makes it least over the set (Lawson & Hanson
 * 1974; the order of growth is that of Farhat, Avery, Chapman & Cortial 2014,
 * doi:10.1002/nme.4668), until `enough` says so, `most` unknowns are used, or none lowers it.
 * places and x have room for `most`; *used tells how many there are. */
thrum_status thrum_nonnegative(const thrum_squares *squares, int64_t most,
                               bool (*enough)(void *context, int64_t used, const int64_t *places,
                                              const double *x),
                               void *context, int64_t *places, double *x, int64_t *used,
                               thrum_error *error);

#endif
