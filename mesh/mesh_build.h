/* What the mesh readers share while they build a mesh: growing arrays and adding groups.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_BUILD_H
#define THRUM_MESH_MESH_BUILD_H

#include <stddef.h>

#include "mesh/mesh.h"

/* Groups, materials or regions that one mesh may have; names have at most this many bytes. */
enum { THRUM_MESH_GROUPS_MAX = 4096, THRUM_MESH_NAME_MAX = 255 };

/* Makes room for `needed` items of `size` bytes in `array` (malloc'ed or NULL), doubling *capacity,
 * so that memory follows what a file holds and not what it claims. Returns the moved array; NULL
 * when out of memory (or a size would overflow), and `array` is still valid then. */
void *thrum_mesh_grow(void *array, int64_t *capacity, int64_t needed, size_t size);

/* Adds a group of `count` vertices (any order, repeats allowed; each below vertex_count), copied.
 * Vertices of a name that exists already join that group. An empty group is left out. */
thrum_status thrum_mesh_add_group(thrum_mesh *mesh, const char *name, const int32_t *vertices,
                                  int64_t count, thrum_error *error);

/* Adds the group of the vertices of a region's tets. */
thrum_status thrum_mesh_add_region_group(thrum_mesh *mesh, int32_t region, const char *name,
                                         thrum_error *error);

/* NULL, or why this is no name for a group: its length, its bytes. */
const char *thrum_mesh_name_fault(const char *name, size_t length);

/* For each tet the first one with the same four vertices before it, or -1: tet_count numbers,
 * malloc'ed; NULL when out of memory. */
int64_t *thrum_mesh_tet_repeats(const thrum_mesh *mesh);

/* Six times the signed volume that three edges from one vertex span. */
static inline double thrum_mesh_triple(double e[3][3]) {
  return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
         e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
         e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

#endif
