/* Volumes of a deformed body at the points of quadrature, det F. Cost: one pass over them.
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/fem_inverted.h"

#include <math.h>

#include "core/base/vec3.h"
#include "precompute/fem/fem_solids.h"

/* det F at a point */
static double volume_of(const thrum_tet *tet) {
  double cofactor[3];
  thrum_cross3(tet->deformation[0], tet->deformation[1], cofactor);
  return thrum_dot3(cofactor, tet->deformation[2]);
}

/* Counts an element whose least volume is that; what is no number is no volume. */
static void count_element(double least, int64_t t, thrum_fem_inversion *found) {
  found->count += !(least > 0);
  if (least < found->least || isnan(least)) {
    found->least = least;
    found->tet = t;
  }
}

thrum_fem_inversion thrum_fem_inverted(const thrum_fem *fem, const double *u) {
  thrum_fem_inversion found = {.least = INFINITY};
  for (int64_t t = 0; t < fem->tet_count; t++) {
    double least = INFINITY;
    for (int p = 0; p < fem->point_count; p++) {
      thrum_tet tet;
      thrum_fem_tet_at(fem, t, p, u, &tet);
      const double volume = volume_of(&tet);
      least = volume < least || isnan(volume) ? volume : least;
    }
    count_element(least, t, &found);
  }

  // a solid is named by its first tet
  for (int64_t s = 0; s < fem->solids.count; s++) {
    double least = INFINITY;
    for (int p = 0; p < fem->solids.tables[fem->solids.form[s]].points; p++) {
      thrum_tet tet;
      thrum_fem_solid_at(fem, s, p, u, &tet);
      const double volume = volume_of(&tet);
      least = volume < least || isnan(volume) ? volume : least;
    }
    count_element(least, thrum_solid_tet(&fem->solids, s), &found);
  }
  return found;
}
