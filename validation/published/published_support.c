/* Bodies, modes by their shape, and polynomials by hand. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/pi.h"
#include "core/base/vec3.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh_fix.h"
#include "platform/allocate.h"
#include "thrum/polynomial.h"
#include "validation/published/published.h"

#define SHARE_LEAST 0.01

thrum_status published_precompute(const published_body *body, int64_t modes, int64_t rank,
                                  bool keep_modes, thrum_precomputed *result, thrum_error *error) {
  thrum_mesh mesh = {0};
  uint8_t *fixed = NULL;
  const thrum_mesh_read_options how = {.scale = 1,
                                       .order = body->order,
                                       .element =
                                           body->shell ? THRUM_ELEMENT_SHELL : THRUM_ELEMENT_TET};
  THRUM_TRY(thrum_mesh_read_with(body->mesh, &how, &mesh, error));
  thrum_status status = thrum_reserve(&fixed, mesh.vertex_count, 1, body->mesh, error);

  // what is held is named in the mesh as it is generated
  for (int n = 0; n < 4 && body->fix[n] != NULL && status >= 0; n++) {
    int64_t count;
    status = thrum_mesh_fix(&mesh, body->fix[n], fixed, &count, error);
  }
  for (int64_t v = 0; body->map != NULL && v < mesh.vertex_count; v++)
    body->map(mesh.vertices + 3 * v);

  // the body is of one material
  if (status >= 0) {
    mesh.materials[0] = body->material;
    thrum_precompute_options options = thrum_default_precompute_options();
    options.modes = modes;
    options.rank = rank;
    options.keep_modes = keep_modes;
    status = thrum_precompute(&mesh, fixed, &options, result, error);
  }

  // the result has copies of what it needs of the mesh
  free(fixed);
  thrum_mesh_free(&mesh);
  return status;
}

double published_frequency_of(const thrum_precomputed *result,
                              void (*field)(const double x[3], double u[3])) {
  const thrum_model *model = &result->model;
  double *weight = calloc((size_t)model->vertex_count, sizeof *weight);
  if (weight == NULL)
    return NAN;

  // the volume about each vertex stands for the mass
  for (int64_t t = 0; t < model->tet_count; t++) {
    const int32_t *v = model->tets + 4 * t;
    double e[3][3];
    thrum_tet_edges(model->vertices, v, e);
    for (int a = 0; a < 4; a++)
      weight[v[a]] += thrum_triple3(e[0], e[1], e[2]);
  }

  // the product of a mode and the field in this mass, relative to both norms, is the share
  double sum = 0, total = 0, whole = 0;
  for (int64_t v = 0; v < model->vertex_count; v++) {
    double u[3];
    field(model->vertices + 3 * v, u);
    whole += weight[v] * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
  }

  // modes of a pair may come as any two of their plane: the mean by shares is of the whole plane
  for (int64_t mode = 0; mode < result->mode_count; mode++) {
    const double *shape = result->mode_vectors + mode * 3 * model->vertex_count;
    double product = 0, square = 0;
    for (int64_t v = 0; v < model->vertex_count; v++) {
      double u[3];
      field(model->vertices + 3 * v, u);
      for (int axis = 0; axis < 3; axis++) {
        product += weight[v] * u[axis] * shape[3 * v + axis];
        square += weight[v] * shape[3 * v + axis] * shape[3 * v + axis];
      }
    }
    const double share = product * product / (square * whole);
    if (share > SHARE_LEAST) {
      sum += share * sqrt(result->mode_omega2[mode]) / THRUM_TWO_PI;
      total += share;
    }
  }
  free(weight);
  return sum / total;
}

void published_add(const published_sink *sink, const char *problem, const char *quantity,
                   const char *mesh, double size, double published, double computed) {
  published_row row = {problem, quantity, "", size, published, computed};
  snprintf(row.mesh, sizeof row.mesh, "%s", mesh);
  sink->row(sink->context, &row);
}

void published_polynomial_make(published_polynomial *p, int64_t rank, const double *omega2) {
  memset(p, 0, sizeof *p);
  memcpy(p->omega2, omega2, (size_t)rank * sizeof *omega2);
  p->model = (thrum_model){.rank = rank,
                           .c3_count = thrum_c3_count(rank),
                           .c4_count = thrum_c4_count(rank),
                           .omega2 = p->omega2,
                           .c3 = p->c3,
                           .c4 = p->c4};
}

void published_polynomial_add(published_polynomial *p, double weight, const double *a) {
  const int64_t r = p->model.rank;
  // every ordered product goes to the one place of its monomial
  for (int64_t n = 0; n < r * r * r * r; n++) {
    int64_t index[4] = {n % r, n / r % r, n / (r * r) % r, n / (r * r * r)};
    const double product = a[index[0]] * a[index[1]] * a[index[2]] * a[index[3]];
    for (int s = 1; s < 4; s++)
      for (int t = s; t > 0 && index[t - 1] > index[t]; t--) {
        const int64_t swap = index[t];
        index[t] = index[t - 1];
        index[t - 1] = swap;
      }
    p->c4[thrum_c4_index(r, index[0], index[1], index[2], index[3])] += weight * product;
  }
}

thrum_status published_state(const thrum_model *model, const thrum_state_def *def, const double *q,
                             const double *p, thrum_state **state, thrum_error *error) {
  THRUM_TRY(thrum_state_create(model, def, state, error));
  const thrum_status status = thrum_state_set(model, *state, q, p, error);
  if (status < 0)
    thrum_state_destroy(*state);
  return status;
}
