/* The derivatives of frequencies by the places of vertices: of a mode phi of unit mass
 *
 *   d omega^2/dX_a = sum w [(s:e - rho omega^2 |phi|^2) grad N_a - 2 G^T s grad N_a]
 *
 * over the points of the elements around vertex a, of weight w, with G the gradient of phi, e its
 * symmetric part, s the stress and N_a the shape function: the mode stays, and goes with the
 * vertices; a place that moves by V changes G by -G grad V and w by w div V. The mass of linear
 * tets is integrated exactly, and is 1/4 rho V at each corner where it is lumped.
 * Hexahedra, wedges and solid-shells have strains that are assumed or enhanced, so the stiffness
 * and mass of each element alone are made with each of its nodes moved to either side, and their
 * differences taken: phi (dK/dX - omega^2 dM/dX) phi, to APART^2 of it.
 * Cost: as many passes over the points as there are modes. Sources: Fox & Kapoor 1968,
 * doi:10.2514/3.5008; Eshelby 1951, doi:10.1098/rsta.1951.0016.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/shape_gradient.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver/model/frequency_gradient.h"
#include "platform/allocate.h"
#include "precompute/fem/fem_solids.h"
#include "precompute/fem/fem_tet.h"
#include "precompute/model/model_fem.h"

#define APART 3e-5 /* of the shortest way between two nodes of an element: how far one is moved */

typedef struct work {
  const thrum_fem *fem;
  thrum_mass kind;
  double omega2;
  const double *mode; /* 3 vertex_count */
  double *to;         /* likewise */
} work;

/* |phi|^2 at point p of an element; of linear tets that of its mass over its volume. */
static double square_at(const work *w, const int32_t *node, int p) {
  const int nodes = w->fem->node_count;
  double sum[3] = {0, 0, 0}, squares = 0, square = 0;
  double shape[THRUM_QUADRATIC_NODES] = {1, 1, 1, 1};
  if (nodes == THRUM_QUADRATIC_NODES)
    thrum_quadratic_shape(w->fem->rule[p].place, shape);
  for (int a = 0; a < nodes; a++)
    for (int c = 0; c < 3; c++) {
      const double u = w->mode[3 * (int64_t)node[a] + c];
      sum[c] += shape[a] * u;
      squares += u * u;
    }
  square = sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2];
  if (nodes == THRUM_QUADRATIC_NODES)
    return square;
  return w->kind == THRUM_MASS_LUMPED ? squares / 4 : (square + squares) / 20;
}

/* Adds what point p of tet t says. */
static void add_point(const work *w, int64_t t, int p) {
  const int32_t *node = w->fem->nodes + w->fem->node_count * t;
  thrum_tet tet;
  thrum_fem_tet_at(w->fem, t, p, w->mode, &tet);
  double strain[3][3], stress[3][3], energy = 0;
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      strain[c][d] = 0.5 * (tet.displacement[c][d] + tet.displacement[d][c]);
  thrum_stress(tet.lambda, tet.mu, strain, stress);
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      energy += stress[c][d] * strain[c][d];
  const double density = w->fem->density[w->fem->tet_region[t]];
  const double bulk = energy - density * w->omega2 * square_at(w, node, p);

  for (int a = 0; a < w->fem->node_count; a++) {
    double pulled[3], *to = w->to + 3 * (int64_t)node[a];
    thrum_product_vector(stress, tet.gradient[a], pulled);
    for (int e = 0; e < 3; e++) {
      double along = 0;
      for (int c = 0; c < 3; c++)
        along += tet.displacement[c][e] * pulled[c];
      to[e] += tet.weight * (bulk * tet.gradient[a][e] - 2 * along);
    }
  }
}

/* Rows of modes that share a frequency become their mean. */
static void share_rows(const double *omega2, int64_t modes, int64_t count, double *rows) {
  for (int64_t first = 0, last = 0; first < modes; first = last) {
    last = frequency_shared_end(omega2, modes, first);
    for (int64_t c = 0; c < count && last - first > 1; c++) {
      double sum = 0;
      for (int64_t i = first; i < last; i++)
        sum += rows[i * count + c];
      for (int64_t i = first; i < last; i++)
        rows[i * count + c] = sum / (double)(last - first);
    }
  }
}

static thrum_status check_body(const thrum_model_fem *body, thrum_error *error) {
  if (body->fem.node_count == THRUM_QUADRATIC_NODES && body->kind == THRUM_MASS_LUMPED)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "ten-node tetrahedra of lumped mass have no derivative by places here: "
                           "precompute with --mass consistent");
  return THRUM_OK;
}

/* --- elements that are no tetrahedra ---------------------------------------------------------- */

enum { COPIES = 6 * THRUM_SOLID_NODES_MAX, PLACES = COPIES * THRUM_SOLID_NODES_MAX };

/* An element, over and over, in each with one node moved: node a along axis c to either side are
 * copies 6 a + 2 c and the next. */
typedef struct copies {
  int nodes;
  double apart;
  double vertices[3 * PLACES];
  int32_t node[PLACES], ends[COPIES], tet_ends[COPIES], region[COPIES];
  uint8_t form[COPIES];
  thrum_solid_blocks blocks; /* of one of them */
  double masses[THRUM_SOLID_NODES_MAX][THRUM_SOLID_NODES_MAX];
} copies;

static void copy_element(const thrum_fem *fem, int64_t s, copies *c) {
  const thrum_solid_elements *e = &fem->solids;
  const int32_t *nodes = thrum_solid_nodes(e, s);
  c->nodes = thrum_solid_node_count(e, s);
  double least = INFINITY;
  for (int a = 0; a < c->nodes; a++)
    for (int b = 0; b < a; b++) {
      const double *x = e->vertices + 3 * (int64_t)nodes[a],
                   *y = e->vertices + 3 * (int64_t)nodes[b];
      least = fmin(least, hypot(hypot(x[0] - y[0], x[1] - y[1]), x[2] - y[2]));
    }
  c->apart = APART * least;
  for (int n = 0; n < 6 * c->nodes; n++) {
    c->ends[n] = (n + 1) * c->nodes;
    c->tet_ends[n] = n + 1;
    c->region[n] = e->region[s];
    c->form[n] = e->form[s];
    for (int a = 0; a < c->nodes; a++) {
      const int at = n * c->nodes + a;
      c->node[at] = at;
      memcpy(c->vertices + 3 * at, e->vertices + 3 * (int64_t)nodes[a], 3 * sizeof(double));
    }
    c->vertices[3 * (n * c->nodes + n / 6) + n % 6 / 2] += n % 2 == 0 ? c->apart : -c->apart;
  }
}

/* phi (K - omega^2 M) phi of the copy that has its stiffness and mass. */
static double form_of(const copies *c, const double *mode, int64_t rank, const int32_t *nodes,
                      double omega2) {
  double sum = 0;
  for (int a = 0; a < c->nodes; a++)
    for (int b = 0; b < c->nodes; b++)
      for (int i = 0; i < 3; i++) {
        const double u = mode[(3 * (int64_t)nodes[a] + i) * rank];
        double answer = -omega2 * c->masses[a][b] * mode[(3 * (int64_t)nodes[b] + i) * rank];
        for (int j = 0; j < 3; j++)
          answer += c->blocks[a][b][i][j] * mode[(3 * (int64_t)nodes[b] + j) * rank];
        sum += u * answer;
      }
  return sum;
}

/* Adds what element `s` says of all modes. */
static thrum_status add_solid(const thrum_model *model, const thrum_model_fem *body, int64_t s,
                              int64_t modes, copies *c, double *rows, thrum_error *error) {
  thrum_scope memory = thrum_scope_begin("the derivatives by places", error);
  thrum_mesh mesh = body->mesh;
  thrum_fem fem = body->fem;
  copy_element(&body->fem, s, c);
  mesh.vertices = c->vertices;
  mesh.vertex_count = (int64_t)6 * c->nodes * c->nodes;
  mesh.tet_count = mesh.solid_count = (int64_t)6 * c->nodes;
  mesh.tet_region = c->region;
  mesh.solid_form = c->form;
  mesh.solid_ends = c->ends;
  mesh.solid_nodes = c->node;
  mesh.solid_tet_ends = c->tet_ends;
  mesh.tet_line = mesh.tet_number = NULL;
  fem.vertices = c->vertices;
  const thrum_status status =
      thrum_solid_elements_make(&mesh, fem.lambda, fem.mu, &memory, &fem.solids, error);
  const int32_t *nodes = thrum_solid_nodes(&body->fem.solids, s);
  for (int64_t n = 0; n < mesh.solid_count && status >= 0; n++) {
    thrum_fem_solid_stiffness(&fem, n, NULL, false, c->blocks);
    for (int a = 0; a < c->nodes; a++)
      thrum_fem_solid_mass(&fem, body->kind, n, a, c->masses[a]);
    const double by = (n % 2 == 0 ? 0.5 : -0.5) / c->apart;
    for (int64_t i = 0; i < modes; i++)
      rows[3 * (i * model->vertex_count + nodes[n / 6]) + n % 6 / 2] +=
          by * form_of(c, model->basis + i, model->rank, nodes, model->omega2[i]);
  }
  thrum_scope_free(&memory);
  return status;
}

static thrum_status add_solids(const thrum_model *model, const thrum_model_fem *body, int64_t modes,
                               double *rows, thrum_error *error) {
  copies *c = NULL;
  thrum_status status = THRUM_OK;
  if (body->fem.solids.count > 0)
    status = thrum_reserve(&c, 1, sizeof *c, "the derivatives by places", error);
  for (int64_t s = 0; s < body->fem.solids.count && status >= 0; s++)
    status = add_solid(model, body, s, modes, c, rows, error);
  free(c);
  return status;
}

/* --- all -------------------------------------------------------------------------------------- */

/* Row `i` of what is found; mode: 3 vertex_count. */
static void put_row(const thrum_model *model, const thrum_model_fem *body, int64_t i, double *mode,
                    double *row) {
  const int64_t count = 3 * model->vertex_count, r = model->rank;
  const work w = {
      .fem = &body->fem, .kind = body->kind, .omega2 = model->omega2[i], .mode = mode, .to = row};
  for (int64_t c = 0; c < count; c++)
    mode[c] = model->basis[c * r + i];
  for (int64_t t = 0; t < body->fem.tet_count; t++)
    for (int p = 0; p < body->fem.point_count; p++)
      add_point(&w, t, p);
  for (int64_t c = 0; c < count; c++)
    row[c] = w.omega2 > 0 ? row[c] / (2 * w.omega2) : NAN;
}

thrum_status shape_gradient_find(const thrum_model *model, int64_t modes, double **found,
                                 thrum_error *error) {
  if (model->basis == NULL || model->tets == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no mesh or basis, by which its frequencies change");
  thrum_model_fem body = {0};
  const int64_t count = 3 * model->vertex_count;
  double *mode = NULL, *rows = NULL;
  thrum_status status = thrum_model_fem_create(model, &body, error);
  THRUM_THEN(status, check_body(&body, error));
  THRUM_THEN(status, thrum_reserve(&mode, count, sizeof *mode, "the derivatives by places", error));
  THRUM_THEN(status,
             thrum_reserve(&rows, modes * count, sizeof *rows, "the derivatives by places", error));
  THRUM_THEN(status, add_solids(model, &body, modes, rows, error));
  for (int64_t i = 0; i < modes && status >= 0; i++)
    put_row(model, &body, i, mode, rows + i * count);
  free(mode);
  thrum_model_fem_free(&body);
  if (status < 0) {
    free(rows);
    return status;
  }
  share_rows(model->omega2, modes, count, rows);
  *found = rows;
  return THRUM_OK;
}
