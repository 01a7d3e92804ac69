/* A run's motion in the formats of other programs, its body in place. All write beside their place
 * first and rename. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_ANIMATION_WRITE_H
#define THRUM_DRIVER_ANIMATION_WRITE_H

#include "driver/display_surface.h"
#include "driver/render_mesh.h"

/* glTF 2.0 (.glb): the surface at rest, a morph target for each coordinate, q(t) as their weights.
 * Targets and weights are scaled so that no weight passes 1. */
thrum_status cli_glb_write(const char *path, const cli_run *run, const cli_shown *shown,
                           thrum_error *error);

/* Vertex caches of the surface: PC2 (little-endian) and MDD (big-endian). */
thrum_status cli_pc2_write(const char *path, const cli_run *run, const cli_shown *shown,
                           thrum_error *error);
thrum_status cli_mdd_write(const char *path, const cli_run *run, const cli_shown *shown,
                           thrum_error *error);

/* Wavefront .obj of the surface at rest: what the caches move, vertex by vertex. */
thrum_status cli_obj_write(const char *path, const cli_run_place *place, const cli_shown *shown,
                           thrum_error *error);

#endif
