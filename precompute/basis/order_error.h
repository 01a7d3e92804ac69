/* How much too high the frequencies of linear tetrahedra are. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_PRECOMPUTE_BASIS_ORDER_ERROR_H
#define THRUM_PRECOMPUTE_BASIS_ORDER_ERROR_H

#include "mesh/mesh.h"
#include "precompute/fem/fem.h"

/* Estimates errors[i] = f_i / f - 1 of the first `count` modes (free_count x count, column-major,
 * M-orthonormal, with their omega2), where f is the frequency that the mode has once the nodes in
 * the middle of the edges are free to move. The estimate is from below, in bending half of the true
 * error or more. `mesh` is that of the fem, with linear tets. Cost: a few passes over the tets for
 * each mode. */
thrum_status thrum_order_errors(const thrum_mesh *mesh, const thrum_fem *fem, int64_t count,
                                const double *modes, const double *omega2, double *errors,
                                thrum_error *error);

#endif
