/* Warnings of the changes that reading a mesh made to it, and of its faults.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MESH_WARNINGS_H
#define THRUM_DRIVER_MESH_WARNINGS_H

#include <cjson/cJSON.h>

#include "mesh/mesh.h"

/* Warns of elements that were cut, of tets that were flipped or read by their corners, of vertices
 * dropped, and whatever else the reader noted. */
void mesh_warnings_print(const thrum_mesh *mesh, const char *name);

/* Adds what the reader noted to a result, as the list "notes". */
void mesh_notes_object(cJSON *object, const thrum_mesh *mesh);

/* Warns of densities that no solid has, once it is known what the mesh is made of. */
void mesh_warn_density(const thrum_mesh *mesh, const char *name);

/* Warns of Poisson's ratios so near 1/2 that rounding is felt. */
void mesh_warn_poisson(const thrum_mesh *mesh, const char *name);

#endif
