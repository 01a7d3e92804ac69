/* Was a linear mode missed? SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BASIS_MODE_CHECK_H
#define THRUM_PRECOMPUTE_BASIS_MODE_CHECK_H

#include <stdbool.h>

#include "precompute/fem/sparse.h"

/* Searches the mass-orthogonal complement of `count` modes (n x count, column-major, M-orthonormal,
 * values ascending) afresh, from a block of other start vectors. What lies below the last mode and
 * is not among the modes was missed: it takes its place, and the modes are made exact again.
 * *recovered: how many; *next: the lowest value left in the complement, from above (INFINITY when
 * the complement is empty). Signs and clusters are left for thrum_eigen_canonicalise.
 * THRUM_NOT_CONVERGED when searches go on finding modes. */
thrum_status thrum_mode_search(const thrum_sparse *stiffness, const thrum_sparse *mass,
                               thrum_factor *factor, int64_t count, double *values, double *vectors,
                               int64_t *recovered, double *next, thrum_error *error);

/* A shift between two of the values, or between the last one and `next`, as high as the gaps allow;
 * *below: how many of the values lie below it. */
double thrum_mode_shift(int64_t count, const double *values, double next, int64_t *below);

/* How many eigenvalues of K x = s M x lie below `shift`: the negative pivots of an L D L^T of
 * K - shift M (Sylvester's law of inertia), which MUMPS counts. Takes about the time and memory of
 * the Cholesky factor. THRUM_UNSUPPORTED where MUMPS is not built in. Not re-entrant. */
bool thrum_inertia_available(void);
thrum_status thrum_inertia_count(const thrum_sparse *stiffness, const thrum_sparse *mass,
                                 double shift, int64_t *count, thrum_error *error);

#endif
