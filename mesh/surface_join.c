/* Joining the vertices of a surface that are at just the same place; see surface_join.h. Cost:
 * linear. SPDX-License-Identifier: Apache-2.0 */
#include "mesh/surface_join.h"

#include <stdlib.h>
#include <string.h>

#include "mesh/point_hash.h"
#include "platform/allocate.h"

/* Numbers the vertices anew in the order of their first use; new_number: -1 at first. */
static thrum_status renumber(thrum_surface_mesh *surface, thrum_point_hash *places,
                             int32_t *new_number, double *kept, int64_t *count, int64_t *joined,
                             thrum_error *error) {
  for (int64_t n = 0; n < 3 * surface->triangle_count; n++) {
    const int32_t old = surface->triangles[n];
    if (new_number[old] < 0) {
      const double *x = surface->vertices + 3 * (int64_t)old;
      THRUM_TRY(thrum_point_hash_find(places, kept, *count, x, &new_number[old], error));
      if (new_number[old] == *count)
        memcpy(kept + 3 * (*count)++, x, 3 * sizeof *kept);
      else
        ++*joined;
    }
    surface->triangles[n] = new_number[old];
  }
  return THRUM_OK;
}

thrum_status thrum_surface_join(thrum_surface_mesh *surface, int64_t *joined, thrum_error *error) {
  const int64_t all = surface->vertex_count;
  thrum_point_hash places = {0};
  int32_t *new_number = NULL;
  double *kept = NULL;
  int64_t count = 0;
  thrum_status status = thrum_reserve(&new_number, all, sizeof *new_number, "the surface", error);
  THRUM_THEN(status, thrum_reserve(&kept, all, 3 * sizeof *kept, "the surface", error));
  *joined = 0;

  if (status >= 0) {
    memset(new_number, 0xff, (size_t)all * sizeof *new_number);
    status = renumber(surface, &places, new_number, kept, &count, joined, error);
  }

  free(new_number);
  thrum_point_hash_free(&places);

  // after a failure the triangles may be half renumbered; the caller only frees them
  if (status < 0) {
    free(kept);
    return status;
  }

  free(surface->vertices);
  surface->vertices = kept;
  surface->vertex_count = count;
  return THRUM_OK;
}
