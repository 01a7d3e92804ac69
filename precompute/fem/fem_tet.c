/* One deformed tetrahedron, design 1. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/fem_tet.h"

#include <string.h>

void thrum_product_vector(double matrix[3][3], const double vector[3], double result[3]) {
  for (int c = 0; c < 3; c++)
    result[c] = matrix[c][0] * vector[0] + matrix[c][1] * vector[1] + matrix[c][2] * vector[2];
}

void thrum_stress(double lambda, double mu, double strain[3][3], double stress[3][3]) {
  const double pressure = lambda * (strain[0][0] + strain[1][1] + strain[2][2]);
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      stress[c][d] = 2 * mu * strain[c][d] + (c == d ? pressure : 0);
}

void thrum_tet_deform(const thrum_fem *fem, int64_t t, const double *u, thrum_tet *tet) {
  const int32_t *corner = fem->tets + 4 * t;
  const int32_t region = fem->tet_region[t];
  memset(tet, 0, sizeof *tet);
  tet->volume = fem->volume[t];
  tet->lambda = fem->lambda[region];
  tet->mu = fem->mu[region];
  thrum_fem_shape_gradients(fem, t, tet->gradient);

  // G from edge displacements: a translation gives exact zeros
  double g[3][3] = {{0}};
  for (int a = 1; u && a < 4; a++)
    for (int c = 0; c < 3; c++) {
      const double edge = u[3 * (int64_t)corner[a] + c] - u[3 * (int64_t)corner[0] + c];
      for (int d = 0; d < 3; d++)
        g[c][d] += edge * tet->gradient[a][d];
    }
  double strain[3][3];
  double trace = 0, square = 0;
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      strain[c][d] =
          (g[c][d] + g[d][c]) / 2 + (g[0][c] * g[0][d] + g[1][c] * g[1][d] + g[2][c] * g[2][d]) / 2;
      square += strain[c][d] * strain[c][d];
      tet->deformation[c][d] = g[c][d] + (c == d ? 1 : 0);
    }
  trace = strain[0][0] + strain[1][1] + strain[2][2];
  thrum_stress(tet->lambda, tet->mu, strain, tet->stress);
  tet->energy = tet->volume * (tet->lambda / 2 * trace * trace + tet->mu * square);
}
