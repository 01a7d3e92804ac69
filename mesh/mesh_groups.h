/* Adding named vertex groups to a mesh.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_GROUPS_H
#define THRUM_MESH_MESH_GROUPS_H

#include "io/text.h"
#include "mesh/mesh.h"

/* Groups, materials or regions that one mesh may have; names have at most this many bytes. */
enum { THRUM_MESH_GROUPS_MAX = 4096, THRUM_MESH_NAME_MAX = 255 };

/* Adds a group of `count` vertices (any order, repeats allowed; each below vertex_count), copied.
 * Vertices of a name that exists already join that group. An empty group is left out. */
thrum_status thrum_mesh_add_group(thrum_mesh *mesh, const char *name, const int32_t *vertices,
                                  int64_t count, thrum_error *error);

/* The group of that name; NULL: there is none. */
thrum_group *thrum_mesh_find_group(const thrum_mesh *mesh, const char *name);

/* Adds the group of the vertices of a region's tets. */
thrum_status thrum_mesh_add_region_group(thrum_mesh *mesh, int32_t region, const char *name,
                                         thrum_error *error);

/* Gives region `region` the name that its file has for it, `length` bytes, which are copied. */
thrum_status thrum_mesh_name_region(thrum_mesh *mesh, int64_t region, const char *name,
                                    size_t length, thrum_error *error);

/* The name of a region; without one, its number from 1. */
typedef struct thrum_region_text {
  char text[THRUM_MESH_NAME_MAX + 1];
} thrum_region_text;
thrum_region_text thrum_mesh_region_text(const thrum_mesh *mesh, int64_t region);

/* Appends to an array as thrum_mesh_append does, in which a text may have at most
 * THRUM_MESH_GROUPS_MAX of `what`, plural. */
thrum_status thrum_mesh_append_few(const thrum_text *text, const char *what, void *array,
                                   int64_t *count, const void *item, size_t size);

/* NULL, or why this is no name for a group: its length, its bytes. */
const char *thrum_mesh_name_fault(const char *name, size_t length);
/* Refuses a name in a text that is none for a group. */
thrum_status thrum_mesh_name_check(const thrum_text *text, thrum_word name);
/* Puts a copy of `length` bytes, with a zero behind it, in the place of *kept, which is freed. */
thrum_status thrum_mesh_keep_text(const char *text, size_t length, char **kept, thrum_error *error);

#endif
