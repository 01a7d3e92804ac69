/* Writes the frames of a run for ParaView: a .vtu for each frame, and the .pvd that lists them with
 * their times.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_VTU_H
#define THRUM_IO_VTU_H

#include <stdbool.h>

#include "thrum/thrum.h"

/* Von Mises' stresses of a frame [Pa]; a zeroed one has none, and each array may be NULL. */
typedef struct vtu_stress {
  const double *nodes;   /* vertex_count: the largest of the regions at each vertex */
  const double *centres; /* tet_count: at the centre of each tetrahedron */
  bool patches;          /* nodes are averages of patches of linear tetrahedra */
} vtu_stress;

/* Writes one frame to `path`: the mesh at rest, the point vectors `displacement` (vertex_count x 3,
 * [m]), the points' `von_mises`, or `von_mises_patch_average`, the cells' `von_mises_centre`
 * (`stress` may be NULL) and the time [s]. The model needs a mesh. The file grows in its place, so
 * its folder should not be visible to readers yet. */
thrum_status vtu_write(const char *path, const thrum_model *model, const double *displacement,
                       const vtu_stress *stress, double time, thrum_error *error);

/* Writes a single frame, first beside its place and then renamed. */
thrum_status vtu_write_whole(const char *path, const thrum_model *model, const double *displacement,
                             const vtu_stress *stress, thrum_error *error);

/* Writes linear modes to `path` in the same way: the mesh at rest and for each of `count` modes the
 * point vectors `mode_N_F_Hz` with its frequency F; modes: count x 3 vertex_count [kg^-1/2]. */
thrum_status vtu_write_modes(const char *path, const thrum_model *model, int64_t count,
                             const double *hertz, const double *modes, thrum_error *error);

/* A .pvd file that is being written; a zeroed one is closed. */
typedef struct pvd_file {
  void *stream; /* FILE * */
  char path[1024];
} pvd_file;
thrum_status pvd_open(const char *path, pvd_file *pvd, thrum_error *error);
/* Adds a frame; `file` is its name relative to the .pvd. */
thrum_status pvd_add(pvd_file *pvd, const char *file, double time, thrum_error *error);
thrum_status pvd_close(pvd_file *pvd, thrum_error *error);
void pvd_abandon(pvd_file *pvd);

#endif
