/* The error of linear tetrahedra by hierarchical functions, as of Bank & Smith 1993, A posteriori
 * error estimates based on hierarchical bases, doi:10.1137/0730048. Ten-node tetrahedra are linear
 * ones and a function 4 l_a l_b on each edge. The linear modes psi start a step of subspace
 * iteration with ten nodes: K x = M psi is solved for each, and the eigenvalues of K and M on the
 * span of all x stand beside those of psi. What linear tetrahedra hold by locking, the corners'
 * share included, is let go in x.
 *
 * Conjugate gradients solve for x. They are preconditioned by the factor of the linear stiffness,
 * the block of the corners in this basis, and by the 3 x 3 blocks of the edges. The spaces of both
 * meet at an angle that does not depend on the size of the mesh, and neither does the number of
 * steps.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/order_error.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/midsides.h"
#include "platform/allocate.h"
#include "precompute/fem/lapack_status.h"
#include "precompute/fem/rigid_modes.h"
#include "runtime/base/quadratic_tet.h"
#include "runtime/base/vec3.h"

#define STEPS_MAX 300
#define SETTLED 1e-4  /* of what is let go so far: the rest, in the norm of the preconditioner */
#define NOTHING 0.002 /* of the energy of a mode that counts as nothing let go */

/* Fields are free_count numbers of the corners and then three for each edge. */
typedef struct edge_problem {
  const thrum_fem *fem;
  const thrum_order_body *body;
  int64_t count;              /* of edges */
  int64_t size;               /* of a field */
  int32_t *edges;             /* tet_count x 6 */
  uint8_t *held;              /* count: axes that both ends hold, a bit each */
  double *inverse;            /* count x 9: of the diagonal blocks */
  double *x, *load, *weighed; /* modes x size: x, K x and M x */
  double *r, *z, *p, *image;  /* size */
  thrum_scope memory;
} edge_problem;

static thrum_status edge_problem_allocate(const thrum_mesh *mesh, int64_t modes, edge_problem *s,
                                          thrum_error *error) {
  s->memory = thrum_scope_begin("the error of the order", error);
  s->edges = thrum_scope_allocate(&s->memory, 6 * mesh->tet_count, sizeof *s->edges);
  THRUM_TRY(s->memory.status);
  THRUM_TRY(thrum_midsides_number(mesh, s->edges, &s->count, error));
  for (int64_t i = 0; i < 6 * mesh->tet_count; i++)
    s->edges[i] -= (int32_t)mesh->vertex_count;

  s->size = s->fem->free_count + 3 * s->count;
  s->held = thrum_scope_allocate(&s->memory, s->count, sizeof *s->held);
  s->inverse = thrum_scope_allocate(&s->memory, 9 * s->count, sizeof(double));
  double **const fields[] = {&s->r, &s->z, &s->p, &s->image};
  double **const blocks[] = {&s->x, &s->load, &s->weighed};
  for (int n = 0; n < 4; n++)
    *fields[n] = thrum_scope_allocate(&s->memory, s->size, sizeof(double));
  for (int n = 0; n < 3; n++)
    *blocks[n] = thrum_scope_allocate(&s->memory, modes * s->size, sizeof(double));
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

static void clear_held(const edge_problem *s, double *field) {
  double *edges = field + s->fem->free_count;
  for (int64_t i = 0; i < 3 * s->count; i++)
    if (s->held[i / 3] >> (i % 3) & 1)
      edges[i] = 0;
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
static void multiply(const edge_problem *s, const double *field, double *image) {
  double *edges = image + s->fem->free_count;
  memset(image, 0, sizeof *image * (size_t)s->size);
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
  clear_held(s, image);
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
static void weigh(const edge_problem *s, const double *field, double *image) {
  const double *edges = field + s->fem->free_count;
  double *edge_image = image + s->fem->free_count;
  memset(image, 0, sizeof *image * (size_t)s->size);
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
  clear_held(s, image);
}

/* field -= left (right . field) on the corners, for each of the six columns: with Z and M Z what
 * is rigid is gone, with M Z and Z the load that would move it. */
static void project(const edge_problem *s, const double *left, const double *right, double *field) {
  const int64_t n = s->fem->free_count;
  for (int i = 0; left && i < THRUM_RIGID_COUNT; i++)
    cblas_daxpy((int)n, -cblas_ddot((int)n, right + i * n, 1, field, 1), left + i * n, 1, field, 1);
}

/* Z and M Z are of the corners, and M of the edges' part of a field is missing in M Z . field. */
static void drop_rigid(const edge_problem *s, double *field, double *work) {
  if (!s->body->rigid)
    return;
  weigh(s, field, work);
  const int64_t n = s->fem->free_count;
  for (int i = 0; i < THRUM_RIGID_COUNT; i++) {
    const double *rigid = s->body->rigid + i * n;
    cblas_daxpy((int)n, -cblas_ddot((int)n, rigid, 1, work, 1), rigid, 1, field, 1);
  }
}

static double dot(const edge_problem *s, const double *a, const double *b) {
  double sum = 0;
  for (int64_t i = 0; i < s->size; i++)
    sum += a[i] * b[i];
  return sum;
}

static thrum_status precondition(const edge_problem *s, thrum_error *error) {
  const int64_t n = s->fem->free_count;
  THRUM_TRY(thrum_factor_solve_roughly(s->body->factor, s->r, 1, s->z, error));
  for (int64_t i = 0; i < 3 * s->count; i++)
    s->z[n + i] = thrum_dot3(s->inverse + 3 * i, s->r + n + i / 3 * 3);
  clear_held(s, s->z);
  return THRUM_OK;
}

/* Solves K x = omega^2 M psi from x = psi: each step lets go of length * now. On entry r is the
 * load; on return that of x, K x. */
static thrum_status let_go(const edge_problem *s, double *x, double *load, thrum_error *error) {
  double released = 0, before = 0;
  const double energy = dot(s, load, x);
  multiply(s, x, s->image);
  for (int64_t i = 0; i < s->size; i++)
    s->r[i] = load[i] - s->image[i];
  memset(s->p, 0, sizeof *s->p * (size_t)s->size);

  for (int step = 0; step < STEPS_MAX; step++) {
    // what is left counts against what has been let go
    THRUM_TRY(precondition(s, error));
    const double now = dot(s, s->r, s->z);
    if (!(now > SETTLED * fmax(released, NOTHING * energy)))
      break;
    for (int64_t i = 0; i < s->size; i++)
      s->p[i] = s->z[i] + (step > 0 ? now / before : 0) * s->p[i];
    before = now;

    multiply(s, s->p, s->image);
    const double length = now / dot(s, s->p, s->image);
    released += length * now;
    for (int64_t i = 0; i < s->size; i++) {
      x[i] += length * s->p[i];
      s->r[i] -= length * s->image[i];
    }
  }

  for (int64_t i = 0; i < s->size; i++)
    load[i] -= s->r[i];
  return THRUM_OK;
}

/* The eigenvalues of K and M on the span of the columns of x, ascending. */
static thrum_status ritz(const edge_problem *s, int64_t count, double *values, thrum_error *error) {
  double stiff[THRUM_ORDER_MODES_MAX * THRUM_ORDER_MODES_MAX];
  double mass[THRUM_ORDER_MODES_MAX * THRUM_ORDER_MODES_MAX];
  for (int64_t i = 0; i < count; i++)
    for (int64_t j = i; j < count; j++) {
      stiff[j * count + i] = dot(s, s->x + i * s->size, s->load + j * s->size);
      mass[j * count + i] = dot(s, s->x + i * s->size, s->weighed + j * s->size);
    }
  const int k = (int)count;
  return thrum_lapack_status(
      LAPACKE_dsygv(LAPACK_COL_MAJOR, 1, 'N', 'U', k, stiff, k, mass, k, values), THRUM_SINGULAR,
      "the modes of linear tetrahedra are dependent once middle nodes move", error);
}

/* K x and M x of all columns. */
static void measure(const edge_problem *s, int64_t count) {
  for (int64_t i = 0; i < count; i++) {
    multiply(s, s->x + i * s->size, s->load + i * s->size);
    weigh(s, s->x + i * s->size, s->weighed + i * s->size);
  }
}

static thrum_status find(edge_problem *s, int64_t count, const double *modes, double *errors,
                         thrum_error *error) {
  const int64_t n = s->fem->free_count;
  double linear[THRUM_ORDER_MODES_MAX], let[THRUM_ORDER_MODES_MAX];
  prepare(s);

  // the values of the linear modes, whatever mass they were made with
  memset(s->x, 0, sizeof *s->x * (size_t)(count * s->size));
  for (int64_t i = 0; i < count; i++)
    memcpy(s->x + i * s->size, modes + i * n, sizeof *modes * (size_t)n);
  measure(s, count);
  THRUM_TRY(ritz(s, count, linear, error));

  // a step of subspace iteration
  for (int64_t i = 0; i < count; i++) {
    double *x = s->x + i * s->size, *load = s->load + i * s->size;
    const double omega2 = dot(s, x, load) / dot(s, x, s->weighed + i * s->size);
    for (int64_t j = 0; j < s->size; j++)
      load[j] = omega2 * s->weighed[i * s->size + j];
    project(s, s->body->rigid_dual, s->body->rigid, load);
    THRUM_TRY(let_go(s, x, load, error));
    drop_rigid(s, x, s->image);
    weigh(s, x, s->weighed + i * s->size);
  }
  THRUM_TRY(ritz(s, count, let, error));
  for (int64_t i = 0; i < count; i++)
    errors[i] = sqrt(fmax(linear[i] / let[i], 1)) - 1;
  return THRUM_OK;
}

thrum_status thrum_order_errors(const thrum_order_body *body, int64_t count, const double *modes,
                                double *errors, thrum_error *error) {
  edge_problem s = {.fem = body->fem, .body = body};
  double found[THRUM_ORDER_MODES_MAX];
  thrum_status status = edge_problem_allocate(body->mesh, count, &s, error);
  THRUM_THEN(status, find(&s, count, modes, found, error));
  if (status >= 0)
    memcpy(errors, found, sizeof *errors * (size_t)count);
  thrum_scope_free(&s.memory);
  return status;
}
