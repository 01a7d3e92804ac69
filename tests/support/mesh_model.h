/* A model that is a mesh and its supports, of one material, for the full-order body.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_MESH_MODEL_H
#define THRUM_TESTS_SUPPORT_MESH_MODEL_H

#include "mesh/mesh.h"
#include "thrum/model.h"

/* Borrows the arrays. */
static inline thrum_model mesh_model(const thrum_mesh *mesh, const double *material,
                                     const uint8_t *fixed) {
  return (thrum_model){.vertex_count = mesh->vertex_count,
                       .tet_count = mesh->tet_count,
                       .region_count = 1,
                       .vertices = mesh->vertices,
                       .tets = mesh->tets,
                       .midsides = mesh->midsides,
                       .tet_region = mesh->tet_region,
                       .material = material,
                       .fixed = fixed};
}

#endif
