/* Static modal derivatives, design 2: K Phi_ij = b_ij = -d^2 R(sum p_a psi_a) / dp_i dp_j at p = 0,
 * where a point of weight w of a tet with shape gradients g_a adds to node a
 *   -w [S(sym(G_i^T G_j)) + G_i S(sym G_j) + G_j S(sym G_i)] g_a.
 * After Barbic, James 2005, doi:10.1145/1073204.1073300. Solved in blocks of right-hand sides:
 * O(points count^2) to build them.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/modal_derivatives.h"

#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/fem_tet.h"

// what a mode does in a tet: its gradient G, and the stress S(sym G)
typedef struct mode_in_tet {
  double gradient[3][3];
  double stress[3][3];
} mode_in_tet;

static void deform(const thrum_fem *fem, int64_t t, double shape[THRUM_FEM_NODES_MAX][3],
                   const double *mode, mode_in_tet *result) {
  const int32_t *node = fem->nodes + fem->node_count * t;

  // the displacement gradient, a sum over the free nodes
  memset(result, 0, sizeof *result);
  for (int a = 0; a < fem->node_count; a++)
    for (int c = 0; c < 3; c++) {
      const int32_t dof = fem->dof[3 * (int64_t)node[a] + c];
      const double u = dof < 0 ? 0 : mode[dof];
      for (int d = 0; d < 3; d++)
        result->gradient[c][d] += u * shape[a][d];
    }

  // the linear strain and its stress
  double strain[3][3];
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      strain[c][d] = (result->gradient[c][d] + result->gradient[d][c]) / 2;
  const int32_t region = fem->tet_region[t];
  thrum_stress(fem->lambda[region], fem->mu[region], strain, result->stress);
}

// S(sym(G_i^T G_j)) + G_i S_j + G_j S_i
static void second_stress(double lambda, double mu, mode_in_tet *i, mode_in_tet *j,
                          double total[3][3]) {
  double product[3][3], strain[3][3];
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      product[c][d] = i->gradient[0][c] * j->gradient[0][d] +
                      i->gradient[1][c] * j->gradient[1][d] + i->gradient[2][c] * j->gradient[2][d];
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      strain[c][d] = (product[c][d] + product[d][c]) / 2;
  thrum_stress(lambda, mu, strain, total);
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      for (int e = 0; e < 3; e++)
        total[c][d] += i->gradient[c][e] * j->stress[e][d] + j->gradient[c][e] * i->stress[e][d];
}

// what a tet adds to its nodes, for each pair of modes of a block
typedef struct tet_forces {
  double pair[THRUM_SOLVE_BLOCK][THRUM_FEM_NODES_MAX][3];
} tet_forces;

// adds one point of a tet to the forces of the pairs [first, first + width)
static void add_point(const thrum_fem *fem, int64_t t, int p, const int32_t *pairs, int64_t width,
                      mode_in_tet *modes, double shape[THRUM_FEM_NODES_MAX][3],
                      tet_forces *forces) {
  const int32_t region = fem->tet_region[t];
  const double weight = fem->weight[t * fem->point_count + p];

  // each pair's second derivative of the stress acts on the nodes through the shape gradients
  for (int64_t b = 0; b < width; b++) {
    double total[3][3];
    second_stress(fem->lambda[region], fem->mu[region], &modes[pairs[2 * b]],
                  &modes[pairs[2 * b + 1]], total);
    for (int a = 0; a < fem->node_count; a++)
      for (int c = 0; c < 3; c++)
        forces->pair[b][a][c] += weight * (total[c][0] * shape[a][0] + total[c][1] * shape[a][1] +
                                           total[c][2] * shape[a][2]);
  }
}

// adds one tet to the right-hand sides of the pairs [first, first + width); local: a mode each
static void add_tet(const thrum_fem *fem, int64_t t, const int32_t *pairs, int64_t width,
                    int64_t count, const double *modes, mode_in_tet *local, double *right) {
  const int32_t *node = fem->nodes + fem->node_count * t;
  const int64_t n = fem->free_count;
  tet_forces forces;
  memset(&forces, 0, sizeof forces.pair[0] * (size_t)width);

  // the strains of the modes at each point, then what all points add to the nodes
  for (int p = 0; p < fem->point_count; p++) {
    double shape[THRUM_FEM_NODES_MAX][3];
    thrum_fem_shape_gradients(fem, t, p, shape);
    for (int64_t i = pairs[0]; i < count; i++)
      deform(fem, t, shape, modes + i * n, &local[i]);
    add_point(fem, t, p, pairs, width, local, shape, &forces);
  }

  for (int64_t b = 0; b < width; b++)
    for (int a = 0; a < fem->node_count; a++)
      for (int c = 0; c < 3; c++) {
        const int32_t dof = fem->dof[3 * (int64_t)node[a] + c];
        if (dof >= 0)
          right[b * n + dof] -= forces.pair[b][a][c];
      }
}

static thrum_status solve_all(const thrum_fem *fem, thrum_factor *factor, int64_t count,
                              const double *modes, const int32_t *pairs, mode_in_tet *local,
                              double *derivatives, const thrum_reporter *reporter,
                              thrum_error *error) {
  const int64_t n = fem->free_count, total = count * (count + 1) / 2;
  thrum_status status = THRUM_OK;

  // a block of right-hand sides at a time, which the factor solves together
  for (int64_t first = 0; first < total && status >= 0; first += THRUM_SOLVE_BLOCK) {
    // the right-hand sides are built where the solutions will stand
    const int64_t left = total - first, width = left < THRUM_SOLVE_BLOCK ? left : THRUM_SOLVE_BLOCK;
    double *block = derivatives + first * n;
    memset(block, 0, sizeof *block * (size_t)(n * width));

    for (int64_t t = 0; t < fem->tet_count; t++)
      add_tet(fem, t, pairs + 2 * first, width, count, modes, local, block);

    status = thrum_factor_solve(factor, block, width, block, error);
    THRUM_THEN(status, thrum_report(reporter, (double)(first + width) / (double)total, error));
  }
  return status;
}

thrum_status thrum_derivatives(const thrum_fem *fem, thrum_factor *factor, int64_t count,
                               const double *modes, double *derivatives,
                               const thrum_reporter *reporter, thrum_error *error) {
  const int64_t total = count * (count + 1) / 2;
  int32_t *pairs = thrum_allocate(2 * total, sizeof *pairs, "the modal derivatives", error);
  mode_in_tet *local = thrum_allocate(count, sizeof *local, "the modal derivatives", error);
  thrum_status status = THRUM_OUT_OF_MEMORY;

  // pairs i <= j, in the order of the derivatives
  if (pairs && local) {
    int64_t next = 0;
    for (int64_t i = 0; i < count; i++)
      for (int64_t j = i; j < count; j++) {
        pairs[next++] = (int32_t)i;
        pairs[next++] = (int32_t)j;
      }

    status = solve_all(fem, factor, count, modes, pairs, local, derivatives, reporter, error);
  }

  free(pairs);
  free(local);
  return status;
}
