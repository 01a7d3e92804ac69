/* Cauchy stress at the nodes of a body of solid elements: the stress of the strains that an element
 * is assumed to have, with its enhanced ones, at the points of quadrature; from there to the nodes
 * by the linear functions of the element that fit it best; and at a node the mean of the elements
 * of one region around it, by their volumes.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_SOLID_STRESS_H
#define THRUM_PRECOMPUTE_FEM_SOLID_STRESS_H

#include "precompute/fem/fem.h"

typedef struct thrum_solid_stresses {
  thrum_scope memory;
  const thrum_fem *fem; /* borrowed */
  int64_t count;        /* pairs of a vertex and a region */
  int32_t *vertex;      /* count, ascending */
  int32_t *region;      /* count */
  int32_t *slot;        /* the pair of each node of each element, as solid_nodes has them */
  double *weight;       /* count: one over the volume around each pair [1/m^3] */
  int64_t *begin;       /* elements + 1: places in `matrix` */
  double *matrix;       /* of an element with rows: 6 stresses a point by its products */
  double *to_nodes;     /* of each form THRUM_SOLID_NODES_MAX x THRUM_SOLID_POINTS_MAX */
} thrum_solid_stresses;

/* Plans for a body of solids, which must stay. On failure nothing is left to free. */
thrum_status thrum_solid_stresses_make(const thrum_fem *fem, thrum_solid_stresses *made,
                                       thrum_error *error);
void thrum_solid_stresses_free(thrum_solid_stresses *stress);

/* At displacements u (3 vertex_count [m]): count x 6, xx, yy, zz, xy, yz, xz [Pa]. NaN at nodes of
 * elements that are turned inside out at a point. */
void thrum_solid_stresses_read(const thrum_solid_stresses *stress, const double *u, double *cauchy);

#endif
