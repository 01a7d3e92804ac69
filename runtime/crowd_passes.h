/* The passes of runtime/crowd.h, for a file that has defined
 *
 *   vs                  a number of each of LANES states
 *   LANES, ROWS         states; rows of a block taken at once, 1 to 3
 *   INLINE, PASS        as for runtime/kernel_lanes.h
 *   vs_zero, vs_set1(s), vs_load(p), vs_store(p, a), vs_mul(a, b), vs_add(a, b)
 *
 * A sum over columns has eight partial sums, column mod 8, as runtime/kernel.h says; here they are
 * eight registers, and no sum is taken across one. The passes over a whole model read it packed
 * (runtime/pack.h).
 * Cost: for each coefficient and LANES states 4 operations (force), 2 (restrict_to).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "crowd.h"
#include "pack.h"

#define EACH_COLUMN(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7)

/* The eight partial sums of a row. */
typedef struct sums8 {
  vs s[8];
} sums8;

INLINE sums8 sums_zero(void) {
  sums8 y;
#define X(c) y.s[c] = vs_zero();
  EACH_COLUMN(X)
#undef X
  return y;
}

INLINE vs sums_total(const sums8 *y) {
  return vs_add(vs_add(vs_add(y->s[0], y->s[4]), vs_add(y->s[2], y->s[6])),
                vs_add(vs_add(y->s[1], y->s[5]), vs_add(y->s[3], y->s[7])));
}

/* Coefficients either are shared, a number each, or every state has its own. */
INLINE vs coefficient(bool own, const double *b, int64_t c) {
  return own ? vs_load(b + c * LANES) : vs_set1(b[c]);
}

/* What rows meet: columns m and their results w; a number x for each row. */
typedef struct rows3 {
  const double *b[3]; /* by absolute column */
  vs x[3];
} rows3;

/* One column c, of partial sum s: y_r += b_r m_c and w_c += x_r b_r, r ascending. */
INLINE void column(int rows, bool own, bool sums, int s, const rows3 *r, int64_t c, const double *m,
                   double *w, sums8 *y) {
  const vs m_c = sums ? vs_load(m + c * LANES) : vs_zero();
  vs w_c = vs_load(w + c * LANES);
  for (int n = 0; n < rows; n++) {
    const vs b = coefficient(own, r->b[n], c);
    if (sums)
      y[n].s[s] = vs_add(y[n].s[s], vs_mul(b, m_c));
    w_c = vs_add(w_c, vs_mul(r->x[n], b));
  }
  vs_store(w + c * LANES, w_c);
}

/* The columns lo..hi-1 of up to three rows. */
INLINE void sweep(int rows, bool own, bool sums, const rows3 *r, int64_t lo, int64_t hi,
                  const double *m, double *w, sums8 *y) {
  int64_t c = lo / 8 * 8;
#define X(s)                                                                                       \
  if (c + s >= lo && c + s < hi)                                                                   \
    column(rows, own, sums, s, r, c + s, m, w, y);
  if (c < lo) {
    EACH_COLUMN(X)
    c += 8;
  }
#undef X
#define X(s) column(rows, own, sums, s, r, c + s, m, w, y);
  for (; c + 8 <= hi; c += 8) {
    EACH_COLUMN(X)
  }
#undef X
#define X(s)                                                                                       \
  if (c + s < hi)                                                                                  \
    column(rows, own, sums, s, r, c + s, m, w, y);
  if (c < hi) {
    EACH_COLUMN(X)
  }
#undef X
}

/* A form in n coordinates as thrum_form, its cubic part shared or every state's own. */
typedef struct crowd_form {
  int64_t n, skip;
  const double *c3, *c4;
  bool own_cubic;
} crowd_form;

/* Rows i, i+1, .. of block j: y_ij, and g and w get their transposed products. */
INLINE void form_rows(int rows, bool own, int64_t n, int64_t j, int64_t i, const double *c3,
                      const double *c4, const double *q, const double *m, double *g, double *w,
                      double *y) {
  const int64_t pairs = thrum_pair_count(n), columns = thrum_pair_count(n - j);
  const int64_t first = pairs - columns, width = own ? LANES : 1;
  const vs q_j = vs_load(q + j * LANES);
  sums8 sum[ROWS];
  rows3 cubic, quartic;
  for (int k = 0; k < rows; k++) {
    sum[k] = sums_zero();
    cubic.x[k] = quartic.x[k] = vs_mul(vs_load(q + (i + k) * LANES), q_j);
    cubic.b[k] = c3 + ((i + k) * (n - j) - j) * width;
    quartic.b[k] = c4 + (i + k) * columns - first;
  }
  sweep(rows, own, true, &cubic, j, n, q, g, sum);
  sweep(rows, false, true, &quartic, first, pairs, m, w, sum);
  for (int k = 0; k < rows; k++)
    vs_store(y + k * LANES, sums_total(&sum[k]));
}

/* The pair gradient of w over rows 0..last-1: g_l += q_k w_kl, s_k = sum_l w_kl q_l. */
INLINE void upper_pairs(int64_t n, int64_t last, const double *w, const double *q, double *g,
                        double *s) {
  for (int64_t k = 0; k < last; k++) {
    sums8 y = sums_zero();
    rows3 row;
    row.b[0] = w - k * LANES;
    row.x[0] = vs_load(q + k * LANES);
    sweep(1, true, true, &row, k, n, q, g, &y);
    vs_store(s + k * LANES, sums_total(&y));
    w += (n - k) * LANES;
  }
}

INLINE void lower_pairs(int64_t n, const double *y, const double *q, double *g, double *s) {
  for (int64_t j = 0; j < n; j++) {
    sums8 sum = sums_zero();
    rows3 row;
    row.b[0] = y;
    row.x[0] = vs_load(q + j * LANES);
    sweep(1, true, true, &row, 0, j + 1, q, g, &sum);
    vs_store(s + j * LANES, sums_total(&sum));
    y += (j + 1) * LANES;
  }
}

INLINE vs dot(int64_t n, const double *a, const double *b) {
  sums8 y = sums_zero();
#define X(k)                                                                                       \
  if (c + k < n)                                                                                   \
    y.s[k] = vs_add(y.s[k], vs_mul(vs_load(a + (c + k) * LANES), vs_load(b + (c + k) * LANES)));
  for (int64_t c = 0; c < n; c += 8) {
    EACH_COLUMN(X)
  }
#undef X
  return sums_total(&y);
}

INLINE void clear(double *a, int64_t count) {
  memset(a, 0, (size_t)(count * LANES) * sizeof *a);
}

/* gradient += grad of the form at q; returns its value. */
INLINE vs form_gradient(bool own, const crowd_form *f, const double *q, double *gradient,
                        double *work) {
  const int64_t n = f->n, pairs = thrum_pair_count(n);
  double *m = work, *w = m + pairs * LANES, *y = w + pairs * LANES, *g = y + pairs * LANES;
  double *sums = g + n * LANES, *more = sums + n * LANES;
  const double *c3 = f->c3, *c4 = f->c4;
  double *to = m;
  for (int64_t k = 0; k < n; k++)
    for (int64_t l = k; l < n; l++, to += LANES)
      vs_store(to, vs_mul(vs_load(q + k * LANES), vs_load(q + l * LANES)));
  clear(w, pairs);
  clear(g, n);
  to = y;
  for (int64_t j = 0; j < n; j++) {
    const int64_t columns = thrum_pair_count(n - j);
    int64_t i = 0;
    c4 += f->skip * columns;
    for (; i + ROWS <= j + 1; i += ROWS)
      form_rows(ROWS, own, n, j, i, c3, c4, q, m, g, w, to + i * LANES);
    for (; i <= j; i++)
      form_rows(1, own, n, j, i, c3, c4, q, m, g, w, to + i * LANES);
    to += (j + 1) * LANES;
    c3 += (j + 1) * (n - j) * (own ? LANES : 1);
    c4 += (j + 1) * columns;
  }
  lower_pairs(n, y, q, g, sums);
  upper_pairs(n, n, w, q, g, more);
  for (int64_t c = 0; c < n * LANES; c += LANES)
    vs_store(gradient + c,
             vs_add(vs_load(gradient + c),
                    vs_add(vs_load(g + c), vs_add(vs_load(sums + c), vs_load(more + c)))));
  return dot(n, q, sums);
}

/* Packed coefficients from `at` on, in one of two precisions. */
typedef struct packed {
  const double *d;
  const float *f;
} packed;

INLINE packed packed_at(const packed *b, int64_t at) {
  const packed here = {b->d ? b->d + at : NULL, b->f ? b->f + at : NULL};
  return here;
}

INLINE vs packed_one(bool single, const packed *b, int64_t at) {
  return vs_set1(single ? (double)b->f[at] : b->d[at]);
}

/* `rows` rows of a group of `size`, over vectors of 8 columns: their sums with m, and w += B^T x.
 */
INLINE void group_rows(bool single, bool adds, int rows, const packed *b, int64_t size,
                       int64_t vectors, const vs *x, const double *m, double *w, sums8 *y) {
  int64_t at = 0;
  for (int64_t v = 0; v < vectors; v++, at += 8 * size, m += 8 * LANES, w += adds ? 8 * LANES : 0) {
#define X(p)                                                                                       \
  {                                                                                                \
    const vs m_c = vs_load(m + p * LANES);                                                         \
    vs w_c = adds ? vs_load(w + p * LANES) : m_c;                                                  \
    for (int k = 0; k < rows; k++) {                                                               \
      const vs b_c = packed_one(single, b, at + 8 * k + p);                                        \
      y[k].s[p] = vs_add(y[k].s[p], vs_mul(b_c, m_c));                                             \
      if (adds)                                                                                    \
        w_c = vs_add(w_c, vs_mul(x[k], b_c));                                                      \
    }                                                                                              \
    if (adds)                                                                                      \
      vs_store(w + p * LANES, w_c);                                                                \
  }
    EACH_COLUMN(X)
#undef X
  }
}

INLINE void group_sums(bool single, bool adds, int rows, const packed *b, int64_t size,
                       int64_t vectors, const vs *x, const double *m, double *w, double *y) {
  sums8 sum[ROWS];
  for (int k = 0; k < rows; k++)
    sum[k] = sums_zero();
  group_rows(single, adds, rows, b, size, vectors, x, m, w, sum);
  for (int k = 0; k < rows; k++)
    vs_store(y + k * LANES, sums_total(&sum[k]));
}

/* The first `wanted` of the rows of a block at b, whose vectors are `whole` apart and of which the
 * first `vectors` count: y by row; w += B^T x with x_d = q_c q_d if `adds`. */
INLINE void block_rows(bool single, bool adds, int64_t n, int64_t c, int64_t wanted,
                       const packed *b, int64_t whole, int64_t vectors, const double *q,
                       const double *m, double *w, double *y) {
  const vs q_c = vs_load(q + c * LANES);
  for (int64_t first = 0; first < wanted; first += THRUM_PACK_ROWS) {
    const int64_t size = thrum_pack_size(n - c, first);
    const int64_t last = size < wanted - first ? size : wanted - first;
    for (int64_t r = 0; r < last;) {
      const packed here = packed_at(b, 8 * (first * whole + r));
      const int taken = last - r >= ROWS ? ROWS : 1;
      vs x[ROWS];
      for (int k = 0; k < taken; k++)
        x[k] = vs_mul(q_c, vs_load(q + (n - 1 - first - r - k) * LANES));
      if (taken == ROWS)
        group_sums(single, adds, ROWS, &here, size, vectors, x, m, w, y + (first + r) * LANES);
      else
        group_sums(single, adds, 1, &here, size, vectors, x, m, w, y + (first + r) * LANES);
      r += taken;
    }
  }
}

#define BLOCK_PASS(name, adds)                                                                     \
  PASS void name(int64_t n, int64_t c, int64_t wanted, const packed *b, int64_t whole,             \
                 int64_t vectors, const double *q, const double *m, double *w, double *y) {        \
    if (b->f)                                                                                      \
      block_rows(true, adds, n, c, wanted, b, whole, vectors, q, m, w, y);                         \
    else                                                                                           \
      block_rows(false, adds, n, c, wanted, b, whole, vectors, q, m, w, y);                        \
  }

BLOCK_PASS(block_both, true)
BLOCK_PASS(block_sums, false)

/* m_ba = q_b q_a over the runs below `last`, zeros up to the end of the vector; q with 1 before it.
 */
INLINE void monomials(int64_t last, const double *lifted, double *m) {
  for (int64_t b = 0; b < last; b++)
    for (int64_t a = 0; a < b + 2; a++, m += LANES)
      vs_store(m, vs_mul(vs_load(lifted + (b + 1) * LANES), vs_load(lifted + a * LANES)));
  for (int k = 0; k < 8; k++)
    vs_store(m + k * LANES, vs_zero());
}

INLINE void lift(int64_t n, const double *q, double *lifted) {
  vs_store(lifted, vs_set1(1.0));
  memcpy(lifted + LANES, q, (size_t)(n * LANES) * sizeof *q);
}

/* g_d += q_c y_d over the rows of block c; returns sum_d y_d q_d. */
INLINE vs lower_block(int64_t n, int64_t c, const double *y, const double *q, double *g) {
  const vs q_c = vs_load(q + c * LANES);
  sums8 sum = sums_zero();
  for (int64_t t = 0; t < n - c; t += 8) {
#define X(k)                                                                                       \
  if (t + k < n - c) {                                                                             \
    const int64_t d = (n - 1 - t - k) * LANES;                                                     \
    const vs y_d = vs_load(y + (t + k) * LANES);                                                   \
    vs_store(g + d, vs_add(vs_load(g + d), vs_mul(q_c, y_d)));                                     \
    sum.s[k] = vs_add(sum.s[k], vs_mul(y_d, vs_load(q + d)));                                      \
  }
    EACH_COLUMN(X)
#undef X
  }
  return sums_total(&sum);
}

PASS void pass_force(const thrum_model *model, const double *q, double *force, double *energy,
                     double *work) {
  const int64_t n = model->rank, columns = thrum_crowd_columns(n);
  double *m = work, *w = m + columns * LANES, *y = w + columns * LANES, *g = y + n * LANES;
  double *s = g + n * LANES, *h = s + n * LANES, *lifted = h + (n + 1) * LANES;
  packed b = {model->packed, model->packed_single};
  lift(n, q, lifted);
  monomials(n, lifted, m);
  clear(w, columns);
  clear(g, n);
  clear(h, n + 1);
  for (int64_t c = 0; c < n; c++) {
    const int64_t vectors = thrum_pack_vectors(c);
    block_both(n, c, n - c, &b, vectors, vectors, q, m, w, y);
    vs_store(s + c * LANES, lower_block(n, c, y, q, g));
    b = packed_at(&b, 8 * (n - c) * vectors);
  }
  const vs value = dot(n, q, s);
  vs quadratic = vs_zero();
  for (int64_t i = 0; i < n; i++) {
    const vs q_i = vs_load(q + i * LANES);
    quadratic = vs_add(quadratic, vs_mul(vs_mul(vs_set1(0.5 * model->omega2[i]), q_i), q_i));
  }
  vs_store(energy, vs_add(quadratic, value));
  // y is free: the sums of w's gradient
  const double *run = w;
  for (int64_t k = 0; k < n; run += (k + 2) * LANES, k++) {
    sums8 sum = sums_zero();
    rows3 row;
    row.b[0] = run;
    row.x[0] = vs_load(q + k * LANES);
    sweep(1, true, true, &row, 0, k + 2, lifted, h, &sum);
    vs_store(y + k * LANES, sums_total(&sum));
  }
  for (int64_t i = 0; i < n; i++) {
    const int64_t at = i * LANES;
    const vs linear = vs_mul(vs_set1(model->omega2[i]), vs_load(q + at));
    const vs direct = vs_add(vs_load(g + at), vs_load(h + at + LANES));
    vs_store(force + at, vs_add(linear, vs_add(direct, vs_add(vs_load(s + at), vs_load(y + at)))));
  }
}

/* w += sum_a q_a (row a of a shared matrix) over `rows` rows of so many columns. */
INLINE void add_rows(int64_t rows, const double *b, int64_t stride, int64_t columns,
                     const double *q, double *w) {
  for (int64_t a = 0; a < rows;) {
    rows3 r;
    const int taken = rows - a >= 3 ? 3 : 1;
    for (int k = 0; k < taken; k++) {
      r.x[k] = vs_load(q + (a + k) * LANES);
      r.b[k] = b + (a + k) * stride;
    }
    if (taken == 3)
      sweep(3, false, false, &r, 0, columns, w, w, NULL);
    else
      sweep(1, false, false, &r, 0, columns, w, w, NULL);
    a += taken;
  }
}

/* The cubic part of V with the first `split` coordinates held: c3, and the rows a < split of c4. */
INLINE void restrict_cubic(const thrum_model *model, int64_t split, const double *q, double *cubic,
                           double *t) {
  const int64_t n = model->rank - split;
  const double *c3 = model->c3 + thrum_c3_index(model->rank, 0, split, split);
  const double *c4 = model->c4 + thrum_c4_index(model->rank, 0, split, split, split);
  double *kept = cubic;
  for (int64_t j = 0; j < n; j++) {
    const int64_t size = (j + 1) * (n - j);
    c3 += split * (n - j);
    for (int64_t c = 0; c < size; c++, kept += LANES)
      vs_store(kept, vs_set1(c3[c]));
    c3 += size;
  }
  for (int64_t i = 0; i < n; i++) {
    const int64_t columns = thrum_pair_count(n - i);
    clear(t, columns);
    add_rows(split, c4, columns, columns, q, t);
    c4 += (split + i + 1) * columns;
    // c4_aijk belongs to row i of block j of the cubic part
    const double *from = t;
    double *to = cubic;
    for (int64_t j = 0; j < n; j++) {
      double *row = to + i * (n - j) * LANES;
      for (int64_t k = 0; j >= i && k < n - j; k++, from += LANES, row += LANES)
        vs_store(row, vs_add(vs_load(row), vs_load(from)));
      to += (j + 1) * (n - j) * LANES;
    }
  }
}

PASS void pass_restrict(const thrum_model *model, int64_t split, const double *q,
                        double *restricted, double *work) {
  const int64_t rank = model->rank, n = rank - split, columns = thrum_crowd_columns(rank);
  double *m = work, *t = m + columns * LANES, *y = t + columns * LANES;
  double *lifted = y + rank * LANES, *g = lifted + (rank + 1) * LANES;
  double *quadratic = restricted + n * LANES;
  packed b = {model->packed, model->packed_single};
  lift(split, q, lifted);
  monomials(split, lifted, m);
  clear(g, rank);
  for (int64_t c = 0; c < split; c++) {
    const int64_t vectors = thrum_pack_vectors(c);
    block_sums(rank, c, n, &b, vectors, vectors, q, m, NULL, y);
    const vs q_c = vs_load(q + c * LANES);
    for (int64_t k = 0; k < n; k++) {
      double *to = g + (rank - 1 - k) * LANES;
      vs_store(to, vs_add(vs_load(to), vs_mul(q_c, vs_load(y + k * LANES))));
    }
    b = packed_at(&b, 8 * (rank - c) * vectors);
  }
  memcpy(restricted, g + split * LANES, (size_t)(n * LANES) * sizeof *restricted);
  const int64_t held = (thrum_pack_first(split) + 7) / 8;
  for (int64_t c = split; c < rank; c++) {
    const int64_t vectors = thrum_pack_vectors(c);
    block_sums(rank, c, rank - c, &b, vectors, held, q, m, NULL, y);
    for (int64_t d = c; d < rank; d++, quadratic += LANES) {
      const vs rest = vs_set1(d == c ? 0.5 * model->omega2[c] : 0.0);
      vs_store(quadratic, vs_add(vs_load(y + (rank - 1 - d) * LANES), rest));
    }
    b = packed_at(&b, 8 * (rank - c) * vectors);
  }
  if (n > 0)
    restrict_cubic(model, split, q, quadratic, t);
}

PASS void pass_restricted_gradient(const thrum_model *model, int64_t split,
                                   const double *restricted, const double *q, double *gradient,
                                   double *value, double *work) {
  const int64_t n = model->rank - split, pairs = thrum_pair_count(n);
  const double *quadratic = restricted + n * LANES;
  const int64_t start = n > 0 ? thrum_c4_index(model->rank, 0, split, split, split) : 0;
  const crowd_form f = {n, split, quadratic + pairs * LANES, model->c4 + start, true};
  double *g = work, *sums = g + n * LANES;
  vs sum = vs_zero();
  for (int64_t c = 0; c < n * LANES; c += LANES)
    sum = vs_add(sum, vs_mul(vs_load(restricted + c), vs_load(q + c)));
  clear(g, n);
  upper_pairs(n, n, quadratic, q, g, sums);
  for (int64_t c = 0; c < n * LANES; c += LANES)
    vs_store(gradient + c,
             vs_add(vs_load(restricted + c), vs_add(vs_load(g + c), vs_load(sums + c))));
  sum = vs_add(sum, dot(n, q, sums));
  vs_store(value, vs_add(sum, form_gradient(true, &f, q, gradient, work)));
}

#define THRUM_CROWD_TABLE                                                                          \
  { LANES, pass_force, pass_restrict, pass_restricted_gradient }
