/* Writes surfaces for the programs that mesh: Gmsh's .msh 2.2 (one surface, entity 1) and TetGen's
 * .smesh (each triangle is a facet). SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/surface_write.h"

#include <inttypes.h>
#include <stdio.h>

#include "io/file.h"

static void put_vertices(FILE *file, const thrum_surface_mesh *surface) {
  for (int64_t v = 0; v < surface->vertex_count; v++) {
    const double *x = surface->vertices + 3 * v;
    fprintf(file, "%" PRId64 " %.17g %.17g %.17g\n", v + 1, x[0], x[1], x[2]);
  }
}

thrum_status thrum_surface_write_msh(const char *path, const thrum_surface_mesh *surface,
                                     thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));

  FILE *file = writer.stream; // an error leaves its mark on the stream

  fprintf(file, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%" PRId64 "\n",
          surface->vertex_count);
  put_vertices(file, surface);

  // all triangles belong to surface 1, which Gmsh then fills
  fprintf(file, "$EndNodes\n$Elements\n%" PRId64 "\n", surface->triangle_count);
  for (int64_t t = 0; t < surface->triangle_count; t++) {
    const int32_t *v = surface->triangles + 3 * t;
    fprintf(file, "%" PRId64 " 2 2 0 1 %d %d %d\n", t + 1, v[0] + 1, v[1] + 1, v[2] + 1);
  }

  fputs("$EndElements\n", file);
  return thrum_file_writer_commit(&writer, error);
}

thrum_status thrum_surface_write_smesh(const char *path, const thrum_surface_mesh *surface,
                                       const double *holes, int64_t hole_count,
                                       thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));
  FILE *file = writer.stream;

  fprintf(file, "%" PRId64 " 3 0 0\n", surface->vertex_count);
  put_vertices(file, surface);

  // facets without boundary markers
  fprintf(file, "%" PRId64 " 0\n", surface->triangle_count);
  for (int64_t t = 0; t < surface->triangle_count; t++) {
    const int32_t *v = surface->triangles + 3 * t;
    fprintf(file, "3 %d %d %d\n", v[0] + 1, v[1] + 1, v[2] + 1);
  }

  // a point in each cavity tells TetGen to leave it empty
  fprintf(file, "%" PRId64 "\n", hole_count);
  for (int64_t n = 0; n < hole_count; n++)
    fprintf(file, "%" PRId64 " %.17g %.17g %.17g\n", n + 1, holes[3 * n], holes[3 * n + 1],
            holes[3 * n + 2]);

  fputs("0\n", file); // regions
  return thrum_file_writer_commit(&writer, error);
}
