/* The triangles of a tetrahedral mesh: which tets share each, and which are its surface.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_FACES_H
#define THRUM_MESH_MESH_FACES_H

#include "mesh/mesh.h"

typedef struct thrum_mesh_face {
  int32_t vertices[3]; /* ascending */
  int32_t tet, other;  /* those that share it; other is -1 on the surface */
  bool even;           /* the vertices go round outwards of `tet` in this order */
} thrum_mesh_face;

typedef struct thrum_mesh_faces {
  int64_t count;
  thrum_mesh_face *faces; /* owned; in the order of their first tets */
} thrum_mesh_faces;

/* Finds the faces of a mesh whose tets all have positive volume. A face of three tets, or of two on
 * the same side of it, is no body's: THRUM_BAD_VALUE, and tets[0..2] say which (the last is -1 for
 * two). Cost: linear. */
thrum_status thrum_mesh_find_faces(const thrum_mesh *mesh, thrum_mesh_faces *faces, int64_t tets[3],
                                   thrum_error *error);

#endif
