/* Warnings of the changes that reading a mesh made to it, and of its faults.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MESH_WARNINGS_H
#define THRUM_DRIVER_MESH_WARNINGS_H

#include "mesh/mesh.h"

/* Warns of tets that were flipped or read by their corners, and of vertices dropped. */
void mesh_warnings_print(const thrum_mesh *mesh, const char *name);

#endif
