/* Barycentric coordinates in a tetrahedron, and the distance to a triangle; see tet_distance.h.
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/tet_distance.h"

#include <string.h>

#include "core/base/vec3.h"

/* Adds to w_1..w_3 what the vector x takes of the edges from corner a, and takes it off w_0. */
static void add_weights(double edges[3][3], double volume, const double x[3], double weights[4]) {
  for (int c = 0; c < 3; c++) {
    double with[3][3];
    memcpy(with, edges, sizeof with);
    memcpy(with[c], x, sizeof with[c]);
    const double share = thrum_triple3(with[0], with[1], with[2]) / volume;
    weights[c + 1] += share;
    weights[0] -= share;
  }
}

void thrum_tet_weights(const double *const corners[4], const double point[3], double weights[4]) {
  double edges[3][3], x[3];
  for (int c = 0; c < 3; c++)
    thrum_subtract3(corners[c + 1], corners[0], edges[c]);
  const double volume = thrum_triple3(edges[0], edges[1], edges[2]);
  memcpy(weights, (double[4]){1, 0, 0, 0}, 4 * sizeof *weights);
  thrum_subtract3(point, corners[0], x);
  add_weights(edges, volume, x, weights);
  // what is left of x
  for (int axis = 0; axis < 3; axis++)
    x[axis] -=
        weights[1] * edges[0][axis] + weights[2] * edges[1][axis] + weights[3] * edges[2][axis];
  add_weights(edges, volume, x, weights);
}

/* Squared distance to a + s (b - a) + t (c - a). */
static double distance2_at(const double ap[3], const double ab[3], const double ac[3], double s,
                           double t) {
  double rest[3];
  for (int axis = 0; axis < 3; axis++)
    rest[axis] = ap[axis] - s * ab[axis] - t * ac[axis];
  return thrum_dot3(rest, rest);
}

double thrum_triangle_distance2(const double *a, const double *b, const double *c,
                                const double point[3]) {
  // the projections of the point onto the sides, from each corner
  double ab[3], ac[3], ap[3], bp[3], cp[3];
  thrum_subtract3(b, a, ab);
  thrum_subtract3(c, a, ac);
  thrum_subtract3(point, a, ap);
  thrum_subtract3(point, b, bp);
  thrum_subtract3(point, c, cp);
  const double d1 = thrum_dot3(ab, ap), d2 = thrum_dot3(ac, ap), d3 = thrum_dot3(ab, bp),
               d4 = thrum_dot3(ac, bp);
  const double d5 = thrum_dot3(ab, cp), d6 = thrum_dot3(ac, cp);

  // nearest to a corner
  if (d1 <= 0 && d2 <= 0)
    return thrum_dot3(ap, ap);
  if (d3 >= 0 && d4 <= d3)
    return thrum_dot3(bp, bp);
  if (d6 >= 0 && d5 <= d6)
    return thrum_dot3(cp, cp);

  // nearest to a side
  const double in_c = d1 * d4 - d3 * d2, in_b = d5 * d2 - d1 * d6, in_a = d3 * d6 - d5 * d4;
  if (in_c <= 0 && d1 >= 0 && d3 <= 0)
    return distance2_at(ap, ab, ac, d1 / (d1 - d3), 0);
  if (in_b <= 0 && d2 >= 0 && d6 <= 0)
    return distance2_at(ap, ab, ac, 0, d2 / (d2 - d6));
  if (in_a <= 0 && d4 >= d3 && d5 >= d6) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return distance2_at(ap, ab, ac, 1 - t, t);
  }

  // nearest to the inside
  const double whole = in_a + in_b + in_c;
  return distance2_at(ap, ab, ac, in_b / whole, in_c / whole);
}
