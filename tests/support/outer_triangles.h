/* The outer triangles of a mesh, for tests of what touches with them.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_OUTER_TRIANGLES_H
#define THRUM_TESTS_SUPPORT_OUTER_TRIANGLES_H

#include "tests/support/precompute_support.h"

#include "mesh/mesh_faces.h"

/* *count x 3 vertices, counter-clockwise from outside; free() frees. */
static inline int32_t *outer_triangles(const thrum_mesh *mesh, int64_t *count) {
  thrum_mesh_faces faces = {0};
  thrum_error error = {0};
  int64_t shared[3];
  if (thrum_mesh_find_faces(mesh, &faces, shared, &error) < 0)
    fail_msg("%s", error.message);
  int32_t *triangles = need(3 * (size_t)faces.count, sizeof *triangles);
  *count = 0;

  // a face that two tetrahedra share is none of the surface
  for (int64_t n = 0; n < faces.count; n++) {
    const thrum_mesh_face *face = &faces.faces[n];
    if (face->other >= 0)
      continue;
    int32_t *corners = triangles + 3 * (*count)++;
    corners[0] = face->vertices[0];
    corners[1] = face->vertices[face->even ? 1 : 2];
    corners[2] = face->vertices[face->even ? 2 : 1];
  }
  free(faces.faces);
  return triangles;
}

#endif
