/* How many cells a body has over its thickness. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_THICKNESS_H
#define THRUM_MESH_MESH_THICKNESS_H

#include "mesh/mesh_faces.h"

enum { THRUM_THICKNESS_CELLS_MAX = 16 };

/* How many cells lie under the thinnest quarter of the surface. A line from the middle of each
 * surface triangle straight into the body crosses three tets for each cell of a grid until it
 * leaves; the result is the most that a quarter of the area has, and at most
 * THRUM_THICKNESS_CELLS_MAX. `faces` are the faces of the mesh; middle nodes do not count. Cost:
 * linear in the mesh. */
thrum_status thrum_mesh_cells_across(const thrum_mesh *mesh, const thrum_mesh_faces *faces,
                                     double *cells, thrum_error *error);

/* How much too high linear tets make the frequencies of a bar or plate of so many cells in bending,
 * as f_i / f - 1: sqrt(1 + 4 / cells^2) - 1, fitted to cantilevers (docs/meshes.md). */
double thrum_bending_error(double cells);

#endif
