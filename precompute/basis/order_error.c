/* The error of linear tetrahedra by hierarchical functions (precompute/basis/hierarchy.h). Ten-node
 * tetrahedra are linear ones and a function 4 l_a l_b on each edge, and those of the nodes stay.
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/order_error.h"

#include <string.h>

#include "core/base/quadratic_tet.h"
#include "core/base/vec3.h"
#include "mesh/midsides.h"

/* What the larger space is of. */
typedef struct edge_problem {
  const thrum_fem *fem;
  int32_t *edges; /* tet_count x 6 */
} edge_problem;

// a tet: gradients of its barycentric coordinates, and its material
typedef struct linear_tet {
  double gradient[THRUM_FEM_NODES_MAX][3];
  double volume, lambda, mu, density;
  const int32_t *corner, *edge;
} linear_tet;

static linear_tet tet_of(const edge_problem *s, int64_t t) {
  const thrum_fem *fem = s->fem;
  const int32_t region = fem->tet_region[t];
  linear_tet tet = {.volume = fem->volume[t],
                    .lambda = fem->lambda[region],
                    .mu = fem->mu[region],
                    .density = fem->density[region],
                    .corner = fem->nodes + 4 * t,
                    .edge = s->edges + 6 * t};
  thrum_fem_shape_gradients(fem, t, 0, tet.gradient);
  return tet;
}

// stress = S(sym G)
static void stress_of(const linear_tet *tet, double g[3][3], double stress[3][3]) {
  const double pressure = tet->lambda * (g[0][0] + g[1][1] + g[2][2]);
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      stress[c][d] = tet->mu * (g[c][d] + g[d][c]) + (c == d ? pressure : 0);
}

// adds the diagonal blocks of a tet: the integral of the product of two gradients of 4 l_a l_b
static void add_diagonal(const linear_tet *tet, double *blocks) {
  for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++) {
    const double *a = tet->gradient[thrum_quadratic_edges[e][0]];
    const double *b = tet->gradient[thrum_quadratic_edges[e][1]];
    double product[3][3];
    for (int c = 0; c < 3; c++)
      for (int d = 0; d < 3; d++)
        product[c][d] = 16 * tet->volume *
                        ((a[c] * a[d] + b[c] * b[d]) / 10 + (a[c] * b[d] + b[c] * a[d]) / 20);
    const double trace = product[0][0] + product[1][1] + product[2][2];
    for (int c = 0; c < 3; c++)
      for (int d = 0; d < 3; d++)
        blocks[9 * tet->edge[e] + 3 * c + d] +=
            tet->lambda * product[c][d] + tet->mu * product[d][c] + (c == d ? tet->mu * trace : 0);
  }
}

static void prepare(const edge_problem *s, hierarchy *h) {
  // an axis is held where both ends of the edge hold it
  memset(h->held, 7, (size_t)h->count);
  memset(h->inverse, 0, sizeof *h->inverse * (size_t)(9 * h->count));
  for (int64_t t = 0; t < s->fem->tet_count; t++) {
    const linear_tet tet = tet_of(s, t);
    for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++)
      for (int end = 0; end < 2; end++)
        for (int c = 0; c < 3; c++)
          if (s->fem->dof[3 * (int64_t)tet.corner[thrum_quadratic_edges[e][end]] + c] >= 0)
            h->held[tet.edge[e]] &= (uint8_t) ~(1U << c);
    add_diagonal(&tet, h->inverse);
  }
  hierarchy_invert_blocks(h);
}

/* The displacements of a tet's corners; held ones are zero. */
static void take_corners(const edge_problem *s, const linear_tet *tet, const double *field,
                         double u[4][3]) {
  for (int a = 0; a < 4; a++)
    for (int c = 0; c < 3; c++) {
      const int32_t dof = s->fem->dof[3 * (int64_t)tet->corner[a] + c];
      u[a][c] = dof < 0 ? 0 : field[dof];
    }
}

static void add_corner(const edge_problem *s, const linear_tet *tet, int a, const double *force,
                       double *image) {
  for (int c = 0; c < 3; c++) {
    const int32_t dof = s->fem->dof[3 * (int64_t)tet->corner[a] + c];
    if (dof >= 0)
      image[dof] += force[c];
  }
}

/* The gradients of a displacement at the corners of a tet, and their sum. */
static void take_gradients(const edge_problem *s, const linear_tet *tet, const double *field,
                           double g[5][3][3]) {
  const double *edges = field + s->fem->free_count;
  double u[4][3], mean[3][3] = {{0}};

  // that of the corners' displacements is the same everywhere
  take_corners(s, tet, field, u);
  for (int a = 0; a < 4; a++)
    for (int c = 0; c < 3; c++)
      for (int d = 0; d < 3; d++)
        mean[c][d] += u[a][c] * tet->gradient[a][d];
  for (int a = 0; a < 4; a++)
    memcpy(g[a], mean, sizeof mean);

  // 4 l_a l_b has the gradient 4 grad l_b at corner a
  for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++)
    for (int end = 0; end < 2; end++) {
      const int at = thrum_quadratic_edges[e][end], other = thrum_quadratic_edges[e][1 - end];
      for (int c = 0; c < 3; c++)
        for (int d = 0; d < 3; d++)
          g[at][c][d] += 4 * edges[3 * tet->edge[e] + c] * tet->gradient[other][d];
    }

  memset(g[4], 0, sizeof g[4]);
  for (int a = 0; a < 4; a++)
    for (int c = 0; c < 9; c++)
      g[4][c / 3][c % 3] += g[a][c / 3][c % 3];
}

/* image = K field; gradients are linear in a tet, and a product of two linear functions has the
 * integral vol/20 (sum of the products at the corners + product of the sums) */
static void multiply(const hierarchy *h, const double *field, double *image) {
  const edge_problem *s = h->context;
  double *edges = image + s->fem->free_count;
  memset(image, 0, sizeof *image * (size_t)h->size);
  for (int64_t t = 0; t < s->fem->tet_count; t++) {
    const linear_tet tet = tet_of(s, t);
    double g[5][3][3], stress[5][3][3]; // at the corners, and their sum
    take_gradients(s, &tet, field, g);
    for (int a = 0; a < 5; a++)
      stress_of(&tet, g[a], stress[a]);

    // corners feel the mean stress
    for (int a = 0; a < 4; a++) {
      double force[3];
      for (int c = 0; c < 3; c++)
        force[c] = tet.volume / 4 * thrum_dot3(stress[4][c], tet.gradient[a]);
      add_corner(s, &tet, a, force, image);
    }

    for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++)
      for (int end = 0; end < 2; end++) {
        const int at = thrum_quadratic_edges[e][end], other = thrum_quadratic_edges[e][1 - end];
        for (int c = 0; c < 3; c++)
          for (int d = 0; d < 3; d++)
            edges[3 * tet.edge[e] + c] +=
                tet.volume / 5 * tet.gradient[other][d] * (stress[at][c][d] + stress[4][c][d]);
      }
  }
  thrum_fem_add_free_springs(s->fem, field, image);
  hierarchy_clear_held(h, image);
}

/* The integral of 16 l_a l_b l_c l_d over a tet of unit volume: 64/840 for an edge with itself, a
 * half of that where two share a corner, and a quarter where they are opposite. */
static double edge_mass(int e, int f) {
  const int *a = thrum_quadratic_edges[e], *b = thrum_quadratic_edges[f];
  const int shared = (a[0] == b[0]) + (a[0] == b[1]) + (a[1] == b[0]) + (a[1] == b[1]);
  return (shared == 2 ? 64 : shared == 1 ? 32 : 16) / 840.0;
}

/* image = M field, consistent: l_a l_b has the integral vol/20, twice that for a = b, and 4 l_a l_b
 * l_c vol/30, twice that where c is an end */
static void weigh(const hierarchy *h, const double *field, double *image) {
  const edge_problem *s = h->context;
  const double *edges = field + s->fem->free_count;
  double *edge_image = image + s->fem->free_count;
  memset(image, 0, sizeof *image * (size_t)h->size);
  for (int64_t t = 0; t < s->fem->tet_count; t++) {
    const linear_tet tet = tet_of(s, t);
    const double mass = tet.density * tet.volume;
    double u[4][3], force[4][3], sum[3] = {0}, edge_sum[3] = {0};
    take_corners(s, &tet, field, u);
    for (int c = 0; c < 3; c++) {
      for (int a = 0; a < 4; a++)
        sum[c] += u[a][c];
      for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++)
        edge_sum[c] += edges[3 * tet.edge[e] + c];
      for (int a = 0; a < 4; a++)
        force[a][c] = mass * ((sum[c] + u[a][c]) / 20 + edge_sum[c] / 30);
    }

    // each edge with its ends, and with all edges
    for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++) {
      const int a = thrum_quadratic_edges[e][0], b = thrum_quadratic_edges[e][1];
      for (int c = 0; c < 3; c++) {
        const double own = edges[3 * tet.edge[e] + c];
        double product = (sum[c] + u[a][c] + u[b][c]) / 30;
        for (int f = 0; f < THRUM_QUADRATIC_EDGES; f++)
          product += edge_mass(e, f) * edges[3 * tet.edge[f] + c];
        edge_image[3 * tet.edge[e] + c] += mass * product;
        force[a][c] += mass * own / 30;
        force[b][c] += mass * own / 30;
      }
    }
    for (int a = 0; a < 4; a++)
      add_corner(s, &tet, a, force[a], image);
  }
  hierarchy_clear_held(h, image);
}

thrum_status thrum_order_errors(const thrum_order_body *body, int64_t count, const double *modes,
                                double *errors, thrum_error *error) {
  const int64_t tets = body->mesh->tet_count;
  edge_problem s = {.fem = body->fem};
  hierarchy h = {.multiply = multiply, .weigh = weigh, .context = &s};
  int64_t edges = 0;
  h.memory = thrum_scope_begin("the error of the order", error);
  s.edges = thrum_scope_allocate(&h.memory, 6 * tets, sizeof *s.edges);
  thrum_status status = h.memory.status;
  THRUM_THEN(status, thrum_midsides_number(body->mesh, s.edges, &edges, error));
  for (int64_t i = 0; i < 6 * tets && status >= 0; i++)
    s.edges[i] -= (int32_t)body->mesh->vertex_count;

  THRUM_THEN(status, hierarchy_allocate(body, edges, count, &h));
  if (status >= 0) {
    prepare(&s, &h);
    status = hierarchy_errors(&h, count, modes, errors, error);
  }
  thrum_scope_free(&h.memory);
  return status;
}
