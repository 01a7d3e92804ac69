/* The generator of boxes of tetrahedra.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_BEAM_H
#define THRUM_MESH_MESH_BEAM_H

#include "mesh/mesh.h"

/* Makes the mesh of a spec `beam:NXxNYxNZ@LXxLYxLZ[,hex | ,split=N][,parts=N]`, see
 * thrum_mesh_read. */
thrum_status thrum_mesh_beam(const char *spec, thrum_mesh *mesh, thrum_error *error);

/* The cells of such a spec along x, y and z, without making the mesh. */
thrum_status thrum_mesh_beam_cells(const char *spec, int64_t cells[3], thrum_error *error);

#endif
