/* How much too high the frequencies of linear tetrahedra are. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_PRECOMPUTE_BASIS_ORDER_ERROR_H
#define THRUM_PRECOMPUTE_BASIS_ORDER_ERROR_H

#include "precompute/basis/hierarchy.h"

/* Estimates errors[i] = f_i / f - 1 of the first `count` <= THRUM_ORDER_MODES_MAX
 * modes (free_count x count, column-major,
 * M-orthonormal), where f is the frequency of the same mesh with ten nodes a tet. Cost: for each
 * mode some ten to a hundred passes over the tets, and as many solves. */
thrum_status thrum_order_errors(const thrum_order_body *body, int64_t count, const double *modes,
                                double *errors, thrum_error *error);

#endif
