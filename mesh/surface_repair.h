/* Mending a triangle surface where nothing is lost: triangles without area, triangles that are
 * there twice, and cracks without width.
 *
 * Where an edge has one triangle, vertices within CLOSE of the surface's diagonal of each other
 * become one, and a triangle whose open edge runs through vertices of other open edges is split
 * there. A triangle without area is a vertex on the edge of its neighbour: it goes, and the
 * neighbour is split. Of triangles with the same corners one stays of those that go round the same
 * way; two that go round opposite ways enclose nothing, and both go.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_SURFACE_REPAIR_H
#define THRUM_MESH_SURFACE_REPAIR_H

#include "mesh/surface_mesh.h"

/* What was done, each counted. */
typedef struct thrum_surface_repairs {
  int64_t joined; /* vertices that became others close by */
  int64_t flat;   /* triangles without area that went */
  int64_t split;  /* triangles that were split at a vertex on an edge */
  int64_t twice;  /* triangles that were there again */
  int64_t walls;  /* pairs of triangles that enclosed nothing */
} thrum_surface_repairs;

/* Mends a surface whose vertices at just the same place are one (surface_join.h). What cannot be
 * mended stays. On failure the surface is only good for thrum_surface_mesh_free. Cost: n log n,
 * times the longest chain of triangles without area. */
thrum_status thrum_surface_repair(thrum_surface_mesh *surface, thrum_surface_repairs *repairs,
                                  thrum_error *error);

#endif
