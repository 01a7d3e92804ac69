/* A mesh of hexahedra that is twice as fine. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_REFINE_SOLIDS_H
#define THRUM_MESH_REFINE_SOLIDS_H

#include "mesh/mesh.h"

/* How many elements the refined mesh has; 0 where it cannot be refined, as not all elements are
 * hexahedra of eight nodes or solid-shells of those. */
int64_t thrum_mesh_refined_count(const thrum_mesh *mesh);

/* The mesh with each hexahedron divided into eight, and where all are solid-shells into four, which
 * are as thick. *finer is a mesh of its own, without groups; *held: which axes of its vertices are
 * held, those of a new one where all corners around it hold them. Both are to be freed. Unchanged
 * on failure. Cost: linear in the mesh. */
thrum_status thrum_mesh_refine(const thrum_mesh *mesh, const uint8_t *fixed, thrum_mesh *finer,
                               uint8_t **held, thrum_error *error);

#endif
