/* A body with a basis whose vertices may all touch, as fixture of tests of scenes.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_TOUCHING_BODY_H
#define THRUM_TESTS_TOUCHING_BODY_H

#include "tests/support/outer_triangles.h"
#include "tests/support/precompute_support.h"

typedef struct touching_body {
  body mesh;
  thrum_precomputed made;
  int32_t *triangles, *touch;
  int64_t triangle_count;
} touching_body;

/* The basis, the surface and the touching vertices of f->mesh. */
static inline void touching_body_make(touching_body *f, int modes, int rank) {
  f->made = body_precompute(&f->mesh, modes, rank);
  f->triangles = outer_triangles(&f->mesh.mesh, &f->triangle_count);
  const int64_t count = f->made.model.vertex_count;
  f->touch = need((size_t)count, sizeof *f->touch);
  for (int64_t v = 0; v < count; v++)
    f->touch[v] = (int32_t)v;
}

/* Frees what a setup has allocated with calloc. */
static inline int touching_body_teardown(void **context) {
  touching_body *f = *context;
  thrum_precomputed_free(&f->made);
  body_free(&f->mesh);
  free(f->triangles);
  free(f->touch);
  free(f);
  return 0;
}

#endif
