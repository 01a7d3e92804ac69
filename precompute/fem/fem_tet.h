/* One point of a deformed tetrahedron, for the files that loop over tets. SPDX-License-Identifier:
 * Apache-2.0
 */
#ifndef THRUM_PRECOMPUTE_FEM_FEM_TET_H
#define THRUM_PRECOMPUTE_FEM_FEM_TET_H

#include "precompute/fem/fem.h"

typedef struct thrum_tet {
  double weight, lambda, mu;
  const double *stiffness;   /* 6 x 6 in their place, of solids (elastic.h); NULL: none */
  thrum_law law;             /* at rest all laws are Saint Venant-Kirchhoff's */
  double displacement[3][3]; /* G, the displacement gradient, of F_e */
  double deformation[3][3];  /* F = 1 + G; F_e of plastic flow, F = F_e F_p */
  double stress[3][3];       /* second Piola-Kirchhoff S; of other laws the first, P */
  double energy;             /* [J] */
  double gradient[THRUM_FEM_NODES_MAX][3]; /* of the shape functions; F_p^-T times that */
} thrum_tet;

/* Point p of tet `t` under the displacement u of all components, but for stress and energy; NULL:
 * at rest. */
void thrum_fem_tet_at(const thrum_fem *fem, int64_t t, int p, const double *u, thrum_tet *tet);

/* The same with both. */
void thrum_tet_deform(const thrum_fem *fem, int64_t t, int p, const double *u, thrum_tet *tet);

/* G and F of an element of so many nodes under u (NULL: at rest) by its gradients; F_p is the
 * caller's to add. */
void thrum_tet_displace(const int32_t *node, int nodes, const double *u, thrum_tet *tet);

/* Stress and energy of Saint Venant-Kirchhoff material. */
void thrum_tet_respond(thrum_tet *tet);

/* traction = F S g of a gradient g; of other laws P g. The force on a node, for its shape function,
 * is the weight times that. */
void thrum_tet_traction(thrum_tet *tet, const double gradient[3], double traction[3]);

/* stress = lambda tr(strain) 1 + 2 mu strain; or C strain, where `stiffness` is not NULL. */
void thrum_stress_of(const double *stiffness, double lambda, double mu, double strain[3][3],
                     double stress[3][3]);
void thrum_stress(double lambda, double mu, double strain[3][3], double stress[3][3]);

/* result = matrix vector */
void thrum_product_vector(double matrix[3][3], const double vector[3], double result[3]);

#endif
