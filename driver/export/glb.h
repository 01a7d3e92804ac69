/* The motion of one body or of several as glTF 2.0, each in its place. Files are written beside
 * their place first and renamed. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_EXPORT_GLB_H
#define THRUM_DRIVER_EXPORT_GLB_H

#include "driver/export/render_mesh.h"
#include "driver/record/run_read.h"

/* A body of the file. */
typedef struct glb_body {
  const char *name; /* of its node; NULL: none */
  const recorded_run *run;
  const render_mesh *shown;
} glb_body;

/* glTF 2.0 (.glb): for each body the surface at rest with normals, a morph target of both for each
 * coordinate, and q(t) as their weights. Targets and weights are scaled so that no weight passes 1.
 */
thrum_status glb_write(const char *path, const glb_body *bodies, int64_t count, thrum_error *error);

#endif
