/* Measures what of a load a model's basis cannot show, design 10. With u = K^-1 f and
 * u_r = U (U^T K U)^-1 U^T f the static share is |u - u_r|_K / |u|_K, K-orthogonal as U^T K U is
 * diagonal; with f_r = M U U^T f the share of the load is |f - f_r| / |f| in the norm of M^-1.
 * Both are taken of the differences, not as 1 less a ratio, so that small shares keep their digits.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/load_share.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/rigid_modes.h"
#include "precompute/model/model_statics.h"

thrum_status thrum_load_fill(const thrum_model *model, const int32_t *vertices, int64_t count,
                             const double force[3], double *forces, thrum_error *error) {
  if (vertices == NULL)
    count = model->vertex_count;
  for (int64_t n = 0; n < count; n++) {
    const int64_t v = vertices == NULL ? n : vertices[n];
    if (v < 0 || v >= model->vertex_count)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model has vertices 1 to %lld",
                             (long long)model->vertex_count);
    for (int axis = 0; axis < 3; axis++)
      forces[3 * v + axis] += force[axis] / (double)count;
  }
  return THRUM_OK;
}

/* The mass of each vertex of the body behind the model; the caller frees it. */
static thrum_status find_masses(const thrum_model *model, double **mass, thrum_error *error) {
  thrum_model_fem body = {0};
  thrum_status status = thrum_model_fem_create(model, &body, error);
  THRUM_THEN(status, thrum_reserve(mass, model->vertex_count, sizeof **mass, "the loads", error));
  if (status >= 0)
    thrum_fem_vertex_mass(&body.fem, body.kind, *mass);
  thrum_model_fem_free(&body);
  return status;
}

thrum_status thrum_load_fill_gravity(const thrum_model *model, const double acceleration[3],
                                     double *forces, thrum_error *error) {
  double *mass = NULL;
  const thrum_status status = find_masses(model, &mass, error);

  // m g at each vertex
  for (int64_t c = 0; status >= 0 && c < 3 * model->vertex_count; c++)
    forces[c] += mass[c / 3] * acceleration[c % 3];
  free(mass);
  return status;
}

thrum_status thrum_load_fill_spin(const thrum_model *model, const double spin[3], double *forces,
                                  thrum_error *error) {
  double *mass = NULL, centre[3] = {0}, whole = 0;
  const thrum_status status = find_masses(model, &mass, error);
  for (int64_t c = 0; status >= 0 && c < 3 * model->vertex_count; c++) {
    centre[c % 3] += mass[c / 3] * model->vertices[c];
    whole += c % 3 == 0 ? mass[c / 3] : 0;
  }

  // m (|w|^2 d - (w d) w) with d from the centre of mass
  const double square = cblas_ddot(3, spin, 1, spin, 1);
  for (int64_t v = 0; status >= 0 && v < model->vertex_count; v++) {
    double from[3];
    for (int axis = 0; axis < 3; axis++)
      from[axis] = model->vertices[3 * v + axis] - centre[axis] / whole;
    const double along = cblas_ddot(3, spin, 1, from, 1);
    for (int axis = 0; axis < 3; axis++)
      forces[3 * v + axis] += mass[v] * (square * from[axis] - along * spin[axis]);
  }
  free(mass);
  return status;
}

#define NOTHING 1e-12 /* a load of which no more is left acts on held or rigid motion alone */

typedef struct meter {
  const thrum_model *model;
  thrum_model_statics statics;
  thrum_factor *mass;
  double *f, *x, *rest, *work, *q; /* n each; q: rank */
} meter;

static void meter_free(meter *m) {
  thrum_factor_free(m->mass);
  thrum_model_statics_free(&m->statics);
  free(m->f);
}

// the load on the free components, less what moves a free body as a whole; q = U^T f;
// false when nothing is left of it
static bool take_load(meter *m, const double *forces) {
  const thrum_fem *fem = &m->statics.body.fem;
  const int64_t n = fem->free_count, r = m->model->rank;
  thrum_fem_gather(fem, forces, m->f);
  const double whole = cblas_dnrm2((int)n, m->f, 1);
  for (int z = 0; m->statics.rigid && z < THRUM_RIGID_COUNT; z++)
    cblas_daxpy((int)n, -cblas_ddot((int)n, m->statics.rigid + z * n, 1, m->f, 1),
                m->statics.dual + z * n, 1, m->f, 1);
  memset(m->q, 0, sizeof *m->q * (size_t)r);
  for (int64_t i = 0; i < n; i++)
    cblas_daxpy((int)r, m->f[i], m->model->basis + fem->component[i] * r, 1, m->q, 1);
  return cblas_dnrm2((int)n, m->f, 1) > NOTHING * whole;
}

// rest = start - U (q * scale)
static void subtract(const meter *m, const double *start, const double *scale, double *rest) {
  const int64_t r = m->model->rank;
  for (int64_t i = 0; i < m->statics.body.fem.free_count; i++) {
    const double *row = m->model->basis + m->statics.body.fem.component[i] * r;
    rest[i] = start[i];
    for (int64_t j = 0; j < r; j++)
      rest[i] -= row[j] * m->q[j] / (scale ? scale[j] : 1);
  }
}

// sqrt(x^T A x)
static double norm_in(const meter *m, const thrum_sparse *matrix, const double *x) {
  thrum_sparse_product(matrix, x, 1, m->work);
  return sqrt(fmax(0, cblas_ddot((int)matrix->size, x, 1, m->work, 1)));
}

static thrum_status measure(meter *m, const double *forces, thrum_load_share *share,
                            thrum_error *error) {
  if (!take_load(m, forces)) {
    *share = (thrum_load_share){NAN, NAN, NAN};
    return THRUM_OK;
  }

  // the static answer, and what of it the basis cannot show
  THRUM_TRY(thrum_factor_solve(m->statics.factor, m->f, 1, m->x, error));
  share->reach = fabs(m->x[cblas_idamax((int)m->statics.body.fem.free_count, m->x, 1)]);
  subtract(m, m->x, m->model->omega2, m->rest);
  share->statics = norm_in(m, &m->statics.body.stiffness, m->rest) /
                   norm_in(m, &m->statics.body.stiffness, m->x);

  // |f| in the norm of M^-1 is |M^-1 f| in that of M
  THRUM_TRY(thrum_factor_solve(m->mass, m->f, 1, m->x, error));
  subtract(m, m->x, NULL, m->rest);
  share->load =
      norm_in(m, &m->statics.body.mass, m->rest) / norm_in(m, &m->statics.body.mass, m->x);
  return THRUM_OK;
}

thrum_status thrum_load_share_measure(const thrum_model *model, int64_t count, const double *forces,
                                      thrum_load_share *shares, thrum_error *error) {
  if (model->basis == NULL)
    return thrum_error_set(error, THRUM_MISSING, "the model has no basis to measure a load by");

  meter m = {.model = model};
  thrum_status status = thrum_model_statics_create(model, &m.statics, error);
  const int64_t n = m.statics.body.fem.free_count;

  // one block for the vectors of all loads
  THRUM_THEN(status, thrum_reserve(&m.f, 4 * n + model->rank, sizeof *m.f, "the loads", error));
  THRUM_THEN(status, thrum_factor_create(&m.statics.body.mass, &m.mass, error));
  if (status >= 0) {
    m.x = m.f + n;
    m.rest = m.x + n;
    m.work = m.rest + n;
    m.q = m.work + n;
  }

  for (int64_t i = 0; i < count && status >= 0; i++)
    status = measure(&m, forces + i * 3 * model->vertex_count, &shares[i], error);

  meter_free(&m);
  return status;
}
