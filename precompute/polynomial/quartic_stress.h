/* The stress at a point of Saint Venant-Kirchhoff material, or of another law, without its linear
 * part, design 18.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_POLYNOMIAL_QUARTIC_STRESS_H
#define THRUM_PRECOMPUTE_POLYNOMIAL_QUARTIC_STRESS_H

#include "runtime/material/material_law.h"

/* p = T + G S (18.3), the derivative of psi - psi_linear by the displacement gradient g. */
void thrum_quartic_stress(double lambda, double mu, double g[3][3], double p[3][3]);

/* dp: the derivative of p along d, which is symmetric in d and what dp is contracted with. */
void thrum_quartic_tangent(double lambda, double mu, double g[3][3], double d[3][3],
                           double dp[3][3]);

/* The same of any law, P - C:sym g (18.5). */
void thrum_nonlinear_stress(thrum_law law, double lambda, double mu, double g[3][3],
                            double p[3][3]);
void thrum_nonlinear_tangent(thrum_law law, double lambda, double mu, double g[3][3],
                             double d[3][3], double dp[3][3]);

/* p -= C:sym g. */
void thrum_take_linear_stress_off(double lambda, double mu, double g[3][3], double p[3][3]);

#endif
