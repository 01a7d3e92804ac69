/* Volumes of a deformed body at the points of quadrature, det F. Cost: one pass over them.
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/fem_inverted.h"

#include <math.h>

#include "core/base/vec3.h"
#include "precompute/fem/fem_tet.h"

thrum_fem_inversion thrum_fem_inverted(const thrum_fem *fem, const double *u) {
  thrum_fem_inversion found = {.least = INFINITY};
  for (int64_t t = 0; t < fem->tet_count; t++) {
    double least = INFINITY;
    for (int p = 0; p < fem->point_count; p++) {
      thrum_tet tet;
      double cofactor[3];
      thrum_fem_tet_at(fem, t, p, u, &tet);
      thrum_cross3(tet.deformation[0], tet.deformation[1], cofactor);
      const double volume = thrum_dot3(cofactor, tet.deformation[2]);
      least = volume < least || isnan(volume) ? volume : least;
    }

    // what is no number is no volume
    found.count += !(least > 0);
    if (least < found.least || isnan(least)) {
      found.least = least;
      found.tet = t;
    }
  }
  return found;
}
