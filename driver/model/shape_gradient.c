/* The derivatives of frequencies by the places of vertices: of a mode phi of unit mass
 *
 *   d omega^2/dX_a = sum w [(s:e - rho omega^2 |phi|^2) grad N_a - 2 G^T s grad N_a]
 *
 * over the points of the elements around vertex a, of weight w, with G the gradient of phi, e its
 * symmetric part, s the stress and N_a the shape function: the mode stays, and goes with the
 * vertices; a place that moves by V changes G by -G grad V and w by w div V. The mass of linear
 * tets is integrated exactly, and is 1/4 rho V at each corner where it is lumped.
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
#include "precompute/fem/fem_tet.h"
#include "precompute/model/model_fem.h"

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
  if (body->fem.solids.count > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "hexahedra and wedges have no derivative by places here, as their "
                           "strains are assumed: take tetrahedra");
  if (body->fem.node_count == THRUM_QUADRATIC_NODES && body->kind == THRUM_MASS_LUMPED)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "ten-node tetrahedra of lumped mass have no derivative by places here: "
                           "precompute with --mass consistent");
  return THRUM_OK;
}

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
