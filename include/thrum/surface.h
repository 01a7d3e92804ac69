/* The part of a body that somebody shows: positions and normals of chosen vertices in single
 * precision, straight into the caller's buffer.
 *
 *   x_v = X_v + sum_i U_vi q_i
 *
 * A surface is planned (thrum_surface_size), then laid into the caller's memory
 * (thrum_surface_init); afterwards it needs the model no longer, holds no pointer, is immutable and
 * may be shared by any number of threads. Its rows are those of U of the model's vertices, or its
 * own (a surface embedded in the mesh: thrum/embedding.h). It keeps only these, as floats: half the
 * bytes of a double-precision product, in the order in which they are read. Positions have the same
 * bits on every machine (mode by mode, ascending, in single precision).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SURFACE_H
#define THRUM_SURFACE_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/api.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What is shown. Vertices and triangles are only read while a surface is planned and made. */
typedef struct thrum_surface_def {
  const int32_t *vertices; /* 0-based vertices of the model in the order of the output; NULL: all */
  int64_t vertex_count;    /* of `vertices`, or of `positions`; ignored when both are NULL */
  const int32_t *triangles; /* triangle_count x 3, 0-based places in the output; NULL: no normals */
  int64_t triangle_count;
  /* A surface with rows of its own, which needs no basis of the model; then `vertices` is NULL. */
  const double *positions; /* vertex_count x 3: at rest [m]; NULL: the model's vertices */
  const float *rows; /* 3 vertex_count x row_rank: rows 3 v + axis, x = X + rows q [kg^-1/2] */
  int64_t row_rank;  /* at least the model's rank; the first columns are taken */
} thrum_surface_def;

/* Opaque: lives at the start of the memory given to thrum_surface_init. */
typedef struct thrum_surface thrum_surface;

/* What a call of thrum_surface_positions writes. */
typedef enum thrum_surface_output {
  THRUM_SURFACE_DISPLACEMENTS = 0, /* u = U q [m] */
  THRUM_SURFACE_POSITIONS = 1      /* X + U q [m] */
} thrum_surface_output;

/* Bytes of a surface. Needs a model with a basis (THRUM_MISSING otherwise), or rows of its own;
 * checks the def. */
THRUM_API thrum_status thrum_surface_size(const thrum_model *model, const thrum_surface_def *def,
                                          size_t *size, thrum_error *error);

/* Lays a surface into `memory`, aligned to 64, at least thrum_surface_size bytes, which the caller
 * owns. */
THRUM_API thrum_status thrum_surface_init(void *memory, size_t memory_size,
                                          const thrum_model *model, const thrum_surface_def *def,
                                          const thrum_surface **surface, thrum_error *error);

/* Vertices and triangles of a surface; 0 for NULL. */
THRUM_API int64_t thrum_surface_vertex_count(const thrum_surface *surface);
THRUM_API int64_t thrum_surface_triangle_count(const thrum_surface *surface);

/* Writes three floats for each vertex first..first+count-1 (places in the output) to `out`,
 * `stride` >= 3 floats from one vertex to the next; what lies between is left alone. q: rank.
 * THRUM_BAD_VALUE when q is not finite or too large for single precision. A body may be split among
 * threads by ranges; multiples of 16 keep every thread's rows whole. */
THRUM_API thrum_status thrum_surface_positions(const thrum_surface *surface,
                                               thrum_surface_output output, const double *q,
                                               int64_t first, int64_t count, float *out,
                                               int64_t stride, thrum_error *error);

/* Unit normals of all vertices from their positions: the mean of the triangles' normals weighted by
 * area; (0, 0, 0) where that vanishes. Strides in floats, >= 3; the two must not overlap, but may
 * interleave in one buffer. THRUM_MISSING for a surface without triangles. */
THRUM_API thrum_status thrum_surface_normals(const thrum_surface *surface, const float *positions,
                                             int64_t position_stride, float *normals,
                                             int64_t normal_stride, thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
