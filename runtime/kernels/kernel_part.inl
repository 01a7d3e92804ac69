/* The passes of core/polynomial/kernel_private.h that give the force on the explicit modes
 * alone, in mirrored coordinates (core/polynomial/packed.h), for a file that has included
 * runtime/kernels/kernel_model.inl.
 *
 * With k implicit modes z_0..z_{k-1} before the explicit ones, a block c < k is needed for its y
 * alone, because no component of its gradient by c and by its columns is explicit. In the other
 * blocks the columns of runs b < k are needed for y alone.
 * Cost: for each coefficient 2 operations (force), of a term with three explicit modes 4; for each
 * of a term with two explicit modes 2 (tangent times vector), with three 8.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/polynomial/kernel_private.h"

INLINE void part_begin(int64_t n, int64_t plain, const evaluation *e) {
  zeros(e->g, n + 8);
  zeros(e->h, n + 1);
  zeros(e->w + 8 * plain, thrum_pack_first(n) - 8 * plain);
}

INLINE double part_of(bool single, const thrum_model *model, int64_t split, const double *q,
                      double *gradient, double *work) {
  // mirrored coordinates, so that those asked for come last, and monomials
  const int64_t n = model->rank, k = n - split, plain = thrum_pack_first(k) / 8;
  const pack_scratch t = pack_cut(n, work);
  const evaluation e = evaluation_of(&t, 0);
  spread_mirrored(n, 0, q, 1.0, e.q, e.lifted);
  part_begin(n, plain, &e);
  column_monomials(false, n, e.q, e.lifted, e.q, e.lifted, e.m);

  // each block, whose rows' sums meet their own coordinate: rows of held ones have sums alone
  const point p = {e.m, e.x, e.w, e.y};
  packed_block b = packed_mirrored(model);
  for (int64_t c = 0; c < n; c++) {
    const row_end end = {e.q[c], e.q + c, e.g + c};
    v8 sum;
    if (c < k) {
      sum = block_meets(single, WORK_SUMS, &b, &p, &end, NULL);
    } else {
      row_factors(false, n - c, e.q[c], e.q + c, 0.0, e.q + c, e.x);
      b.plain = plain;
      sum = block_meets(single, WORK_BOTH, &b, &p, &end, NULL);
    }
    v8_store(e.blocks + 8 * c, sum);
    packed_next(n, c + 1, &b);
  }

  // columns, then the gradient that is asked for
  lane_sums(0, n, e.blocks, e.s);
  upper(k, n, e.w, e.q, e.lifted, e.h, t.lanes, e.more);
  for (int64_t i = k; i < n; i++)
    gradient[n - 1 - i] += (e.g[i] + e.h[i + 1]) + (e.s[i] + e.more[i]);
  return lanes_dot(n, e.q, e.s);
}

PASS double part_double(const thrum_model *model, int64_t split, const double *q, double *gradient,
                        double *work) {
  return part_of(false, model, split, q, gradient, work);
}

PASS double part_single(const thrum_model *model, int64_t split, const double *q, double *gradient,
                        double *work) {
  return part_of(true, model, split, q, gradient, work);
}

PASS double pass_force_part(const thrum_model *model, int64_t split, const double *q,
                            double *gradient, double *work) {
  return (model->packed_single ? part_single : part_double)(model, split, q, gradient, work);
}

PASS void pass_tangent_vector_part(const thrum_model *model, int64_t split, const double *q,
                                   const double *v, double *product, double *work) {
  const int64_t n = model->rank, k = n - split, plain = thrum_pack_first(k) / 8;
  const pack_scratch t = pack_cut(n, work);

  // every line is the derivative along v of a line of pass_force_part
  const evaluation e = evaluation_of(&t, 0), d = evaluation_of(&t, 1);
  spread_mirrored(n, 0, q, 1.0, e.q, e.lifted);
  spread_mirrored(n, k, v, 0.0, d.q, d.lifted);
  part_begin(n, plain, &e);
  zeros(d.w + 8 * plain, thrum_pack_first(n) - 8 * plain);
  column_monomials(false, n, e.q, e.lifted, e.q, e.lifted, e.m);
  column_monomials(true, n, e.q, e.lifted, d.q, d.lifted, d.m);

  // each block that is asked for, at q and along v
  const point p[2] = {{e.m, e.x, e.w, e.y}, {d.m, d.x, d.w, d.y}};
  packed_block b = packed_mirrored(model);
  for (int64_t c = 0; c < n; packed_next(n, ++c, &b)) {
    if (c < k)
      continue;
    row_factors(false, n - c, e.q[c], e.q + c, 0.0, e.q + c, e.x);
    row_factors(true, n - c, e.q[c], d.q + c, d.q[c], e.q + c, d.x);
    b.plain = plain;
    packed_twice(&b, p, NULL, NULL);

    // row sums of one meet the coordinates of the other
    const v8 sum = lower_block(n - c, e.y, d.q[c], d.q + c, v8_zero(), e.g + c);
    v8_store(e.blocks + 8 * c, lower_block(n - c, d.y, e.q[c], e.q + c, sum, e.g + c));
  }

  // columns of both, then the product that is asked for
  lane_sums(k, n, e.blocks, e.s);
  upper_runs(true, k, n, e.w, d.q, d.lifted, e.h, t.lanes);
  upper_runs(false, k, n, d.w, e.q, e.lifted, e.h, t.lanes);
  lane_sums(k, n, t.lanes, e.more);
  for (int64_t i = k; i < n; i++)
    product[n - 1 - i] += (e.g[i] + e.h[i + 1]) + (e.s[i] + e.more[i]);
}
