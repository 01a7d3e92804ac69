/* The passes of core/polynomial/kernel_private.h over all coefficients of a model, over vectors
 * of 8 lanes, for a file that has included runtime/kernels/kernel_packed.inl.
 *
 * V = sum_{c<=d} q_d q_c y_dc with y_dc = sum_{a<=b<=c} B_dc,ba m_ba; with y held its gradient goes
 * block by block, and w_ba = sum q_d q_c B_dc,ba gives the rest of it.
 * Cost: the bytes of the coefficients, once; 2 (energy), 4 (force), 6 (tangent) or 8 (two forces,
 * tangent times vector) operations each. The tangent of a small model, and that times a vector:
 * see kernel_pairs.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/polynomial/kernel_private.h"

PASS double pass_energy(const thrum_model *model, const double *q_given, double *work) {
  const int64_t n = model->rank;
  const pack_scratch t = pack_cut(n, work);
  double *const *a = t.vectors[0], *q = a[0], *reversed = a[1], *lifted = a[2], *y = a[3],
                *s = a[4];
  double *unused = a[5];

  // the monomials of all columns, once for all blocks
  spread(n, n, q_given, 1.0, q, reversed, lifted);
  zeros(unused, n);
  column_monomials(false, n, q, lifted, q, lifted, t.columns[0][0]);

  // block c gives y_dc for all d; its sum over d is weighted by q_c last
  const point p = {t.columns[0][0], NULL, NULL, y};
  packed_block b = packed_first(model);
  for (int64_t c = 0; c < n; c++) {
    packed_sums(&b, &p, NULL, NULL);
    v8_store(t.lanes + 8 * c, lower_block(n - c, y, 0.0, reversed, v8_zero(), unused));
    packed_next(n, c + 1, &b);
  }

  lane_sums(0, n, t.lanes, s);
  return lanes_dot(n, q, s);
}

/* The arrays of a force evaluation at one point. */
typedef struct evaluation {
  double *q, *reversed, *lifted, *x, *y; /* the point */
  double *g, *s, *h, *more;              /* gradients of y (reversed) and of w (lifted), and sums */
  double *m, *w;
  double *blocks; /* lanes of s */
} evaluation;

INLINE evaluation evaluation_of(const pack_scratch *t, int which) {
  double *const *a = t->vectors[which], *const *c = t->columns[which];
  const evaluation e = {a[0], a[1], a[2], a[3], a[4], a[5],
                        a[6], a[7], a[8], c[0], c[1], t->blocks[which]};
  return e;
}

INLINE void evaluation_begin(int64_t n, const double *q, const evaluation *e) {
  spread(n, n, q, 1.0, e->q, e->reversed, e->lifted);
  zeros(e->g, n);
  zeros(e->h, n + 1);
  zeros(e->w, thrum_pack_first(n));
  column_monomials(false, n, e->q, e->lifted, e->q, e->lifted, e->m);
}

INLINE void evaluation_block(int64_t n, int64_t c, const evaluation *e) {
  v8_store(e->blocks + 8 * c, lower_block(n - c, e->y, e->q[c], e->reversed, v8_zero(), e->g));
}

/* Adds the sums of the blocks and of w to the gradient; returns the value. */
INLINE double evaluation_end(int64_t n, const evaluation *e, double *lanes, double *gradient) {
  lane_sums(0, n, e->blocks, e->s);
  upper(0, n, e->w, e->q, e->lifted, e->h, lanes, e->more);
  for (int64_t i = 0; i < n; i++)
    gradient[i] += (e->g[n - 1 - i] + e->h[i + 1]) + (e->s[i] + e->more[i]);
  return lanes_dot(n, e->q, e->s);
}

INLINE double force_of(bool single, const thrum_model *model, const double *q, double *gradient,
                       double *work) {
  const int64_t n = model->rank;
  const pack_scratch t = pack_cut(n, work);
  const evaluation e = evaluation_of(&t, 0);
  evaluation_begin(n, q, &e);
  const point p = {e.m, e.x, e.w, e.y};
  packed_block b = packed_first(model);
  for (int64_t c = 0; c < n; c++) {
    const row_end end = {e.q[c], e.reversed, e.g};
    row_factors(false, n - c, e.q[c], e.reversed, 0.0, e.reversed, e.x);
    v8_store(e.blocks + 8 * c, block_meets(single, WORK_BOTH, &b, &p, &end, NULL));
    packed_next(n, c + 1, &b);
  }
  return evaluation_end(n, &e, t.lanes, gradient);
}

PASS double force_double(const thrum_model *model, const double *q, double *gradient,
                         double *work) {
  return force_of(false, model, q, gradient, work);
}

PASS double force_single(const thrum_model *model, const double *q, double *gradient,
                         double *work) {
  return force_of(true, model, q, gradient, work);
}

PASS double pass_force(const thrum_model *model, const double *q, double *gradient, double *work) {
  return (model->packed_single ? force_single : force_double)(model, q, gradient, work);
}

PASS void pass_forces(const thrum_model *model, const double *const q[2], double *const gradient[2],
                      double value[2], double *work) {
  // coordinates and monomials of both points
  const int64_t n = model->rank;
  const pack_scratch t = pack_cut(n, work);
  const evaluation e[2] = {evaluation_of(&t, 0), evaluation_of(&t, 1)};
  for (int k = 0; k < 2; k++)
    evaluation_begin(n, q[k], &e[k]);

  // each block is read once and multiplied at both
  const point p[2] = {{e[0].m, e[0].x, e[0].w, e[0].y}, {e[1].m, e[1].x, e[1].w, e[1].y}};
  packed_block b = packed_first(model);
  for (int64_t c = 0; c < n; c++) {
    for (int k = 0; k < 2; k++)
      row_factors(false, n - c, e[k].q[c], e[k].reversed, 0.0, e[k].reversed, e[k].x);
    packed_twice(&b, p, NULL, NULL);
    for (int k = 0; k < 2; k++)
      evaluation_block(n, c, &e[k]);
    packed_next(n, c + 1, &b);
  }

  // the sums become gradient and value
  for (int k = 0; k < 2; k++)
    value[k] = evaluation_end(n, &e[k], t.lanes, gradient[k]);
}

// it needs evaluations
#include "runtime/kernels/kernel_pairs.inl"

PASS void pass_tangent_vector(const thrum_model *model, const double *q, const double *v,
                              double *product, double *work) {
  // small ranks have their products by pairs
  const int64_t n = model->rank;
  if (n <= THRUM_PAIRS_VECTOR_RANK_MOST) {
    tangent_vector_by_pairs(model, q, v, product, work);
    return;
  }

  const pack_scratch t = pack_cut(n, work);

  // every line is the derivative along v of a line of pass_force
  const evaluation e = evaluation_of(&t, 0), d = evaluation_of(&t, 1);
  evaluation_begin(n, q, &e);
  spread(n, n, v, 0.0, d.q, d.reversed, d.lifted);
  zeros(d.w, thrum_pack_first(n));
  column_monomials(true, n, e.q, e.lifted, d.q, d.lifted, d.m);

  // each block at q and along v, whose row sums meet the other's coordinates
  const point p[2] = {{e.m, e.x, e.w, e.y}, {d.m, d.x, d.w, d.y}};
  packed_block b = packed_first(model);
  for (int64_t c = 0; c < n; c++) {
    row_factors(false, n - c, e.q[c], e.reversed, 0.0, e.reversed, e.x);
    row_factors(true, n - c, e.q[c], d.reversed, d.q[c], e.reversed, d.x);
    packed_twice(&b, p, NULL, NULL);
    const v8 sum = lower_block(n - c, e.y, d.q[c], d.reversed, v8_zero(), e.g);
    v8_store(e.blocks + 8 * c, lower_block(n - c, d.y, e.q[c], e.reversed, sum, e.g));
    packed_next(n, c + 1, &b);
  }

  // columns of both, then the product
  lane_sums(0, n, e.blocks, e.s);
  upper_runs(true, 0, n, e.w, d.q, d.lifted, e.h, t.lanes);
  upper_runs(false, 0, n, d.w, e.q, e.lifted, e.h, t.lanes);
  lane_sums(0, n, t.lanes, e.more);
  for (int64_t i = 0; i < n; i++)
    product[i] += (e.g[n - 1 - i] + e.h[i + 1]) + (e.s[i] + e.more[i]);
}

/* The list of every coordinate, one after the other, all zero; in the order of rows. */
INLINE void tangent_lists(bool mirrored, int64_t n, double *at, double **list) {
  for (int64_t e = 0; e < n; e++) {
    list[mirrored ? e : n - 1 - e] = at;
    zeros(at, thrum_pack_columns(e));
    at += 8 * thrum_pack_vectors(e);
  }
}

/* w += q_c l, list += l, l = 0. */
INLINE void block_list_done(int64_t columns, double q_c, double *l, double *list, double *w) {
  const v8 factor = v8_set1(q_c);
  for (int64_t k = 0; k < columns; k += 8) {
    const v8 l_k = v8_load(l + k);
    v8_store(w + k, v8_add(v8_load(w + k), v8_mul(factor, l_k)));
    v8_store(list + k, v8_add(v8_load(list + k), l_k));
    v8_store(l + k, v8_zero());
  }
}

/* hessian = half + half^T, where w is half of its lower triangle too. */
INLINE void tangent_close(int64_t n, const double *w, double *hessian) {
  for (int64_t b = 0; b < n; b++) {
    w++;
    for (int64_t a = 0; a <= b; a++) {
      const double half = hessian[b * n + a] + *w++;
      hessian[b * n + a] = hessian[a * n + b] = half + (a == b ? half : hessian[a * n + b]);
    }
  }
}

PASS double pass_tangent(const thrum_model *model, const double *q, double *gradient,
                         double *hessian, double *work) {
  // small ranks have their products by pairs
  const int64_t n = model->rank;
  if (thrum_pairs_count(n) > 0)
    return tangent_by_pairs(model, q, gradient, hessian, work);

  // coordinates and monomials; a list of columns for each coordinate
  const pack_scratch t = pack_cut(n, work);
  const evaluation e = evaluation_of(&t, 0);
  double *l = t.columns[1][0], *g = t.vectors[1][0], *s = t.vectors[1][1];
  double *list[THRUM_RANK_MAX];
  evaluation_begin(n, q, &e);
  zeros(l, thrum_pack_first(n));
  tangent_lists(false, n, t.more, list);

  // half of it now, half + half^T at the end
  for (int64_t k = 0; k < n * n; k++)
    hessian[k] *= 0.5;

  // each block gives its column of the Hessian and its part of the lists
  const point p = {e.m, e.reversed, l, e.y};
  packed_block b = packed_first(model);
  for (int64_t c = 0; c < n; c++) {
    // y_dc is the coefficient of q_d q_c; list d gets q_c B_dc, list c gets sum_d q_d B_dc
    const row_lists rows = {e.q[c], list};
    packed_lists(&b, &p, &rows, NULL);
    block_list_done(thrum_pack_columns(c), e.q[c], l, list[n - 1 - c], e.w);
    evaluation_block(n, c, &e);
    for (int64_t d = c; d < n; d++)
      hessian[d * n + c] += e.y[n - 1 - d];
    packed_next(n, c + 1, &b);
  }

  // the mixed derivatives by q_d and the columns: the gradient of all that meets q_d
  for (int64_t d = 0; d < n; d++) {
    zeros(g, d + 2);
    upper(0, d + 1, list[n - 1 - d], e.q, e.lifted, g, t.lanes, s);
    for (int64_t k = 0; k <= d; k++)
      hessian[d * n + k] += g[k + 1] + s[k];
  }

  tangent_close(n, e.w, hessian);
  return gradient ? evaluation_end(n, &e, t.lanes, gradient) : 0.0;
}
