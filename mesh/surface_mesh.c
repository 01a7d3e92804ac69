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

static thrum_status no_memory(thrum_error *error) {
  return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "not enough memory for the surface");
}

static thrum_status too_many(thrum_error *error, const char *what) {
  return thrum_error_set(error, THRUM_UNSUPPORTED, "the surface has more than 2^31 - 2 %s", what);
}

thrum_status thrum_surface_add_vertex(thrum_surface_builder *b, const double position[3]) {
  thrum_surface_mesh *made = &b->made;
  if (made->vertex_count >= INT32_MAX - 1)
    return too_many(b->error, "vertices");
  if (!thrum_mesh_grow(&made->vertices, &b->vertex_capacity, made->vertex_count + 1,
                       3 * sizeof *position))
    return no_memory(b->error);
  memcpy(made->vertices + 3 * made->vertex_count++, position, 3 * sizeof *position);
  return THRUM_OK;
}

thrum_status thrum_surface_add_triangle(thrum_surface_builder *b, const int32_t corners[3],
                                        int64_t line) {
  thrum_surface_mesh *made = &b->made;
  const int64_t count = made->triangle_count;
  if (count >= INT32_MAX - 1)
    return too_many(b->error, "triangles");

  if (!thrum_mesh_grow(&made->triangles, &b->triangle_capacity, count + 1, 3 * sizeof *corners) ||
      !thrum_mesh_grow(&made->triangle_line, &b->line_capacity, count + 1, sizeof line))
    return no_memory(b->error);
  memcpy(made->triangles + 3 * count, corners, 3 * sizeof *corners);
  made->triangle_line[count] = line;
  made->triangle_count++;
  return THRUM_OK;
}
