/* Joining the vertices of a surface that are at just the same place.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_SURFACE_JOIN_H
#define THRUM_MESH_SURFACE_JOIN_H

#include "mesh/surface_mesh.h"

/* Makes vertices at just the same place one, and drops those that no triangle uses: an .obj may
 * name a vertex once for each of its normals. *joined gets how many went into others. On
 * failure the surface is only good for thrum_surface_mesh_free. */
thrum_status thrum_surface_join(thrum_surface_mesh *surface, int64_t *joined, thrum_error *error);

#endif
