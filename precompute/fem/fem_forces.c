/* Internal forces of several displacements at once, see fem_forces.h. A tetrahedron's nodes, shape
 * functions and material are looked up once for all of them, and the compiler makes vectors of the
 * loops over displacements; but other laws than Saint Venant-Kirchhoff's are evaluated one by one.
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/fem_forces.h"

#include <string.h>

#define LANES THRUM_FEM_LANES

/* A 3 x 3 matrix for each displacement. */
typedef struct matrices {
  double at[9][LANES];
} matrices;

/* The displacement gradient, from edges, so that a translation gives exact zeros. */
static void take_gradients(const thrum_fem *fem, const int32_t *node, const double *u,
                           double (*shape)[3], matrices *g) {
  memset(g, 0, sizeof *g);
  for (int a = 1; a < fem->node_count; a++)
    for (int c = 0; c < 3; c++) {
      const double *to = u + LANES * (3 * (int64_t)node[a] + c);
      const double *from = u + LANES * (3 * (int64_t)node[0] + c);
      for (int d = 0; d < 3; d++)
        for (int k = 0; k < LANES; k++)
          g->at[3 * c + d][k] += (to[k] - from[k]) * shape[a][d];
    }
}

/* The first Piola-Kirchhoff stress (1 + G) S of Saint Venant-Kirchhoff material. */
static void take_stresses(double lambda, double mu, const matrices *g, matrices *p) {
  for (int k = 0; k < LANES; k++) {
    double s[3][3], trace = 0;
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) {
        s[a][b] = g->at[3 * a + b][k] + g->at[3 * b + a][k];
        for (int c = 0; c < 3; c++)
          s[a][b] += g->at[3 * c + a][k] * g->at[3 * c + b][k];
        s[a][b] *= mu;
      }

    // S = 2 mu E so far, of which the trace is that of E times 2 mu
    trace = s[0][0] + s[1][1] + s[2][2];
    for (int a = 0; a < 3; a++)
      s[a][a] += lambda / (2 * mu) * trace;
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++)
        p->at[3 * a + b][k] = s[a][b] + g->at[3 * a][k] * s[0][b] + g->at[3 * a + 1][k] * s[1][b] +
                              g->at[3 * a + 2][k] * s[2][b];
  }
}

/* The same of another law. */
static void take_law_stresses(thrum_law law, double lambda, double mu, const matrices *g,
                              matrices *p) {
  for (int k = 0; k < LANES; k++) {
    double gradient[3][3], stress[3][3];
    for (int c = 0; c < 9; c++)
      gradient[c / 3][c % 3] = g->at[c][k];
    thrum_law_stress(law, lambda, mu, gradient, stress);
    for (int c = 0; c < 9; c++)
      p->at[c][k] = stress[c / 3][c % 3];
  }
}

/* force += w P g_a on each node a. */
static void add_forces(const thrum_fem *fem, const int32_t *node, double weight, double (*shape)[3],
                       const matrices *p, double *force) {
  for (int a = 0; a < fem->node_count; a++)
    for (int c = 0; c < 3; c++) {
      double *restrict to = force + LANES * (3 * (int64_t)node[a] + c);
      for (int k = 0; k < LANES; k++)
        to[k] += weight * (p->at[3 * c][k] * shape[a][0] + p->at[3 * c + 1][k] * shape[a][1] +
                           p->at[3 * c + 2][k] * shape[a][2]);
    }
}

void thrum_fem_forces(const thrum_fem *fem, const double *u, double *force) {
  memset(force, 0, sizeof *force * (size_t)(3 * LANES * fem->vertex_count));
  for (int64_t t = 0; t < fem->tet_count; t++) {
    const int32_t region = fem->tet_region[t], *node = fem->nodes + fem->node_count * t;
    const double lambda = fem->lambda[region], mu = fem->mu[region];
    const thrum_law law = thrum_fem_law(fem, region);
    for (int point = 0; point < fem->point_count; point++) {
      double shape[THRUM_FEM_NODES_MAX][3];
      matrices g, p;
      thrum_fem_shape_gradients(fem, t, point, shape);
      take_gradients(fem, node, u, shape, &g);

      // the stresses, and what they push the nodes with
      if (law == THRUM_LAW_STVK)
        take_stresses(lambda, mu, &g, &p);
      else
        take_law_stresses(law, lambda, mu, &g, &p);
      add_forces(fem, node, fem->weight[t * fem->point_count + point], shape, &p, force);
    }
  }
  thrum_fem_add_springs(fem, LANES, u, force);
}
