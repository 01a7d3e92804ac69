/* The arrays of a mesh as the passes of mesh_body.cl take them; private to the accelerator library.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_ACCELERATOR_DEVICE_MESH_H
#define THRUM_ACCELERATOR_DEVICE_MESH_H

#include <stdint.h>

#include "thrum/model.h"

/* Numbers of a tetrahedron t at k * tets + t, of a vertex at 3 v + axis; one block of memory each,
 * which device_mesh_free returns. */
typedef struct device_mesh {
  int64_t vertices, tets;
  int nodes, points;     /* of a tetrahedron: 4 and 1, or 10 and 11 */
  int32_t *node;         /* nodes x tets */
  double *gradients;     /* 9 x tets: of the barycentric coordinates 1, 2, 3 [1/m] */
  double *volume;        /* tets [m^3] */
  double *moduli;        /* 2 x tets: Lame's lambda, mu [Pa] */
  double *slopes;        /* points x nodes x 3: of the shape functions by these coordinates */
  double *shares;        /* points: weights, which add up to 1 */
  int32_t *around_ends;  /* vertices: end of each one's run in */
  int32_t *around;       /* nodes x tets: node * tets + t of what is around it, ascending */
  int32_t *mass_ends;    /* vertices: end of each one's row of the consistent mass matrix, in */
  int32_t *mass_columns; /* columns ascending, and */
  double *mass;          /* its entries [kg], the same along each axis */
  double *diagonal_mass, *diagonal_stiffness; /* 3 x vertices: of M, and of K at rest */
} device_mesh;

/* THRUM_MISSING for a model without tetrahedra, THRUM_UNSUPPORTED for curved edges and for other
 * elements, THRUM_OUT_OF_MEMORY. */
thrum_status device_mesh_make(const thrum_model *model, device_mesh *mesh, thrum_error *error);
void device_mesh_free(device_mesh *mesh); /* an empty (zeroed) one is fine */

#endif
