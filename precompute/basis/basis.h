/* The basis U from linear modes and modal derivatives, design 2.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BASIS_BASIS_H
#define THRUM_PRECOMPUTE_BASIS_BASIS_H

#include "precompute/fem/fem.h"
#include "precompute/options/stage.h"

/* candidates: n x (k + k (k + 1) / 2), column-major: k modes, then the derivatives in the order of
 * thrum_derivatives; destroyed. omega2: k, and response_count. responses: n x
 * response_count, of unit mass norm or zero (omega2 INFINITY), and behind them all derivatives that
 * have one of them; U spans them, and as many directions that those derivatives add, beside as many
 * vectors of modes and derivatives as the rank leaves. shares:
 * NULL, or weights of the candidates, which then replace those by frequency. The last trained_count
 * of the rank are for `trained`, fields of 3 vertex_count each, one after the other. basis: U, 3
 * vertex_count x rank, row-major, zero rows where held; *orthonormality: max |U^T M U - 1|. U^T M U
 * = 1, U^T K U diagonal and ascending, signs and clusters canonical. THRUM_INVALID_ARGUMENT, with
 * the rank that can be had, when the candidates span fewer. */
thrum_status thrum_basis(const thrum_fem *fem, const thrum_sparse *mass, int64_t k,
                         const double *omega2, double *candidates, const double *shares,
                         const double *responses, int64_t response_count, int64_t rank,
                         const double *trained, int64_t trained_count, double *basis,
                         double *orthonormality, const thrum_reporter *reporter,
                         thrum_error *error);

#endif
