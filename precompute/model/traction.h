/* Surface tractions as forces at vertices. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MODEL_TRACTION_H
#define THRUM_PRECOMPUTE_MODEL_TRACTION_H

#include "thrum/model.h"

/* Adds to forces (3 vertex_count) [N] a traction (x, y, z) [Pa] on the faces of elements on the
 * surface that have all their vertices among `count` given ones (NULL: the whole surface), at rest:
 * each vertex takes the integral of its shape function. *area (may be NULL): of those faces [m^2].
 * A dead load: it keeps its direction and its size as the body deforms. THRUM_MISSING without a
 * mesh, THRUM_INVALID_ARGUMENT when there is no such face. */
thrum_status thrum_traction_fill(const thrum_model *model, const int32_t *vertices, int64_t count,
                                 const double traction[3], double *forces, double *area,
                                 thrum_error *error);

#endif
