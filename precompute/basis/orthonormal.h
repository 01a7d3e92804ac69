/* Orthonormal columns in the mass inner product. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BASIS_ORTHONORMAL_H
#define THRUM_PRECOMPUTE_BASIS_ORTHONORMAL_H

#include "precompute/fem/sparse.h"

/* Columns of work of all functions here: products of a block, and what they are made in. */
#define THRUM_GRAM_WORK (THRUM_SOLVE_BLOCK + THRUM_PRODUCT_WORK)

/* gram = A^T M B: A n x a, B n x b, gram a x b, all column-major; work: n x THRUM_GRAM_WORK. */
void thrum_mass_gram(const thrum_sparse *mass, const double *left, int64_t a, const double *right,
                     int64_t b, double *gram, double *work);

/* x -= Q (Q^T M x): `done` orthonormal columns Q and `count` columns x; gram: done x count. Once
 * leaves rounding, which a second call takes away. */
void thrum_mass_project(const thrum_sparse *mass, const double *q, int64_t done, double *x,
                        int64_t count, double *gram, double *work);

/* Turns the columns of x (n x count, column-major, each of unit mass norm or zero) in place into
 * *rank mass-orthonormal ones that span them; what is left of a column below `tolerance` counts as
 * nothing. work: n x THRUM_GRAM_WORK. */
thrum_status thrum_mass_orthonormalise(const thrum_sparse *mass, int64_t count, double *x,
                                       double tolerance, int64_t *rank, double *work,
                                       thrum_error *error);

/* The same, with the factors that give the columns back, so that they need not be kept beside Q:
 * the given column which[c] is Q times column c of `entries` (count x count, column-major, rows
 * from *rank on zero), up to what counted as nothing. */
thrum_status thrum_mass_factor(const thrum_sparse *mass, int64_t count, double *x, double tolerance,
                               int64_t *rank, double *entries, int32_t *which, double *work,
                               thrum_error *error);

#endif
