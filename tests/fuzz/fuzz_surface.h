/* The use that every fuzz target of a surface reader makes of its surface.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_FUZZ_FUZZ_SURFACE_H
#define THRUM_TESTS_FUZZ_FUZZ_SURFACE_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/formats/surface_read.h"
#include "mesh/surface_join.h"
#include "mesh/surface_mesh.h"
#include "mesh/surface_repair.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* After a failure the surface must be empty and the message one line; otherwise every index and
 * number must be valid. */
static inline int fuzz_surface_parse(thrum_surface_parser *parse, const uint8_t *data,
                                     size_t size) {
  thrum_surface_mesh surface = {0};
  thrum_error error = {0};
  const thrum_status status = parse("input", data, size, &surface, &error);
  if (status < 0 && (surface.vertices || surface.triangles || error.status != status ||
                     !error.message[0] || strchr(error.message, '\n')))
    abort();
  for (int64_t n = 0; n < 3 * surface.triangle_count; n++)
    if (surface.triangles[n] < 0 || surface.triangles[n] >= surface.vertex_count)
      abort();
  for (int64_t n = 0; n < 3 * surface.vertex_count; n++)
    if (!isfinite(surface.vertices[n]))
      abort();

  // what is mended has valid indices too
  thrum_surface_repairs repairs;
  int64_t joined;
  if (status >= 0 && thrum_surface_join(&surface, &joined, &error) >= 0 &&
      thrum_surface_repair(&surface, &repairs, &error) >= 0)
    for (int64_t n = 0; n < 3 * surface.triangle_count; n++)
      if (surface.triangles[n] < 0 || surface.triangles[n] >= surface.vertex_count)
        abort();
  thrum_surface_mesh_free(&surface);
  return 0;
}

#endif
