/* The exact reduced polynomial by one Gram product, design 3. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_PRECOMPUTE_POLYNOMIAL_POLYNOMIAL_REDUCE_H
#define THRUM_PRECOMPUTE_POLYNOMIAL_POLYNOMIAL_REDUCE_H

#include "precompute/fem/fem.h"
#include "precompute/options/stage.h"

/* The basis U has rows 3 v + axis (all components) by rank, row-major, any vectors.
 * linear: U^T K U, rank x rank, both triangles, exact and semi-definite by construction;
 * c3, c4: coefficients in the block order of thrum/model.h. squared: rank; or fewer, and then only
 * the monomials of these first coordinates, and those of two of them and another, are made, which
 * is what condensing takes: the other coefficients are zero. At least 1. */
thrum_status thrum_polynomial_reduce(const thrum_fem *fem, int64_t rank, int64_t squared,
                                     const double *basis, double *linear, double *c3, double *c4,
                                     const thrum_reporter *reporter, thrum_error *error);

/* U^T K U alone: strains are multiplied, not K, so small eigenvalues keep their digits. */
thrum_status thrum_reduced_stiffness(const thrum_fem *fem, int64_t rank, const double *basis,
                                     double *linear, thrum_error *error);

/* Sorts the few indices of a monomial, upwards. */
void thrum_indices_sort(int64_t *index, int count);

#endif
