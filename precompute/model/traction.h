/* Surface tractions as forces at vertices. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MODEL_TRACTION_H
#define THRUM_PRECOMPUTE_MODEL_TRACTION_H

#include "thrum/model.h"

/* Adds to forces (3 vertex_count) [N] a traction (x, y, z) [Pa] on the triangles of the surface
 * that have all their vertices among `count` given ones (NULL: the whole surface), at rest: each
 * vertex of a linear triangle takes a third, each middle node of one with six nodes where its edges
 * are straight. *area (may be NULL): of those triangles [m^2]. A dead load:
 * it keeps its direction and its size as the body deforms. THRUM_MISSING without a mesh,
 * THRUM_INVALID_ARGUMENT when there is no such triangle. */
thrum_status thrum_traction_fill(const thrum_model *model, const int32_t *vertices, int64_t count,
                                 const double traction[3], double *forces, double *area,
                                 thrum_error *error);

#endif
