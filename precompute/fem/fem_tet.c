/* One point of a deformed tetrahedron, design 1. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/fem_tet.h"

#include <string.h>

#include "core/base/vec3.h"

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

void thrum_stress_of(const double *stiffness, double lambda, double mu, double strain[3][3],
                     double stress[3][3]) {
  if (!stiffness) {
    thrum_stress(lambda, mu, strain, stress);
    return;
  }
  for (int k = 0; k < THRUM_STRAINS; k++) {
    const int *to = thrum_solid_strain_axes[k];
    double sum = 0;
    for (int i = 0; i < THRUM_STRAINS; i++) {
      const int *from = thrum_solid_strain_axes[i];
      sum += stiffness[THRUM_STRAINS * k + i] * (i < 3 ? 1 : 2) * strain[from[0]][from[1]];
    }
    stress[to[0]][to[1]] = stress[to[1]][to[0]] = sum;
  }
}

void thrum_tet_traction(thrum_tet *tet, const double gradient[3], double traction[3]) {
  if (tet->law != THRUM_LAW_STVK) {
    thrum_product_vector(tet->stress, gradient, traction);
    return;
  }
  double second[3];
  thrum_product_vector(tet->stress, gradient, second);
  thrum_product_vector(tet->deformation, second, traction);
}

/* g = F_p^-T g, of F_p^-1 - 1 */
static void add_plastic(const double *plastic, double g[3]) {
  double more[3];
  thrum_apply3_transposed(plastic, g, more);
  for (int d = 0; d < 3; d++)
    g[d] += more[d];
}

void thrum_tet_displace(const int32_t *node, int nodes, const double *u, thrum_tet *tet) {
  // G from edge displacements: a translation gives exact zeros
  double(*g)[3] = tet->displacement;
  memset(tet->displacement, 0, sizeof tet->displacement);
  for (int a = 1; u && a < nodes; a++)
    for (int c = 0; c < 3; c++) {
      const double edge = u[3 * (int64_t)node[a] + c] - u[3 * (int64_t)node[0] + c];
      for (int d = 0; d < 3; d++)
        g[c][d] += edge * tet->gradient[a][d];
    }
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      tet->deformation[c][d] = g[c][d] + (c == d ? 1 : 0);
}

void thrum_fem_tet_at(const thrum_fem *fem, int64_t t, int p, const double *u, thrum_tet *tet) {
  const int nodes = fem->node_count;
  const int32_t *node = fem->nodes + nodes * t;
  const int32_t region = fem->tet_region[t];
  tet->weight = fem->weight[t * fem->point_count + p];
  tet->lambda = fem->lambda[region];
  tet->mu = fem->mu[region];
  tet->stiffness = NULL;
  tet->law = u ? thrum_fem_law(fem, region) : THRUM_LAW_STVK;
  thrum_fem_shape_gradients(fem, t, p, tet->gradient);

  // with F_p in place of the shape at rest: F_e = sum of x_a (F_p^-T g_a)^T
  const int64_t point = t * fem->point_count + p;
  const double *plastic = u && fem->plastic ? fem->plastic + 9 * point : NULL;
  for (int a = 0; plastic && a < nodes; a++)
    add_plastic(plastic, tet->gradient[a]);

  thrum_tet_displace(node, nodes, u, tet);
  for (int c = 0; plastic && c < 9; c++) {
    tet->displacement[c / 3][c % 3] += plastic[c];
    tet->deformation[c / 3][c % 3] = tet->displacement[c / 3][c % 3] + (c / 3 == c % 3 ? 1 : 0);
  }
}

void thrum_tet_deform(const thrum_fem *fem, int64_t t, int p, const double *u, thrum_tet *tet) {
  double(*g)[3] = tet->displacement;
  thrum_fem_tet_at(fem, t, p, u, tet);

  // other laws answer for the first stress
  if (tet->law != THRUM_LAW_STVK) {
    tet->energy = tet->weight * thrum_law_stress(tet->law, tet->lambda, tet->mu, g, tet->stress);
    return;
  }

  thrum_tet_respond(tet);
}

void thrum_tet_respond(thrum_tet *tet) {
  double(*g)[3] = tet->displacement;

  // Green's strain has no terms that cancel
  double strain[3][3];
  double trace = 0, square = 0;
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      strain[c][d] =
          (g[c][d] + g[d][c]) / 2 + (g[0][c] * g[0][d] + g[1][c] * g[1][d] + g[2][c] * g[2][d]) / 2;
      square += strain[c][d] * strain[c][d];
    }
  trace = strain[0][0] + strain[1][1] + strain[2][2];
  thrum_stress_of(tet->stiffness, tet->lambda, tet->mu, strain, tet->stress);
  tet->energy = tet->weight * (tet->lambda / 2 * trace * trace + tet->mu * square);
  if (!tet->stiffness)
    return;
  tet->energy = 0;
  for (int c = 0; c < 9; c++)
    tet->energy += tet->weight * strain[c / 3][c % 3] * tet->stress[c / 3][c % 3] / 2;
}
