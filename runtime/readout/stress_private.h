/* Memory layout of stress points, private to the runtime (thrum/stress.h).
 *
 * Stress points on all tets keep one set of rows of U a vertex; stress points on chosen ones keep
 * the rows of their four corners, whether or not two share a vertex: chosen tets are few and
 * scattered.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_READOUT_STRESS_PRIVATE_H
#define THRUM_RUNTIME_READOUT_STRESS_PRIVATE_H

#include <stdbool.h>

#include "thrum/stress.h"

/* One tet's part. */
typedef struct thrum_stress_point_tet {
  double shape[9]; /* gradients of shape functions 1..3 [1/m] */
  double lambda, mu;
  int32_t corner[4]; /* places of its rows of U */
  int32_t tet;
  int32_t pad;
} thrum_stress_point_tet;

/* The header; behind it, each at a multiple of 64: tets (count), rows (3 places x rank). */
struct thrum_stress_points {
  uint64_t magic;
  int64_t rank;
  int64_t count;
  int64_t places; /* vertices whose rows of U are kept */
};

const thrum_stress_point_tet *thrum_stress_points_data(const thrum_stress_points *stress_points);

/* G of stress points n at q, and its Green strain. */
void thrum_stress_points_strain(const thrum_stress_points *stress_points, int64_t n,
                                const double *q, double gradient[3][3], double strain[6]);

/* Gradients of shape functions 1..3 of a model's tet; false when its volume is not positive. */
bool thrum_stress_points_shape(const thrum_model *model, int64_t tet, double shape[9]);

#endif
