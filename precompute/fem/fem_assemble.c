/* Assembly of stiffness and mass of the free components, design 1: the block of nodes a and b is a
 * sum over the points of a tet, of weights w and shape functions N_a of gradients g_a,
 *   K_ab = sum w [(g_a.S g_b) 1 + lambda (F g_a)(F g_b)^T + mu (F g_b)(F g_a)^T
 *                 + mu (g_a.g_b) F F^T],
 *   with another law (K_ab)_ij = sum w (g_a)_k (dP_ik/dF_jl) (g_b)_l,
 *   M_ab = rho sum w N_a N_b 1, in a linear tet rho vol/20 (1 + [a = b]) 1,
 * or lumped rho vol/4 [a = b] 1 in a linear tet and M_aa rho vol/sum_b M_bb [a = b] 1 in one of ten
 * nodes. The pattern takes two passes over the vertices, which list the neighbours; the stiffness
 * takes one pass over the tets, which looks for the place of each block in its column.
 * Cost: O(tets points nodes^2).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/fem_actuators.h"
#include "precompute/fem/fem_solids.h"

static int ascending(const void *left, const void *right) {
  const int32_t a = *(const int32_t *)left, b = *(const int32_t *)right;
  return (a > b) - (a < b);
}

// the neighbours of v with a higher number, ascending; mark[w] == v says that w is listed
static int64_t neighbours(const thrum_fem *fem, int64_t v, int32_t *mark, int32_t *list) {
  int64_t count = 0;
  for (int64_t e = fem->incident_begin[v]; e < fem->incident_begin[v + 1]; e++) {
    int nodes;
    const int32_t *node = thrum_fem_around(fem, e, &nodes);
    for (int a = 0; a < nodes; a++)
      if (node[a] > v && mark[node[a]] != v) {
        mark[node[a]] = (int32_t)v;
        list[count++] = node[a];
      }
  }
  qsort(list, (size_t)count, sizeof *list, ascending);
  return count;
}

static int64_t free_of(const thrum_fem *fem, int64_t v) {
  return (fem->dof[3 * v] >= 0) + (fem->dof[3 * v + 1] >= 0) + (fem->dof[3 * v + 2] >= 0);
}

// one pass over the vertices: without `rows` it fills begin, with rows it fills them
static void walk_pattern(const thrum_fem *fem, int64_t *begin, int64_t *rows, int32_t *mark,
                         int32_t *list) {
  for (int64_t v = 0; v < fem->vertex_count; v++)
    mark[v] = -1;

  // how many free components the vertex and its neighbours below have
  for (int64_t v = 0; v < fem->vertex_count; v++) {
    const int64_t count = neighbours(fem, v, mark, list);
    int64_t below = free_of(fem, v);
    for (int64_t i = 0; i < count; i++)
      below += free_of(fem, list[i]);

    // each of the vertex's free components is a column
    for (int axis = 0; axis < 3; axis++) {
      const int32_t column = fem->dof[3 * v + axis];
      if (column < 0)
        continue;
      // a column holds what is left of its own vertex, then every neighbour
      begin[column + 1] = begin[column] + below--;
      int64_t next = begin[column];
      for (int d = axis; rows && d < 3; d++)
        if (fem->dof[3 * v + d] >= 0)
          rows[next++] = fem->dof[3 * v + d];
      for (int64_t i = 0; rows && i < 3 * count; i++) {
        const int32_t row = fem->dof[3 * (int64_t)list[i / 3] + i % 3];
        if (row >= 0)
          rows[next++] = row;
      }
    }
  }
}

thrum_status thrum_fem_pattern(const thrum_fem *fem, thrum_sparse *stiffness, thrum_error *error) {
  const int64_t n = fem->free_count;
  thrum_scope memory = thrum_scope_begin("the assembly", error);
  int32_t *mark = thrum_scope_allocate(&memory, fem->vertex_count, sizeof *mark);
  int32_t *list = thrum_scope_allocate(&memory, fem->vertex_count, sizeof *list);
  int64_t *begin = thrum_scope_allocate(&memory, n + 1, sizeof *begin);
  thrum_status status = memory.status;

  // the first walk counts the entries, the second one writes their rows
  if (status >= 0) {
    walk_pattern(fem, begin, NULL, mark, list);
    status = thrum_sparse_create(n, begin[n], stiffness, error);
    if (status >= 0) {
      walk_pattern(fem, stiffness->begin, stiffness->row, mark, list);
      stiffness->ranks = fem->ranks;
    }
  }

  thrum_scope_free(&memory);
  return status;
}

static double dot(const double *a, const double *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// what the blocks of a tet's nodes have in common at one of its points
typedef struct point_terms {
  double fg[THRUM_FEM_NODES_MAX][3], sg[THRUM_FEM_NODES_MAX][3]; /* F g_a, S g_a */
  double ff[3][3];                                               /* F F^T */
} point_terms;

static void take_terms(thrum_tet *tet, int nodes, point_terms *terms) {
  for (int a = 0; a < nodes; a++) {
    thrum_product_vector(tet->deformation, tet->gradient[a], terms->fg[a]);
    thrum_product_vector(tet->stress, tet->gradient[a], terms->sg[a]);
  }
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      terms->ff[c][d] = dot(tet->deformation[c], tet->deformation[d]);
}

// adds to block[c][d] of nodes a (rows) and b (columns)
static void add_block(const thrum_tet *tet, const point_terms *terms, int a, int b,
                      double block[3][3]) {
  const double *fa = terms->fg[a], *fb = terms->fg[b];
  const double geometric = dot(tet->gradient[a], terms->sg[b]);
  const double shear = tet->mu * dot(tet->gradient[a], tet->gradient[b]);
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      block[c][d] += tet->weight * ((c == d ? geometric : 0) + tet->lambda * fa[c] * fb[d] +
                                    tet->mu * fb[c] * fa[d] + shear * terms->ff[c][d]);
}

// the blocks of all pairs of nodes at a point by its law's own tangent, in the order of add_tet
static void add_law_blocks(thrum_tet *tet, bool positive, const int32_t *node, int nodes,
                           double blocks[][3][3]) {
  double tangent[9][9], beside[9][3];
  thrum_law_tangent(tet->law, tet->lambda, tet->mu, tet->displacement, tangent);
  if (positive)
    thrum_law_make_positive(tangent);

  for (int a = 0; a < nodes; a++) {
    // the tangent times the gradient of node a, from its columns
    for (int row = 0; row < 9; row++)
      for (int d = 0; d < 3; d++)
        beside[row][d] = tet->weight * dot(tangent[row] + 3 * d, tet->gradient[a]);

    // the later vertex of a pair has the rows
    for (int b = 0; b < nodes; b++) {
      if (node[b] < node[a])
        continue;
      double(*block)[3] = blocks[a > b ? a * (a + 1) / 2 + b : b * (b + 1) / 2 + a];
      const double *g = tet->gradient[b];
      for (int c = 0; c < 3; c++)
        for (int d = 0; d < 3; d++)
          block[c][d] +=
              g[0] * beside[3 * c][d] + g[1] * beside[3 * c + 1][d] + g[2] * beside[3 * c + 2][d];
    }
  }
}

// the place of a row in a column of the matrix, which holds it
static int64_t find_row(const thrum_sparse *matrix, int64_t column, int64_t row) {
  int64_t low = matrix->begin[column], high = matrix->begin[column + 1];
  while (high - low > 1) {
    const int64_t middle = low + (high - low) / 2;
    if (matrix->row[middle] > row)
      high = middle;
    else
      low = middle;
  }
  return low;
}

// adds the block of vertices w (rows) and v <= w (columns) below the diagonal
static void scatter_block(const thrum_fem *fem, int64_t w, int64_t v, double block[3][3],
                          thrum_sparse *stiffness) {
  // the rows of a vertex stand together, and later columns of v lack those above their diagonal
  int64_t place = -1;

  // only rows at or below the diagonal of the free components are stored
  for (int axis = 0, j = 0; axis < 3; axis++) {
    const int32_t column = fem->dof[3 * v + axis];
    if (column < 0)
      continue;
    for (int c = 0, next = 0; c < 3; c++) {
      const int32_t row = fem->dof[3 * w + c];
      if (row < 0)
        continue;
      if (place < 0)
        place = find_row(stiffness, column, row) - stiffness->begin[column];
      if (row >= column)
        stiffness->value[stiffness->begin[column] + place + next - j] += block[c][axis];
      next++;
    }
    j++;
  }
}

// adds one tet: the blocks of its nodes over all its points, then these to the matrix
static void add_tet(const thrum_fem *fem, int64_t t, const double *u, bool positive,
                    thrum_sparse *stiffness) {
  const int nodes = fem->node_count;
  const int32_t *node = fem->nodes + nodes * t;
  double blocks[THRUM_FEM_NODES_MAX * (THRUM_FEM_NODES_MAX + 1) / 2][3][3];
  memset(blocks, 0, sizeof blocks[0] * (size_t)(nodes * (nodes + 1) / 2));

  // the later vertex of a pair has the rows: only the lower triangle is stored
  for (int p = 0; p < fem->point_count; p++) {
    thrum_tet tet;
    point_terms terms;
    thrum_tet_deform(fem, t, p, u, &tet);
    if (tet.law != THRUM_LAW_STVK || positive) {
      add_law_blocks(&tet, positive, node, nodes, blocks);
      continue;
    }
    take_terms(&tet, nodes, &terms);
    for (int a = 0, pair = 0; a < nodes; a++)
      for (int b = 0; b <= a; b++, pair++)
        add_block(&tet, &terms, node[a] < node[b] ? b : a, node[a] < node[b] ? a : b, blocks[pair]);
  }

  for (int a = 0, pair = 0; a < nodes; a++)
    for (int b = 0; b <= a; b++, pair++) {
      const int32_t w = node[a] < node[b] ? node[b] : node[a];
      scatter_block(fem, w, node[a] < node[b] ? node[a] : node[b], blocks[pair], stiffness);
    }
}

// adds one solid
static void add_solid(const thrum_fem *fem, int64_t s, const double *u, bool positive,
                      thrum_sparse *stiffness) {
  const int32_t *node = thrum_solid_nodes(&fem->solids, s);
  thrum_solid_blocks blocks;
  thrum_fem_solid_stiffness(fem, s, u, positive, blocks);
  for (int a = 0; a < thrum_solid_node_count(&fem->solids, s); a++)
    for (int b = 0; b < thrum_solid_node_count(&fem->solids, s); b++)
      if (node[a] >= node[b])
        scatter_block(fem, node[a], node[b], blocks[a][b], stiffness);
}

static void assemble(const thrum_fem *fem, const double *u, bool positive,
                     thrum_sparse *stiffness) {
  memset(stiffness->value, 0, sizeof(double) * (size_t)stiffness->begin[stiffness->size]);
  for (int64_t t = 0; t < fem->tet_count; t++)
    add_tet(fem, t, u, positive, stiffness);
  for (int64_t s = 0; s < fem->solids.count; s++)
    add_solid(fem, s, u, positive, stiffness);

  // a column begins with its diagonal
  for (int64_t i = 0; fem->springs && i < fem->free_count; i++)
    stiffness->value[stiffness->begin[i]] += fem->springs[fem->component[i]];
  thrum_fem_acting_stiffness(fem, u, stiffness);
}

thrum_status thrum_fem_stiffness(const thrum_fem *fem, const double *u, thrum_sparse *stiffness,
                                 thrum_error *error) {
  (void)error;
  assemble(fem, u, false, stiffness);
  return THRUM_OK;
}

void thrum_fem_stiffness_positive(const thrum_fem *fem, const double *u, thrum_sparse *stiffness) {
  assemble(fem, u, true, stiffness);
}

// entries of a stiffness column that a mass matrix shares: rows of the same axis
static int64_t mass_column(const thrum_fem *fem, thrum_mass kind, const thrum_sparse *pattern,
                           int64_t column, const double *couple, thrum_sparse *mass, int64_t next) {
  const int32_t component = fem->component[column];
  for (int64_t e = pattern->begin[column]; e < pattern->begin[column + 1]; e++) {
    const int64_t row = pattern->row[e];
    const bool kept =
        kind == THRUM_MASS_LUMPED ? row == column : fem->component[row] % 3 == component % 3;
    if (!kept)
      continue;
    if (mass->row) {
      mass->row[next] = row;
      mass->value[next] = couple[fem->component[row] / 3];
    }
    next++;
  }
  return next;
}

// mass between node a and every node of ten-node tet t
static void node_masses(const thrum_fem *fem, thrum_mass kind, int64_t t, int a,
                        double masses[THRUM_QUADRATIC_NODES]) {
  const double density = fem->density[fem->tet_region[t]];
  double diagonal = 0;
  memset(masses, 0, sizeof *masses * THRUM_QUADRATIC_NODES);
  for (int p = 0; p < fem->point_count; p++) {
    double shape[THRUM_QUADRATIC_NODES];
    const double weight = density * fem->weight[t * fem->point_count + p];
    thrum_quadratic_shape(fem->rule[p].place, shape);
    for (int b = 0; b < THRUM_QUADRATIC_NODES; b++) {
      masses[b] += weight * (shape[a] * shape[b]);
      diagonal += weight * (shape[b] * shape[b]);
    }
  }

  // lumped: the diagonal, scaled so that the masses of all nodes add up to that of the tet
  for (int b = 0; b < THRUM_QUADRATIC_NODES && kind == THRUM_MASS_LUMPED; b++)
    masses[b] = b == a ? masses[b] * (density * fem->volume[t] / diagonal) : 0;
}

// the same of solids
static void couple_solids(const thrum_fem *fem, thrum_mass kind, int64_t v, double *couple) {
  for (int pass = 0; pass < 2; pass++)
    for (int64_t e = fem->incident_begin[v]; e < fem->incident_begin[v + 1]; e++) {
      int nodes, own = 0;
      const int32_t *node = thrum_fem_around(fem, e, &nodes);
      double masses[THRUM_SOLID_NODES_MAX];
      while (node[own] != v)
        own++;
      if (pass == 1)
        thrum_fem_solid_mass(fem, kind, fem->incident[e], own, masses);
      for (int a = 0; a < nodes; a++)
        couple[node[a]] = pass == 0 ? 0 : couple[node[a]] + masses[a];
    }
}

// couple[w] = mass between v and each neighbour w >= v
static void couple_vertex(const thrum_fem *fem, thrum_mass kind, int64_t v, double *couple) {
  const int nodes = fem->node_count;

  // the first pass clears what the second adds to, as neighbours come several times
  for (int pass = 0; pass < 2; pass++)
    for (int64_t e = fem->incident_begin[v]; e < fem->incident_begin[v + 1]; e++) {
      const int64_t t = fem->incident[e] / nodes;
      const double weight = fem->density[fem->tet_region[t]] * fem->volume[t];
      double masses[THRUM_QUADRATIC_NODES] = {0};
      if (fem->rule && pass == 1)
        node_masses(fem, kind, t, (int)(fem->incident[e] % nodes), masses);
      for (int a = 0; a < nodes; a++) {
        const int64_t w = fem->nodes[nodes * t + a];
        if (pass == 0)
          couple[w] = 0;
        else if (fem->rule)
          couple[w] += masses[a];
        else if (kind == THRUM_MASS_LUMPED)
          couple[w] += w == v ? weight / 4 : 0;
        else
          couple[w] += weight / (w == v ? 10 : 20);
      }
    }
}

thrum_status thrum_fem_mass(const thrum_fem *fem, thrum_mass kind, const thrum_sparse *pattern,
                            thrum_sparse *mass, thrum_error *error) {
  const int64_t n = fem->free_count;
  double *couple = NULL;
  THRUM_TRY(thrum_reserve(&couple, fem->vertex_count, sizeof *couple, "the assembly", error));

  // count first, then fill
  thrum_sparse made = {.size = n};
  int64_t entries = 0;
  for (int64_t column = 0; column < n; column++)
    entries = mass_column(fem, kind, pattern, column, couple, &made, entries);

  // columns of one vertex share its couplings to its neighbours
  thrum_status status = thrum_sparse_create(n, entries, &made, error);
  if (status >= 0) {
    made.ranks = fem->ranks;
    int64_t vertex = -1;
    for (int64_t column = 0; column < n; column++) {
      if (fem->component[column] / 3 != vertex) {
        vertex = fem->component[column] / 3;
        if (fem->solids.count > 0)
          couple_solids(fem, kind, vertex, couple);
        else
          couple_vertex(fem, kind, vertex, couple);
      }
      made.begin[column + 1] =
          mass_column(fem, kind, pattern, column, couple, &made, made.begin[column]);
    }
    *mass = made;
  }

  free(couple);
  return status;
}

// row sums of one ten-node tet
static void add_row_sums(const thrum_fem *fem, thrum_mass kind, int64_t t, double *mass) {
  const int32_t *node = fem->nodes + THRUM_QUADRATIC_NODES * t;
  const double density = fem->density[fem->tet_region[t]];
  double masses[THRUM_QUADRATIC_NODES], shape[THRUM_QUADRATIC_NODES];

  // the shape functions add up to 1, so the sum over a row is the integral of one of them
  for (int p = 0; p < fem->point_count && kind == THRUM_MASS_CONSISTENT; p++) {
    thrum_quadratic_shape(fem->rule[p].place, shape);
    for (int a = 0; a < THRUM_QUADRATIC_NODES; a++)
      mass[node[a]] += density * fem->weight[t * fem->point_count + p] * shape[a];
  }
  for (int a = 0; a < THRUM_QUADRATIC_NODES && kind == THRUM_MASS_LUMPED; a++) {
    node_masses(fem, kind, t, a, masses);
    mass[node[a]] += masses[a];
  }
}

void thrum_fem_vertex_mass(const thrum_fem *fem, thrum_mass kind, double *mass) {
  memset(mass, 0, sizeof *mass * (size_t)fem->vertex_count);
  for (int64_t t = 0; t < fem->tet_count; t++) {
    if (fem->rule)
      add_row_sums(fem, kind, t, mass);
    for (int a = 0; a < 4 && !fem->rule; a++)
      mass[fem->nodes[4 * t + a]] += fem->density[fem->tet_region[t]] * fem->volume[t] / 4;
  }
  for (int64_t s = 0; s < fem->solids.count; s++)
    for (int a = 0; a < thrum_solid_node_count(&fem->solids, s); a++) {
      double masses[THRUM_SOLID_NODES_MAX];
      thrum_fem_solid_mass(fem, kind, s, a, masses);
      for (int b = 0; b < thrum_solid_node_count(&fem->solids, s); b++)
        mass[thrum_solid_nodes(&fem->solids, s)[a]] += masses[b];
    }
}

// energy at one point, whose forces are added
static double add_point(const thrum_fem *fem, int64_t t, int p, const double *u, double *force) {
  thrum_tet tet;
  thrum_tet_deform(fem, t, p, u, &tet);

  // force on node a: w F S g_a, or w P g_a
  for (int a = 0; force && a < fem->node_count; a++) {
    double *at = force + 3 * (int64_t)fem->nodes[fem->node_count * t + a];
    double traction[3];
    thrum_tet_traction(&tet, tet.gradient[a], traction);
    for (int c = 0; c < 3; c++)
      at[c] += tet.weight * traction[c];
  }
  return tet.energy;
}

double thrum_fem_energy(const thrum_fem *fem, const double *u, double *force) {
  double energy = 0;
  if (force)
    memset(force, 0, sizeof *force * (size_t)(3 * fem->vertex_count));
  for (int64_t t = 0; t < fem->tet_count; t++)
    for (int p = 0; p < fem->point_count; p++)
      energy += add_point(fem, t, p, u, force);
  if (fem->solids.count > 0)
    energy += thrum_fem_solids_energy(fem, u, force);
  energy += thrum_fem_acting_energy(fem, u, force);

  // beyond the state about which the body is
  energy -= fem->about ? fem->about_energy : 0;
  for (int64_t c = 0; fem->about && c < 3 * fem->vertex_count; c++) {
    energy -= fem->about_force[c] * u[c];
    if (force)
      force[c] -= fem->about_force[c];
  }
  return energy + thrum_fem_add_springs(fem, 1, u, force);
}
