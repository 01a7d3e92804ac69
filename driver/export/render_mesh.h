/* The surface that is drawn of a model (by glTF, vertex caches and the browser): the skin of its
 * mesh, or a surface embedded in the mesh, as the same arrays. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_DRIVER_EXPORT_RENDER_MESH_H
#define THRUM_DRIVER_EXPORT_RENDER_MESH_H

#include "platform/allocate.h"
#include "thrum/thrum.h"

/* Positions are x = positions + basis q. Owned; render_mesh_free frees. */
typedef struct render_mesh {
  int64_t rank; /* the model's */
  int64_t vertex_count;
  double *positions; /* vertex_count x 3, at rest [m] */
  float *basis;      /* 3 vertex_count x rank, rows 3 v + axis [kg^-1/2] */
  uint8_t *fixed;    /* vertex_count: bits 0..2, x, y, z held, as of the model */
  int64_t triangle_count;
  int32_t *triangles; /* triangle_count x 3: 0-based vertices of these */
  thrum_scope memory; /* of the arrays */
} render_mesh;

/* The model must have a mesh and a basis (THRUM_MISSING). `surface` is NULL: the skin, the
 * triangles between a tetrahedron and nothing, outwards counter-clockwise; or the path of a surface
 * that `thrum embed` wrote, which must be of this model; or of an .obj or .stl in metres, which is
 * embedded here, with a warning where it lies outside. */
thrum_status render_mesh_make(const thrum_model *model, const char *surface, render_mesh *shown,
                              thrum_error *error);
void render_mesh_free(render_mesh *shown);

#endif
