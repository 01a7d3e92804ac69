/* Saint Venant-Kirchhoff material, design 1, at a point that has neighbours of another law: with
 * Green's strain E = sym G + G^T G / 2 and S = lambda tr(E) 1 + 2 mu E,
 *   density = 1/2 E:S,  P = F S,  dP = dF S + F (lambda tr(dE) 1 + 2 mu dE),  dE = sym(F^T dF).
 * Where all points have this law core/polynomial and precompute/fem evaluate it in their own
 * ways, which are shorter.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/material/material_law_private.h"

/* Makes F, and S; returns the energy density. */
static double second_stress(double lambda, double mu, double g[3][3], double f[3][3],
                            double s[3][3]) {
  // Green's strain from G, in which nothing cancels
  double strain[3][3], twice = 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      f[i][j] = g[i][j] + (i == j ? 1 : 0);
      strain[i][j] = 0.5 * (g[i][j] + g[j][i]) +
                     0.5 * (g[0][i] * g[0][j] + g[1][i] * g[1][j] + g[2][i] * g[2][j]);
    }

  // twice the energy is the stress times the strain
  const double pressure = lambda * (strain[0][0] + strain[1][1] + strain[2][2]);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      s[i][j] = 2 * mu * strain[i][j] + (i == j ? pressure : 0);
      twice += s[i][j] * strain[i][j];
    }
  return 0.5 * twice;
}

double material_law_stvk_stress(double lambda, double mu, double gradient[3][3],
                                double stress[3][3]) {
  double f[3][3], s[3][3];
  const double energy = second_stress(lambda, mu, gradient, f, s);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      stress[i][j] = f[i][0] * s[0][j] + f[i][1] * s[1][j] + f[i][2] * s[2][j];
  return energy;
}

void material_law_stvk_tangent(double lambda, double mu, double gradient[3][3],
                               double tangent[9][9]) {
  double f[3][3], s[3][3], square[3][3];
  second_stress(lambda, mu, gradient, f, s);
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++)
      square[i][k] = f[i][0] * f[k][0] + f[i][1] * f[k][1] + f[i][2] * f[k][2];

  // dP_ij / dF_kl = 1_ik S_jl + lambda F_ij F_kl + mu (F_il F_kj + (F F^T)_ik 1_jl)
  for (int row = 0; row < 9; row++)
    for (int column = 0; column < 9; column++) {
      const int i = row / 3, j = row % 3, k = column / 3, l = column % 3;
      tangent[row][column] = (i == k ? s[j][l] : 0) + lambda * f[i][j] * f[k][l] +
                             mu * (f[i][l] * f[k][j] + (j == l ? square[i][k] : 0));
    }
}
