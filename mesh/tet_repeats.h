/* Tets that a mesh holds more than once.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_TET_REPEATS_H
#define THRUM_MESH_TET_REPEATS_H

#include "mesh/mesh.h"

/* For each tet the first one with the same four vertices before it, or -1: tet_count numbers in
 * *earlier, which the caller frees, also on failure. */
thrum_status thrum_mesh_tet_repeats(const thrum_mesh *mesh, int64_t **earlier, thrum_error *error);

#endif
