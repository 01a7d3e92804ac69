/* The discrete gradient of a law's energy density. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MATERIAL_MATERIAL_LAW_MEAN_H
#define THRUM_PRECOMPUTE_MATERIAL_MATERIAL_LAW_MEAN_H

#include "runtime/material/material_law.h"

/* stress = P-bar between two displacement gradients: its product with `to` - `from` is the change
 * of the energy density to rounding, and P-bar times the transposed mean of both F is symmetric.
 * It is not made for THRUM_LAW_STVK. */
void thrum_law_mean_stress(thrum_law law, double lambda, double mu, double from[3][3],
                           double to[3][3], double stress[3][3]);

#endif
