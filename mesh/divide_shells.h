/* Solid-shell wedges as three solid-shell hexahedra each. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_DIVIDE_SHELLS_H
#define THRUM_MESH_DIVIDE_SHELLS_H

#include <stdbool.h>

#include "mesh/mesh.h"

/* Divides the solid-shell wedges of a clean mesh into three solid-shell hexahedra each, and the
 * solid-shell hexahedra beside them into four: a node in the middle of each edge of their two
 * faces, and one in the middle of each face, which join the groups that hold all vertices of that
 * edge or face. The tetrahedra of the new elements follow. Wedges lock in thin sheets; hexahedra do
 * not.
 *
 * *divided: false, and the mesh is as it was, where other elements stand beside them, or an edge is
 * both along a face and across the thickness. On failure the mesh is as it was too. Cost: linear in
 * the mesh. */
thrum_status thrum_mesh_divide_shells(thrum_mesh *mesh, bool *divided, thrum_error *error);

/* Marks the nodes that the division made where all vertices of their edge or face are marked. */
void thrum_mesh_mark_divided(const thrum_mesh *mesh, uint8_t *marks);

#endif
