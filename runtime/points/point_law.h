/* Laws other than Saint Venant-Kirchhoff's, or several, at eight cubature points, one in each lane,
 * less the law of small strains, whose energy is that of the whole body
 * (core/polynomial/points.h). Plain C for all kernels, which so have the same bits. Private to
 * runtime/.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_POINTS_POINT_LAW_H
#define THRUM_RUNTIME_POINTS_POINT_LAW_H

#include <stdint.h>

#include "runtime/material/material_law.h"

/* Eight points: component c of lane k is entry 8 c + k of a gradient (72 numbers) or stress. */
typedef struct thrum_point_lanes {
  int64_t count; /* of points in these lanes, the first; the others give zeros */
  thrum_law law[8];
  double lambda[8], mu[8]; /* times the weights of the points [J] */
  const double *gradient;
  const double *plastic; /* F_p^-1 - 1 of each point, 9 numbers; NULL: nothing has flowed */
} thrum_point_lanes;

/* energy (8) and stress (72), where F_p is held, without their linear parts. */
void thrum_point_law_stress(const thrum_point_lanes *at, double *energy, double *stress);

/* tangent[8 (9 i + j) + k] = dP_i / dF_j in lane k, less that at rest. */
void thrum_point_law_tangent(const thrum_point_lanes *at, double *tangent);

/* The part of degree 2 in the gradient of the stress (72), and that of degree 4 of the energy (8),
 * at rest and to some 1e-4 of themselves. */
void thrum_point_law_terms(const thrum_point_lanes *at, double *energy, double *stress);

#endif
