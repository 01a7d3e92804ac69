/* Triangle surfaces, as modellers write them: what is embedded in a mesh to be shown, or meshed.
 *
 * A surface is one struct of owned arrays; thrum_surface_mesh_free releases it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_SURFACE_MESH_H
#define THRUM_MESH_SURFACE_MESH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

typedef struct thrum_surface_mesh {
  int64_t vertex_count;
  double *vertices; /* vertex_count x 3 */
  int64_t triangle_count;
  int32_t *triangles;     /* triangle_count x 3, 0-based, in the winding of the file */
  int64_t *triangle_line; /* triangle_count: line in the file, or, where the file is binary, the
                             number of the facet from 1 */
  bool binary;            /* triangle_line counts facets */
  int64_t polygons;       /* of more than three corners, split into a fan from the first */
  int64_t merged;         /* corners of an .stl at just the place of an earlier one */
} thrum_surface_mesh;

/* Reads a surface by its suffix, .obj (Wavefront) or .stl (ASCII and binary); lengths are
 * multiplied by `scale`. An .obj keeps all its vertices and their order, used or not, so that what
 * is made of them plays on the file itself; its texture coordinates, normals, groups and materials
 * are passed over. Corners of an .stl at just the same place become one vertex, in the order in
 * which they come. Triangles are kept as they are, flat ones too. Numbers that are not finite,
 * indices out of range and statements of curved surfaces are refused with the file and the line. On
 * failure *surface is untouched. */
thrum_status thrum_surface_mesh_read(const char *path, double scale, thrum_surface_mesh *surface,
                                     thrum_error *error);
/* The name is that of a surface by its ending, whether or not it is there. */
bool thrum_surface_mesh_is_named(const char *name);

void thrum_surface_mesh_free(thrum_surface_mesh *surface); /* leaves it empty; empty is fine */

/* The readers behind it, one file each, from the bytes of a file; `name` is for messages. On
 * failure *surface is untouched. */
typedef thrum_status thrum_surface_parser(const char *name, const void *data, size_t size,
                                          thrum_surface_mesh *surface, thrum_error *error);
thrum_surface_parser thrum_surface_parse_obj, thrum_surface_parse_stl;

/* For the readers: a surface that grows. */
typedef struct thrum_surface_builder {
  thrum_surface_mesh made;
  int64_t vertex_capacity, triangle_capacity, line_capacity;
  thrum_error *error;
} thrum_surface_builder;
thrum_status thrum_surface_add_vertex(thrum_surface_builder *b, const double position[3]);
thrum_status thrum_surface_add_triangle(thrum_surface_builder *b, const int32_t corners[3],
                                        int64_t line);

#endif
