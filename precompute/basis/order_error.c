/* The error of linear tetrahedra by hierarchical functions, as of Bank & Smith 1993, A posteriori
 * error estimates based on hierarchical bases, doi:10.1137/0730048. Ten-node tetrahedra are linear
 * ones and a function 4 l_a l_b on each edge. With the corners held in a mode psi, those functions
 * take the displacement w that minimises 1/2 w.K w - r.w, r = -(K - omega^2 M) psi on the edges,
 * and omega^2 falls by r.w: a linear tetrahedron that bends is too stiff by just what they let go.
 * w comes from a few steps of conjugate gradients with the 3 x 3 blocks of the diagonal, and so the
 * fall is a little too small.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/order_error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/midsides.h"
#include "platform/allocate.h"
#include "runtime/base/quadratic_tet.h"
#include "runtime/base/vec3.h"

#define STEPS 4

typedef struct edge_problem {
  const thrum_fem *fem;
  int64_t count;             /* of edges */
  int32_t *edges;            /* tet_count x 6 */
  uint8_t *held;             /* count: axes that both ends hold, a bit each */
  double *inverse;           /* count x 9: of the diagonal blocks */
  double *r, *z, *p, *image; /* count x 3 */
  thrum_scope memory;
} edge_problem;

static thrum_status edge_problem_allocate(const thrum_mesh *mesh, edge_problem *s,
                                          thrum_error *error) {
  s->memory = thrum_scope_begin("the error of the order", error);
  s->edges = thrum_scope_allocate(&s->memory, 6 * mesh->tet_count, sizeof *s->edges);
  THRUM_TRY(s->memory.status);
  THRUM_TRY(thrum_midsides_number(mesh, s->edges, &s->count, error));
  for (int64_t i = 0; i < 6 * mesh->tet_count; i++)
    s->edges[i] -= (int32_t)mesh->vertex_count;
  s->held = thrum_scope_allocate(&s->memory, s->count, sizeof *s->held);
  s->inverse = thrum_scope_allocate(&s->memory, 9 * s->count, sizeof(double));
  s->r = thrum_scope_allocate(&s->memory, 3 * s->count, sizeof(double));
  s->z = thrum_scope_allocate(&s->memory, 3 * s->count, sizeof(double));
  s->p = thrum_scope_allocate(&s->memory, 3 * s->count, sizeof(double));
  s->image = thrum_scope_allocate(&s->memory, 3 * s->count, sizeof(double));
  return s->memory.status;
}

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

// the blocks become their inverses, without the axes that are held
static void invert_blocks(edge_problem *s) {
  for (int64_t e = 0; e < s->count; e++) {
    double m[3][3], cofactor[9];
    for (int c = 0; c < 3; c++)
      for (int d = 0; d < 3; d++) {
        const bool out = (s->held[e] >> c & 1) || (s->held[e] >> d & 1);
        m[c][d] = out ? c == d : s->inverse[9 * e + 3 * c + d];
      }
    for (int c = 0; c < 3; c++)
      thrum_cross3(m[(c + 1) % 3], m[(c + 2) % 3], cofactor + 3 * c);
    const double determinant = thrum_dot3(m[0], cofactor);
    for (int c = 0; c < 9; c++)
      s->inverse[9 * e + c] = cofactor[c] / determinant;
  }
}

static void prepare(edge_problem *s) {
  // an axis is held where both ends of the edge hold it
  memset(s->held, 7, (size_t)s->count);
  memset(s->inverse, 0, sizeof *s->inverse * (size_t)(9 * s->count));
  for (int64_t t = 0; t < s->fem->tet_count; t++) {
    const linear_tet tet = tet_of(s, t);
    for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++)
      for (int end = 0; end < 2; end++)
        for (int c = 0; c < 3; c++)
          if (s->fem->dof[3 * (int64_t)tet.corner[thrum_quadratic_edges[e][end]] + c] >= 0)
            s->held[tet.edge[e]] &= (uint8_t) ~(1U << c);
    add_diagonal(&tet, s->inverse);
  }
  invert_blocks(s);
}

static void clear_held(const edge_problem *s, double *x) {
  for (int64_t i = 0; i < 3 * s->count; i++)
    if (s->held[i / 3] >> (i % 3) & 1)
      x[i] = 0;
}

// r = -(K - omega^2 M) psi on the edges
static void make_residual(edge_problem *s, const double *mode, double omega2) {
  memset(s->r, 0, sizeof *s->r * (size_t)(3 * s->count));
  for (int64_t t = 0; t < s->fem->tet_count; t++) {
    const linear_tet tet = tet_of(s, t);

    // the displacements of the corners, their sum and their gradient
    double u[4][3], sum[3] = {0}, g[3][3] = {{0}}, stress[3][3];
    for (int a = 0; a < 4; a++)
      for (int c = 0; c < 3; c++) {
        const int32_t dof = s->fem->dof[3 * (int64_t)tet.corner[a] + c];
        u[a][c] = dof < 0 ? 0 : mode[dof];
        sum[c] += u[a][c];
        for (int d = 0; d < 3; d++)
          g[c][d] += u[a][c] * tet.gradient[a][d];
      }
    stress_of(&tet, g, stress);

    // the mean gradient of 4 l_a l_b is that of l_a + l_b; the mass with l_c is vol/30, or /15 at
    // an end
    for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++) {
      const int a = thrum_quadratic_edges[e][0], b = thrum_quadratic_edges[e][1];
      for (int c = 0; c < 3; c++) {
        double force = 0;
        for (int d = 0; d < 3; d++)
          force += stress[c][d] * (tet.gradient[a][d] + tet.gradient[b][d]);
        const double inertia = omega2 * tet.density * (sum[c] + u[a][c] + u[b][c]) / 30;
        s->r[3 * tet.edge[e] + c] -= tet.volume * (force - inertia);
      }
    }
  }
  clear_held(s, s->r);
}

// image = K p; gradients are linear in a tet, and a product of two linear functions has the
// integral vol/20 (sum of the products at the corners + product of the sums)
static void multiply(edge_problem *s) {
  memset(s->image, 0, sizeof *s->image * (size_t)(3 * s->count));
  for (int64_t t = 0; t < s->fem->tet_count; t++) {
    const linear_tet tet = tet_of(s, t);
    double g[5][3][3] = {{{0}}}, stress[5][3][3]; // at the corners, and their sum

    // 4 l_a l_b has the gradient 4 grad l_b at corner a
    for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++)
      for (int end = 0; end < 2; end++) {
        const int at = thrum_quadratic_edges[e][end], other = thrum_quadratic_edges[e][1 - end];
        for (int c = 0; c < 3; c++)
          for (int d = 0; d < 3; d++)
            g[at][c][d] += 4 * s->p[3 * tet.edge[e] + c] * tet.gradient[other][d];
      }
    for (int a = 0; a < 4; a++)
      for (int c = 0; c < 9; c++)
        g[4][c / 3][c % 3] += g[a][c / 3][c % 3];
    for (int a = 0; a < 5; a++)
      stress_of(&tet, g[a], stress[a]);

    for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++)
      for (int end = 0; end < 2; end++) {
        const int at = thrum_quadratic_edges[e][end], other = thrum_quadratic_edges[e][1 - end];
        for (int c = 0; c < 3; c++)
          for (int d = 0; d < 3; d++)
            s->image[3 * tet.edge[e] + c] +=
                tet.volume / 5 * tet.gradient[other][d] * (stress[at][c][d] + stress[4][c][d]);
      }
  }
  clear_held(s, s->image);
}

static double dot(const edge_problem *s, const double *a, const double *b) {
  double sum = 0;
  for (int64_t i = 0; i < 3 * s->count; i++)
    sum += a[i] * b[i];
  return sum;
}

// r.w for the w of a few steps: each takes off what its direction lets go
static double fall(edge_problem *s) {
  double total = 0, before = 0;
  memset(s->p, 0, sizeof *s->p * (size_t)(3 * s->count));

  // conjugate gradients, preconditioned by the blocks of the diagonal
  for (int step = 0; step < STEPS; step++) {
    for (int64_t i = 0; i < 3 * s->count; i++)
      s->z[i] = thrum_dot3(s->inverse + 3 * i, s->r + i / 3 * 3);
    clear_held(s, s->z);
    const double now = dot(s, s->r, s->z);
    if (!(now > 0))
      break;
    for (int64_t i = 0; i < 3 * s->count; i++)
      s->p[i] = s->z[i] + (step > 0 ? now / before : 0) * s->p[i];
    before = now;

    multiply(s);
    const double length = now / dot(s, s->p, s->image);
    total += length * now;
    for (int64_t i = 0; i < 3 * s->count; i++)
      s->r[i] -= length * s->image[i];
  }
  return total;
}

thrum_status thrum_order_errors(const thrum_mesh *mesh, const thrum_fem *fem, int64_t count,
                                const double *modes, const double *omega2, double *errors,
                                thrum_error *error) {
  edge_problem s = {.fem = fem};
  const thrum_status status = edge_problem_allocate(mesh, &s, error);
  if (status >= 0) {
    prepare(&s);
    for (int64_t i = 0; i < count; i++) {
      make_residual(&s, modes + i * fem->free_count, omega2[i]);

      // the fall cannot be all of it
      const double share = fmin(fall(&s) / omega2[i], 0.99);
      errors[i] = 1 / sqrt(1 - share) - 1;
    }
  }
  thrum_scope_free(&s.memory);
  return status;
}
