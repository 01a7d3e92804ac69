/* Tets that a mesh holds more than once.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_TET_REPEATS_H
#define THRUM_MESH_TET_REPEATS_H

#include "mesh/mesh.h"

/* For each tet the first one with the same four vertices before it, or -1: tet_count numbers,
 * malloc'ed; NULL when out of memory. */
int64_t *thrum_mesh_tet_repeats(const thrum_mesh *mesh);

#endif
