/* Static modal derivatives, design 2: K Phi_ij = b_ij = -d^2 R(sum p_a psi_a) / dp_i dp_j at p = 0,
 * where a point of weight w of a tet with shape gradients g_a adds to node a
 *   -w [S(sym(G_i^T G_j)) + G_i S(sym G_j) + G_j S(sym G_i)] g_a.
 * With another law than Saint Venant-Kirchhoff's its stress of second degree in the strains is
 * added (thrum_law_cubic_stress). After Barbic, James 2005, doi:10.1145/1073204.1073300. Solved in
 * blocks of right-hand sides: O(points count^2) to build them.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/modal_derivatives.h"

#include <cblas.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/fem_solids.h"

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

// what another law adds, for the gradients of two modes
static void add_law(const thrum_law_cubic *law, double i[3][3], double j[3][3],
                    double total[3][3]) {
  double strain[2][3][3];
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      strain[0][c][d] = (i[c][d] + i[d][c]) / 2;
      strain[1][c][d] = (j[c][d] + j[d][c]) / 2;
    }
  thrum_law_cubic_stress(law, strain[0], strain[1], total);
}

// F S(sym(G_i^T G_j)) + G_i S_j + G_j S_i, F = 1 but in a state of the body
static void second_stress(const double *stiffness, double lambda, double mu, const thrum_tet *state,
                          mode_in_tet *i, mode_in_tet *j, double total[3][3]) {
  double product[3][3], strain[3][3];
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      product[c][d] = i->gradient[0][c] * j->gradient[0][d] +
                      i->gradient[1][c] * j->gradient[1][d] + i->gradient[2][c] * j->gradient[2][d];
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      strain[c][d] = (product[c][d] + product[d][c]) / 2;
  thrum_stress_of(stiffness, lambda, mu, strain, total);
  for (int c = 0; c < 9 && state; c++) {
    product[c / 3][c % 3] = 0;
    for (int k = 0; k < 3; k++)
      product[c / 3][c % 3] += state->deformation[c / 3][k] * total[k][c % 3];
  }
  if (state)
    memcpy(total, product, sizeof product);
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      for (int e = 0; e < 3; e++)
        total[c][d] += i->gradient[c][e] * j->stress[e][d] + j->gradient[c][e] * i->stress[e][d];
}

// what a tet adds to its nodes, for each pair of modes of a block
typedef struct tet_forces {
  double pair[THRUM_SOLVE_BLOCK][4][3];
} tet_forces;

// adds one point of a tet to the forces of the pairs [first, first + width)
static void add_point(const thrum_fem *fem, int64_t t, int p, const int32_t *pairs, int64_t width,
                      mode_in_tet *modes, double shape[THRUM_FEM_NODES_MAX][3],
                      tet_forces *forces) {
  const int32_t region = fem->tet_region[t];
  const double weight = fem->weight[t * fem->point_count + p];
  const thrum_law name = thrum_fem_law(fem, region);
  const thrum_law_cubic law = thrum_law_cubic_of(name, fem->lambda[region], fem->mu[region]);

  // each pair's second derivative of the stress acts on the nodes through the shape gradients
  for (int64_t b = 0; b < width; b++) {
    double total[3][3];
    second_stress(NULL, fem->lambda[region], fem->mu[region], NULL, &modes[pairs[2 * b]],
                  &modes[pairs[2 * b + 1]], total);
    if (name != THRUM_LAW_STVK)
      add_law(&law, modes[pairs[2 * b]].gradient, modes[pairs[2 * b + 1]].gradient, total);
    for (int a = 0; a < fem->node_count; a++)
      for (int c = 0; c < 3; c++)
        forces->pair[b][a][c] += weight * (total[c][0] * shape[a][0] + total[c][1] * shape[a][1] +
                                           total[c][2] * shape[a][2]);
  }
}

// adds the forces of one linear tet to the right-hand sides of the pairs; local: a mode each
static void add_linear_tet(const thrum_fem *fem, int64_t t, const int32_t *pairs, int64_t width,
                           int64_t count, const double *modes, mode_in_tet *local, double *right) {
  const int32_t *node = fem->nodes + 4 * t;
  const int64_t n = fem->free_count;
  tet_forces forces;
  memset(&forces, 0, sizeof forces.pair[0] * (size_t)width);

  // the strains of the modes, then what they add to the nodes
  double shape[THRUM_FEM_NODES_MAX][3];
  thrum_fem_shape_gradients(fem, t, 0, shape);
  for (int64_t i = pairs[0]; i < count; i++)
    deform(fem, t, shape, modes + i * n, &local[i]);
  add_point(fem, t, 0, pairs, width, local, shape, &forces);

  for (int64_t b = 0; b < width; b++)
    for (int a = 0; a < 4; a++)
      for (int c = 0; c < 3; c++) {
        const int32_t dof = fem->dof[3 * (int64_t)node[a] + c];
        if (dof >= 0)
          right[b * n + dof] -= forces.pair[b][a][c];
      }
}

/* --- ten nodes ----------------------------------------------------------------------------------
 * Many points a tet: the sums over nodes and over points are matrix products for all modes or pairs
 * at once, and what stands between them runs over the points of a group, which lie side by side. */

#define GROUP 16 /* points that are treated together; those that are missing have no weight */

typedef struct group_terms {
  double shape[THRUM_QUADRATIC_NODES][3][GROUP];    /* gradients */
  double weighted[THRUM_QUADRATIC_NODES][3][GROUP]; /* times the weight */
  double total[THRUM_SOLVE_BLOCK][3][3][GROUP];     /* of each pair */
  double force[THRUM_SOLVE_BLOCK][3][THRUM_QUADRATIC_NODES];
} group_terms;

typedef struct mode_terms {
  double u[3][THRUM_QUADRATIC_NODES];
  double gradient[3][3][GROUP], stress[3][3][GROUP];
} mode_terms;

static void take_shapes(const thrum_fem *fem, int64_t t, int first, int points, group_terms *g) {
  memset(g->shape, 0, sizeof g->shape);
  memset(g->weighted, 0, sizeof g->weighted);
  for (int p = 0; p < points; p++) {
    double shape[THRUM_FEM_NODES_MAX][3];
    const double weight = fem->weight[t * fem->point_count + first + p];
    thrum_fem_shape_gradients(fem, t, first + p, shape);
    for (int a = 0; a < THRUM_QUADRATIC_NODES; a++)
      for (int d = 0; d < 3; d++) {
        g->shape[a][d][p] = shape[a][d];
        g->weighted[a][d][p] = weight * shape[a][d];
      }
  }
}

// gradient and stress of one mode at the points of a group
static void take_mode(double lambda, double mu, const group_terms *g, mode_terms *mode) {
  cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, 3, 3 * GROUP, THRUM_QUADRATIC_NODES, 1,
              mode->u[0], THRUM_QUADRATIC_NODES, g->shape[0][0], 3 * GROUP, 0, mode->gradient[0][0],
              3 * GROUP);
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      for (int p = 0; p < GROUP; p++) {
        const double trace =
            mode->gradient[0][0][p] + mode->gradient[1][1][p] + mode->gradient[2][2][p];
        mode->stress[c][d][p] = mu * (mode->gradient[c][d][p] + mode->gradient[d][c][p]) +
                                (c == d ? lambda * trace : 0);
      }
}

// S(sym(G_i^T G_j)) + G_i S_j + G_j S_i at the points of a group
static void pair_stress(double lambda, double mu, const mode_terms *i, const mode_terms *j,
                        double total[3][3][GROUP]) {
  double product[3][3][GROUP], pressure[GROUP];
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      for (int p = 0; p < GROUP; p++)
        product[c][d][p] = i->gradient[0][c][p] * j->gradient[0][d][p] +
                           i->gradient[1][c][p] * j->gradient[1][d][p] +
                           i->gradient[2][c][p] * j->gradient[2][d][p];
  for (int p = 0; p < GROUP; p++)
    pressure[p] = lambda * (product[0][0][p] + product[1][1][p] + product[2][2][p]);

  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      for (int p = 0; p < GROUP; p++) {
        double sum = mu * (product[c][d][p] + product[d][c][p]) + (c == d ? pressure[p] : 0);
        for (int e = 0; e < 3; e++)
          sum +=
              i->gradient[c][e][p] * j->stress[e][d][p] + j->gradient[c][e][p] * i->stress[e][d][p];
        total[c][d][p] = sum;
      }
}

// what another law adds at the points of a group
static void add_law_group(const thrum_law_cubic *law, const mode_terms *i, const mode_terms *j,
                          double total[3][3][GROUP]) {
  for (int p = 0; p < GROUP; p++) {
    double g[2][3][3], sum[3][3] = {{0}};
    for (int c = 0; c < 9; c++) {
      g[0][c / 3][c % 3] = i->gradient[c / 3][c % 3][p];
      g[1][c / 3][c % 3] = j->gradient[c / 3][c % 3][p];
    }
    add_law(law, g[0], g[1], sum);
    for (int c = 0; c < 9; c++)
      total[c / 3][c % 3][p] += sum[c / 3][c % 3];
  }
}

// adds the forces of one ten-node tet
static void add_quadratic_tet(const thrum_fem *fem, int64_t t, const int32_t *pairs, int64_t width,
                              int64_t count, const double *modes, mode_terms *local, group_terms *g,
                              double *right) {
  const int32_t *node = fem->nodes + THRUM_QUADRATIC_NODES * t;
  const int64_t n = fem->free_count;
  const double lambda = fem->lambda[fem->tet_region[t]], mu = fem->mu[fem->tet_region[t]];
  const thrum_law name = thrum_fem_law(fem, fem->tet_region[t]);
  const thrum_law_cubic law = thrum_law_cubic_of(name, lambda, mu);

  // the displacements of the modes at the nodes
  for (int64_t i = pairs[0]; i < count; i++)
    for (int c = 0; c < 3; c++)
      for (int a = 0; a < THRUM_QUADRATIC_NODES; a++) {
        const int32_t dof = fem->dof[3 * (int64_t)node[a] + c];
        local[i].u[c][a] = dof < 0 ? 0 : modes[i * n + dof];
      }

  // what the points of each group add to the nodes
  for (int first = 0; first < fem->point_count; first += GROUP) {
    const int left = fem->point_count - first;
    take_shapes(fem, t, first, left < GROUP ? left : GROUP, g);
    for (int64_t i = pairs[0]; i < count; i++)
      take_mode(lambda, mu, g, &local[i]);
    for (int64_t b = 0; b < width; b++)
      pair_stress(lambda, mu, &local[pairs[2 * b]], &local[pairs[2 * b + 1]], g->total[b]);
    for (int64_t b = 0; b < width && name != THRUM_LAW_STVK; b++)
      add_law_group(&law, &local[pairs[2 * b]], &local[pairs[2 * b + 1]], g->total[b]);
    cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasTrans, 3 * (int)width, THRUM_QUADRATIC_NODES,
                3 * GROUP, 1, g->total[0][0][0], 3 * GROUP, g->weighted[0][0], 3 * GROUP, first > 0,
                g->force[0][0], THRUM_QUADRATIC_NODES);
  }

  for (int64_t b = 0; b < width; b++)
    for (int c = 0; c < 3; c++)
      for (int a = 0; a < THRUM_QUADRATIC_NODES; a++) {
        const int32_t dof = fem->dof[3 * (int64_t)node[a] + c];
        if (dof >= 0)
          right[b * n + dof] -= g->force[b][c][a];
      }
}

/* --- solids -------------------------------------------------------------------------------------
 * Of an element with rows, edges Y and products s, two modes v_i and v_j add
 *   S(v_i v_j) Y + S(Y v_i) v_j + S(Y v_j) v_i,  S(s) = R^T R s,
 * to its edges (solid_elements.h). */

// one mode of an element with rows: its edges, and the stress of its linear strain
typedef struct mode_in_solid {
  double edges[3 * THRUM_SOLID_EDGES_MAX], stress[THRUM_SOLID_PRODUCTS_MAX];
} mode_in_solid;

// subtracts the force on component c of a node from a right-hand side
static void take_off(const thrum_fem *fem, int32_t node, int c, double force, double *right) {
  const int32_t dof = fem->dof[3 * (int64_t)node + c];
  if (dof >= 0)
    right[dof] -= force;
}

static double mode_at(const thrum_fem *fem, int32_t node, int c, const double *mode) {
  const int32_t dof = fem->dof[3 * (int64_t)node + c];
  return dof < 0 ? 0 : mode[dof];
}

static void add_rows(const thrum_fem *fem, int64_t s, const int32_t *pairs, int64_t width,
                     int64_t count, const double *modes, mode_in_solid *local, double *right) {
  const thrum_solid_elements *e = &fem->solids;
  const int32_t *node = thrum_solid_nodes(e, s);
  const int nodes = thrum_solid_node_count(e, s), rows = thrum_solid_row_count(e, s);
  const int products = thrum_solid_products(nodes);
  const double *matrix = e->rows + e->row_begin[s];
  double rest[3 * THRUM_SOLID_EDGES_MAX], both[THRUM_SOLID_PRODUCTS_MAX];
  double stress[THRUM_SOLID_PRODUCTS_MAX];
  thrum_fem_solid_rest(fem, s, rest);

  // the linear strains of the modes
  for (int64_t i = pairs[0]; i < count; i++) {
    for (int a = 1; a < nodes; a++)
      for (int c = 0; c < 3; c++)
        local[i].edges[3 * (a - 1) + c] = mode_at(fem, node[a], c, modes + i * fem->free_count) -
                                          mode_at(fem, node[0], c, modes + i * fem->free_count);
    thrum_solid_multiply(nodes, rest, local[i].edges, both);
    thrum_solid_stress(rows, products, matrix, both, local[i].stress);
  }

  // what each pair adds to the edges, and these to their ends
  for (int64_t b = 0; b < width; b++) {
    const mode_in_solid *i = &local[pairs[2 * b]], *j = &local[pairs[2 * b + 1]];
    double force[3 * THRUM_SOLID_EDGES_MAX] = {0};
    thrum_solid_multiply(nodes, i->edges, j->edges, both);
    thrum_solid_stress(rows, products, matrix, both, stress);
    thrum_solid_pull(nodes, stress, rest, 1, force);
    thrum_solid_pull(nodes, i->stress, j->edges, 1, force);
    thrum_solid_pull(nodes, j->stress, i->edges, 1, force);
    for (int k = 0; k < 3 * (nodes - 1); k++) {
      take_off(fem, node[k / 3 + 1], k % 3, force[k], right + b * fem->free_count);
      take_off(fem, node[0], k % 3, -force[k], right + b * fem->free_count);
    }
  }
}

// sym(F^T G) in a state of the body
static double strain_of(const thrum_tet *state, double g[3][3], int c, int d) {
  double sum = 0;
  for (int k = 0; k < 3; k++)
    sum += state->deformation[k][c] * g[k][d] + state->deformation[k][d] * g[k][c];
  return sum / 2;
}

// the same of an element with points
static void add_points(const thrum_fem *fem, int64_t s, const int32_t *pairs, int64_t width,
                       int64_t count, const double *modes, mode_in_tet *local, double *right) {
  const thrum_solid_elements *e = &fem->solids;
  const int32_t *node = thrum_solid_nodes(e, s), region = e->region[s];
  const int nodes = thrum_solid_node_count(e, s);
  const double lambda = fem->lambda[region], mu = fem->mu[region];
  const double *stiffness = thrum_solid_stiffness(e, region);
  for (int64_t p = e->point_begin[s]; p < e->point_begin[s + 1]; p++) {
    double shape[THRUM_FEM_NODES_MAX][3];
    thrum_tet state;
    thrum_solid_gradients(e, s, (int)(p - e->point_begin[s]), shape);
    thrum_fem_solid_at(fem, s, (int)(p - e->point_begin[s]), NULL, &state);

    // gradients and stresses of the modes
    for (int64_t i = pairs[0]; i < count; i++) {
      double strain[3][3];
      memset(&local[i], 0, sizeof local[i]);
      for (int a = 0; a < nodes; a++)
        for (int c = 0; c < 3; c++) {
          const double u = mode_at(fem, node[a], c, modes + i * fem->free_count);
          for (int d = 0; d < 3; d++)
            local[i].gradient[c][d] += u * shape[a][d];
        }
      for (int c = 0; c < 3; c++)
        for (int d = 0; d < 3; d++)
          strain[c][d] = strain_of(&state, local[i].gradient, c, d);
      thrum_stress_of(stiffness, lambda, mu, strain, local[i].stress);
    }

    for (int64_t b = 0; b < width; b++) {
      double total[3][3];
      second_stress(stiffness, lambda, mu, fem->about ? &state : NULL, &local[pairs[2 * b]],
                    &local[pairs[2 * b + 1]], total);
      for (int a = 0; a < nodes; a++)
        for (int c = 0; c < 3; c++)
          take_off(fem, node[a], c,
                   e->weight[p] * (total[c][0] * shape[a][0] + total[c][1] * shape[a][1] +
                                   total[c][2] * shape[a][2]),
                   right + b * fem->free_count);
    }
  }
}

// room for the modes in one tet, of whichever order
typedef struct tet_work {
  mode_in_tet *linear;
  mode_terms *quadratic;
  group_terms *group;
  mode_in_solid *solid;
} tet_work;

static tet_work work_allocate(const thrum_fem *fem, int64_t count, thrum_scope *memory) {
  if (fem->solids.count > 0)
    return (tet_work){.linear = thrum_scope_allocate(memory, count, sizeof(mode_in_tet)),
                      .solid = thrum_scope_allocate(memory, count, sizeof(mode_in_solid))};
  if (!fem->rule)
    return (tet_work){.linear = thrum_scope_allocate(memory, count, sizeof(mode_in_tet))};
  return (tet_work){.quadratic = thrum_scope_allocate(memory, count, sizeof(mode_terms)),
                    .group = thrum_scope_allocate(memory, 1, sizeof(group_terms))};
}

static thrum_status solve_all(const thrum_fem *fem, thrum_factor *factor, int64_t count,
                              const double *modes, const int32_t *pairs, tet_work *work,
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
      if (fem->rule)
        add_quadratic_tet(fem, t, pairs + 2 * first, width, count, modes, work->quadratic,
                          work->group, block);
      else
        add_linear_tet(fem, t, pairs + 2 * first, width, count, modes, work->linear, block);
    for (int64_t s = 0; s < fem->solids.count; s++)
      if (thrum_solid_has_rows(&fem->solids, s))
        add_rows(fem, s, pairs + 2 * first, width, count, modes, work->solid, block);
      else
        add_points(fem, s, pairs + 2 * first, width, count, modes, work->linear, block);

    status = thrum_factor_solve(factor, block, width, block, error);
    THRUM_THEN(status, thrum_report(reporter, (double)(first + width) / (double)total, error));
  }
  return status;
}

thrum_status thrum_derivatives(const thrum_fem *fem, thrum_factor *factor, int64_t count,
                               const double *modes, double *derivatives,
                               const thrum_reporter *reporter, thrum_error *error) {
  const int64_t total = count * (count + 1) / 2;
  thrum_scope memory = thrum_scope_begin("the modal derivatives", error);
  int32_t *pairs = thrum_scope_allocate(&memory, 2 * total, sizeof *pairs);
  tet_work work = work_allocate(fem, count, &memory);
  thrum_status status = memory.status;

  // pairs i <= j, in the order of the derivatives
  if (status >= 0) {
    int64_t next = 0;
    for (int64_t i = 0; i < count; i++)
      for (int64_t j = i; j < count; j++) {
        pairs[next++] = (int32_t)i;
        pairs[next++] = (int32_t)j;
      }

    status = solve_all(fem, factor, count, modes, pairs, &work, derivatives, reporter, error);
  }

  thrum_scope_free(&memory);
  return status;
}
