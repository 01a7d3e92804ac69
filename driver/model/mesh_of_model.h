/* The mesh that a model file holds, for another model of the same body.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_MESH_OF_MODEL_H
#define THRUM_DRIVER_MODEL_MESH_OF_MODEL_H

#include "mesh/mesh.h"
#include "thrum/model.h"

/* Is this the name of a model file? */
bool mesh_of_model_is_named(const char *name);

/* Reads the model file: its mesh with materials and groups, which thrum_mesh_free frees, and what
 * it holds, vertex_count bytes that the caller frees. THRUM_MISSING where it has no mesh. */
thrum_status mesh_of_model_read(const char *path, thrum_mesh *mesh, uint8_t **fixed,
                                thrum_error *error);

#endif
