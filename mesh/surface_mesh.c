/* Triangle surfaces: growth and release.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/surface_mesh.h"

#include <stdlib.h>
#include <string.h>

#include "mesh/mesh_grow.h"

void thrum_surface_mesh_free(thrum_surface_mesh *surface) {
  free(surface->vertices);
  free(surface->triangles);
  free(surface->triangle_line);
  *surface = (thrum_surface_mesh){0};
}

thrum_status thrum_surface_mesh_deliver(thrum_status status, thrum_surface_mesh *read,
                                        thrum_surface_mesh *surface) {
  if (status < 0)
    thrum_surface_mesh_free(read);
  else
    *surface = *read;
  return status;
}

static thrum_status too_many(thrum_error *error, const char *what) {
  return thrum_error_set(error, THRUM_UNSUPPORTED, "the surface has more than 2^31 - 2 %s", what);
}

thrum_status thrum_surface_add_vertex(thrum_surface_builder *b, const double position[3]) {
  thrum_surface_mesh *made = &b->made;
  if (made->vertex_count >= INT32_MAX - 1)
    return too_many(b->error, "vertices");
  return thrum_mesh_append(&made->vertices, &made->vertex_count, position, 3 * sizeof *position,
                           b->error);
}

thrum_status thrum_surface_add_triangle(thrum_surface_builder *b, const int32_t corners[3],
                                        int64_t line) {
  thrum_surface_mesh *made = &b->made;
  int64_t lines = made->triangle_count;
  if (lines >= INT32_MAX - 1)
    return too_many(b->error, "triangles");

  // each triangle has a line
  THRUM_TRY(thrum_mesh_append(&made->triangle_line, &lines, &line, sizeof line, b->error));
  return thrum_mesh_append(&made->triangles, &made->triangle_count, corners, 3 * sizeof *corners,
                           b->error);
}
