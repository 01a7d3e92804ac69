/* How much too high the frequencies of ten-node tetrahedra are. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_PRECOMPUTE_BASIS_CUBIC_ERROR_H
#define THRUM_PRECOMPUTE_BASIS_CUBIC_ERROR_H

#include "precompute/basis/order_error.h"

/* thrum_order_errors of ten-node tets: f is the frequency of the same mesh with functions of third
 * degree. What they hold near incompressibility, or as their mesh is coarse, is let go. Cost: for
 * each mode some ten to three hundred passes over the points of the tets, and as many solves. */
thrum_status thrum_cubic_errors(const thrum_order_body *body, int64_t count, const double *modes,
                                double *errors, thrum_error *error);

#endif
