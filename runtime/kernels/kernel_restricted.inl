/* The passes of core/polynomial/kernel_private.h with the explicit modes held, in mirrored
 * coordinates (core/polynomial/packed.h), for a file that has included
 * runtime/kernels/kernel_model.inl.
 *
 * With n implicit modes z_0..z_{n-1} the blocks c < n hold all coefficients that remain of V. Their
 * rows d < n are the quartic and cubic terms in these modes; the sum of their other rows gives the
 * terms with one explicit mode. Terms with two and three explicit modes are the rows of the highest
 * modes in the order that is not mirrored.
 * Cost: the restriction 2 operations for each coefficient of a term with an implicit and an
 * explicit mode; the gradient 4, the Hessian 6 for each of a term in the implicit modes alone.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "core/polynomial/kernel_private.h"

/* The linear terms of `rows` implicit modes, rows row.. of each of the first `split` blocks, which
 * meet two explicit modes in their columns and a third, q_c: y[k] = sum_c q_c y_kc. */
INLINE void linear_rows(bool single, int rows, const thrum_model *model, int64_t split, int64_t row,
                        const double *q, const double *m, double *y) {
  const int64_t first = row / THRUM_PACK_ROWS * THRUM_PACK_ROWS;
  packed_block k = packed_first(model);
  v8 total = v8_zero();
  for (int64_t c = 0; c < split; c++) {
    // the rows' sums over the columns of a block
    const int64_t size = thrum_pack_size(k.all, first), end = 8 * k.vectors;
    int64_t at = k.at + 8 * first * k.whole + 8 * (row - first);
    v8x8 sum = rows_zero8();
    for (int64_t v = 0; v < end; v += 8, at += 8 * size)
      sum_rows(single, false, rows, &k.b, at, v8_load(m + v), &sum);

    total = v8_add(total, v8_mul(v8_set1(q[c]), v8_sums_of(rows, &sum)));
    packed_next(model->rank, c + 1, &k);
  }
  v8_store(y, total);
}

/* The linear terms of all n implicit modes, as many at a time as registers hold. */
INLINE void linear_terms(bool single, const thrum_model *model, int64_t split, const double *q,
                         const double *m, double *y) {
  const int64_t n = model->rank - split;
  for (int64_t row = 0; row < n; row += ROWS_MANY)
    switch (n - row < ROWS_MANY ? n - row : ROWS_MANY) {
#define X(k)                                                                                       \
  case k + 1:                                                                                      \
    if (k < ROWS_MANY)                                                                             \
      linear_rows(single, k + 1, model, split, row, q, m, y + row);                                \
    break;
      EACH_8(X)
#undef X
    default:
      break;
    }
}

/* Writes the linear and quadratic terms of the restriction; a quadratic term stands in the column
 * (b,-1) of row c. */
INLINE void restrict_low(bool single, const thrum_model *model, int64_t split,
                         const double *q_given, double *restricted, double *work) {
  // monomials of the held coordinates
  const int64_t rank = model->rank, n = rank - split;
  const pack_scratch t = pack_cut(rank, work);
  double *const *a = t.vectors[0], *q = a[0], *reversed = a[1], *lifted = a[2], *y = a[3];
  spread(rank, split, q_given, 1.0, q, reversed, lifted);
  column_monomials(false, split, q, lifted, q, lifted, t.columns[0][0]);

  // linear terms: rows of two held coordinates
  linear_terms(single, model, split, q, t.columns[0][0], y);
  for (int64_t k = 0; k < thrum_restricted_first(n); k++)
    restricted[k] = k < n ? y[k] : 0.0;

  // in the other rows, only the columns whose coordinates are all held
  const int64_t vectors = (thrum_pack_first(split) + 7) / 8;
  const point p = {t.columns[0][0], NULL, NULL, y};
  packed_block b = packed_first(model);
  for (int64_t c = 0; c < split; c++)
    packed_next(rank, c + 1, &b);
  double *row = restricted + thrum_restricted_count(n);
  for (int64_t c = n - 1; c >= 0; c--) {
    row -= 8 * thrum_pack_vectors(c);
    b.vectors = vectors;
    block_work(single, WORK_SUMS, &b, &p, NULL, NULL);
    for (int64_t d = 0; d <= c; d++)
      row[thrum_pack_first(d)] = y[d] + (d == c ? 0.5 * model->omega2[rank - 1 - c] : 0.0);
    packed_next(rank, rank - c, &b);
  }
}

INLINE void restriction(bool single, const thrum_model *model, int64_t split, const double *q,
                        double *restricted, double *work) {
  const int64_t n = model->rank - split;
  const pack_scratch t = pack_cut(model->rank, work);
  double *z = t.vectors[0][0], *row = restricted + thrum_restricted_first(n);
  spread_mirrored(model->rank, n, q, 1.0, z, t.vectors[0][1]);
  packed_block b = packed_mirrored(model);
  for (int64_t c = 0; c < n; c++) {
    const point p = {NULL, z + c, row, NULL};
    zeros(row, thrum_pack_columns(c));
    b.first = n - c;
    block_work(single, WORK_ADDS, &b, &p, NULL, NULL);
    row += 8 * thrum_pack_vectors(c);
    packed_next(model->rank, c + 1, &b);
  }
  restrict_low(single, model, split, q, restricted, work);
}

PASS void restriction_double(const thrum_model *model, int64_t split, const double *q,
                             double *restricted, double *work) {
  restriction(false, model, split, q, restricted, work);
}

PASS void restriction_single(const thrum_model *model, int64_t split, const double *q,
                             double *restricted, double *work) {
  restriction(true, model, split, q, restricted, work);
}

PASS void pass_restrict(const thrum_model *model, int64_t split, const double *q,
                        double *restricted, double *work) {
  (model->packed_single ? restriction_single : restriction_double)(model, split, q, restricted,
                                                                   work);
}

INLINE void restricted_begin(int64_t n, const double *q, const evaluation *e) {
  spread_mirrored(n, 0, q, 1.0, e->q, e->lifted);
  // rows of block c begin at entry c, so that the last vector of g lies behind n
  zeros(e->g, n + 8);
  zeros(e->h, n + 1);
  zeros(e->w, thrum_pack_first(n));
  column_monomials(false, n, e->q, e->lifted, e->q, e->lifted, e->m);
}

INLINE double restricted_gradient_of(bool single, const thrum_model *model, int64_t split,
                                     const double *restricted, const double *q, double *gradient,
                                     double *work) {
  // coordinates and monomials, and the restriction's own rows
  const int64_t n = model->rank - split;
  const pack_scratch t = pack_cut(n, work);
  const evaluation e = evaluation_of(&t, 0);
  restricted_begin(n, q, &e);
  const point p = {e.m, e.x, e.w, e.y};
  const double *row = restricted + thrum_restricted_first(n);

  // each block of the model with the restriction's own row
  packed_block b = packed_mirrored(model);
  for (int64_t c = 0; c < n; c++) {
    const own_row own = {row, e.q[c], e.more + c};
    const row_end end = {e.q[c], e.q + c, e.g + c};
    row_factors(false, n - c, e.q[c], e.q + c, 0.0, e.q + c, e.x);
    b.rows = n - c;
    v8_store(e.blocks + 8 * c, block_meets(single, WORK_OWN, &b, &p, &end, &own));
    row += 8 * thrum_pack_vectors(c);
    packed_next(model->rank, c + 1, &b);
  }

  // the sums meet the coordinates
  lane_sums(0, n, e.blocks, e.s);
  for (int64_t c = 0; c < n; c++)
    e.s[c] += restricted[c] + e.more[c];

  // columns, then gradient and value
  upper(0, n, e.w, e.q, e.lifted, e.h, t.lanes, e.more);
  for (int64_t k = 0; k < n; k++)
    gradient[n - 1 - k] = (e.g[k] + e.h[k + 1]) + (e.s[k] + e.more[k]);
  return lanes_dot(n, e.q, e.s);
}

PASS double restricted_gradient_double(const thrum_model *model, int64_t split,
                                       const double *restricted, const double *q, double *gradient,
                                       double *work) {
  return restricted_gradient_of(false, model, split, restricted, q, gradient, work);
}

PASS double restricted_gradient_single(const thrum_model *model, int64_t split,
                                       const double *restricted, const double *q, double *gradient,
                                       double *work) {
  return restricted_gradient_of(true, model, split, restricted, q, gradient, work);
}

PASS double pass_restricted_gradient(const thrum_model *model, int64_t split,
                                     const double *restricted, const double *q, double *gradient,
                                     double *work) {
  return (model->packed_single ? restricted_gradient_single : restricted_gradient_double)(
      model, split, restricted, q, gradient, work);
}

/* Reverses the order of entries: from mirrored coordinates and back. */
INLINE void reverse(int64_t count, double *a) {
  for (int64_t k = 0; k < count / 2; k++) {
    const double kept = a[k];
    a[k] = a[count - 1 - k];
    a[count - 1 - k] = kept;
  }
}

PASS void pass_restricted_hessian(const thrum_model *model, int64_t split, const double *restricted,
                                  const double *q, double *hessian, double *work) {
  // coordinates and monomials; a list of columns for each coordinate
  const int64_t n = model->rank - split;
  const pack_scratch t = pack_cut(n, work);
  const evaluation e = evaluation_of(&t, 0);
  double *l = t.columns[1][0], *g = t.vectors[1][0], *s = t.vectors[1][1];
  double *list[THRUM_RANK_MAX];
  restricted_begin(n, q, &e);
  tangent_lists(true, n, t.more, list);
  memset(hessian, 0, (size_t)(n * n) * sizeof *hessian);

  // each block gives its column of the Hessian and its part of the lists
  const double *row = restricted + thrum_restricted_first(n);
  packed_block b = packed_mirrored(model);
  for (int64_t c = 0; c < n; c++) {
    // as pass_tangent; list c gets the state's own row too
    const row_lists rows = {e.q[c], list + c};
    const point p = {e.m, e.q + c, l, e.y};
    memcpy(l, row, (size_t)(8 * thrum_pack_vectors(c)) * sizeof *l);
    b.rows = n - c;
    packed_lists(&b, &p, &rows, NULL);
    block_list_done(thrum_pack_columns(c), e.q[c], l, list[c], e.w);
    for (int64_t d = c; d < n; d++)
      hessian[d * n + c] += e.y[d - c];
    row += 8 * thrum_pack_vectors(c);
    packed_next(model->rank, c + 1, &b);
  }

  // the mixed derivatives by q_d and the columns, as pass_tangent has them
  for (int64_t d = 0; d < n; d++) {
    zeros(g, d + 2);
    upper(0, d + 1, list[d], e.q, e.lifted, g, t.lanes, s);
    for (int64_t k = 0; k <= d; k++)
      hessian[d * n + k] += g[k + 1] + s[k];
  }

  tangent_close(n, e.w, hessian);
  reverse(n * n, hessian);
}
