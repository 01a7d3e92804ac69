/* Checking and cleaning a mesh as it came from its file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_CLEAN_H
#define THRUM_MESH_MESH_CLEAN_H

#include "mesh/mesh.h"

/* Scales, checks and cleans in place, as described at thrum_mesh_read. `name` is for messages. On
 * failure the mesh may be half cleaned and is only good for thrum_mesh_free. */
thrum_status thrum_mesh_clean(thrum_mesh *mesh, const char *name, double scale, thrum_error *error);

#endif
