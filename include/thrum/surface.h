/* Positions and normals of chosen vertices for drawing, in single precision, written straight into
 * the caller's buffer.
 *
 *   x_v = X_v + sum_i U_vi q_i
 *
 * Its rows are those of U of the model's vertices, or its own (a surface embedded in the mesh:
 * thrum/embedding.h). It keeps only these, as floats: half the bytes of a double-precision product,
 * in the order in which they are read. Positions have the same bits on every machine (mode by mode,
 * ascending, in single precision).
 *
 * Memory: a surface is planned (thrum_surface_size), then laid into the caller's memory
 * (thrum_surface_init); afterwards it needs the model no longer and holds no pointer. No function
 * here allocates.
 *
 * Threads: a surface is immutable and may be shared by any number of threads.
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

/* Which vertices a surface has; zero-initialise it for all vertices without normals. The arrays are
 * only read while a surface is planned and made. */
typedef struct thrum_surface_def {
  /* vertex_count: 0-based vertices of the model in the order of the output; NULL: all. */
  const int32_t *vertices;

  /* Number of `vertices` or `positions`; 1 to 2^31 - 1, ignored when both are NULL. Larger: more
   * output, and time and memory in proportion. */
  int64_t vertex_count;

  /* triangle_count x 3: 0-based places in the output; NULL: the surface has no normals. */
  const int32_t *triangles;

  /* Number of triangles; 1 to 2^31 - 1, ignored without them. Larger: normals take longer. */
  int64_t triangle_count;

  /* vertex_count x 3: rest positions [m] of a surface with rows of its own, which needs no basis of
   * the model; `rows` comes with it and `vertices` is NULL. NULL: the model's vertices. */
  const double *positions;

  /* 3 vertex_count x row_rank: rows 3 v + axis with x = X + rows q [kg^-1/2]; comes with
   * `positions`. */
  const float *rows;

  /* Columns of `rows`; the model's rank to THRUM_RANK_MAX, ignored without them. Larger: the
   * further columns are skipped. */
  int64_t row_rank;
} thrum_surface_def;

/* Opaque: lives at the start of the memory given to thrum_surface_init. */
typedef struct thrum_surface thrum_surface;

/* Which quantity a call of thrum_surface_positions writes. */
typedef enum thrum_surface_output {
  THRUM_SURFACE_DISPLACEMENTS = 0, /* u = U q [m] */
  THRUM_SURFACE_POSITIONS = 1      /* X + U q [m] */
} thrum_surface_output;

/* Bytes of a surface of this model, into *size. THRUM_INVALID_ARGUMENT for a def out of its ranges,
 * THRUM_MISSING where neither the model has a basis nor the def its own rows. */
THRUM_API thrum_status thrum_surface_size(const thrum_model *model, const thrum_surface_def *def,
                                          size_t *size, thrum_error *error);

/* Lays a surface into `memory`, aligned to 64 bytes and of at least thrum_surface_size bytes. The
 * caller owns the memory and frees it when done; *surface points into it. THRUM_MISALIGNED,
 * THRUM_BUFFER_TOO_SMALL, or the failures of thrum_surface_size. */
THRUM_API thrum_status thrum_surface_init(void *memory, size_t memory_size,
                                          const thrum_model *model, const thrum_surface_def *def,
                                          const thrum_surface **surface, thrum_error *error);

/* Number of vertices and of triangles of a surface; 0 for NULL. */
THRUM_API int64_t thrum_surface_vertex_count(const thrum_surface *surface);
THRUM_API int64_t thrum_surface_triangle_count(const thrum_surface *surface);

/* THRUM_MODEL_MISMATCH where the surface was made of a model with other coordinates than `model`
 * has: another rank, or other frequencies. thrum_surface_positions cannot know whose q it is given.
 * Reads omega2 once. */
THRUM_API thrum_status thrum_surface_fits(const thrum_surface *surface, const thrum_model *model,
                                          thrum_error *error);

/* Writes three floats for each vertex first..first+count-1 (places in the output) to `out`,
 * `stride` >= 3 floats from one vertex to the next; the floats between stay as they are. q: rank.
 * THRUM_BAD_VALUE where q is not finite or too large for single precision, THRUM_INVALID_ARGUMENT
 * for NULL, a range beyond the surface or a smaller stride. Threads may share a body by ranges;
 * multiples of 16 keep every thread's rows whole. */
THRUM_API thrum_status thrum_surface_positions(const thrum_surface *surface,
                                               thrum_surface_output output, const double *q,
                                               int64_t first, int64_t count, float *out,
                                               int64_t stride, thrum_error *error);

/* Unit normals of all vertices from their positions, vertex_count x 3 each: the mean of the
 * triangles' normals weighted by area; (0, 0, 0) where that vanishes. Strides are in floats and
 * >= 3; the two arrays must not overlap, but may interleave in one buffer. THRUM_MISSING for a
 * surface without triangles, THRUM_INVALID_ARGUMENT for NULL or a smaller stride. */
THRUM_API thrum_status thrum_surface_normals(const thrum_surface *surface, const float *positions,
                                             int64_t position_stride, float *normals,
                                             int64_t normal_stride, thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
