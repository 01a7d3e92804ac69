/* Two models of one beam, free and held, and the surface of both, as fixture of tests of scenes.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_TWO_BARS_H
#define THRUM_TESTS_SUPPORT_TWO_BARS_H

#include "tests/support/outer_triangles.h"
#include "tests/support/precompute_support.h"

enum { BAR_MODES = 3, BAR_RANK = 6 };

typedef struct two_bars {
  body meshes[2];
  thrum_precomputed free_bar, held_bar;
  int32_t *triangles;
  int64_t triangle_count;
} two_bars;

/* A beam of the generator with Young's modulus [Pa]; the second is held at x = 0. */
static inline void two_bars_make(two_bars *bars, const char *spec, double young) {
  for (int n = 0; n < 2; n++) {
    bars->meshes[n] = body_make(spec, n == 0 ? NULL : "x<0.001");
    bars->meshes[n].mesh.materials[0] = (thrum_material){young, 0.3, 1000};
  }
  bars->free_bar = body_precompute(&bars->meshes[0], BAR_MODES, BAR_RANK);
  bars->held_bar = body_precompute(&bars->meshes[1], BAR_MODES, BAR_RANK);
  bars->triangles = outer_triangles(&bars->meshes[0].mesh, &bars->triangle_count);
}

static inline void two_bars_free(two_bars *bars) {
  thrum_precomputed_free(&bars->free_bar);
  thrum_precomputed_free(&bars->held_bar);
  for (int n = 0; n < 2; n++)
    body_free(&bars->meshes[n]);
  free(bars->triangles);
}

#endif
