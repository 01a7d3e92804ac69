/* Warnings of the changes that reading a mesh made to it, and of its faults.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_MESH_WARNINGS_H
#define THRUM_DRIVER_MODEL_MESH_WARNINGS_H

#include <cjson/cJSON.h>

#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"

/* Warns of elements that were cut, of tets that were flipped or read by their corners, of vertices
 * dropped, and whatever else the reader noted; and asks for the unit of a file whose body is longer
 * or shorter than bodies are, where `reading` says neither a unit nor a scale (NULL: of what is in
 * metres anyhow). All commands that take a mesh come here. */
void mesh_warnings_print(const thrum_mesh *mesh, const char *name,
                         const thrum_mesh_read_options *reading);

/* Adds what the reader noted to a result, as the list "notes". */
void mesh_notes_object(cJSON *object, const thrum_mesh *mesh);

/* Warns of densities and moduli that no solid has, once it is known what the mesh is made of.
 * `unit`: that of the file, as --unit says; NULL: it was not said. */
void mesh_warn_materials(const thrum_mesh *mesh, const char *name, const char *unit);

/* Asks whether a generated body is in metres that could not bear its own weight, at its materials.
 */
void mesh_warn_weight(const thrum_mesh *mesh, const char *name,
                      const thrum_mesh_read_options *reading);

/* Warns of Poisson's ratios so near 1/2 that rounding is felt. */
void mesh_warn_poisson(const thrum_mesh *mesh, const char *name);

#endif
