/* The passes of runtime/batch/batch_kernel.h that give the force on the explicit modes
 * alone; see runtime/kernels/kernel_part.inl. runtime/batch/batch_passes.inl includes this
 * file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/batch/batch_kernel.h"

PASS void pass_force_part(const thrum_model *model, int64_t split, const double *q, double *force,
                          double *energy, double *work) {
  // coordinates and monomials of every state, and the first block of coefficients
  const int64_t n = model->rank, implicit = n - split, plain = thrum_pack_first(implicit) / 8;
  const evaluation e = evaluation_of(n, work);
  evaluation_begin(n, plain, q, &e);
  batch_block k = evaluation_blocks(model, &e);
  k.plain = plain;

  // each block: rows of held coordinates have sums alone, the others hand w to the columns too
  for (int64_t c = 0; c < n; c++) {
    k.z = e.z + c * LANES;
    k.scale = vs_load(k.z);
    if (c < implicit)
      block_sums(&k);
    else
      block_both(&k);

    // the rows' sums meet their own coordinate
    sums8 sum = sums_zero();
    lower_block(n - c, e.y, k.scale, k.z, &sum, e.g + c * LANES);
    vs_store(e.s + c * LANES, sums_total(&sum));
    block_next(n, c + 1, &k);
  }

  // the energy: half of omega^2 q^2, and the polynomial from its row sums
  vs_store(energy, vs_add(quadratic_energy(model, q), dot(n, e.z, e.s)));

  // y is free
  upper(implicit, n, e.w, e.z, e.lifted, e.h, e.y);

  // force of the coordinates that are asked for
  for (int64_t i = 0; i < split; i++)
    vs_store(force + i * LANES, vs_add(linear_force(model, q, i), evaluation_entry(&e, n - 1 - i)));
}

/* Evaluates the same runs of two w, each with the other's coordinates: h adds all of one and then
 * all of the other, and the sums of a run are over both. `parts` is scratch for these sums. */
INLINE void upper_twice(int64_t first, int64_t last, const evaluation *e, const evaluation *d,
                        double *parts) {
  // all sums of the first, whose eight partial sums wait in `parts`
  const int64_t begin = thrum_pack_first(first) * LANES;
  const double *w = e->w + begin;
  double *part = parts;
  for (int64_t b = first; b < last; w += (b + 2) * LANES, part += 8 * LANES, b++) {
    sums8 sum = sums_zero();
    own_columns(b + 2, w, vs_load(d->z + b * LANES), d->lifted, e->h, &sum);
    for (int k = 0; k < 8; k++)
      vs_store(part + k * LANES, sum.s[k]);
  }

  // the sums of the second go on from there
  w = d->w + begin;
  part = parts;
  for (int64_t b = first; b < last; w += (b + 2) * LANES, part += 8 * LANES, b++) {
    sums8 sum;
    for (int k = 0; k < 8; k++)
      sum.s[k] = vs_load(part + k * LANES);
    own_columns(b + 2, w, vs_load(e->z + b * LANES), e->lifted, e->h, &sum);
    vs_store(e->y + b * LANES, sums_total(&sum));
  }
}

PASS void pass_tangent_vector_part(const thrum_model *model, int64_t split, const double *q,
                                   const double *v, double *product, double *work) {
  const int64_t n = model->rank, implicit = n - split, plain = thrum_pack_first(implicit) / 8;

  // every line is the derivative along v of a line of pass_force_part
  const evaluation e = evaluation_of(n, work), d = evaluation_of(n, e.end);
  evaluation_begin(n, plain, q, &e);
  mirror(n, implicit, v, 0.0, d.lifted);
  monomials(true, n, e.lifted, d.lifted, d.m);
  clear(d.w + 8 * plain * LANES, thrum_batch_columns(n) - 8 * plain);

  // blocks from the first coordinate that is asked for; x is scratch for the factors of rows along
  // v
  batch_block k = evaluation_blocks(model, &e);
  k.plain = plain;
  double *x = d.end, *parts = x + n * LANES;
  for (int64_t c = 0; c < n; block_next(n, ++c, &k)) {
    if (c < implicit)
      continue;

    // the block at q
    const double *z = e.z + c * LANES, *z_v = d.z + c * LANES;
    const vs q_c = vs_load(z), v_c = vs_load(z_v);
    k.z = z;
    k.scale = q_c;
    block_both(&k);

    // its derivative along v: the factors q_c v_d + v_c q_d in place of q_c q_d
    for (int64_t t = 0; t < (n - c) * LANES; t += LANES)
      vs_store(x + t, vs_add(vs_mul(q_c, vs_load(z_v + t)), vs_mul(v_c, vs_load(z + t))));
    batch_block along = k;
    along.m = d.m;
    along.z = x;
    along.scale = vs_set1(1.0);
    along.w = d.w;
    along.y = d.y;

    // the columns before it have no part along v
    along.begin = plain;
    along.plain = 0;
    block_both(&along);

    // both meet their coordinates
    sums8 sum = sums_zero();
    lower_block(n - c, e.y, v_c, z_v, &sum, e.g + c * LANES);
    lower_block(n - c, d.y, q_c, z, &sum, e.g + c * LANES);
    vs_store(e.s + c * LANES, sums_total(&sum));
  }

  // columns, then the products that are asked for
  upper_twice(implicit, n, &e, &d, parts);
  for (int64_t i = 0; i < split; i++) {
    const vs linear = vs_mul(vs_set1(model->omega2[i]), vs_load(v + i * LANES));
    vs_store(product + i * LANES, vs_add(linear, evaluation_entry(&e, n - 1 - i)));
  }
}
