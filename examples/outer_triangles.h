/* The surface of a model's mesh, for the examples whose bodies touch something by their faces.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef OUTER_TRIANGLES_H
#define OUTER_TRIANGLES_H

#include <stdlib.h>

#include "thrum/thrum.h"

/* The outer triangles of the model, of which bodies touch each other: those of its tetrahedra that
 * no other has. Fine for small meshes. NULL without memory. */
static inline int32_t *outer_triangles(const thrum_model *model, int64_t *count) {
  static const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  int32_t *triangles = malloc((size_t)(12 * model->tet_count) * sizeof *triangles);
  *count = 0;
  for (int64_t n = 0; n < 4 * model->tet_count && triangles != NULL; n++) {
    const int32_t *tet = model->tets + 4 * (n / 4);
    const int *face = faces[n % 4];
    int shared = 0;

    // a face within the body belongs to two tetrahedra
    for (int64_t m = 0; m < model->tet_count; m++) {
      int found = 0;
      for (int k = 0; k < 4; k++)
        for (int j = 0; j < 3; j++)
          found += model->tets[4 * m + k] == tet[face[j]];
      shared += found == 3;
    }
    for (int j = 0; j < 3 && shared == 1; j++)
      triangles[3 * *count + j] = tet[face[j]];
    *count += shared == 1;
  }
  return triangles;
}

#endif
