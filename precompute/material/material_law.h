/* Laws of isotropic hyperelastic materials, design 19: energy density, first Piola-Kirchhoff stress
 * and its derivative at a displacement gradient G, where F = 1 + G.
 *
 * All laws take Lame's constants of small strains, so their second derivatives at rest are the
 * same: modes and frequencies do not depend on the law. Tensors are row-major, row and column as
 * those of F; the densities belong to the volume at rest. The functions are pure, for any thread.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MATERIAL_MATERIAL_LAW_H
#define THRUM_PRECOMPUTE_MATERIAL_MATERIAL_LAW_H

/* X(name, value, text) */
#define THRUM_LAW_LIST(X)                                                                          \
  X(STVK, 0, "stvk")                 /* Saint Venant-Kirchhoff */                                  \
  X(COROTATIONAL, 1, "corotational") /* linear elasticity of F without its rotation */             \
  X(NEO_HOOKEAN, 2, "neo-hookean")   /* stable neo-Hookean: Smith, De Goes & Kim 2018 */

typedef enum thrum_law {
#define X(name, value, text) THRUM_LAW_##name = value,
  THRUM_LAW_LIST(X)
#undef X
} thrum_law;

/* The energy density at `gradient` [J/m^3], which is zero at rest, and the first Piola-Kirchhoff
 * stress P = d density / dF there [Pa]. Not of THRUM_LAW_STVK, which precompute/fem evaluates. */
double thrum_law_stress(thrum_law law, double lambda, double mu, double gradient[3][3],
                        double stress[3][3]);

/* tangent[3 i + j][3 k + l] = dP_ij / dF_kl [Pa], symmetric. Not of THRUM_LAW_STVK. */
void thrum_law_tangent(thrum_law law, double lambda, double mu, double gradient[3][3],
                       double tangent[9][9]);

/* The tangent without its negative eigenvalues, which become zero: symmetric and positive
 * semidefinite, so that a correction made with it leads downhill (Teran, Sifakis, Irving & Fedkiw
 * 2005, doi:10.1145/1073368.1073394). */
void thrum_law_make_positive(double tangent[9][9]);

/* stress = P-bar between two displacement gradients: its product with `to` - `from` is the change
 * of the energy density to rounding, and P-bar times the transposed mean of both F is symmetric.
 * Not of THRUM_LAW_STVK. */
void thrum_law_mean_stress(thrum_law law, double lambda, double mu, double from[3][3],
                           double to[3][3], double stress[3][3]);

#endif
