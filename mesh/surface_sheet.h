/* A sheet of wedges and hexahedra from a surface and a thickness.
 *
 * Each triangle becomes a wedge and each polygon of four corners a hexahedron, in as many layers as
 * are asked for. A vertex moves along the mean normal of the facets around it, weighted by their
 * angles there, by so much that the facets' own distances have the thickness in the mean.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_SURFACE_SHEET_H
#define THRUM_MESH_SURFACE_SHEET_H

#include "mesh/mesh.h"
#include "mesh/surface_mesh.h"

typedef enum thrum_sheet_side {
  THRUM_SHEET_MIDDLE,
  THRUM_SHEET_TOP,
  THRUM_SHEET_BOTTOM
} thrum_sheet_side;

typedef struct thrum_sheet_options {
  double thickness;      /* [m] */
  int64_t layers;        /* at least 1 */
  thrum_sheet_side side; /* where the surface lies in the sheet; the top is where normals point */
} thrum_sheet_options;

/* Makes the mesh, with the groups `bottom` and `top`, `edge`, all vertices above and below an open
 * edge, and of an even number of layers `middle` and `edge_middle`. The surface may be open.
 * Refused with the line of the first of them: facets without area or twice, edges of three facets,
 * neighbours that go round opposite ways, and folds that the thickness does not fit: where the mean
 * normal is more than 60 degrees off a facet's, or an element turns inside out. */
thrum_status thrum_surface_sheet(const thrum_surface_mesh *surface,
                                 const thrum_sheet_options *options, const char *path,
                                 thrum_mesh *mesh, thrum_error *error);

#endif
