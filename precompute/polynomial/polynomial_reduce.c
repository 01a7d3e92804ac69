/* The exact reduced polynomial by one Gram product, design 3. The strain at a point of a tet, of
 * which a linear one has one, is
 *   eps(q) = sum_i q_i a_i + sum_{i<=j} q_i q_j b_ij,
 * a_i = sym G_i, b_ii = G_i^T G_i / 2, b_ij = sym(G_i^T G_j), so V = 1/2 z^T (A^T A) z with
 * z = (q_i, q_i q_j) and A the stack of W_e [a b], W_e^T W_e = w C, w the weight
 * of the point. Blocks of points make six rows each, component by component and point by point
 * within, and one DSYRK a block adds them up. The strain energy of a ten-node tet with straight
 * edges is of degree 4 in the place, for which its points are exact.
 * Cost: m^2 rows of BLAS-3, m = r + r (r + 1) / 2, rows = 6 points; memory: m^2 numbers and a
 * block.
 *
 * Where only the first k vectors have products, as condensing wants it, m = r + k (k + 1) / 2, and
 * the monomials of two of them and one other vector lack what the other's products with them
 * would bring, a_i . b_jh + a_j . b_ih. With S the stress of a vector times w that is
 * G_h : (G_j S_i + G_i S_j), a second Gram product, of 9 rows a point.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/polynomial/polynomial_reduce.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/fem_solids.h"
#include "thrum/model.h"
#include "thrum/polynomial.h"

// points in a block: 768 rows, deep enough for DSYRK at its best, and a panel that fits a cache
#define BLOCK 128

typedef struct panel {
  const thrum_fem *fem;
  const double *basis;
  int64_t rank, squared; /* coordinates, and how many of them have products: the first */
  int64_t columns;       /* m = rank + squared (squared + 1) / 2 */
  double *gradient;      /* rank x 9 x BLOCK */
  double *row;           /* columns x 6 BLOCK: the transposed panel */
  double *stress;        /* squared x 6 x BLOCK, or NULL where squared = rank */
  double *force;         /* squared x 9 x BLOCK, likewise: of one vector and all later ones */
  double weight[3][BLOCK];
  const double *stiffness[BLOCK]; /* C and R of points of elasticity with directions, NULL: none, */
  double root_weight[BLOCK];      /* and the root of their weight */
  bool directed;                  /* there are some in this block */
  double (*place)[9];             /* BLOCK: F of the state of the body; NULL: it is 1 */
  double *turned;                 /* 9 x BLOCK: F^T G of one vector */
  double *products;   /* columns x products of edges, of one solid with rows; NULL: there is none */
  double *edges;      /* rank x 3 edges of that */
  thrum_scope memory; /* of all arrays but the basis */
} panel;

// whether there are products of two vectors that lack those with a third
static bool has_others(const panel *p) {
  return p->squared > 0 && p->squared < p->rank;
}

static int64_t pairs_of(int64_t count) {
  return count * (count + 1) / 2;
}

static int64_t columns_of(int64_t rank, int64_t squared) {
  return rank + pairs_of(squared);
}

static thrum_status panel_create(const thrum_fem *fem, int64_t rank, const double *basis,
                                 int64_t squared, panel *p, thrum_error *error) {
  const int64_t columns = columns_of(rank, squared);
  *p = (panel){.fem = fem, .basis = basis, .rank = rank, .squared = squared, .columns = columns};
  p->memory = thrum_scope_begin("the polynomial", error);
  p->gradient = thrum_scope_allocate(&p->memory, rank * 9 * BLOCK, sizeof(double));
  p->row = thrum_scope_allocate(&p->memory, columns * 6 * BLOCK, sizeof(double));
  if (has_others(p)) {
    p->stress = thrum_scope_allocate(&p->memory, squared * 6 * BLOCK, sizeof(double));
    p->force = thrum_scope_allocate(&p->memory, squared * 9 * BLOCK, sizeof(double));
  }
  if (fem->about) {
    p->place = thrum_scope_allocate(&p->memory, BLOCK, sizeof *p->place);
    p->turned = thrum_scope_allocate(&p->memory, 9 * BLOCK, sizeof *p->turned);
  }
  if (fem->solids.count > 0) {
    p->products =
        thrum_scope_allocate(&p->memory, columns * THRUM_SOLID_PRODUCTS_MAX, sizeof(double));
    p->edges = thrum_scope_allocate(&p->memory, rank * 3 * THRUM_SOLID_EDGES_MAX, sizeof(double));
  }
  return p->memory.status;
}

// G of every basis vector at one point of a linear tet, into place s of the block
static void fill_linear_tet(panel *p, int64_t t, int64_t s) {
  const int32_t *corner = p->fem->nodes + 4 * t;
  const double *shape = p->fem->gradient + 9 * t;
  const int64_t rank = p->rank;

  // row c of G: gradients of the corners times differences to corner 0
  for (int c = 0; c < 3; c++) {
    const double *u[4];
    for (int a = 0; a < 4; a++)
      u[a] = p->basis + (3 * (int64_t)corner[a] + c) * rank;
    for (int64_t i = 0; i < rank; i++) {
      const double x = u[1][i] - u[0][i], y = u[2][i] - u[0][i], z = u[3][i] - u[0][i];
      double *out = p->gradient + (9 * i + 3 * c) * BLOCK + s;
      out[0] = x * shape[0] + y * shape[3] + z * shape[6];
      out[BLOCK] = x * shape[1] + y * shape[4] + z * shape[7];
      out[2 * BLOCK] = x * shape[2] + y * shape[5] + z * shape[8];
    }
  }
}

// the same at one point of any element, of so many nodes with these gradients
static void fill_nodes(panel *p, const int32_t *node, int nodes, double (*shape)[3], int64_t s) {
  const int64_t rank = p->rank;

  // row c of G, a sum over differences to node 0
  for (int c = 0; c < 3; c++) {
    const double *u[THRUM_FEM_NODES_MAX];
    for (int a = 0; a < nodes; a++)
      u[a] = p->basis + (3 * (int64_t)node[a] + c) * rank;
    for (int64_t i = 0; i < rank; i++) {
      double x = 0, y = 0, z = 0;
      for (int a = 1; a < nodes; a++) {
        const double difference = u[a][i] - u[0][i];
        x += difference * shape[a][0];
        y += difference * shape[a][1];
        z += difference * shape[a][2];
      }

      // components lie a block apart
      double *out = p->gradient + (9 * i + 3 * c) * BLOCK + s;
      out[0] = x;
      out[BLOCK] = y;
      out[2 * BLOCK] = z;
    }
  }
}

// W = sqrt(w) (sqrt(2 mu) 1 + trace part) on the normal strains, sqrt(4 mu) on the shears
static void weigh(panel *p, int32_t region, double weight, int64_t s) {
  const double mu = p->fem->mu[region], bulk = 3 * p->fem->lambda[region] + 2 * mu;
  p->weight[0][s] = sqrt(2 * mu * weight);
  p->weight[1][s] = (sqrt(bulk * weight) - p->weight[0][s]) / 3;
  p->weight[2][s] = sqrt(mu * weight);
}

// G of every basis vector at every point of the block; those missing from the last block stay zero
static void fill_gradients(panel *p, int64_t first, int64_t count) {
  const thrum_fem *fem = p->fem;
  if (count < BLOCK) {
    memset(p->gradient, 0, sizeof(double) * (size_t)(p->rank * 9 * BLOCK));
    memset(p->weight, 0, sizeof p->weight);
  }

  for (int64_t s = 0; s < count; s++) {
    const int64_t t = (first + s) / fem->point_count;
    if (fem->rule) {
      double shape[THRUM_FEM_NODES_MAX][3];
      thrum_fem_shape_gradients(fem, t, (int)((first + s) % fem->point_count), shape);
      fill_nodes(p, fem->nodes + THRUM_QUADRATIC_NODES * t, THRUM_QUADRATIC_NODES, shape, s);
    } else {
      fill_linear_tet(p, t, s);
    }
    weigh(p, fem->tet_region[t], fem->weight[first + s], s);
  }
}

// about a state of gradient F the strain of first degree is sym(F^T G)
static const double *turn_by_state(const panel *p, const double *g) {
  if (!p->place)
    return g;
  for (int c = 0; c < 9; c++)
    for (int s = 0; s < BLOCK; s++)
      p->turned[c * BLOCK + s] = p->place[s][c / 3] * g[c % 3 * BLOCK + s] +
                                 p->place[s][3 + c / 3] * g[(3 + c % 3) * BLOCK + s] +
                                 p->place[s][6 + c / 3] * g[(6 + c % 3) * BLOCK + s];
  return p->turned;
}

// W sym G of one basis vector
static void fill_linear(const panel *p, int64_t i, double *restrict row) {
  const double *restrict g = turn_by_state(p, p->gradient + 9 * i * BLOCK);
  const double *restrict normal = p->weight[0], *restrict trace = p->weight[1],
                         *restrict shear = p->weight[2];

  // six strain components, weighted so that their squares add up to the energy
  for (int s = 0; s < BLOCK; s++) {
    const double x = g[s], y = g[4 * BLOCK + s], z = g[8 * BLOCK + s];
    const double pressure = trace[s] * (x + y + z);

    row[s] = normal[s] * x + pressure;
    row[BLOCK + s] = normal[s] * y + pressure;
    row[2 * BLOCK + s] = normal[s] * z + pressure;

    row[3 * BLOCK + s] = shear[s] * (g[5 * BLOCK + s] + g[7 * BLOCK + s]);
    row[4 * BLOCK + s] = shear[s] * (g[2 * BLOCK + s] + g[6 * BLOCK + s]);
    row[5 * BLOCK + s] = shear[s] * (g[BLOCK + s] + g[3 * BLOCK + s]);
  }
}

// scale W sym(G_i^T G_j); scale is 1/2 when i = j, else 1
static void fill_product(const panel *p, int64_t i, int64_t j, double scale, double *restrict row) {
  const double *restrict g = p->gradient + 9 * i * BLOCK;
  const double *restrict h = p->gradient + 9 * j * BLOCK;
  const double *restrict normal = p->weight[0], *restrict trace = p->weight[1],
                         *restrict shear = p->weight[2];
  for (int s = 0; s < BLOCK; s++) {
    const double g0 = g[s], g1 = g[BLOCK + s], g2 = g[2 * BLOCK + s];
    const double g3 = g[3 * BLOCK + s], g4 = g[4 * BLOCK + s], g5 = g[5 * BLOCK + s];
    const double g6 = g[6 * BLOCK + s], g7 = g[7 * BLOCK + s], g8 = g[8 * BLOCK + s];
    const double h0 = h[s], h1 = h[BLOCK + s], h2 = h[2 * BLOCK + s];
    const double h3 = h[3 * BLOCK + s], h4 = h[4 * BLOCK + s], h5 = h[5 * BLOCK + s];
    const double h6 = h[6 * BLOCK + s], h7 = h[7 * BLOCK + s], h8 = h[8 * BLOCK + s];

    // normal parts of G_i^T G_j, then its weights
    const double x = g0 * h0 + g3 * h3 + g6 * h6, y = g1 * h1 + g4 * h4 + g7 * h7,
                 z = g2 * h2 + g5 * h5 + g8 * h8;
    const double w = scale * normal[s], v = scale * shear[s];
    const double pressure = scale * trace[s] * (x + y + z);

    row[s] = w * x + pressure;
    row[BLOCK + s] = w * y + pressure;
    row[2 * BLOCK + s] = w * z + pressure;
    row[3 * BLOCK + s] = v * (g1 * h2 + g2 * h1 + g4 * h5 + g5 * h4 + g7 * h8 + g8 * h7);
    row[4 * BLOCK + s] = v * (g0 * h2 + g2 * h0 + g3 * h5 + g5 * h3 + g6 * h8 + g8 * h6);
    row[5 * BLOCK + s] = v * (g0 * h1 + g1 * h0 + g3 * h4 + g4 * h3 + g6 * h7 + g7 * h6);
  }
}

// w C sym G of one basis vector from its row of W sym G, as components 00, 11, 22, 12, 02, 01
static void fill_stress(const panel *p, const double *restrict row, double *restrict stress) {
  const double *restrict normal = p->weight[0], *restrict trace = p->weight[1],
                         *restrict shear = p->weight[2];
  for (int s = 0; s < BLOCK; s++) {
    const double x = row[s], y = row[BLOCK + s], z = row[2 * BLOCK + s];
    const double pressure = trace[s] * (x + y + z);

    stress[s] = normal[s] * x + pressure;
    stress[BLOCK + s] = normal[s] * y + pressure;
    stress[2 * BLOCK + s] = normal[s] * z + pressure;
    for (int c = 3; c < 6; c++)
      stress[c * BLOCK + s] = shear[s] * row[c * BLOCK + s];
  }
}

// force += G_i S_j, both of one block; the caller clears it
static void add_force(const panel *p, int64_t i, int64_t j, double *restrict force) {
  const double *restrict stress = p->stress + 6 * j * BLOCK;
  for (int c = 0; c < 3; c++) {
    const double *restrict g = p->gradient + (9 * i + 3 * c) * BLOCK;
    double *restrict out = force + 3 * c * BLOCK;
    for (int s = 0; s < BLOCK; s++) {
      const double x = g[s], y = g[BLOCK + s], z = g[2 * BLOCK + s];
      const double yz = stress[3 * BLOCK + s], xz = stress[4 * BLOCK + s],
                   xy = stress[5 * BLOCK + s];
      out[s] += x * stress[s] + y * xy + z * xz;
      out[BLOCK + s] += x * xy + y * stress[BLOCK + s] + z * yz;
      out[2 * BLOCK + s] += x * xz + y * yz + z * stress[2 * BLOCK + s];
    }
  }
}

/* At points of elasticity with directions: sqrt(w) R strain, or sqrt(w) R^T of that. */
static void direct(const panel *p, bool transposed, double *row) {
  for (int s = 0; s < BLOCK && p->directed; s++) {
    double own[THRUM_STRAINS];
    if (!p->stiffness[s])
      continue;
    const double *root = p->stiffness[s] + THRUM_STRAINS * THRUM_STRAINS;
    for (int k = 0; k < THRUM_STRAINS; k++)
      own[k] = p->root_weight[s] * row[k * BLOCK + s];
    for (int k = 0; k < THRUM_STRAINS; k++) {
      row[k * BLOCK + s] = 0;
      for (int i = 0; i < THRUM_STRAINS; i++)
        row[k * BLOCK + s] +=
            own[i] * (transposed ? root[THRUM_STRAINS * i + k] : root[THRUM_STRAINS * k + i]);
    }
  }
}

// others (rank - squared x pairs i <= j, i outermost, column-major) += G_h : (G_i S_j + G_j S_i)
static void add_others(panel *p, double *others) {
  const int64_t rest = p->rank - p->squared, depth = 9 * BLOCK;
  for (int64_t i = 0; i < p->squared; i++)
    fill_stress(p, p->row + 6 * i * BLOCK, p->stress + 6 * i * BLOCK);
  for (int64_t i = 0; i < p->squared; i++)
    direct(p, true, p->stress + 6 * i * BLOCK);

  // all forces of one i in a block, for one product of matrices
  for (int64_t i = 0; i < p->squared; i++) {
    const int64_t count = p->squared - i;
    memset(p->force, 0, sizeof(double) * (size_t)(count * depth));
    for (int64_t j = i; j < p->squared; j++) {
      add_force(p, i, j, p->force + (j - i) * depth);
      if (j > i)
        add_force(p, j, i, p->force + (j - i) * depth);
    }
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, (int)rest, (int)count, (int)depth, 1,
                p->gradient + p->squared * depth, (int)depth, p->force, (int)depth, 1, others,
                (int)rest);
    others += rest * count;
  }
}

// adds the products of the columns of so many rows of A, which lie `depth` apart
static void add_product(const panel *p, int64_t rows, double *gram) {
  cblas_dsyrk(CblasColMajor, CblasUpper, CblasTrans, (int)p->columns, (int)rows, 1, p->row,
              6 * BLOCK, 1, gram, (int)p->columns);
}

// adds a block of points, whose gradients are there
static void add_block(panel *p, double *gram, double *others) {
  const int64_t depth = 6 * BLOCK;

  // the columns of A, transposed
  double *row = p->row;
  for (int64_t i = 0; i < p->rank; i++, row += depth)
    fill_linear(p, i, row);
  for (int64_t i = 0; i < p->squared; i++)
    for (int64_t j = i; j < p->squared; j++, row += depth)
      fill_product(p, i, j, i == j ? 0.5 : 1, row);
  for (int64_t c = 0; c < p->columns; c++)
    direct(p, false, p->row + c * depth);

  add_product(p, depth, gram);
  if (others != NULL)
    add_others(p, others);
}

/* --- solids -------------------------------------------------------------------------------------
 * The rows of an element are R (Y u_i), R (u_i u_j) and R (u_i u_i) / 2 (solid_elements.h). */

// edges of all basis vectors, and their products with those at rest and with each other
static void fill_products(panel *p, int64_t s) {
  const thrum_solid_elements *e = &p->fem->solids;
  const int32_t *node = thrum_solid_nodes(e, s);
  const int nodes = thrum_solid_node_count(e, s), size = 3 * (nodes - 1);
  const int count = thrum_solid_products(nodes);
  double rest[3 * THRUM_SOLID_EDGES_MAX];
  thrum_fem_solid_rest(p->fem, s, rest);
  for (int64_t i = 0; i < p->rank; i++)
    for (int k = 0; k < size; k++) {
      const int64_t to = 3 * (int64_t)node[k / 3 + 1] + k % 3, from = 3 * (int64_t)node[0] + k % 3;
      p->edges[i * size + k] = p->basis[to * p->rank + i] - p->basis[from * p->rank + i];
    }

  double *column = p->products;
  for (int64_t i = 0; i < p->rank; i++, column += count)
    thrum_solid_multiply(nodes, rest, p->edges + i * size, column);
  for (int64_t i = 0; i < p->squared; i++)
    for (int64_t j = i; j < p->squared; j++, column += count) {
      thrum_solid_multiply(nodes, p->edges + i * size, p->edges + j * size, column);
      for (int k = 0; k < count && i == j; k++)
        column[k] /= 2;
    }
}

// others += u_h . (S_i u_j + S_j u_i), S_i the stress of Y u_i, whose edges and products are there
static void add_solid_others(panel *p, int64_t s, double *others) {
  const thrum_solid_elements *e = &p->fem->solids;
  const int nodes = thrum_solid_node_count(e, s), size = 3 * (nodes - 1);
  const int count = thrum_solid_products(nodes), rows = thrum_solid_row_count(e, s);
  const int64_t rest = p->rank - p->squared;
  for (int64_t i = 0; i < p->squared; i++)
    thrum_solid_stress(rows, count, e->rows + e->row_begin[s], p->products + i * count,
                       p->stress + i * count);
  for (int64_t i = 0; i < p->squared; i++)
    for (int64_t j = i; j < p->squared; j++, others += rest) {
      double force[3 * THRUM_SOLID_EDGES_MAX] = {0};
      thrum_solid_pull(nodes, p->stress + i * count, p->edges + j * size, 1, force);
      if (j > i)
        thrum_solid_pull(nodes, p->stress + j * count, p->edges + i * size, 1, force);
      cblas_dgemv(CblasRowMajor, CblasNoTrans, (int)rest, size, 1, p->edges + p->squared * size,
                  size, force, 1, 1, others, 1);
    }
}

// elements with rows: as many of them as a panel has room for before each product
static thrum_status add_row_solids(panel *p, double *gram, double *others,
                                   const thrum_reporter *reporter, thrum_error *error) {
  const thrum_solid_elements *e = &p->fem->solids;
  const int64_t depth = 6 * BLOCK;
  int64_t filled = 0;
  for (int64_t s = 0; s < e->count; s++) {
    const int rows = thrum_solid_row_count(e, s);
    const int count = thrum_solid_products(thrum_solid_node_count(e, s));
    if (!thrum_solid_has_rows(e, s))
      continue;
    if (filled + rows > depth) {
      add_product(p, filled, gram);
      filled = 0;
    }
    fill_products(p, s);
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, rows, (int)p->columns, count, 1,
                e->rows + e->row_begin[s], count, p->products, count, 0, p->row + filled,
                (int)depth);
    if (others != NULL)
      add_solid_others(p, s, others);
    filled += rows;
    if (s % BLOCK == 0)
      THRUM_TRY(thrum_report(reporter, (double)s / (double)e->count, error));
  }
  if (filled > 0)
    add_product(p, filled, gram);
  return THRUM_OK;
}

// of a point of elasticity with directions the strains are filled as they are
static void take_directions(panel *p, int32_t region, double weight, int64_t s) {
  p->stiffness[s] = thrum_solid_stiffness(&p->fem->solids, region);
  if (!p->stiffness[s])
    return;
  p->directed = true;
  p->root_weight[s] = sqrt(weight);
  p->weight[0][s] = p->weight[2][s] = 1;
  p->weight[1][s] = 0;
}

// elements with points, gathered to blocks of them
static void add_point_solids(panel *p, double *gram, double *others) {
  const thrum_solid_elements *e = &p->fem->solids;
  int64_t filled = 0;
  for (int64_t s = 0; s < e->count; s++) {
    if (thrum_solid_has_rows(e, s))
      continue;
    for (int64_t point = e->point_begin[s]; point < e->point_begin[s + 1]; point++) {
      double shape[THRUM_FEM_NODES_MAX][3];
      if (filled == 0) {
        memset(p->gradient, 0, sizeof(double) * (size_t)(p->rank * 9 * BLOCK));
        memset(p->weight, 0, sizeof p->weight);
        memset(p->stiffness, 0, sizeof p->stiffness);
        p->directed = false;
      }
      thrum_solid_gradients(e, s, (int)(point - e->point_begin[s]), shape);
      fill_nodes(p, thrum_solid_nodes(e, s), thrum_solid_node_count(e, s), shape, filled);
      weigh(p, e->region[s], e->weight[point], filled);
      take_directions(p, e->region[s], e->weight[point], filled);
      if (p->place) {
        thrum_tet tet;
        thrum_fem_solid_at(p->fem, s, (int)(point - e->point_begin[s]), NULL, &tet);
        memcpy(p->place[filled], tet.deformation, sizeof p->place[filled]);
      }
      filled++;
      if (filled == BLOCK) {
        add_block(p, gram, others);
        filled = 0;
      }
    }
  }
  if (filled > 0)
    add_block(p, gram, others);
}

static thrum_status add_solids(panel *p, double *gram, double *others,
                               const thrum_reporter *reporter, thrum_error *error) {
  THRUM_TRY(add_row_solids(p, gram, others, reporter, error));
  add_point_solids(p, gram, others);
  return THRUM_OK;
}

// gram (columns x columns, column-major, upper triangle) = A^T A, and others as above, which may be
// NULL
static thrum_status accumulate(panel *p, double *gram, double *others,
                               const thrum_reporter *reporter, thrum_error *error) {
  const int64_t points = p->fem->tet_count * p->fem->point_count, m = p->columns;
  memset(gram, 0, sizeof *gram * (size_t)(m * m));
  if (others != NULL)
    memset(others, 0, sizeof *others * (size_t)((p->rank - p->squared) * pairs_of(p->squared)));

  for (int64_t first = 0; first < points; first += BLOCK) {
    fill_gradients(p, first, points - first < BLOCK ? points - first : BLOCK);
    add_block(p, gram, others);
    THRUM_TRY(thrum_report(reporter, (double)first / (double)points, error));
  }
  return p->fem->solids.count > 0 ? add_solids(p, gram, others, reporter, error) : THRUM_OK;
}

// linear = U^T K U about a state, where stresses are part of K
static thrum_status about_linear(const thrum_fem *fem, int64_t rank, const double *basis,
                                 double *linear, thrum_error *error) {
  const int64_t n = fem->free_count;
  thrum_sparse stiffness = {0};
  thrum_scope memory = thrum_scope_begin("the polynomial", error);
  double *vectors = thrum_scope_allocate(&memory, n * rank, sizeof *vectors);
  double *images = thrum_scope_allocate(&memory, n * rank, sizeof *images);
  thrum_status status = memory.status;
  THRUM_THEN(status, thrum_fem_pattern(fem, &stiffness, error));
  THRUM_THEN(status, thrum_fem_stiffness(fem, NULL, &stiffness, error));
  if (status >= 0) {
    for (int64_t i = 0; i < rank; i++)
      for (int64_t f = 0; f < n; f++)
        vectors[i * n + f] = basis[fem->component[f] * rank + i];
    thrum_sparse_product(&stiffness, vectors, rank, images);
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, (int)rank, (int)rank, (int)n, 1, vectors,
                (int)n, images, (int)n, 0, linear, (int)rank);
    for (int64_t i = 0; i < rank; i++)
      for (int64_t j = 0; j < i; j++)
        linear[i * rank + j] = linear[j * rank + i] =
            (linear[i * rank + j] + linear[j * rank + i]) / 2;
  }
  thrum_sparse_free(&stiffness);
  thrum_scope_free(&memory);
  return status;
}

static void copy_linear(const double *gram, int64_t m, int64_t rank, double *linear) {
  for (int64_t i = 0; i < rank; i++)
    for (int64_t j = i; j < rank; j++)
      linear[i * rank + j] = linear[j * rank + i] = gram[i + j * m];
}

// linear += U^T S U, S the springs to the ground
static void add_springs(const thrum_fem *fem, int64_t rank, const double *basis, double *linear) {
  for (int64_t c = 0; fem->springs && c < 3 * fem->vertex_count; c++)
    for (int64_t i = 0; fem->springs[c] > 0 && i < rank; i++)
      for (int64_t j = 0; j < rank; j++)
        linear[i * rank + j] += fem->springs[c] * basis[c * rank + i] * basis[c * rank + j];
}

void thrum_indices_sort(int64_t *index, int count) {
  for (int a = 1; a < count; a++)
    for (int b = a; b > 0 && index[b] < index[b - 1]; b--) {
      const int64_t swap = index[b];
      index[b] = index[b - 1];
      index[b - 1] = swap;
    }
}

// adds every product of strains to the monomial it multiplies
static void symmetrise(const double *gram, int64_t rank, int64_t squared, double *c3, double *c4) {
  const int64_t m = columns_of(rank, squared);
  memset(c3, 0, sizeof *c3 * (size_t)thrum_c3_count(rank));
  memset(c4, 0, sizeof *c4 * (size_t)thrum_c4_count(rank));

  int64_t column = rank;
  for (int64_t k = 0; k < squared; k++)
    for (int64_t l = k; l < squared; l++, column++) {
      const double *entries = gram + column * m;

      // linear times quadratic strains make the cubic part
      for (int64_t i = 0; i < rank; i++) {
        int64_t index[3] = {i, k, l};
        thrum_indices_sort(index, 3);
        c3[thrum_c3_index(rank, index[0], index[1], index[2])] += entries[i];
      }

      // pairs (i, j) up to (k, l): the mirror image counts too, except on the diagonal
      int64_t row = rank;
      for (int64_t i = 0; i <= k; i++)
        for (int64_t j = i; j < squared && row <= column; j++, row++) {
          int64_t index[4] = {i, j, k, l};
          thrum_indices_sort(index, 4);
          c4[thrum_c4_index(rank, index[0], index[1], index[2], index[3])] +=
              row == column ? entries[row] / 2 : entries[row];
        }
    }
}

// adds what `others` of add_others has to the monomials of two of the first vectors and another
static void add_mixed(const double *others, int64_t rank, int64_t squared, double *c3) {
  for (int64_t i = 0; i < squared; i++)
    for (int64_t j = i; j < squared; j++)
      for (int64_t h = squared; h < rank; h++)
        c3[thrum_c3_index(rank, i, j, h)] += *others++;
}

// *gram = A^T A with the products of the first `squared` vectors, which the caller frees; others as
// in accumulate
static thrum_status make_gram(const thrum_fem *fem, int64_t rank, const double *basis,
                              int64_t squared, double *others, const thrum_reporter *reporter,
                              double **gram, thrum_error *error) {
  panel p = {0};
  const int64_t columns = columns_of(rank, squared);

  // an index of the Gram matrix must fit what BLAS counts with
  if (columns > INT32_MAX / 2)
    return THRUM_OUT_OF_MEMORY;
  thrum_status status =
      thrum_reserve(gram, columns * columns, sizeof **gram, "the Gram matrix of strains", error);
  THRUM_THEN(status, panel_create(fem, rank, basis, squared, &p, error));
  THRUM_THEN(status, accumulate(&p, *gram, others, reporter, error));
  thrum_scope_free(&p.memory);
  return status;
}

thrum_status thrum_polynomial_reduce(const thrum_fem *fem, int64_t rank, int64_t squared,
                                     const double *basis, double *linear, double *c3, double *c4,
                                     const thrum_reporter *reporter, thrum_error *error) {
  double *others = NULL, *gram = NULL;
  if (squared < rank)
    THRUM_TRY(thrum_reserve(&others, (rank - squared) * pairs_of(squared), sizeof *others,
                            "the polynomial", error));

  const thrum_status status = make_gram(fem, rank, basis, squared, others, reporter, &gram, error);
  if (status >= 0) {
    copy_linear(gram, columns_of(rank, squared), rank, linear);
    add_springs(fem, rank, basis, linear);
    symmetrise(gram, rank, squared, c3, c4);
    if (others != NULL)
      add_mixed(others, rank, squared, c3);

    // the strain energy of the whole body is the sum of those of its parts
    thrum_ranks_sum(fem->ranks, linear, rank * rank);
    thrum_ranks_sum(fem->ranks, c3, thrum_c3_count(rank));
    thrum_ranks_sum(fem->ranks, c4, thrum_c4_count(rank));
  }
  free(others);
  free(gram);
  if (fem->about)
    THRUM_TRY(status >= 0 ? about_linear(fem, rank, basis, linear, error) : status);
  return status;
}

thrum_status thrum_reduced_stiffness(const thrum_fem *fem, int64_t rank, const double *basis,
                                     double *linear, thrum_error *error) {
  double *gram = NULL;
  const thrum_status status = make_gram(fem, rank, basis, 0, NULL, NULL, &gram, error);
  if (status >= 0) {
    copy_linear(gram, rank, rank, linear);
    add_springs(fem, rank, basis, linear);
    thrum_ranks_sum(fem->ranks, linear, rank * rank);
  }
  free(gram);
  if (fem->about)
    THRUM_TRY(status >= 0 ? about_linear(fem, rank, basis, linear, error) : status);
  return status;
}
