/* Which tetrahedra a displacement turns inside out. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_FEM_INVERTED_H
#define THRUM_PRECOMPUTE_FEM_FEM_INVERTED_H

#include "precompute/fem/fem.h"

typedef struct thrum_fem_inversion {
  int64_t count; /* tetrahedra with det F <= 0, or no number, at a point of quadrature */
  int64_t tet;   /* 0-based, where det F is least */
  double least;  /* det F there */
} thrum_fem_inversion;

/* u: displacements of all components (3 vertex_count). */
thrum_fem_inversion thrum_fem_inverted(const thrum_fem *fem, const double *u);

#endif
