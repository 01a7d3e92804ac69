/* Energy, forces, stiffness and mass of the solid elements of a body (solid_elements.h), for the
 * files that loop over its tets. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_FEM_SOLIDS_H
#define THRUM_PRECOMPUTE_FEM_FEM_SOLIDS_H

#include "precompute/fem/fem_tet.h"

/* The edges of an element in the state of the body: at rest, where it is about none. */
void thrum_fem_solid_rest(const thrum_fem *fem, int64_t s, double *edges);

/* Point p of element `s` under the displacement u, as thrum_tet_deform has it; NULL: none. */
void thrum_fem_solid_at(const thrum_fem *fem, int64_t s, int p, const double *u, thrum_tet *tet);

/* Strain energy of all solids [J]; adds R(u) to force, which may be NULL. */
double thrum_fem_solids_energy(const thrum_fem *fem, const double *u, double *force);

/* Adds the forces between two displacements whose work on their difference is the change of energy.
 */
void thrum_fem_solids_mean_force(const thrum_fem *fem, const double *from, const double *to,
                                 double *force);

/* The tangent stiffness of element `s` at u (NULL: at rest), without its part by stresses where
 * `positive`; blocks[a][b] of two nodes. */
typedef double thrum_solid_blocks[THRUM_SOLID_NODES_MAX][THRUM_SOLID_NODES_MAX][3][3];
void thrum_fem_solid_stiffness(const thrum_fem *fem, int64_t s, const double *u, bool positive,
                               thrum_solid_blocks blocks);

/* Mass between node `a` of element `s` and each of its nodes [kg]. */
void thrum_fem_solid_mass(const thrum_fem *fem, thrum_mass kind, int64_t s, int a,
                          double masses[THRUM_SOLID_NODES_MAX]);

/* The displacements of the edges of an element with rows from the shape without stress, up to 3
 * THRUM_SOLID_EDGES_MAX, under u (NULL: none), and about the state of the body. */
void thrum_fem_solid_edges(const thrum_fem *fem, int64_t s, const double *u, double *edges);

/* The products of an element with rows at u, 0 at rest. */
void thrum_fem_solid_products(const thrum_fem *fem, int64_t s, const double *u, double *products);

/* Adds forces on the edges of an element with rows to those on its nodes. */
void thrum_fem_solid_add(const thrum_fem *fem, int64_t s, const double *edge_force, double scale,
                         double *force);

#endif
