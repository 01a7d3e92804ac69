/* What a short load gives, see blow.h. A step from x, v is (M + h^2/4 K) d = h M v + h^2/2 (f - K
 * x), x + d, 2 d/h - v, which keeps the energy but for the work f d: that of all steps is the
 * energy. In the basis both matrices are diagonal. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/blow.h"

#include <cblas.h>
#include <stdlib.h>

#include "platform/allocate.h"
#include "precompute/fem/sparse.h"
#include "precompute/model/model_fem.h"

/* M + a K; the rows of M are among those of K. */
static thrum_status add_matrices(const thrum_model_fem *body, double a, thrum_sparse *sum,
                                 thrum_error *error) {
  const thrum_sparse *k = &body->stiffness, *m = &body->mass;
  THRUM_TRY(thrum_sparse_create(k->size, k->begin[k->size], sum, error));
  for (int64_t c = 0; c < k->size; c++) {
    sum->begin[c + 1] = k->begin[c + 1];
    int64_t at = m->begin[c];
    for (int64_t e = k->begin[c]; e < k->begin[c + 1]; e++) {
      sum->row[e] = k->row[e];
      sum->value[e] = a * k->value[e];
      while (at < m->begin[c + 1] && m->row[at] < k->row[e])
        at++;
      if (at < m->begin[c + 1] && m->row[at] == k->row[e])
        sum->value[e] += m->value[at];
    }
  }
  return THRUM_OK;
}

/* The work of the mesh's steps. x, v, d, kx, mv: n each, the first two zeroed. */
static thrum_status step_mesh(const thrum_model_fem *body, thrum_factor *factor, const double *f,
                              double h, int64_t steps, double *x, double *work,
                              thrum_error *error) {
  const int n = (int)body->fem.free_count;
  double *v = x + n, *d = v + n, *kx = d + n, *mv = kx + n;
  *work = 0;
  for (int64_t s = 0; s < steps; s++) {
    thrum_sparse_product(&body->stiffness, x, 1, kx);
    thrum_sparse_product(&body->mass, v, 1, mv);
    for (int i = 0; i < n; i++)
      d[i] = h * mv[i] + 0.5 * h * h * (f[i] - kx[i]);
    THRUM_TRY(thrum_factor_solve(factor, d, 1, d, error));
    *work += cblas_ddot(n, f, 1, d, 1);
    for (int i = 0; i < n; i++) {
      x[i] += d[i];
      v[i] = 2 * d[i] / h - v[i];
    }
  }
  return THRUM_OK;
}

/* The same of one coordinate of unit mass. */
static double step_mode(double omega2, double f, double h, int64_t steps) {
  double x = 0, v = 0, work = 0;
  for (int64_t s = 0; s < steps; s++) {
    const double d = (h * v + 0.5 * h * h * (f - omega2 * x)) / (1 + 0.25 * h * h * omega2);
    work += f * d;
    x += d;
    v = 2 * d / h - v;
  }
  return work;
}

static double step_basis(const thrum_model *model, const thrum_fem *fem, const double *f, double h,
                         int64_t steps) {
  double work = 0;
  for (int64_t i = 0; i < model->rank; i++) {
    double reduced = 0;
    for (int64_t c = 0; c < fem->free_count; c++)
      reduced += model->basis[fem->component[c] * model->rank + i] * f[c];
    work += step_mode(model->omega2[i], reduced, h, steps);
  }
  return work;
}

thrum_status thrum_blow_measure(const thrum_model *model, const double *forces, double dt,
                                int64_t steps, thrum_blow *blow, thrum_error *error) {
  if (model->basis == NULL || model->rigid != NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no basis to measure a blow by, or nothing holds it");
  thrum_model_fem body = {0};
  thrum_sparse sum = {0};
  thrum_factor *factor = NULL;
  double *f = NULL;
  thrum_blow found = {0};

  // the body, the matrix of its steps, and vectors: f, then x, v, d, K x, M v
  thrum_status status = thrum_model_fem_create(model, &body, error);
  THRUM_THEN(status, add_matrices(&body, 0.25 * dt * dt, &sum, error));
  THRUM_THEN(status, thrum_factor_create(&sum, &factor, error));
  THRUM_THEN(status, thrum_reserve(&f, 6 * body.fem.free_count + 1, sizeof *f, "the blow", error));
  if (status >= 0) {
    thrum_fem_gather(&body.fem, forces, f);
    status = step_mesh(&body, factor, f, dt, steps, f + body.fem.free_count, &found.mesh, error);
    found.basis = step_basis(model, &body.fem, f, dt, steps);
  }

  free(f);
  thrum_factor_free(factor);
  thrum_sparse_free(&sum);
  thrum_model_fem_free(&body);
  if (status >= 0)
    *blow = found;
  return status;
}
