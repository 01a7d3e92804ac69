/* Measures what a model's mesh is like: volume, mass, extent, and how well shaped its tetrahedra
 * are.
 *
 * The shape measure is the mean ratio 12 (3 V)^(2/3) / (sum of the six squared edges): 1 for the
 * regular tetrahedron, towards 0 for flat ones. A. Liu, B. Joe 1994, Relationship between
 * tetrahedron shape measures, doi:10.1007/BF01955874. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MODEL_QUALITY_H
#define THRUM_MESH_MODEL_QUALITY_H

#include "thrum/model.h"

typedef struct thrum_quality {
  double volume;     /* [m^3] */
  double mass;       /* [kg] */
  double box_min[3]; /* bounding box at rest [m] */
  double box_max[3];
  double ratio_min; /* mean ratio of the worst tetrahedron, in (0, 1]; of solids their scaled
                       Jacobian (solids.h) */
  double ratio_mean;
  int64_t worst_tet;   /* 0-based; of solids the worst of these */
  int64_t fixed_count; /* vertices with any component held */
} thrum_quality;

/* Measures the mesh of a model in one pass; THRUM_MISSING when it has none. Any thread. */
thrum_status thrum_quality_measure(const thrum_model *model, thrum_quality *quality,
                                   thrum_error *error);

/* Mean ratio and signed volume [m^3] of a tetrahedron given by four corners. */
double thrum_tet_mean_ratio(const double *const corners[4], double *volume);

/* Frequencies [Hz] of `count` squared angular frequencies [1/s^2]. */
void thrum_frequencies(const double *omega2, int64_t count, double *hertz);

#endif
