/* Static modal derivatives, design 2. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BASIS_MODAL_DERIVATIVES_H
#define THRUM_PRECOMPUTE_BASIS_MODAL_DERIVATIVES_H

#include "precompute/fem/fem.h"
#include "precompute/options/stage.h"

/* Phi_ij of the linear modes, i <= j, i outermost: modes n x count, derivatives
 * n x count (count + 1) / 2, both column-major over the free components. */
thrum_status thrum_derivatives(const thrum_fem *fem, thrum_factor *factor, int64_t count,
                               const double *modes, double *derivatives,
                               const thrum_reporter *reporter, thrum_error *error);

#endif
