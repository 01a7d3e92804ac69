/* Writes triangle surfaces for the programs that mesh.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_FORMATS_SURFACE_WRITE_H
#define THRUM_MESH_FORMATS_SURFACE_WRITE_H

#include "mesh/surface_mesh.h"

/* Writes the surface for the programs that mesh: Gmsh's .msh 2.2 and TetGen's .smesh, with all bits
 * of the vertices; `holes`, hole_count x 3, are points in what is to stay empty. */
thrum_status thrum_surface_write_msh(const char *path, const thrum_surface_mesh *surface,
                                     thrum_error *error);
thrum_status thrum_surface_write_smesh(const char *path, const thrum_surface_mesh *surface,
                                       const double *holes, int64_t hole_count, thrum_error *error);

#endif
