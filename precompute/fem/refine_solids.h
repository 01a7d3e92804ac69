/* A mesh of solids that is twice as fine. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_REFINE_SOLIDS_H
#define THRUM_PRECOMPUTE_FEM_REFINE_SOLIDS_H

#include "mesh/mesh.h"

/* How many elements and about how many vertices the refined mesh has; zero where it cannot be
 * refined, as not all elements are hexahedra or wedges. */
typedef struct thrum_refined_size {
  int64_t elements, vertices;
} thrum_refined_size;
thrum_status thrum_mesh_refined_size(const thrum_mesh *mesh, thrum_refined_size *size,
                                     thrum_error *error);

/* The mesh with each hexahedron and each wedge divided into eight of its kind, and where all are
 * solid-shells of one sheet into four, which are as thick; new nodes are where the shape functions
 * of the element have them. *finer is a mesh of its own, without groups and springs; *held: which
 * axes of its vertices are held, those of a new one where all nodes on which its place depends hold
 * them. Both are to be freed. Unchanged on failure. Cost: linear in the mesh. */
thrum_status thrum_mesh_refine(const thrum_mesh *mesh, const uint8_t *fixed, thrum_mesh *finer,
                               uint8_t **held, thrum_error *error);

#endif
