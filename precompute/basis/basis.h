/* The basis U from linear modes and modal derivatives, design 2.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BASIS_BASIS_H
#define THRUM_PRECOMPUTE_BASIS_BASIS_H

#include "precompute/fem/fem.h"
#include "precompute/options/stage.h"

/* Makes the basis U. It spans the static responses, as many directions of their derivatives, the
 * trained fields, and as many vectors of modes and derivatives as the rank leaves.
 *
 * candidates: n x (k + k (k + 1) / 2), column-major, destroyed: k modes, then the derivatives in
 * the order of thrum_derivatives. omega2: of the k modes, then of the responses, INFINITY for one
 * that is zero. responses: n x response_count, each of unit mass norm or zero, and behind them all
 * derivatives that have one of them. shares: weights of the candidates in place of those by
 * frequency, or NULL. trained: trained_count fields of 3 vertex_count each, one after the other,
 * for the last trained_count of the rank.
 *
 * basis: U, 3 vertex_count x rank, row-major, zero rows where held, with U^T M U = 1, U^T K U
 * diagonal and ascending, signs and clusters canonical; *orthonormality: max |U^T M U - 1|.
 * THRUM_INVALID_ARGUMENT, with the largest possible rank, when the candidates span fewer. */
thrum_status thrum_basis(const thrum_fem *fem, const thrum_sparse *mass, int64_t k,
                         const double *omega2, double *candidates, const double *shares,
                         const double *responses, int64_t response_count, int64_t rank,
                         const double *trained, int64_t trained_count, double *basis,
                         double *orthonormality, const thrum_reporter *reporter,
                         thrum_error *error);

#endif
