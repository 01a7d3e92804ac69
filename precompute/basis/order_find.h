/* How much too high the frequencies of a mesh of linear tetrahedra are, by itself.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BASIS_ORDER_FIND_H
#define THRUM_PRECOMPUTE_BASIS_ORDER_FIND_H

#include "precompute/basis/order_error.h"

/* Finds the first modes of linear tets, at most THRUM_ORDER_MODES_MAX, and estimates their errors
 * as thrum_order_errors does; *count: how many are wanted, and on return how many there are. `fem`
 * is that of the mesh; with nothing held the six rigid modes are left out. *count becomes 0 of
 * solids, and where it would take more memory than `room` [bytes]; INFINITY: it may take all. Fails
 * where the stiffness is singular. Cost: a factor, a few modes, and the estimate. */
thrum_status thrum_order_find(const thrum_mesh *mesh, const thrum_fem *fem, double room,
                              int64_t *count, double *errors, thrum_error *error);

#endif
