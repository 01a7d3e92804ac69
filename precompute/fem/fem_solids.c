/* What solid elements do in a body, see fem_solids.h. With edges y, products s and rows R of an
 * element, V = 1/2 |R s|^2, its force on edge a is sum_b S_ab y_b, S = R^T R s, and its tangent
 * (R ds/dy)^T (R ds/dy) + S. Cost: O(rows products) an element.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/fem_solids.h"

#include <string.h>

#define EDGE_COMPONENTS (3 * THRUM_SOLID_EDGES_MAX)

void thrum_fem_solid_at(const thrum_fem *fem, int64_t s, int p, const double *u, thrum_tet *tet) {
  const thrum_solid_elements *e = &fem->solids;
  const int32_t *nodes = thrum_solid_nodes(e, s);
  tet->weight = e->weight[e->point_begin[s] + p];
  tet->lambda = fem->lambda[e->region[s]];
  tet->mu = fem->mu[e->region[s]];
  tet->stiffness = thrum_solid_stiffness(e, e->region[s]);
  tet->law = THRUM_LAW_STVK;
  thrum_solid_gradients(e, s, p, tet->gradient);
  thrum_tet_displace(nodes, thrum_solid_node_count(e, s), u, tet);
  if (fem->about) {
    thrum_tet state = *tet;
    thrum_tet_displace(nodes, thrum_solid_node_count(e, s), fem->about, &state);
    for (int c = 0; c < 9; c++) {
      tet->displacement[c / 3][c % 3] += state.displacement[c / 3][c % 3];
      tet->deformation[c / 3][c % 3] += state.displacement[c / 3][c % 3];
    }
  }
  thrum_tet_respond(tet);
}

void thrum_fem_solid_edges(const thrum_fem *fem, int64_t s, const double *u, double *edges) {
  const int32_t *nodes = thrum_solid_nodes(&fem->solids, s);
  const int count = thrum_solid_node_count(&fem->solids, s);
  double state[EDGE_COMPONENTS];
  memset(edges, 0, 3 * (size_t)(count - 1) * sizeof *edges);
  if (u)
    thrum_solid_edges(nodes, count, u, edges);
  if (fem->about)
    thrum_solid_edges(nodes, count, fem->about, state);
  for (int c = 0; c < 3 * (count - 1) && fem->about; c++)
    edges[c] += state[c];
}

void thrum_fem_solid_rest(const thrum_fem *fem, int64_t s, double *edges) {
  const int32_t *nodes = thrum_solid_nodes(&fem->solids, s);
  const int count = thrum_solid_node_count(&fem->solids, s);
  double state[EDGE_COMPONENTS];
  thrum_solid_edges(nodes, count, fem->vertices, edges);
  if (fem->about)
    thrum_solid_edges(nodes, count, fem->about, state);
  for (int c = 0; c < 3 * (count - 1) && fem->about; c++)
    edges[c] += state[c];
}

void thrum_fem_solid_add(const thrum_fem *fem, int64_t s, const double *edge_force, double scale,
                         double *force) {
  const int32_t *nodes = thrum_solid_nodes(&fem->solids, s);
  for (int a = 1; a < thrum_solid_node_count(&fem->solids, s); a++)
    for (int c = 0; c < 3; c++) {
      const double f = scale * edge_force[3 * (a - 1) + c];
      force[3 * (int64_t)nodes[a] + c] += f;
      force[3 * (int64_t)nodes[0] + c] -= f;
    }
}

/* The edges and the products of an element with rows at u. */
static void take_products(const thrum_fem *fem, int64_t s, const double *u, double *edges,
                          double *products) {
  const int nodes = thrum_solid_node_count(&fem->solids, s);
  double v[EDGE_COMPONENTS], half[EDGE_COMPONENTS];
  thrum_solid_edges(thrum_solid_nodes(&fem->solids, s), nodes, fem->vertices, edges);
  thrum_fem_solid_edges(fem, s, u, v);

  // s = Y v + 1/2 v v = (Y + v/2) v
  for (int c = 0; c < 3 * (nodes - 1); c++) {
    half[c] = edges[c] + v[c] / 2;
    edges[c] += v[c];
  }
  thrum_solid_multiply(nodes, half, v, products);
}

void thrum_fem_solid_products(const thrum_fem *fem, int64_t s, const double *u, double *products) {
  double edges[EDGE_COMPONENTS];
  take_products(fem, s, u, edges, products);
}

/* S = R^T R s */
static void take_stress(const thrum_fem *fem, int64_t s, const double *products, double *stress) {
  const thrum_solid_elements *e = &fem->solids;
  thrum_solid_stress(thrum_solid_row_count(e, s),
                     thrum_solid_products(thrum_solid_node_count(e, s)), e->rows + e->row_begin[s],
                     products, stress);
}

static double row_energy(const thrum_fem *fem, int64_t s, const double *u, double *force) {
  const int nodes = thrum_solid_node_count(&fem->solids, s);
  double edges[EDGE_COMPONENTS], products[THRUM_SOLID_PRODUCTS_MAX];
  double stress[THRUM_SOLID_PRODUCTS_MAX], pull[EDGE_COMPONENTS] = {0}, energy = 0;
  take_products(fem, s, u, edges, products);
  take_stress(fem, s, products, stress);
  for (int k = 0; k < thrum_solid_products(nodes); k++)
    energy += stress[k] * products[k] / 2;
  if (!force)
    return energy;
  thrum_solid_pull(nodes, stress, edges, 1, pull);
  thrum_fem_solid_add(fem, s, pull, 1, force);
  return energy;
}

/* Adds the forces of a point: w F S g_a. */
static void add_point_force(const thrum_fem *fem, int64_t s, thrum_tet *tet, double *force) {
  const int32_t *nodes = thrum_solid_nodes(&fem->solids, s);
  for (int a = 0; a < thrum_solid_node_count(&fem->solids, s); a++) {
    double traction[3];
    thrum_tet_traction(tet, tet->gradient[a], traction);
    for (int c = 0; c < 3; c++)
      force[3 * (int64_t)nodes[a] + c] += tet->weight * traction[c];
  }
}

static int point_count(const thrum_fem *fem, int64_t s) {
  return fem->solids.tables[fem->solids.form[s]].points;
}

double thrum_fem_solids_energy(const thrum_fem *fem, const double *u, double *force) {
  double energy = 0;
  for (int64_t s = 0; s < fem->solids.count; s++) {
    if (thrum_solid_has_rows(&fem->solids, s)) {
      energy += row_energy(fem, s, u, force);
      continue;
    }
    for (int p = 0; p < point_count(fem, s); p++) {
      thrum_tet tet;
      thrum_fem_solid_at(fem, s, p, u, &tet);
      energy += tet.energy;
      if (force)
        add_point_force(fem, s, &tet, force);
    }
  }
  return energy;
}

/* S of the mean of both products on the mean of both edges: as s(to) - s(from) is the product of
 * the mean edges and their difference, the work is the change of energy. */
static void row_mean_force(const thrum_fem *fem, int64_t s, const double *from, const double *to,
                           double *force) {
  const int nodes = thrum_solid_node_count(&fem->solids, s);
  double edges[2][EDGE_COMPONENTS], products[2][THRUM_SOLID_PRODUCTS_MAX];
  double stress[THRUM_SOLID_PRODUCTS_MAX], pull[EDGE_COMPONENTS] = {0};
  take_products(fem, s, from, edges[0], products[0]);
  take_products(fem, s, to, edges[1], products[1]);
  for (int c = 0; c < 3 * (nodes - 1); c++)
    edges[0][c] = (edges[0][c] + edges[1][c]) / 2;
  for (int k = 0; k < thrum_solid_products(nodes); k++)
    products[0][k] = (products[0][k] + products[1][k]) / 2;
  take_stress(fem, s, products[0], stress);
  thrum_solid_pull(nodes, stress, edges[0], 1, pull);
  thrum_fem_solid_add(fem, s, pull, 1, force);
}

void thrum_fem_solids_mean_force(const thrum_fem *fem, const double *from, const double *to,
                                 double *force) {
  for (int64_t s = 0; s < fem->solids.count; s++) {
    if (thrum_solid_has_rows(&fem->solids, s)) {
      row_mean_force(fem, s, from, to, force);
      continue;
    }
    for (int p = 0; p < point_count(fem, s); p++) {
      thrum_tet begin, end;
      thrum_fem_solid_at(fem, s, p, from, &begin);
      thrum_fem_solid_at(fem, s, p, to, &end);
      for (int c = 0; c < 9; c++) {
        end.stress[c / 3][c % 3] = (end.stress[c / 3][c % 3] + begin.stress[c / 3][c % 3]) / 2;
        end.deformation[c / 3][c % 3] =
            (end.deformation[c / 3][c % 3] + begin.deformation[c / 3][c % 3]) / 2;
      }
      add_point_force(fem, s, &end, force);
    }
  }
  for (int64_t c = 0; fem->about && c < 3 * fem->vertex_count; c++)
    force[c] -= fem->about_force[c];
}

/* --- stiffness -------------------------------------------------------------------------------- */

static void row_stiffness(const thrum_fem *fem, int64_t s, const double *u, bool positive,
                          thrum_solid_blocks blocks) {
  const thrum_solid_elements *e = &fem->solids;
  const int nodes = thrum_solid_node_count(e, s), rows = thrum_solid_row_count(e, s);
  const int products = thrum_solid_products(nodes), size = 3 * (nodes - 1);
  const double *matrix = e->rows + e->row_begin[s];
  double edges[EDGE_COMPONENTS], s_of_u[THRUM_SOLID_PRODUCTS_MAX];
  double stress[THRUM_SOLID_PRODUCTS_MAX] = {0};
  double k[EDGE_COMPONENTS][EDGE_COMPONENTS];
  memset(k, 0, sizeof k);
  const bool strained = u || fem->about;
  if (strained)
    take_products(fem, s, u, edges, s_of_u);
  else
    thrum_fem_solid_rest(fem, s, edges);
  if (strained && !positive)
    take_stress(fem, s, s_of_u, stress);

  // the slope of each row, and its square
  for (int r = 0; r < rows; r++) {
    double slope[EDGE_COMPONENTS] = {0};
    thrum_solid_pull(nodes, matrix + (size_t)r * (size_t)products, edges, 1, slope);
    for (int i = 0; i < size; i++)
      for (int j = 0; j < size; j++)
        k[i][j] += slope[i] * slope[j];
  }
  for (int b = 0, at = 0; b < nodes - 1; b++)
    for (int a = 0; a <= b; a++, at++)
      for (int c = 0; c < 3; c++) {
        k[3 * a + c][3 * b + c] += stress[at];
        k[3 * b + c][3 * a + c] += stress[at];
      }

  // an edge is a node less node 0
  memset(blocks, 0, sizeof blocks[0] * (size_t)nodes);
  for (int i = 0; i < size; i++)
    for (int j = 0; j < size; j++) {
      const int a = i / 3 + 1, b = j / 3 + 1, c = i % 3, d = j % 3;
      blocks[a][b][c][d] += k[i][j];
      blocks[0][b][c][d] -= k[i][j];
      blocks[a][0][c][d] -= k[i][j];
      blocks[0][0][c][d] += k[i][j];
    }
}

static double dot(const double *a, const double *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The material part of another C, B_a^T C B_b: by node a the strain is B_a u_a = sym(F^T u_a g_a).
 */
static void add_stiffness(int nodes, const thrum_tet *tet, thrum_solid_blocks blocks) {
  double b[THRUM_SOLID_NODES_MAX][THRUM_STRAINS][3], cb[THRUM_STRAINS][3];
  for (int a = 0; a < nodes; a++)
    for (int k = 0; k < THRUM_STRAINS; k++) {
      const int i = thrum_solid_strain_axes[k][0], j = thrum_solid_strain_axes[k][1];
      for (int c = 0; c < 3; c++)
        b[a][k][c] = i == j ? tet->deformation[c][i] * tet->gradient[a][i]
                            : tet->deformation[c][i] * tet->gradient[a][j] +
                                  tet->deformation[c][j] * tet->gradient[a][i];
    }
  for (int n = 0; n < nodes; n++) {
    memset(cb, 0, sizeof cb);
    for (int k = 0; k < THRUM_STRAINS; k++)
      for (int i = 0; i < THRUM_STRAINS; i++)
        for (int d = 0; d < 3; d++)
          cb[k][d] += tet->weight * tet->stiffness[THRUM_STRAINS * k + i] * b[n][i][d];
    for (int a = 0; a < nodes; a++)
      for (int k = 0; k < THRUM_STRAINS; k++)
        for (int c = 0; c < 3; c++)
          for (int d = 0; d < 3; d++)
            blocks[a][n][c][d] += b[a][k][c] * cb[k][d];
  }
}

/* Adds what fem_assemble.c has for tets. */
static void point_stiffness(int nodes, thrum_tet *tet, bool positive, thrum_solid_blocks blocks) {
  double fg[THRUM_SOLID_NODES_MAX][3], sg[THRUM_SOLID_NODES_MAX][3], ff[3][3];
  for (int a = 0; a < nodes; a++) {
    thrum_product_vector(tet->deformation, tet->gradient[a], fg[a]);
    thrum_product_vector(tet->stress, tet->gradient[a], sg[a]);
  }
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      ff[c][d] = dot(tet->deformation[c], tet->deformation[d]);
  for (int a = 0; a < nodes; a++)
    for (int b = 0; b < nodes; b++) {
      const double geometric = positive ? 0 : dot(tet->gradient[a], sg[b]);
      const double shear = tet->mu * dot(tet->gradient[a], tet->gradient[b]);
      for (int c = 0; c < 3 && tet->stiffness; c++)
        blocks[a][b][c][c] += tet->weight * geometric;
      if (tet->stiffness)
        continue;
      for (int c = 0; c < 3; c++)
        for (int d = 0; d < 3; d++)
          blocks[a][b][c][d] +=
              tet->weight * ((c == d ? geometric : 0) + tet->lambda * fg[a][c] * fg[b][d] +
                             tet->mu * fg[b][c] * fg[a][d] + shear * ff[c][d]);
    }
  if (tet->stiffness)
    add_stiffness(nodes, tet, blocks);
}

void thrum_fem_solid_stiffness(const thrum_fem *fem, int64_t s, const double *u, bool positive,
                               thrum_solid_blocks blocks) {
  const int nodes = thrum_solid_node_count(&fem->solids, s);
  if (thrum_solid_has_rows(&fem->solids, s)) {
    row_stiffness(fem, s, u, positive, blocks);
    return;
  }
  memset(blocks, 0, sizeof blocks[0] * (size_t)nodes);
  for (int p = 0; p < point_count(fem, s); p++) {
    thrum_tet tet;
    thrum_fem_solid_at(fem, s, p, u, &tet);
    point_stiffness(nodes, &tet, positive, blocks);
  }
}

void thrum_fem_solid_mass(const thrum_fem *fem, thrum_mass kind, int64_t s, int a,
                          double masses[THRUM_SOLID_NODES_MAX]) {
  const thrum_solid_elements *e = &fem->solids;
  const thrum_solid_table *table = &e->tables[e->form[s]];
  const double density = fem->density[e->region[s]];
  double diagonal = 0;
  memset(masses, 0, THRUM_SOLID_NODES_MAX * sizeof *masses);
  for (int p = 0; p < table->points; p++) {
    const double *shape = table->shape[p];
    const double weight = density * e->weight[e->point_begin[s] + p];
    for (int b = 0; b < table->nodes; b++) {
      masses[b] += weight * (shape[a] * shape[b]);
      diagonal += weight * (shape[b] * shape[b]);
    }
  }

  // lumped: the diagonal, scaled so that the masses of all nodes add up to that of the element
  for (int b = 0; b < table->nodes && kind == THRUM_MASS_LUMPED; b++)
    masses[b] = b == a ? masses[b] * (density * e->volume[s] / diagonal) : 0;
}
