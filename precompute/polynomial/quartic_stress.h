/* The stress at a point of Saint Venant-Kirchhoff material without its linear part, design 18.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_POLYNOMIAL_QUARTIC_STRESS_H
#define THRUM_PRECOMPUTE_POLYNOMIAL_QUARTIC_STRESS_H

/* p = T + G S (18.3), the derivative of psi - psi_linear by the displacement gradient g. */
void thrum_quartic_stress(double lambda, double mu, double g[3][3], double p[3][3]);

/* dp: the derivative of p along d, which is symmetric in d and what dp is contracted with. */
void thrum_quartic_tangent(double lambda, double mu, double g[3][3], double d[3][3],
                           double dp[3][3]);

#endif
