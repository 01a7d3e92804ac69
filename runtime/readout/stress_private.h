/* Memory layout of stress points, private to the runtime (thrum/stress.h).
 *
 * Stress points on all tets keep one set of rows of U a vertex; stress points on chosen ones keep
 * the rows of their four corners, whether or not two share a vertex: chosen tets are few and
 * scattered.
 *
 * A ten-node tet has its stress point at its centre, l_k = 1/4. There the slopes of its corners
 * vanish and those of the middle node of edge ab are those of l_a + l_b, so G is that of a linear
 * tet whose corner k moves by the sum of the three middle nodes next to it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_READOUT_STRESS_PRIVATE_H
#define THRUM_RUNTIME_READOUT_STRESS_PRIVATE_H

#include <stdbool.h>

#include "runtime/material/material_law.h"
#include "thrum/stress.h"

/* One tet's part. */
typedef struct thrum_stress_point_tet {
  double shape[9]; /* gradients of shape functions 1..3 [1/m] */
  double lambda, mu;
  int32_t place[4][3]; /* places of the rows of U that make up the motion of each corner */
  int32_t tet;
  int32_t parts; /* how many these are: 1, or 3 */
  thrum_law law; /* of its region */
} thrum_stress_point_tet;

/* The header; behind it, each at a multiple of 64: tets (count), rows (3 places x rank). */
struct thrum_stress_points {
  uint64_t magic;
  int64_t rank;
  int64_t count;
  int64_t places; /* vertices whose rows of U are kept */
};

/* The law at stress point n. */
thrum_law thrum_stress_points_law(const thrum_stress_points *stress_points, int64_t n);

/* G of stress points n at q, and its Green strain. */
void thrum_stress_points_strain(const thrum_stress_points *stress_points, int64_t n,
                                const double *q, double gradient[3][3], double strain[6]);

/* The vertices whose displacements make up that of a corner: the corner itself, or the three middle
 * nodes next to it in a ten-node tet. Returns how many they are. */
int thrum_stress_points_nodes(const thrum_model *model, int64_t tet, int corner, int32_t nodes[3]);

/* Gradients of shape functions 1..3 of a model's tet, or of the barycentric coordinates 1..3 at the
 * centre of a ten-node tet; false when its volume is not positive there. */
bool thrum_stress_points_shape(const thrum_model *model, int64_t tet, double shape[9]);

#endif
