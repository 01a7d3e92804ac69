/* Elasticity that depends on direction: orthotropic regions, and laminates of such layers.
 *
 * A row of THRUM_ELASTIC_NUMBERS numbers is a layer. A region without rows is isotropic. One row
 * without a thickness holds in the whole region, along directions that are fixed in space. Rows
 * with a thickness are the layers of a laminate, from the lower face of a solid-shell to the upper
 * one: direction 1 is projected onto the sheet, and turned about its normal by the angle. By rows
 * 1, 2, 3 of axes a and with engineering shears,
 *   1/E_1, -nu_12/E_1, ... is the compliance,   C its inverse = R^T R.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_ELASTIC_H
#define THRUM_MESH_ELASTIC_H

#include <stdbool.h>

#include "mesh/mesh.h"

enum {
  THRUM_ELASTIC_REGION = 0,  /* from 0, ascending from row to row */
  THRUM_ELASTIC_YOUNG = 1,   /* E_1, E_2, E_3 [Pa] */
  THRUM_ELASTIC_POISSON = 4, /* nu_12, nu_13, nu_23: strain of the second by stress of the first */
  THRUM_ELASTIC_SHEAR = 7,   /* G_12, G_13, G_23 [Pa] */
  THRUM_ELASTIC_FIRST = 10,  /* direction 1, of any length, */
  THRUM_ELASTIC_SECOND = 13, /* and another one in the plane of directions 1 and 2 */
  THRUM_ELASTIC_ANGLE = 16,  /* [rad] */
  THRUM_ELASTIC_THICKNESS = 17, /* share of that of all layers; 0: this is no layer */
  THRUM_ELASTIC_NUMBERS = 18,
  THRUM_ELASTIC_LAYERS_MAX = 64,
  THRUM_STRAINS = 6 /* 11, 22, 33, 23, 13, 12 */
};

typedef double thrum_elastic_matrix[THRUM_STRAINS][THRUM_STRAINS];

/* R along its own directions, upper triangular; false where the energy is not positive. */
bool thrum_elastic_root(const double *row, thrum_elastic_matrix root);

/* The directions as rows, in a sheet of this unit normal (NULL: in space); false where there are
 * none, as two are parallel. */
bool thrum_elastic_axes(const double *row, const double *normal, double axes[3][3]);

/* R along the axes of space. */
void thrum_elastic_turn(thrum_elastic_matrix root, double axes[3][3], thrum_elastic_matrix turned);

/* C = R^T R */
void thrum_elastic_stiffness(thrum_elastic_matrix root, thrum_elastic_matrix stiffness);

/* The nine constants by C along its own directions; false where C is not positive. */
bool thrum_elastic_constants(thrum_elastic_matrix stiffness, double *row);

/* Gives a region these rows in place of those that it has; 0: none. Young's modulus and Poisson's
 * ratio of the region become those of the isotropic mean of its first row (Voigt). Refuses
 * constants without positive energy and parallel directions. */
thrum_status thrum_mesh_set_elastic(thrum_mesh *mesh, int64_t region, const double *rows,
                                    int64_t count, thrum_error *error);

/* The rows of a region: the first, and the number behind the last. */
int64_t thrum_mesh_elastic_begin(const thrum_mesh *mesh, int64_t region);

/* Is one of the regions a laminate? */
bool thrum_mesh_has_layers(const thrum_mesh *mesh);

/* Makes tetrahedra solids, of four or of ten nodes, which then are cut at their middle nodes:
 * elements with directions are solids. Without effect on a mesh that has solids. */
thrum_status thrum_mesh_make_solids(thrum_mesh *mesh, thrum_error *error);

#endif
