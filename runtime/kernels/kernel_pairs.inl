/* The tangent of a small model by pairs (core/polynomial/packed.h), and its product with a
 * vector, for a file that has included runtime/kernels/kernel_model.inl. Cost: the bytes of the
 * coefficients by pairs, once, and 4 operations each.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/polynomial/kernel_private.h"

/* y = B m; w is scratch. */
INLINE void pairs_product(const thrum_model *model, const double *m, double *w, double *y) {
  const int64_t n = model->rank, rows = thrum_pairs_rows(n);

  // the upper half of B is read once, for the rows and for the columns
  packed_block b = {.b = {model->packed, NULL},
                    .at = thrum_pairs_at(n),
                    .whole = rows / 8,
                    .vectors = rows / 8,
                    .plain = 1,
                    .all = 8,
                    .rows = 8};

  zeros(w, rows);
  for (int64_t k = 0; k < rows; k += 8) {
    const point p = {m + k, m + k, w + k, y + k};
    packed_both(&b, &p, NULL, NULL);
    b.at += 64 * b.whole;
    b.vectors = --b.whole;
  }

  // the two halves of the symmetric product
  for (int64_t k = 0; k < rows; k += 8)
    v8_store(y + k, v8_add(v8_load(y + k), v8_load(w + k)));
}

/* The first step of both: y = B m at q, in an array of the scratch. */
INLINE double *pairs_at(const thrum_model *model, const double *q, const pack_scratch *t,
                        const evaluation *e) {
  const int64_t n = model->rank;
  double *y = t->columns[1][0];
  spread(n, n, q, 1.0, e->q, e->reversed, e->lifted);
  column_monomials(false, n, e->q, e->lifted, e->q, e->lifted, e->m);
  pairs_product(model, e->m, e->w, y);
  return y;
}

INLINE double tangent_by_pairs(const thrum_model *model, const double *q_given, double *gradient,
                               double *hessian, double *work) {
  // y = B m, the second derivatives in their runs
  const int64_t n = model->rank;
  const pack_scratch t = pack_cut(n, work);
  const evaluation e = evaluation_of(&t, 0);
  const double *y = pairs_at(model, q_given, &t, &e), *run = y + 1;

  // rows of the Hessian from the runs, and their mirror images
  for (int64_t d = 0; d < n; run += d + 2, d++) {
    double *row = hessian + d * n;
    for (int64_t a = 0; a < d; a++)
      row[a] = hessian[a * n + d] = row[a] + run[a];
    row[d] += 2.0 * run[d];
  }

  // the gradient follows from the same y
  if (!gradient)
    return 0.0;
  zeros(e.h, n + 1);
  upper(0, n, y, e.q, e.lifted, e.h, t.lanes, e.more);
  for (int64_t i = 0; i < n; i++)
    gradient[i] += (e.h[i + 1] + e.more[i]) / 3.0;
  return lanes_dot(thrum_pairs_rows(n), e.m, y) / 6.0;
}

/* T v is the gradient of sum y_ba q_b q_a with y held, at v, where v_{-1} = 0. */
INLINE void tangent_vector_by_pairs(const thrum_model *model, const double *q, const double *v,
                                    double *product, double *work) {
  const int64_t n = model->rank;
  const pack_scratch t = pack_cut(n, work);
  const evaluation e = evaluation_of(&t, 0);
  const double *y = pairs_at(model, q, &t, &e);
  spread(n, n, v, 0.0, e.q, e.reversed, e.lifted);
  zeros(e.h, n + 1);
  upper(0, n, y, e.q, e.lifted, e.h, t.lanes, e.more);
  for (int64_t i = 0; i < n; i++)
    product[i] += e.h[i + 1] + e.more[i];
}
