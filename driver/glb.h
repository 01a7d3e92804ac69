/* A run's motion as glTF 2.0, its body in place. Files are written beside their place first and
 * renamed. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_GLB_H
#define THRUM_DRIVER_GLB_H

#include "driver/render_mesh.h"
#include "driver/run_read.h"

/* glTF 2.0 (.glb): the surface at rest, a morph target for each coordinate, q(t) as their weights.
 * Targets and weights are scaled so that no weight passes 1. */
thrum_status glb_write(const char *path, const recorded_run *run, const render_mesh *shown,
                       thrum_error *error);

#endif
