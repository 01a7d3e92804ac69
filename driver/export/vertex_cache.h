/* A run's motion as vertex caches and its surface at rest, its body in place. Files are written
 * beside their place first and renamed. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_EXPORT_VERTEX_CACHE_H
#define THRUM_DRIVER_EXPORT_VERTEX_CACHE_H

#include "driver/export/render_mesh.h"
#include "driver/record/run_read.h"

/* Vertex caches of the surface: PC2 (little-endian) and MDD (big-endian). */
thrum_status pc2_write(const char *path, const recorded_run *run, const render_mesh *shown,
                       thrum_error *error);
thrum_status mdd_write(const char *path, const recorded_run *run, const render_mesh *shown,
                       thrum_error *error);

/* Wavefront .obj of the surface at rest: what the caches move, vertex by vertex. */
thrum_status obj_write(const char *path, const run_placement *place, const render_mesh *shown,
                       thrum_error *error);

#endif
