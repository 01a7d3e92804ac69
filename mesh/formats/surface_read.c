/* Triangle surfaces are read by the reader that the suffix names, and then scaled. Cost: linear in
 * the file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/surface_read.h"

#include <math.h>
#include <stdlib.h>

#include "io/file.h"
#include "mesh/formats/file_suffix.h"

static thrum_surface_parser *find_parser(const char *name) {
  if (thrum_file_has_suffix(name, ".obj"))
    return thrum_surface_parse_obj;
  return thrum_file_has_suffix(name, ".stl") ? thrum_surface_parse_stl : NULL;
}

bool thrum_surface_mesh_is_named(const char *name) {
  return find_parser(name) != NULL;
}

static thrum_status scale_vertices(const char *path, double scale, thrum_surface_mesh *surface,
                                   thrum_error *error) {
  for (int64_t n = 0; n < 3 * surface->vertex_count; n++) {
    surface->vertices[n] *= scale;
    if (!isfinite(surface->vertices[n]))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "%.200s: vertex %lld times the scale %g is not a finite number", path,
                             (long long)(n / 3 + 1), scale);
  }
  return THRUM_OK;
}

thrum_status thrum_surface_mesh_read(const char *path, double scale, thrum_surface_mesh *surface,
                                     thrum_error *error) {
  thrum_surface_parser *parse = find_parser(path);
  if (parse == NULL && (thrum_file_has_suffix(path, ".ply") || thrum_file_has_suffix(path, ".off")))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.200s: unknown kind of surface; give an .obj or .stl file, which a "
                           "modeller makes of it, or for .ply: gmsh FILE -save -o NEW.stl",
                           path);
  if (parse == NULL)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "%.200s: unknown kind of surface; give an .obj or .stl file", path);

  void *data = NULL;
  size_t size = 0;
  THRUM_TRY(thrum_file_read(path, &data, &size, error));

  // the caller's surface changes only when all went well
  thrum_surface_mesh read = {0};
  thrum_status status = thrum_file_name_memory(path, parse(path, data, size, &read, error), error);
  free(data);

  THRUM_THEN(status, scale_vertices(path, scale, &read, error));

  return thrum_surface_mesh_deliver(status, &read, surface);
}
