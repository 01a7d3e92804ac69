/* What the material of each region adds to a model, design 22. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_PRECOMPUTE_POLYNOMIAL_REGION_SHARES_H
#define THRUM_PRECOMPUTE_POLYNOMIAL_REGION_SHARES_H

#include "precompute/fem/fem.h"
#include "thrum/model.h"

/* Reduces the body once for each modulus of a region: `energy` (2 region_count x energy_size) and
 * `mass` (region_count x mass_size) as region_energy and region_mass of thrum/model.h. The model
 * has its basis; moduli and densities of the body are changed for the while. */
thrum_status thrum_region_shares(thrum_fem *fem, thrum_mass kind, const thrum_model *model,
                                 double *energy, double *mass, thrum_error *error);

#endif
