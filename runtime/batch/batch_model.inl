/* The passes of runtime/batch/batch_kernel.h over all coefficients of a model; see
 * runtime/kernels/kernel_model.inl and kernel_pairs.inl. runtime/batch/batch_passes.inl
 * includes this file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/batch/batch_kernel.h"

/* Begins an evaluation at q in the order of the modes; `reversed` (n) gets the modes from the last
 * to the first. */
INLINE void model_begin(int64_t n, const double *q, const evaluation *e, double *reversed) {
  vs_store(e->lifted, vs_set1(1.0));
  for (int64_t i = 0; i < n; i++) {
    const vs q_i = vs_load(q + i * LANES);
    vs_store(e->lifted + (i + 1) * LANES, q_i);
    vs_store(reversed + (n - 1 - i) * LANES, q_i);
  }
  monomials(false, n, e->lifted, e->lifted, e->m);
  clear(e->h, n + 1);
}

PASS void pass_force(const thrum_model *model, const double *q, double *force, double *energy,
                     double *work) {
  const int64_t n = model->rank;
  const evaluation e = evaluation_of(n, work);
  double *reversed = e.end;
  model_begin(n, q, &e, reversed);
  clear(e.w, thrum_batch_columns(n));
  clear(e.g, n);

  // each block: y of its rows, and what they add to w
  batch_block k = block_first(model, false);
  k.m = e.m;
  k.w = e.w;
  k.y = e.y;
  k.z = reversed;
  for (int64_t c = 0; c < n; c++) {
    k.scale = vs_load(e.z + c * LANES);
    block_both(&k);
    sums8 sum = sums_zero();
    lower_block(n - c, e.y, k.scale, reversed, &sum, e.g);
    vs_store(e.s + c * LANES, sums_total(&sum));
    block_next(n, c + 1, &k);
  }

  // y is free
  vs_store(energy, vs_add(quadratic_energy(model, q), dot(n, e.z, e.s)));
  upper(0, n, e.w, e.z, e.lifted, e.h, e.y);
  for (int64_t i = 0; i < n; i++) {
    const int64_t at = i * LANES;
    const vs rows = vs_add(vs_load(e.g + (n - 1 - i) * LANES), vs_load(e.h + at + LANES));
    const vs sums = vs_add(vs_load(e.s + at), vs_load(e.y + at));
    vs_store(force + at, vs_add(linear_force(model, q, i), vs_add(rows, sums)));
  }
}

/* The product of the coefficients by pairs with the monomials, y = B m; w is scratch. */
INLINE void pairs_product(const thrum_model *model, const double *m, double *w, double *y) {
  const int64_t n = model->rank, rows = thrum_pairs_rows(n);
  batch_block k = {.b = {model->packed, NULL},
                   .whole = rows / 8,
                   .vectors = rows / 8,
                   .plain = 1,
                   .all = 8,
                   .rows = 8,
                   .scale = vs_set1(1.0)};
  k.b = packed_at(&k.b, thrum_pairs_at(n));

  // the upper half of B is read once, for the rows and for the columns
  clear(w, rows);
  for (int64_t row = 0; row < rows; row += 8) {
    const int64_t at = row * LANES;
    k.m = k.z = m + at;
    k.w = w + at;
    k.y = y + at;
    block_both(&k);
    k.b = packed_at(&k.b, 64 * k.whole);
    k.vectors = --k.whole;
  }
  for (int64_t at = 0; at < rows * LANES; at += LANES)
    vs_store(y + at, vs_add(vs_load(y + at), vs_load(w + at)));
}

PASS void pass_tangent_pairs(const thrum_model *model, const double *q, double *force,
                             double *energy, double *tangent, double *work) {
  const int64_t n = model->rank, rows = thrum_pairs_rows(n);
  const evaluation e = evaluation_of(n, work);
  double *reversed = e.end, *y = reversed + n * LANES, *w = y + rows * LANES;
  model_begin(n, q, &e, reversed);
  pairs_product(model, e.m, w, y);

  // rows of the tangent from the runs of y, and their mirror images
  clear(tangent, n * n);
  const double *run = y + LANES;
  for (int64_t d = 0; d < n; run += (d + 2) * LANES, d++) {
    for (int64_t a = 0; a < d; a++) {
      const vs entry = vs_add(vs_zero(), vs_load(run + a * LANES));
      vs_store(tangent + (d * n + a) * LANES, entry);
      vs_store(tangent + (a * n + d) * LANES, entry);
    }
    vs_store(tangent + (d * n + d) * LANES,
             vs_add(vs_set1(model->omega2[d]), vs_mul(vs_set1(2.0), vs_load(run + d * LANES))));
  }

  // force and energy follow from the same y
  vs_store(energy, vs_add(quadratic_energy(model, q), vs_div(dot(rows, e.m, y), vs_set1(6.0))));
  upper(0, n, y, e.z, e.lifted, e.h, e.s);
  for (int64_t i = 0; i < n; i++) {
    const int64_t at = i * LANES;
    const vs both = vs_add(vs_load(e.h + at + LANES), vs_load(e.s + at));
    vs_store(force + at, vs_add(linear_force(model, q, i), vs_div(both, vs_set1(3.0))));
  }
}
