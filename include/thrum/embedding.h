/* A surface embedded in a model's mesh: a fine triangle surface whose vertices follow the
 * tetrahedra that they are bound to, as `thrum embed` writes it (docs/embedding.md).
 *
 *   x_v = sum_c w_vc (X_c + U_c q) = X_v + W_v q,   W_v = sum_c w_vc U_c,   sum_c w_vc = 1
 *
 * over the four corners c of its tetrahedron; w are its barycentric coordinates there, which stay
 * exact under every affine map of the mesh. In a ten-node tetrahedron W_v is a sum over all nodes,
 * with the quadratic shape functions at w. The rows W are made beforehand, so a surface costs as
 * much as the same number of vertices of the mesh, and a model needs neither mesh nor basis for it.
 *
 *   load the model; thrum_surface_load; each frame: step, thrum_surface_positions, _normals, draw
 *
 * Memory: only thrum_embedding_load and thrum_surface_load allocate, one block each, which
 * thrum_embedding_destroy and thrum_surface_destroy return. Threads: an embedding is immutable and
 * may be shared by any number of threads.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_EMBEDDING_H
#define THRUM_EMBEDDING_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/api.h"
#include "thrum/surface.h"

#ifdef __cplusplus
extern "C" {
#endif

#define THRUM_EMBEDDING_FORMAT_MAJOR 1 /* a reader refuses another major version */
#define THRUM_EMBEDDING_FORMAT_MINOR 0 /* a minor version only adds arrays */

/* Sizes of an embedding. X(name, meaning). */
#define THRUM_EMBEDDING_SIZES(X)                                                                   \
  X(rank, "number of reduced coordinates r of the model")                                          \
  X(vertex_count, "vertices of the surface")                                                       \
  X(triangle_count, "triangles of the surface")                                                    \
  X(meta_bytes, "bytes of the JSON text in meta")

/* The arrays, in file order, as THRUM_MODEL_ARRAYS; f4 is a single-precision number. */
#define THRUM_EMBEDDING_ARRAYS(X)                                                                  \
  X(i4, surface_format, 2, 1, REQUIRED, "version of the format: major, minor")                     \
  X(u1, meta, meta_bytes, 1, OPTIONAL, "UTF-8 JSON about the surface; the runtime never reads it") \
  X(f8, omega2, rank, 1, REQUIRED, "those of the model, which tell it from others [1/s^2]")        \
  X(f8, positions, vertex_count, 3, REQUIRED,                                                      \
    "rest positions X [m], in the order of the surface's file")                                    \
  X(i4, triangles, triangle_count, 3, REQUIRED, "0-based vertices of the surface")                 \
  X(f4, basis, basis_rows, rank, REQUIRED, "W, rows 3 v + axis [kg^-1/2]")                         \
  X(i4, tet, vertex_count, 1, REQUIRED, "0-based tetrahedron of the model's mesh")                 \
  X(f8, weights, vertex_count, 4, REQUIRED, "barycentric coordinates w in it; negative: outside")
/* basis_rows is 3 * vertex_count */

typedef float thrum_f4;

/* Immutable; the arrays lie in a block that the embedding does not own: the caller's file buffer or
 * arrays, or the block of thrum_embedding_load. */
typedef struct thrum_embedding {
#define X(name, meaning) int64_t name;
  THRUM_EMBEDDING_SIZES(X)
#undef X
#define X(type, name, rows, columns, presence, meaning) const thrum_##type *name;
  THRUM_EMBEDDING_ARRAYS(X)
#undef X
} thrum_embedding;

/* Uses `file`, the bytes of a surface file aligned to 8, in place: on success *embedding points
 * into it, and it must outlive the embedding. The whole file is checked: THRUM_BAD_FORMAT,
 * THRUM_BAD_CHECKSUM, THRUM_UNSUPPORTED, THRUM_MISSING, THRUM_BAD_SHAPE or THRUM_BAD_VALUE with the
 * array; THRUM_MISALIGNED where an array is not aligned to its entries (`thrum embed` aligns them).
 * Allocates nothing. */
THRUM_API thrum_status thrum_embedding_view(const void *file, size_t file_size,
                                            thrum_embedding *embedding, thrum_error *error);

/* Reads the file at `path` into one heap block, which the caller owns and returns with
 * thrum_embedding_destroy. THRUM_IO, THRUM_OUT_OF_MEMORY, or the failures of thrum_embedding_view.
 */
THRUM_API thrum_status thrum_embedding_load(const char *path, const thrum_embedding **embedding,
                                            thrum_error *error);
THRUM_API void thrum_embedding_destroy(
    const thrum_embedding *embedding); /* made by _load alone; NULL does nothing */

/* Checks an embedding made by hand: every size, value and index. THRUM_INVALID_ARGUMENT for NULL,
 * THRUM_BAD_SHAPE or THRUM_BAD_VALUE with the array. */
THRUM_API thrum_status thrum_embedding_check(const thrum_embedding *embedding, thrum_error *error);

/* Checks that the surface is embedded in this model, or in the one of which it is the first part:
 * THRUM_BAD_VALUE where omega2 differs, and the surface has to be embedded again;
 * THRUM_INVALID_ARGUMENT for NULL. */
THRUM_API thrum_status thrum_embedding_fits(const thrum_embedding *embedding,
                                            const thrum_model *model, thrum_error *error);

/* The def from which thrum_surface_size and _init make this surface, with its triangles. It points
 * into the embedding, which may go once the surface is made. */
THRUM_API thrum_surface_def thrum_embedding_surface(const thrum_embedding *embedding);

/* Reads the file at `path`, checks that it fits the model, and makes the surface in one heap block,
 * which the caller owns and returns with thrum_surface_destroy. The model may lack mesh and basis,
 * and may go afterwards. It fails as thrum_embedding_load, _fits and thrum_surface_init. */
THRUM_API thrum_status thrum_surface_load(const char *path, const thrum_model *model,
                                          const thrum_surface **surface, thrum_error *error);
THRUM_API void
thrum_surface_destroy(const thrum_surface *surface); /* made by _load alone; NULL does nothing */

#ifdef __cplusplus
}
#endif
#endif
