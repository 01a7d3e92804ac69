/* Elements as tables: nodes, points of quadrature, and shape functions with their slopes there, of
 * each form of solid. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_SOLID_SHAPE_H
#define THRUM_MESH_SOLID_SHAPE_H

#include <stdbool.h>

#include "mesh/solids.h"

enum { THRUM_SOLID_POINTS_MAX = 27 };

/* Natural coordinates are -1 to 1 in a hexahedron; r, s >= 0 of a triangle and -1 to 1 in a wedge;
 * the barycentric coordinates 1, 2, 3 in a tetrahedron. */
typedef struct thrum_solid_table {
  int nodes, points;
  double place[THRUM_SOLID_POINTS_MAX][3];
  double weight[THRUM_SOLID_POINTS_MAX]; /* they add up to the volume in natural coordinates */
  double shape[THRUM_SOLID_POINTS_MAX][THRUM_SOLID_NODES_MAX];
  double slopes[THRUM_SOLID_POINTS_MAX][THRUM_SOLID_NODES_MAX][3];
} thrum_solid_table;

/* Natural coordinates of the corners of elements; no pyramids. */
extern const double thrum_solid_corners[THRUM_SOLID_KINDS][8][3];

/* The same of a node, of which middle ones lie in the middle of their edge. */
void thrum_solid_node_place(thrum_solid kind, int node, double place[3]);

/* The table of a form: the points integrate its mass exactly where faces are flat and opposite
 * edges parallel, and the linear part of its strain energy, too. */
void thrum_solid_table_make(thrum_solid_form form, thrum_solid_table *table);

/* Shape functions and their slopes at any place; either may be NULL. */
void thrum_solid_shape_at(thrum_solid_form form, const double place[3], double *shape,
                          double (*slopes)[3]);

/* The map to space at slopes: jacobian[i] is the derivative of the place by natural coordinate i,
 * and gradients[i] the gradient of that coordinate [1/m], not set where the determinant that it
 * returns is not positive. */
double thrum_solid_map(int nodes, double (*places)[3], double (*slopes)[3], double jacobian[3][3],
                       double gradients[3][3]);

#endif
