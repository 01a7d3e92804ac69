/* Internal forces of several displacements at once, for what takes those of many.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_FEM_FORCES_H
#define THRUM_PRECOMPUTE_FEM_FEM_FORCES_H

#include "precompute/fem/fem.h"

enum { THRUM_FEM_LANES = 8 };

/* R_full [N] of so many displacements u [m] of a body in which nothing has flowed. Both are
 * 3 vertex_count x lanes: the displacements stand side by side. */
void thrum_fem_forces(const thrum_fem *fem, const double *u, double *force);

#endif
