/* Thin elements: which hexahedra and wedges are solid-shells. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_MESH_MESH_SHELLS_H
#define THRUM_MESH_MESH_SHELLS_H

#include <stdbool.h>

#include "mesh/mesh.h"
#include "mesh/solids.h"

/* A thickness below this share of the shorter side is thin: from there on bending rules. */
#define THRUM_SHELL_THIN 0.34

/* Makes solid-shells of the hexahedra of eight nodes and the wedges of six whose thickness is below
 * this share of their shorter side, or of the mean side of a wedge (0: none; INFINITY: all), and
 * returns how many there are. The thickness of a hexahedron is its shortest side, and its nodes are
 * turned so that it comes last; that of a wedge goes from triangle to triangle. */
int64_t thrum_mesh_choose_shells(thrum_mesh *mesh, double thin);

/* Are all elements solid-shells that can be divided along their faces alone, as no edge lies along
 * a face of one and across the thickness of another? Cost: linear in the solids. */
thrum_status thrum_mesh_is_sheet(const thrum_mesh *mesh, bool *sheet, thrum_error *error);

/* The corners around each face of a solid-shell: 3 or 4. */
static inline int thrum_mesh_shell_sides(const thrum_mesh *mesh, int64_t s) {
  return thrum_solid_forms[mesh->solid_form[s]].nodes / 2;
}

#endif
