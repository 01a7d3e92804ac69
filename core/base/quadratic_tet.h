/* The ten-node tetrahedron: the order of its nodes, its shape functions, and the points at which
 * its integrals are taken.
 *
 * Nodes 0 to 3 are the corners, in the order that makes the volume positive; node 4 + e lies on
 * edge e, in the order of VTK and Abaqus. A point of the element is given by its barycentric
 * coordinates l_0 to l_3, which add up to 1; derivatives are by l_1, l_2, l_3, with l_0 = 1 - l_1 -
 * l_2 - l_3. Any thread may call all of it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_QUADRATIC_TET_H
#define THRUM_CORE_BASE_QUADRATIC_TET_H

#include <stdbool.h>

enum { THRUM_QUADRATIC_NODES = 10, THRUM_QUADRATIC_EDGES = 6 };

/* The corners at the ends of each edge. */
extern const int thrum_quadratic_edges[THRUM_QUADRATIC_EDGES][2];

/* A point of a quadrature rule; the weights of a rule add up to 1. */
typedef struct thrum_quadratic_point {
  double place[4]; /* barycentric coordinates */
  double weight;   /* above 0 */
} thrum_quadratic_point;

/* The rule for elements with straight or with curved edges, and its number of points. With straight
 * edges strains are quadratic in the place and the strain energy is of degree 4, for which 11
 * points are exact; with curved ones it is rational, and 14 points exact to degree 5 are taken. All
 * weights are positive and all points inside. */
const thrum_quadratic_point *thrum_quadratic_rule(bool curved, int *count);

/* Four points, exact to degree 2: what other programs take for ten nodes. It integrates the energy
 * of small strains of straight elements exactly, that of large ones not. */
const thrum_quadratic_point *thrum_quadratic_rule_of_four(int *count);

/* The ten shape functions, and their derivatives by l_1, l_2, l_3. */
void thrum_quadratic_shape(const double place[4], double shape[THRUM_QUADRATIC_NODES]);
void thrum_quadratic_slopes(const double place[4], double slopes[THRUM_QUADRATIC_NODES][3]);

/* The map from l to space at a point of slopes `slopes`: gradients of l_1, l_2, l_3 (rows) [1/m].
 * Returns its determinant, six times the volume where edges are straight [m^3]; where that is not
 * positive the gradients are not set. */
double thrum_quadratic_map(double nodes[THRUM_QUADRATIC_NODES][3],
                           double slopes[THRUM_QUADRATIC_NODES][3], double gradients[9]);

/* Volume of the element, whose map is a polynomial that the rules integrate exactly [m^3]. */
double thrum_quadratic_volume(double nodes[THRUM_QUADRATIC_NODES][3]);

/* True where a middle node is off the middle of its edge by more than 1e-5 of the edge. */
bool thrum_quadratic_is_curved(double nodes[THRUM_QUADRATIC_NODES][3]);

#endif
