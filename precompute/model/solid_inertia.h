/* The inertia of the shape of a free body of hexahedra and wedges, for thrum/inertia.h, which knows
 * the mass of tetrahedra alone. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MODEL_SOLID_INERTIA_H
#define THRUM_PRECOMPUTE_MODEL_SOLID_INERTIA_H

#include "thrum/inertia.h"

/* *numbers: for `inertia` of a copy of the model, as thrum_inertia_numbers writes them, by the mass
 * matrix of its elements; the caller frees it. NULL where the model has no solids, is not free or
 * has no basis. Cost: r^2 numbers a vertex, and the mass matrix. */
thrum_status thrum_solid_inertia(const thrum_model *model, double **numbers, thrum_error *error);

/* thrum_inertia_create of all coordinates of any model, unscaled. */
thrum_status thrum_solid_inertia_create(const thrum_model *model, thrum_inertia **inertia,
                                        thrum_error *error);

#endif
