/* The surface of a model's mesh as triangles; what is drawn of it is in
 * driver/export/render_mesh.h. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_DISPLAY_SURFACE_H
#define THRUM_DRIVER_MODEL_DISPLAY_SURFACE_H

#include "thrum/thrum.h"

/* Triangles between a tet and nothing, outwards counter-clockwise. */
typedef struct display_surface {
  int64_t vertex_count;
  int32_t *vertices; /* vertex_count: 0-based vertices of the model, ascending */
  int64_t triangle_count;
  int32_t *triangles; /* triangle_count x 3: 0-based places in `vertices` */
} display_surface;
thrum_status display_surface_make(const thrum_model *model, display_surface *skin,
                                  thrum_error *error);

/* Fills corners (triangle_count x 3) with the triangles by vertices of the model; `corners` may be
 * skin->triangles itself. */
void display_surface_corners(const display_surface *skin, int32_t *corners);

void display_surface_free(display_surface *skin);

#endif
