/* Stress and tangent at a point without their linear parts, see quartic_stress.h.
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/polynomial/quartic_stress.h"

#include "precompute/fem/fem_tet.h"

/* C:N and C:E at the gradient g (18.2). */
static void stresses(double lambda, double mu, double g[3][3], double t[3][3], double s[3][3]) {
  double quadratic[3][3], strain[3][3];
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      quadratic[c][d] = (g[0][c] * g[0][d] + g[1][c] * g[1][d] + g[2][c] * g[2][d]) / 2;
      strain[c][d] = (g[c][d] + g[d][c]) / 2 + quadratic[c][d];
    }
  thrum_stress(lambda, mu, quadratic, t);
  thrum_stress(lambda, mu, strain, s);
}

/* Entry (c, d) of a b. */
static double product(double a[3][3], double b[3][3], int c, int d) {
  return a[c][0] * b[0][d] + a[c][1] * b[1][d] + a[c][2] * b[2][d];
}

void thrum_quartic_stress(double lambda, double mu, double g[3][3], double p[3][3]) {
  double t[3][3], s[3][3];
  stresses(lambda, mu, g, t, s);
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      p[c][d] = t[c][d] + g[c][0] * s[0][d] + g[c][1] * s[1][d] + g[c][2] * s[2][d];
}

void thrum_quartic_tangent(double lambda, double mu, double g[3][3], double d[3][3],
                           double dp[3][3]) {
  double t[3][3], s[3][3], quadratic[3][3], strain[3][3], dt[3][3], ds[3][3];
  stresses(lambda, mu, g, t, s);

  // dN and dE of (18.4)
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      quadratic[a][b] = 0;
      for (int k = 0; k < 3; k++)
        quadratic[a][b] += (g[k][a] * d[k][b] + d[k][a] * g[k][b]) / 2;
      strain[a][b] = (d[a][b] + d[b][a]) / 2 + quadratic[a][b];
    }
  thrum_stress(lambda, mu, quadratic, dt);
  thrum_stress(lambda, mu, strain, ds);

  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      dp[a][b] = dt[a][b] + product(d, s, a, b) + product(g, ds, a, b);
}

void thrum_take_linear_stress_off(double lambda, double mu, double g[3][3], double p[3][3]) {
  double strain[3][3], stress[3][3];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      strain[a][b] = (g[a][b] + g[b][a]) / 2;
  thrum_stress(lambda, mu, strain, stress);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      p[a][b] -= stress[a][b];
}

void thrum_nonlinear_stress(thrum_law law, double lambda, double mu, double g[3][3],
                            double p[3][3]) {
  if (law == THRUM_LAW_STVK) {
    thrum_quartic_stress(lambda, mu, g, p);
    return;
  }
  thrum_law_stress(law, lambda, mu, g, p);
  thrum_take_linear_stress_off(lambda, mu, g, p);
}

void thrum_nonlinear_tangent(thrum_law law, double lambda, double mu, double g[3][3],
                             double d[3][3], double dp[3][3]) {
  if (law == THRUM_LAW_STVK) {
    thrum_quartic_tangent(lambda, mu, g, d, dp);
    return;
  }

  // A:d
  double tangent[9][9];
  thrum_law_tangent(law, lambda, mu, g, tangent);
  for (int i = 0; i < 9; i++) {
    dp[i / 3][i % 3] = 0;
    for (int j = 0; j < 9; j++)
      dp[i / 3][i % 3] += tangent[i][j] * d[j / 3][j % 3];
  }
  thrum_take_linear_stress_off(lambda, mu, d, dp);
}
