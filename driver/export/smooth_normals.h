/* Normals of a drawn surface that bends. Vertices are split where the surface has an edge, and the
 * normal of each follows the coordinates, n(q) = N + sum_i dN_i q_i, not of unit length: the
 * linearisation of the normals of its triangles, weighted by area, over that at rest.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_EXPORT_SMOOTH_NORMALS_H
#define THRUM_DRIVER_EXPORT_SMOOTH_NORMALS_H

#include "driver/export/render_mesh.h"

/* Owned; smooth_normals_free frees. */
typedef struct smooth_normals {
  int64_t vertex_count; /* split vertices */
  int32_t *source;      /* vertex_count: the vertex of the surface that each is */
  int32_t *triangles;   /* triangle_count of the surface x 3: split vertices */
  float *normals;       /* vertex_count x 3, at rest, of unit length */
  float *change;        /* 3 vertex_count x rank, rows 3 v + axis: dN over |N| [kg^-1/2 m^-1] */
  thrum_scope memory;   /* of the arrays */
} smooth_normals;

/* Triangles that meet at 40 degrees or more have an edge between them. */
thrum_status smooth_normals_make(const render_mesh *shown, smooth_normals *normals,
                                 thrum_error *error);
void smooth_normals_free(smooth_normals *normals);

#endif
