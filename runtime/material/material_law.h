/* Laws of isotropic hyperelastic materials, design 19: energy density, first Piola-Kirchhoff stress
 * and its derivative at a displacement gradient G, where F = 1 + G.
 *
 * All laws take Lame's constants of small strains, so their second derivatives at rest are the
 * same: modes and frequencies do not depend on the law. Tensors are row-major, row and column as
 * those of F; the densities belong to the volume at rest. The functions are pure, for any thread.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_MATERIAL_MATERIAL_LAW_H
#define THRUM_RUNTIME_MATERIAL_MATERIAL_LAW_H

#include "core/base/model_law.h"

/* The energy density at `gradient` [J/m^3], which is zero at rest, and the first Piola-Kirchhoff
 * stress P = d density / dF there [Pa]. */
double thrum_law_stress(thrum_law law, double lambda, double mu, double gradient[3][3],
                        double stress[3][3]);

/* tangent[3 i + j][3 k + l] = dP_ij / dF_kl [Pa], symmetric. */
void thrum_law_tangent(thrum_law law, double lambda, double mu, double gradient[3][3],
                       double tangent[9][9]);

/* The tangent without its negative eigenvalues, which become zero: symmetric and positive
 * semidefinite, so that a correction made with it leads downhill (Teran, Sifakis, Irving & Fedkiw
 * 2005, doi:10.1145/1073368.1073394). */
void thrum_law_make_positive(double tangent[9][9]);

/* The part of the energy density of degree 3 in Green's strain E is
 * cube tr(E)^3 + mixed tr(E) tr(E^2) + trace tr(E^3), all in Pa: what a law's second derivatives at
 * rest have beyond those of Saint Venant-Kirchhoff material, where they are zero. */
typedef struct thrum_law_cubic {
  double cube, mixed, trace;
} thrum_law_cubic;

thrum_law_cubic thrum_law_cubic_of(thrum_law law, double lambda, double mu);

/* stress += the derivative of that part's second derivative: its second Piola-Kirchhoff stress of
 * the linear strains `e` and `f` together, which is twice that of one strain where both are it. */
void thrum_law_cubic_stress(const thrum_law_cubic *cubic, double e[3][3], double f[3][3],
                            double stress[3][3]);

#endif
