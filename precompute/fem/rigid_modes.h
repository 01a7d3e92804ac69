/* The rigid modes of a free body, and the six springs that make its stiffness definite.
 *
 * K of a free body is singular: K Z = 0 for its six rigid modes Z. Springs at three vertices, of
 * stiffness matrix S, hold it as little as can be: three directions of the first vertex, the two
 * across the line to the second, the one across the plane of all three. Under loads b without
 * resultant, Z^T b = 0, the springs carry nothing: the solution of K x = b that leaves them at rest
 * solves (K + S) x = b too. So P (K + S)^-1 P^T b, P = 1 - Z Z^T M, is the pseudo-inverse exactly,
 * whatever the springs' strength, with no shift to choose and no iteration (design 2).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_RIGID_MODES_H
#define THRUM_PRECOMPUTE_FEM_RIGID_MODES_H

#include "precompute/fem/fem.h"

#define THRUM_RIGID_COUNT 6

/* Makes, for a body with nothing held, Z (n x 6, column-major, n = 3 vertices) with Z^T M Z = 1,
 * shifts along x, y, z first, then turns about the centre of mass; dual = M Z, n x 6. */
thrum_status thrum_rigid_modes(const thrum_fem *fem, const thrum_sparse *mass, double *modes,
                               double *dual, thrum_error *error);

/* Largest |K z| / (|K| |z|) of the six: rounding where the mesh moves as one body. */
thrum_status thrum_rigid_residual(const thrum_sparse *stiffness, const double *modes,
                                  double *residual, thrum_error *error);

/* Where the springs are: three vertices far from each other, and the matrix of each spring for unit
 * strength, a projector onto its directions. */
enum { THRUM_SUPPORTS = 3 };

typedef struct thrum_support {
  int64_t vertex[THRUM_SUPPORTS];
  double direction[THRUM_SUPPORTS][3][3];
} thrum_support;

/* Finds the springs of a whole body. */
void thrum_support_find(const thrum_fem *fem, thrum_support *support);

/* Keeps what the springs changed, so that it can be put back bit by bit. */
typedef struct thrum_support_springs {
  int64_t entry[18];
  double value[18];
} thrum_support_springs;

/* Adds the springs to the stiffness, inside its pattern. */
void thrum_support_springs_add(const thrum_fem *fem, thrum_sparse *stiffness,
                               thrum_support_springs *springs);
void thrum_support_springs_remove(const thrum_support_springs *springs, thrum_sparse *stiffness);

#endif
