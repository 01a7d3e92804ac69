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

/* Ends a reader: frees what it read after a failure, and hands it over otherwise. */
thrum_status thrum_surface_mesh_deliver(thrum_status status, thrum_surface_mesh *read,
                                        thrum_surface_mesh *surface);
void thrum_surface_mesh_free(thrum_surface_mesh *surface); /* leaves it empty; empty is fine */

/* A surface that grows while a file is read. */
typedef struct thrum_surface_builder {
  thrum_surface_mesh made;
  thrum_error *error;
} thrum_surface_builder;
thrum_status thrum_surface_add_vertex(thrum_surface_builder *b, const double position[3]);
thrum_status thrum_surface_add_triangle(thrum_surface_builder *b, const int32_t corners[3],
                                        int64_t line);

#endif
