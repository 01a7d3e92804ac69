/* The lowest eigenpairs of K psi = omega^2 M psi, design 2. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BASIS_EIGEN_H
#define THRUM_PRECOMPUTE_BASIS_EIGEN_H

#include "precompute/fem/fem.h"
#include "precompute/options/stage.h"

/* `count` lowest pairs, 1 <= count < n: values ascending (count) [1/s^2], vectors n x count,
 * column-major, M-orthonormal, signs and clusters canonical. `factor` is K's.
 * Not re-entrant: ARPACK keeps state of its own, so one call at a time in a process. The start
 * vector is fixed: equal input gives equal bits. */
thrum_status thrum_eigen_lowest(const thrum_sparse *stiffness, const thrum_sparse *mass,
                                thrum_factor *factor, int64_t count, double *values,
                                double *vectors, const thrum_reporter *reporter,
                                thrum_error *error);

/* The same for a factor in single precision, which thrum_eigen_lowest hands over; signs and
 * clusters are left. Re-entrant. */
thrum_status thrum_eigen_lowest_block(const thrum_sparse *stiffness, const thrum_sparse *mass,
                                      thrum_factor *factor, int64_t count, double *values,
                                      double *vectors, const thrum_reporter *reporter,
                                      thrum_error *error);

/* Makes pairs that are nearly right exact: `passes` steps of subspace iteration with Rayleigh-Ritz
 * on all of them together; the values come out ascending, the vectors M-orthonormal. */
thrum_status thrum_eigen_refine(const thrum_sparse *mass, thrum_factor *factor, int64_t count,
                                int passes, double *values, double *vectors, thrum_error *error);

/* |K psi - w^2 M psi| / (|K| |psi|) of each pair, |K| the largest row sum, |psi| Euclidean. */
thrum_status thrum_eigen_residuals(const thrum_sparse *stiffness, const thrum_sparse *mass,
                                   int64_t count, const double *values, const double *vectors,
                                   double *residuals, thrum_error *error);

/* Fixes what an eigensolver leaves free, by a rule that does not depend on how the vectors were
 * found: the sign of a vector (its largest entry is positive; of entries equal within 1e-6 the
 * first), and the rotation within a cluster of values closer than `gap` (the row of largest norm
 * belongs to the first vector alone, and so on with the rest). Vectors are rows x count, entry
 * (row, column) at vectors[row * row_step + column * column_step]. */
void thrum_eigen_canonicalise(int64_t rows, int64_t count, const double *values, double gap,
                              double *vectors, int64_t row_step, int64_t column_step);

/* The same where the rows are of the part of a body, its free components, or with `whole` all
 * components. */
void thrum_eigen_canonicalise_fem(const thrum_fem *fem, bool whole, int64_t count,
                                  const double *values, double gap, double *vectors,
                                  int64_t row_step, int64_t column_step);

#endif
