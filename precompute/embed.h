/* Embedding: a surface bound to the tetrahedra of a model, and its rows of the basis
 * (thrum/embedding.h, docs/embedding.md).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_EMBED_H
#define THRUM_PRECOMPUTE_EMBED_H

#include "mesh/surface_mesh.h"
#include "platform/allocate.h"
#include "thrum/embedding.h"

/* How far outside a surface may lie, in lengths of the body, before its scale or place is in doubt.
 */
#define THRUM_EMBED_FAR 0.1

/* How a surface lies about the mesh. */
typedef struct thrum_embed_report {
  double extent;       /* longest side of the mesh's box [m] */
  int64_t outside;     /* vertices farther from their tetrahedron than 1e-9 of it: extrapolated */
  double distance_max; /* the farthest of them [m]; 0: none */
  int64_t farthest;    /* which, 0-based; -1: none */
  double weight_max; /* the largest weight in size: 1 inside, larger the bolder the extrapolation */
} thrum_embed_report;

/* An embedding whose arrays are its own; zeroed it is empty. */
typedef struct thrum_embed {
  thrum_embedding embedding;
  thrum_embed_report report;
  thrum_scope memory; /* of the arrays */
} thrum_embed;

/* `tell` is called now and then with how far the work is, 0 to 1. */
typedef struct thrum_embed_progress {
  void (*tell)(void *context, double fraction);
  void *context;
} thrum_embed_progress;

/* Binds each vertex of the surface to the tetrahedron of the model that it lies in, or else to the
 * nearest, whose map it follows; makes its rows. Needs a model with a mesh and a basis
 * (THRUM_MISSING). `meta` is JSON text, copied; NULL: none. `progress` may be NULL.
 * thrum_embed_free frees. Cost: a tree of the tetrahedra, then for each vertex about log n and 12
 * operations a coordinate. */
thrum_status thrum_embed_make(const thrum_model *model, const thrum_surface_mesh *surface,
                              const char *meta, const thrum_embed_progress *progress,
                              thrum_embed *embed, thrum_error *error);
void thrum_embed_free(thrum_embed *embed);

/* Writes the surface file. */
thrum_status thrum_embed_save(const char *path, const thrum_embedding *embedding,
                              thrum_error *error);

#endif
