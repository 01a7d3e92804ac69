/* The passes of runtime/batch/batch_kernel.h with the explicit modes held; see
 * runtime/kernels/kernel_restricted.inl. runtime/batch/batch_passes.inl
 * includes this file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "runtime/batch/batch_kernel.h"

INLINE void lift(int64_t n, const double *q, double *lifted) {
  vs_store(lifted, vs_set1(1.0));
  memcpy(lifted + LANES, q, (size_t)(n * LANES) * sizeof *q);
}

/* Writes the linear and quadratic terms of the restriction; a quadratic term stands in the column
 * (b,-1) of row c. */
INLINE void restrict_low(const thrum_model *model, int64_t split, const double *q,
                         double *restricted, double *work) {
  // monomials of the held coordinates, in scratch
  const int64_t rank = model->rank, n = rank - split, columns = thrum_batch_columns(rank);
  double *m = work, *y = m + columns * LANES, *lifted = y + rank * LANES;
  batch_block k = block_first(model, false);
  k.m = m;
  k.y = y;
  lift(split, q, lifted);
  monomials(false, split, lifted, lifted, m);

  // linear terms: rows of two held coordinates
  clear(restricted, thrum_restricted_first(n));
  for (int64_t c = 0; c < split; c++) {
    k.rows = n;
    block_sums(&k);
    const vs q_c = vs_load(q + c * LANES);
    for (int64_t i = 0; i < n * LANES; i += LANES)
      vs_store(restricted + i, vs_add(vs_load(restricted + i), vs_mul(q_c, vs_load(y + i))));
    block_next(rank, c + 1, &k);
  }

  // quadratic terms: rows of one free coordinate, in the columns that are held
  double *row = restricted + thrum_restricted_count(n) * LANES;
  for (int64_t c = n - 1; c >= 0; c--) {
    row -= 8 * thrum_pack_vectors(c) * LANES;
    k.vectors = (thrum_pack_first(split) + 7) / 8;
    block_sums(&k);
    for (int64_t d = 0; d <= c; d++) {
      const vs rest = vs_set1(d == c ? 0.5 * model->omega2[rank - 1 - c] : 0.0);
      vs_store(row + thrum_pack_first(d) * LANES, vs_add(vs_load(y + d * LANES), rest));
    }
    block_next(rank, rank - c, &k);
  }
}

PASS void pass_restrict(const thrum_model *model, int64_t split, const double *q,
                        double *restricted, double *work) {
  const int64_t rank = model->rank, n = rank - split;
  double *z = work, *row = restricted + thrum_restricted_first(n) * LANES;
  for (int64_t d = n; d < rank; d++)
    vs_store(z + d * LANES, vs_load(q + (rank - 1 - d) * LANES));
  batch_block k = block_first(model, true);
  for (int64_t c = 0; c < n; c++) {
    k.first = n - c;
    k.z = z + c * LANES;
    k.w = row;
    block_adds(&k);
    row += 8 * thrum_pack_vectors(c) * LANES;
    block_next(rank, c + 1, &k);
  }
  restrict_low(model, split, q, restricted, work);
}

PASS void pass_restricted_gradient(const thrum_model *model, int64_t split,
                                   const double *restricted, const double *q, double *gradient,
                                   double *value, double *work) {
  // coordinates and monomials, the restriction's own rows, and the model's blocks
  const int64_t n = model->rank - split;
  const evaluation e = evaluation_of(n, work);
  evaluation_begin(n, 0, q, &e);
  const double *row = restricted + thrum_restricted_first(n) * LANES;
  batch_block k = evaluation_blocks(model, &e);
  k.own_y = e.end;

  // each block with the restriction's own row of it
  for (int64_t c = 0; c < n; c++) {
    k.rows = n - c;
    k.z = e.z + c * LANES;
    k.scale = vs_load(k.z);
    k.own = row;
    block_own(&k);

    // the rows' sums meet their own coordinate
    const vs own = vs_add(vs_load(restricted + c * LANES), vs_load(k.own_y));
    sums8 sum = sums_zero();
    lower_block(n - c, e.y, k.scale, k.z, &sum, e.g + c * LANES);
    vs_store(e.s + c * LANES, vs_add(own, sums_total(&sum)));
    row += 8 * thrum_pack_vectors(c) * LANES;
    block_next(model->rank, c + 1, &k);
  }

  // columns, then the gradient and the value
  upper(0, n, e.w, e.z, e.lifted, e.h, e.y);
  for (int64_t i = 0; i < n; i++)
    vs_store(gradient + i * LANES, evaluation_entry(&e, n - 1 - i));
  vs_store(value, dot(n, e.z, e.s));
}

/* Writes hessian in the order of the modes, from its lower triangle in the mirrored order and w. */
INLINE void hessian_close(int64_t n, const double *lower, const double *w, double *hessian) {
  for (int64_t b = 0; b < n; b++) {
    w += LANES;
    for (int64_t a = 0; a <= b; a++, w += LANES) {
      const vs half = vs_add(vs_load(lower + (b * n + a) * LANES), vs_load(w));
      const vs entry = vs_add(half, a == b ? half : vs_zero());
      vs_store(hessian + (n * n - 1 - (b * n + a)) * LANES, entry);
      vs_store(hessian + (n * n - 1 - (a * n + b)) * LANES, entry);
    }
  }
}

/* Adds to the entries a <= d of `lower` the gradient of the factor of z_d, which the list holds. */
INLINE void hessian_row(int64_t d, const double *list, const evaluation *e, double *lower) {
  clear(e->h, d + 2);
  upper(0, d + 1, list, e->z, e->lifted, e->h, e->s);
  for (int64_t a = 0; a <= d * LANES; a += LANES) {
    const vs more = vs_add(vs_load(e->h + a + LANES), vs_load(e->s + a));
    vs_store(lower + a, vs_add(vs_load(lower + a), more));
  }
}

PASS void pass_restricted_hessian(const thrum_model *model, int64_t split, const double *restricted,
                                  const double *q, double *hessian, double *work) {
  // coordinates and monomials
  const int64_t n = model->rank - split;
  const evaluation e = evaluation_of(n, work);
  evaluation_begin(n, 0, q, &e);

  // scratch: the factors of z_c, a list of them, and the coefficients y_dc below the diagonal
  const int64_t spare = thrum_batch_columns(n) * LANES;
  double *l = e.end, *list = l + spare, *lower = list + spare;
  const double *own = restricted + thrum_restricted_first(n) * LANES;
  packed blocks[THRUM_RANK_MAX];
  block_row rows[THRUM_RANK_MAX];
  batch_block k = evaluation_blocks(model, &e);
  k.w = l;

  // each block gives its column of coefficients, then its row of the Hessian
  for (int64_t c = 0; c < n; c++) {
    // y_dc is the coefficient of z_d z_c; l holds the other factors of z_c
    const int64_t columns = 8 * thrum_pack_vectors(c) * LANES;
    k.rows = n - c;
    k.z = e.z + c * LANES;
    k.own = own;
    block_over(&k);
    for (int64_t d = c; d < n; d++)
      vs_store(lower + (d * n + c) * LANES, vs_load(e.y + (d - c) * LANES));
    blocks[c] = k.b;

    // what meets z_c in the blocks before it
    for (int64_t b = 0; b <= c; b++)
      rows[b] = row_of(&blocks[b], b, model->rank - b, c - b);
    list_of(c + 1, rows, e.z, l, list, e.w);
    hessian_row(c, list, &e, lower + c * n * LANES);
    own += columns;
    block_next(model->rank, c + 1, &k);
  }

  hessian_close(n, lower, e.w, hessian);
}
