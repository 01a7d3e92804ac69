/* The passes of runtime/kernel.h over a restricted form, in the order of thrum/model.h, over
 * vectors of 8 lanes, for a file that has included runtime/kernel_lanes.h; and the table of all
 * passes.
 *
 * Long rows are taken four at a time, so that m and w are loaded and stored a quarter as often; for
 * short ones m and w stay in registers while the rows go by. Columns lie at their absolute places
 * in all arrays, so that vectors of m, w, q and g are always the same eight entries: what one block
 * stores the next one loads whole. Zeros pad the ends.
 * Cost: the bytes of the coefficients, once; 4 (gradient) or 6 (Hessian) operations each.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "kernel.h"
#include "kernel_packed.h"

/* Up to four rows, or their sums. */
typedef struct rows4 {
  v8 r0, r1, r2, r3;
} rows4;

/* What a chunk of rows meets: columns m and their results w; x is a number a row. */
typedef struct side {
  const double *m3, *m4; /* by coordinate, by pair */
  double *w3, *w4;
  const double *x;                     /* by row */
  double *y;                           /* by row */
  double *lanes;                       /* 8 by row: sums over c3 that those over c4 go on with */
  double *const *each3, *const *each4; /* by row: lists that get q times the row; or NULL */
  double q;
} side;

/* Rows of block j: row i of c3 is c3 + i columns3, its column k at [k]; of c4 likewise by pair. */
typedef struct block {
  const double *c3, *c4;
  int64_t columns3, columns4, low3, low4, high3, high4;
} block;

INLINE int64_t at_most(int64_t a, int64_t b) {
  return a < b ? a : b;
}

INLINE rows4 rows_zero(void) {
  const rows4 zero = {v8_zero(), v8_zero(), v8_zero(), v8_zero()};
  return zero;
}

INLINE rows4 rows_set(int rows, const double *x) {
  rows4 s = rows_zero();
  s.r0 = v8_set1(x[0]);
  if (rows > 1)
    s.r1 = v8_set1(x[1]);
  if (rows > 2)
    s.r2 = v8_set1(x[2]);
  if (rows > 3)
    s.r3 = v8_set1(x[3]);
  return s;
}

INLINE rows4 rows_load(int rows, const double *b, int64_t stride) {
  rows4 s = rows_zero();
  s.r0 = v8_load(b);
  if (rows > 1)
    s.r1 = v8_load(b + stride);
  if (rows > 2)
    s.r2 = v8_load(b + 2 * stride);
  if (rows > 3)
    s.r3 = v8_load(b + 3 * stride);
  return s;
}

INLINE rows4 rows_load_range(int rows, const double *b, int64_t stride, int64_t lo, int64_t hi) {
  rows4 s = rows_zero();
  s.r0 = v8_load_range(b, lo, hi);
  if (rows > 1)
    s.r1 = v8_load_range(b + stride, lo, hi);
  if (rows > 2)
    s.r2 = v8_load_range(b + 2 * stride, lo, hi);
  if (rows > 3)
    s.r3 = v8_load_range(b + 3 * stride, lo, hi);
  return s;
}

INLINE void rows_store(int rows, const rows4 *s, double *a, int64_t stride) {
  v8_store(a, s->r0);
  if (rows > 1)
    v8_store(a + stride, s->r1);
  if (rows > 2)
    v8_store(a + 2 * stride, s->r2);
  if (rows > 3)
    v8_store(a + 3 * stride, s->r3);
}

/* y_r += b_r m */
INLINE void rows_dot(int rows, rows4 *y, const rows4 *b, v8 m) {
  y->r0 = v8_add(y->r0, v8_mul(b->r0, m));
  if (rows > 1)
    y->r1 = v8_add(y->r1, v8_mul(b->r1, m));
  if (rows > 2)
    y->r2 = v8_add(y->r2, v8_mul(b->r2, m));
  if (rows > 3)
    y->r3 = v8_add(y->r3, v8_mul(b->r3, m));
}

/* w + x_0 b_0 + x_1 b_1 + ..., in this order. */
INLINE v8 rows_add(int rows, v8 w, const rows4 *x, const rows4 *b) {
  w = v8_add(w, v8_mul(x->r0, b->r0));
  if (rows > 1)
    w = v8_add(w, v8_mul(x->r1, b->r1));
  if (rows > 2)
    w = v8_add(w, v8_mul(x->r2, b->r2));
  if (rows > 3)
    w = v8_add(w, v8_mul(x->r3, b->r3));
  return w;
}

/* Where every row, times q, is added to a list of its own; NULL: nowhere. */
typedef struct each_row {
  v8 q;
  double *const *g; /* by row */
} each_row;

INLINE void rows_each(int rows, const each_row *e, const rows4 *b, int64_t c) {
  v8_store(e->g[0] + c, v8_add(v8_load(e->g[0] + c), v8_mul(e->q, b->r0)));
  if (rows > 1)
    v8_store(e->g[1] + c, v8_add(v8_load(e->g[1] + c), v8_mul(e->q, b->r1)));
  if (rows > 2)
    v8_store(e->g[2] + c, v8_add(v8_load(e->g[2] + c), v8_mul(e->q, b->r2)));
  if (rows > 3)
    v8_store(e->g[3] + c, v8_add(v8_load(e->g[3] + c), v8_mul(e->q, b->r3)));
}

/* One vector of columns of some rows; `sums`: of the product, `adds`: to the transposed one. */
INLINE void chunk(int rows, bool sums, bool adds, rows4 *y, const rows4 *b, const double *m,
                  const rows4 *x, double *w) {
  if (sums)
    rows_dot(rows, y, b, v8_load(m));
  if (adds)
    v8_store(w, rows_add(rows, v8_load(w), x, b));
}

/* The next vector of up to four long rows. */
typedef struct streams4 {
  stream s0, s1, s2, s3;
} streams4;

INLINE streams4 streams_open(int rows, const double *b, int64_t stride) {
  streams4 s;
  s.s0 = stream_open(b);
  s.s1 = rows > 1 ? stream_open(b + stride) : s.s0;
  s.s2 = rows > 2 ? stream_open(b + 2 * stride) : s.s0;
  s.s3 = rows > 3 ? stream_open(b + 3 * stride) : s.s0;
  return s;
}

INLINE rows4 streams_next(int rows, streams4 *s) {
  rows4 b = rows_zero();
  b.r0 = stream_next(&s->s0);
  if (rows > 1)
    b.r1 = stream_next(&s->s1);
  if (rows > 2)
    b.r2 = stream_next(&s->s2);
  if (rows > 3)
    b.r3 = stream_next(&s->s3);
  return b;
}

/* Rows shorter than this are not worth opening a stream. */
#define STREAM_COLUMNS 96

/* The columns lo..hi-1 of some rows, the first at b. */
INLINE void sweep(int rows, bool sums, bool adds, rows4 *y, const double *b, int64_t stride,
                  int64_t lo, int64_t hi, const double *m, const rows4 *x, double *w,
                  const each_row *e) {
  int64_t c = lo / 8 * 8;
  if (c < lo) {
    const rows4 head = rows_load_range(rows, b + c, stride, lo - c, at_most(hi - c, 8));
    chunk(rows, sums, adds, y, &head, m + c, x, w + c);
    if (e)
      rows_each(rows, e, &head, c);
    c += 8;
  }
  if (hi - c >= STREAM_COLUMNS) {
    streams4 s = streams_open(rows, b + c, stride);
    for (; c + 16 <= hi; c += 8) {
      const rows4 whole = streams_next(rows, &s);
      chunk(rows, sums, adds, y, &whole, m + c, x, w + c);
      if (e)
        rows_each(rows, e, &whole, c);
    }
  }
  for (; c + 8 <= hi; c += 8) {
    const rows4 whole = rows_load(rows, b + c, stride);
    chunk(rows, sums, adds, y, &whole, m + c, x, w + c);
    if (e)
      rows_each(rows, e, &whole, c);
  }
  if (c < hi) {
    const rows4 tail = rows_load_range(rows, b + c, stride, 0, hi - c);
    chunk(rows, sums, adds, y, &tail, m + c, x, w + c);
    if (e)
      rows_each(rows, e, &tail, c);
  }
}

INLINE void rows_sum(int rows, const rows4 *s, double *sum) {
  sum[0] = v8_sum(s->r0);
  if (rows > 1)
    sum[1] = v8_sum(s->r1);
  if (rows > 2)
    sum[2] = v8_sum(s->r2);
  if (rows > 3)
    sum[3] = v8_sum(s->r3);
}

/* Some rows of c3, or of c4, and what they meet. */
typedef struct rows_of {
  const double *b; /* column 0 of the first row */
  int64_t stride, lo, hi;
  const double *m, *x;
  double *w, *y, *lanes;
  double *const *each; /* lists to add every row to, times q; NULL: none */
  double q;
} rows_of;

/* Rows i, i+1, ...; `starts`: their sums begin at zero, not at `lanes`; `ends`: they go to y. */
INLINE void wide_rows(int rows, bool sums, bool adds, bool each, bool starts, bool ends,
                      const rows_of *r, int64_t i) {
  rows4 y = rows_zero(), x = rows_zero();
  if (adds)
    x = rows_set(rows, r->x + i);
  if (sums && !starts)
    y = rows_load(rows, r->lanes + 8 * i, 8);
  const each_row e = {v8_set1(r->q), r->each ? r->each + i : NULL};
  sweep(rows, sums, adds, &y, r->b + i * r->stride, r->stride, r->lo, r->hi, r->m, &x, r->w,
        each ? &e : NULL);
  if (sums && ends)
    rows_sum(rows, &y, r->y + i);
  if (sums && !ends)
    rows_store(rows, &y, r->lanes + 8 * i, 8);
}

INLINE void wide(bool sums, bool adds, bool each, bool starts, bool ends, int64_t rows,
                 const rows_of *r) {
  int64_t i = 0;
  for (; i + 4 <= rows; i += 4)
    wide_rows(4, sums, adds, each, starts, ends, r, i);
  if (i + 3 == rows)
    wide_rows(3, sums, adds, each, starts, ends, r, i);
  else if (i + 2 == rows)
    wide_rows(2, sums, adds, each, starts, ends, r, i);
  else if (i < rows)
    wide_rows(1, sums, adds, each, starts, ends, r, i);
}

/* Up to six vectors of columns, held in registers. */
#define NARROW_MAX 6
#define EACH_NARROW(X) X(0) X(1) X(2) X(3) X(4) X(5)

typedef struct columns6 {
  v8 c0, c1, c2, c3, c4, c5;
} columns6;

INLINE columns6 columns_load(int chunks, const double *a) {
  const v8 zero = v8_zero();
  columns6 s = {zero, zero, zero, zero, zero, zero};
#define X(t)                                                                                       \
  if (t < chunks)                                                                                  \
    s.c##t = v8_load(a + 8 * t);
  EACH_NARROW(X)
#undef X
  return s;
}

INLINE void columns_store(int chunks, const columns6 *s, double *a) {
#define X(t)                                                                                       \
  if (t < chunks)                                                                                  \
    v8_store(a + 8 * t, s->c##t);
  EACH_NARROW(X)
#undef X
}

/* One row over all its columns; `head` is of the first vector, `tail` of the last of several. */
INLINE v8 narrow_row(int chunks, bool sums, bool adds, v8 sum, const double *b, v8_mask head,
                     v8_mask tail, const columns6 *m, v8 x, columns6 *w, v8 q, double *g) {
#define X(t)                                                                                       \
  if (t < chunks) {                                                                                \
    const v8 part = t == 0            ? v8_load_mask(b, head)                                      \
                    : t == chunks - 1 ? v8_load_mask(b + 8 * t, tail)                              \
                                      : v8_load(b + 8 * t);                                        \
    if (sums)                                                                                      \
      sum = v8_add(sum, v8_mul(part, m->c##t));                                                    \
    if (adds)                                                                                      \
      w->c##t = v8_add(w->c##t, v8_mul(x, part));                                                  \
    if (g)                                                                                         \
      v8_store(g + 8 * t, v8_add(v8_load(g + 8 * t), v8_mul(q, part)));                            \
  }
  EACH_NARROW(X)
#undef X
  return sum;
}

INLINE void narrow_chunks(int chunks, bool sums, bool adds, bool each, bool starts, bool ends,
                          int64_t rows, const rows_of *r) {
  const int64_t first = r->lo / 8 * 8;
  const v8_mask head = v8_range(r->lo - first, r->hi - first);
  const v8_mask tail = v8_range(0, r->hi - first - 8 * (chunks - 1));
  const columns6 m = columns_load(sums ? chunks : 0, r->m + first);
  columns6 w = columns_load(adds ? chunks : 0, r->w + first);
  const double *b = r->b + first;
  for (int64_t i = 0; i < rows; i++, b += r->stride) {
    const v8 start = sums && !starts ? v8_load(r->lanes + 8 * i) : v8_zero();
    const v8 sum =
        narrow_row(chunks, sums, adds, start, b, head, tail, &m, adds ? v8_set1(r->x[i]) : start,
                   &w, v8_set1(r->q), each ? r->each[i] + first : NULL);
    if (sums && ends)
      r->y[i] = v8_sum(sum);
    if (sums && !ends)
      v8_store(r->lanes + 8 * i, sum);
  }
  columns_store(adds ? chunks : 0, &w, r->w + first);
}

INLINE void rows_pass(bool sums, bool adds, bool each, bool starts, bool ends, int64_t rows,
                      const rows_of *r) {
  switch ((r->hi + 7) / 8 - r->lo / 8) {
#define X(t)                                                                                       \
  case t + 1:                                                                                      \
    narrow_chunks(t + 1, sums, adds, each, starts, ends, rows, r);                                 \
    break;
    EACH_NARROW(X)
#undef X
  default:
    wide(sums, adds, each, starts, ends, rows, r);
  }
}

/* All rows of a block: y_i for each if `sums`, w3 and w4 if `adds`. */
INLINE void block_pass(bool sums, bool adds, bool each, int64_t rows, const block *b,
                       const side *s) {
  const rows_of cubic = {b->c3, b->columns3, b->low3,  b->high3, s->m3, s->x,
                         s->w3, s->y,        s->lanes, s->each3, s->q};
  const rows_of quartic = {b->c4, b->columns4, b->low4,  b->high4, s->m4, s->x,
                           s->w4, s->y,        s->lanes, s->each4, s->q};
  rows_pass(sums, adds, each, true, false, rows, &cubic);
  rows_pass(sums, adds, each, false, true, rows, &quartic);
}

PASS void block_both(int64_t rows, const block *b, const side *s) {
  block_pass(true, true, false, rows, b, s);
}

PASS void block_each(int64_t rows, const block *b, const side *s) {
  block_pass(true, true, true, rows, b, s);
}

/* Four rows that lie anywhere and begin and end at columns of their own. */
typedef struct ragged {
  const double *b[4];
  int64_t lo[4], hi[4];
} ragged;

INLINE rows4 ragged_load(const ragged *b, int64_t c) {
  const rows4 s = {v8_load_range(b->b[0] + c, b->lo[0] - c, b->hi[0] - c),
                   v8_load_range(b->b[1] + c, b->lo[1] - c, b->hi[1] - c),
                   v8_load_range(b->b[2] + c, b->lo[2] - c, b->hi[2] - c),
                   v8_load_range(b->b[3] + c, b->lo[3] - c, b->hi[3] - c)};
  return s;
}

/* The whole vectors of the first rows alone, up to column `next`, where one row more begins. */
INLINE int64_t ragged_head(int rows, bool sums, rows4 *y, const ragged *b, int64_t c, int64_t next,
                           const double *m, const rows4 *x, double *w) {
  for (; c + 8 <= next && c + 8 <= b->hi[0]; c += 8) {
    rows4 part = rows_zero();
    part.r0 = v8_load(b->b[0] + c);
    if (rows > 1)
      part.r1 = v8_load(b->b[1] + c);
    if (rows > 2)
      part.r2 = v8_load(b->b[2] + c);
    chunk(rows, sums, true, y, &part, m + c, x, w + c);
  }
  return c;
}

/* As sweep; the lows ascend, and the highs do. */
INLINE void ragged_sweep(bool sums, rows4 *y, const ragged *b, const double *m, const rows4 *x,
                         double *w) {
  int64_t c = b->lo[0] / 8 * 8;
  while (c < b->lo[3] && c < b->hi[3]) {
    const rows4 head = ragged_load(b, c);
    chunk(4, sums, true, y, &head, m + c, x, w + c);
    c += 8;
    if (c < b->lo[1])
      c = ragged_head(1, sums, y, b, c, b->lo[1], m, x, w);
    else if (c < b->lo[2])
      c = ragged_head(2, sums, y, b, c, b->lo[2], m, x, w);
    else if (c < b->lo[3])
      c = ragged_head(3, sums, y, b, c, b->lo[3], m, x, w);
  }
  for (; c + 8 <= b->hi[0]; c += 8) {
    const rows4 whole = {v8_load(b->b[0] + c), v8_load(b->b[1] + c), v8_load(b->b[2] + c),
                         v8_load(b->b[3] + c)};
    chunk(4, sums, true, y, &whole, m + c, x, w + c);
  }
  for (; c < b->hi[3]; c += 8) {
    const rows4 tail = ragged_load(b, c);
    chunk(4, sums, true, y, &tail, m + c, x, w + c);
  }
}

/* Rows k.. of a triangle over some vectors of columns from `first` on, held in registers: row k has
 * the columns k..n-1 (`upper`), or 0..k. */
INLINE void triangle_chunks(int chunks, bool upper, int64_t n, int64_t k, int64_t last,
                            int64_t first, const double *row, const double *q, const double *m,
                            double *g, double *s) {
  const columns6 columns = columns_load(chunks, m + first);
  columns6 sums = columns_load(chunks, g + first);
  const int64_t end = first + 8 * (chunks - 1);
  for (; k < last; k++) {
    const int64_t lo = upper ? k : 0, hi = upper ? n : k + 1;
    const v8_mask head = v8_range(lo - first, hi - first), tail = v8_range(lo - end, hi - end);
    s[k] = v8_sum(narrow_row(chunks, true, true, v8_zero(), row + first, head, tail, &columns,
                             v8_set1(q[k]), &sums, columns.c0, NULL));
    row += upper ? n - k - 1 : k + 1;
  }
  columns_store(chunks, &sums, g + first);
}

/* Rows k = first..last-1 of a triangle: g_l += q_k w_kl; s_k = sum_l w_kl m_l. `row` is column 0 of
 * row k. */
INLINE void triangle_wide(bool upper, int64_t n, int64_t k, int64_t last, const double *row,
                          const double *q, const double *m, double *g, double *s) {
  for (; k + 4 <= last; k += 4) {
    ragged b;
    for (int64_t r = 0; r < 4; r++) {
      b.b[r] = row;
      b.lo[r] = upper ? k + r : 0;
      b.hi[r] = upper ? n : k + r + 1;
      row += upper ? n - (k + r) - 1 : k + r + 1;
    }
    rows4 y = rows_zero(), x = rows_set(4, q + k);
    ragged_sweep(true, &y, &b, m, &x, g);
    rows_sum(4, &y, s + k);
  }
  for (; k < last; k++) {
    rows4 y = rows_zero(), x = rows_set(1, q + k);
    sweep(1, true, true, &y, row, 0, upper ? k : 0, upper ? n : k + 1, m, &x, g, NULL);
    rows_sum(1, &y, s + k);
    row += upper ? n - k - 1 : k + 1;
  }
}

/* Eight rows at a time begin, or end, in the same vector of columns. */
INLINE void triangle(bool upper, int64_t n, int64_t k, int64_t last, const double *row,
                     const double *q, const double *m, double *g, double *s) {
  while (k < last) {
    const int64_t first = upper ? k / 8 * 8 : 0, end = at_most(k / 8 * 8 + 8, last);
    switch (upper ? (n + 7) / 8 - k / 8 : k / 8 + 1) {
#define X(t)                                                                                       \
  case t + 1:                                                                                      \
    triangle_chunks(t + 1, upper, n, k, end, first, row, q, m, g, s);                              \
    break;
      EACH_NARROW(X)
#undef X
    default:
      triangle_wide(upper, n, k, end, row, q, m, g, s);
    }
    for (; k < end; k++)
      row += upper ? n - k - 1 : k + 1;
  }
}

/* The pair gradient of w from row k = first to last - 1: g_l += q_k w_kl; s_k = sum_l w_kl m_l. */
PASS void upper_pairs(int64_t n, int64_t first, int64_t last, const double *w, const double *q,
                      const double *m, double *g, double *s) {
  const double *row = w + (thrum_pair_count(n) - thrum_pair_count(n - first)) - first;
  triangle(true, n, first, last, row, q, m, g, s);
}

/* The same for y_ij, j outermost, i <= j: g_i += q_j y_ij; s_j = sum_i y_ij q_i. */
PASS void lower_pairs(int64_t n, const double *y, const double *q, double *g, double *s) {
  triangle(false, n, 0, n, y, q, q, g, s);
}

INLINE double dot(int64_t n, const double *a, const double *b) {
  v8 sum = v8_zero();
  for (int64_t c = 0; c < n; c += 8)
    sum = v8_add(sum, v8_mul(v8_load(a + c), v8_load(b + c)));
  return v8_sum(sum);
}

INLINE void clear(double *a, int64_t count) {
  for (int64_t c = 0; c < count; c += 8)
    v8_store(a + c, v8_zero());
}

/* a, padded with zeros, into `padded`. */
INLINE void pad(int64_t n, const double *a, double *padded) {
  for (int64_t c = 0; c < thrum_padded(n); c += 8)
    v8_store(padded + c, v8_load_range(a + c, 0, n - c));
}

/* m_kl = a_k b_l (+ b_k a_l if `mixed`) for padded a and b; zeros after them. */
INLINE void pair_monomials(bool mixed, int64_t n, const double *a, const double *b, double *m) {
  for (int64_t k = 0; k < n; k++) {
    const v8 a_k = v8_set1(a[k]), b_k = v8_set1(b[k]);
    // a run's last vector spills into the next run, which is written later
    for (int64_t c = 0; c < n - k; c += 8) {
      v8 product = v8_mul(a_k, v8_load(b + k + c));
      if (mixed)
        product = v8_add(product, v8_mul(b_k, v8_load(a + k + c)));
      v8_store(m + c, product);
    }
    m += n - k;
  }
  v8_store(m, v8_zero());
}

/* x_i = a_i b_j (+ b_i a_j), i <= j. */
INLINE void row_monomials(bool mixed, int64_t j, const double *a, const double *b, double *x) {
  const v8 a_j = v8_set1(a[j]), b_j = v8_set1(b[j]);
  for (int64_t c = 0; c <= j; c += 8) {
    v8 product = v8_mul(v8_load(a + c), b_j);
    if (mixed)
      product = v8_add(product, v8_mul(v8_load(b + c), a_j));
    v8_store(x + c, product);
  }
}

/* Block 0 of a form; next_block goes on. Columns of a block are addressed from column 0 on, which
 * lies before the block's own first column, inside the array for all but block 0. */
INLINE block first_block(const thrum_form *f) {
  const int64_t pairs = thrum_pair_count(f->n);
  const block b = {f->c3, f->c4 + f->skip * pairs, f->n, pairs, 0, 0, f->n, pairs};
  return b;
}

INLINE void next_block(const thrum_form *f, int64_t j, block *b) {
  const int64_t fewer = f->n - j;
  b->c3 += (j + 1) * b->columns3 - 1;
  b->c4 += (j + 1) * b->columns4 - fewer;
  b->low3 += 1;
  b->low4 += fewer;
  b->columns3 -= 1;
  b->columns4 -= fewer;
  b->c4 += f->skip * b->columns4;
}

/* Arrays of a pass, cut from its scratch. */
typedef struct scratch {
  double *pairs[THRUM_KERNEL_PAIR_ARRAYS];
  double *vectors[THRUM_KERNEL_VECTORS];
  double *lanes; /* 8 a row */
} scratch;

INLINE scratch cut(int64_t n, double *work) {
  const int64_t pairs = thrum_padded(thrum_pair_count(n)), vector = thrum_padded(n);
  scratch s;
  for (int64_t k = 0; k < THRUM_KERNEL_VECTORS; k++)
    s.vectors[k] = work + k * vector;
  s.lanes = work + THRUM_KERNEL_VECTORS * vector;
  work = s.lanes + 8 * vector;
  for (int64_t k = 0; k < THRUM_KERNEL_PAIR_ARRAYS; k++)
    s.pairs[k] = work + k * pairs;
  return s;
}

PASS double pass_gradient(const thrum_form *f, const double *q_given, double *gradient,
                          double *work) {
  const int64_t n = f->n;
  const scratch t = cut(n, work);
  double *q = t.vectors[0], *g = t.vectors[1], *x = t.vectors[2], *sums = t.vectors[3];
  double *more = t.vectors[4], *m = t.pairs[0], *w = t.pairs[1], *y = t.pairs[2];
  pad(n, q_given, q);
  clear(g, n);
  clear(sums, n);
  clear(w, thrum_pair_count(n));
  pair_monomials(false, n, q, q, m);
  side s = {q, m, g, w, x, y, t.lanes, NULL, NULL, 0};
  block b = first_block(f);
  for (int64_t j = 0; j < n; j++) {
    row_monomials(false, j, q, q, x);
    block_both(j + 1, &b, &s);
    s.y += j + 1;
    next_block(f, j, &b);
  }
  lower_pairs(n, y, q, g, sums);
  upper_pairs(n, 0, n, w, q, q, g, more);
  for (int64_t i = 0; i < n; i++)
    gradient[i] += g[i] + (sums[i] + more[i]);
  return dot(n, q, sums);
}

PASS double pass_pairs(int64_t n, const double *w, const double *q_given, double *gradient,
                       double *work) {
  const scratch t = cut(n, work);
  double *q = t.vectors[0], *g = t.vectors[1], *sums = t.vectors[2];
  pad(n, q_given, q);
  clear(g, n);
  clear(sums, n);
  upper_pairs(n, 0, n, w, q, q, g, sums);
  for (int64_t i = 0; i < n; i++)
    gradient[i] += g[i] + sums[i];
  return dot(n, q, sums);
}

/* hessian = half + half^T, with w on the upper part of half. */
INLINE void symmetrise(int64_t n, const double *w, double *hessian) {
  for (int64_t k = 0; k < n; k++)
    for (int64_t l = k; l < n; l++) {
      const double half = hessian[k * n + l] + *w++;
      hessian[k * n + l] = hessian[l * n + k] = half + (l == k ? half : hessian[l * n + k]);
    }
}

/* The lists of the Hessian, one for each row a: over coordinates from a on and over pairs of them,
 * at their absolute places; and spare ones. */
typedef struct lists {
  double *g3[THRUM_RANK_MAX], *g4[THRUM_RANK_MAX];
  double *each3[THRUM_RANK_MAX], *each4[THRUM_RANK_MAX]; /* the same, but one spare */
  double *spare3, *spare4;
} lists;

/* All zero, cut from `at`. */
INLINE void lists_make(int64_t n, double *at, lists *l) {
  const int64_t vector = thrum_padded(n), pairs = thrum_padded(thrum_pair_count(n));
  double *begin = at;
  for (int64_t a = 0, first = 0; a < n; first += n - a, a++) {
    l->g3[a] = l->each3[a] = at;
    l->g4[a] = l->each4[a] = at + vector - first / 8 * 8;
    at += vector + pairs - first / 8 * 8;
  }
  l->spare3 = at;
  l->spare4 = at + vector;
  clear(begin, at + vector + pairs - begin);
}

/* Block a has been added to list a without its own row a, which is in the spare list:
 * w += q_a list, list += spare, spare = 0. */
INLINE void list_done(int64_t lo, int64_t hi, double q_a, double *list, double *spare, double *w) {
  const v8 q = v8_set1(q_a);
  for (int64_t c = lo / 8 * 8; c < hi; c += 8) {
    const v8 before = v8_load(list + c);
    if (w)
      v8_store(w + c, v8_add(v8_load(w + c), v8_mul(q, before)));
    v8_store(list + c, v8_add(before, v8_load(spare + c)));
    v8_store(spare + c, v8_zero());
  }
}

PASS void pass_hessian(const thrum_form *f, const double *q_given, double *hessian, double *work) {
  const int64_t n = f->n, pairs = thrum_pair_count(n);
  const scratch t = cut(n, work);
  double *q = t.vectors[0], *y = t.vectors[1], *g = t.vectors[2], *sums = t.vectors[3];
  double *m = t.pairs[0], *w = t.pairs[1];
  lists l;
  lists_make(n, work + thrum_kernel_work(n), &l);
  pad(n, q_given, q);
  clear(w, pairs);
  pair_monomials(false, n, q, q, m);
  // half of it now, half + half^T at the end
  for (int64_t c = 0; c < n * n; c++)
    hessian[c] *= 0.5;
  block b = first_block(f);
  for (int64_t a = 0; a < n; a++) {
    // y_ia is the coefficient of q_i q_a; list a gets sum_i q_i B_ia, list i gets q_a B_ia
    const side s = {q, m, l.g3[a], l.g4[a], q, y, t.lanes, l.each3, l.each4, q[a]};
    l.each3[a] = l.spare3;
    l.each4[a] = l.spare4;
    block_each(a + 1, &b, &s);
    l.each3[a] = l.g3[a];
    l.each4[a] = l.g4[a];
    // w is q_a times the list before the rows a are in
    list_done(b.low3, n, q[a], l.g3[a], l.spare3, NULL);
    list_done(b.low4, pairs, q[a], l.g4[a], l.spare4, w);
    for (int64_t i = 0; i <= a; i++)
      hessian[a * n + i] += y[i];
    next_block(f, a, &b);
  }
  // the mixed derivatives by q_a and the columns: the pair gradient of all that meets q_a
  for (int64_t a = 0; a < n; a++) {
    clear(g, n);
    upper_pairs(n, a, n, l.g4[a], q, q, g, sums);
    for (int64_t k = a; k < n; k++)
      hessian[a * n + k] += l.g3[a][k] + (g[k] + sums[k]);
  }
  symmetrise(n, w, hessian);
}

/* w += sum_a q_a (row a) over `rows` rows. */
INLINE void add_block(int64_t rows, const double *b, int64_t columns, const double *q, double *w) {
  rows4 unused = rows_zero();
  int64_t a = 0;
  for (; a + 4 <= rows; a += 4) {
    const rows4 x = rows_set(4, q + a);
    sweep(4, false, true, &unused, b + a * columns, columns, 0, columns, w, &x, w, NULL);
  }
  for (; a < rows; a++) {
    const rows4 x = rows_set(1, q + a);
    sweep(1, false, true, &unused, b + a * columns, columns, 0, columns, w, &x, w, NULL);
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
    memcpy(kept, c3 + split * (n - j), (size_t)size * sizeof *kept);
    c3 += (split + j + 1) * (n - j);
    kept += size;
  }
  for (int64_t i = 0; i < n; i++) {
    const int64_t columns = thrum_pair_count(n - i);
    clear(t, columns);
    add_block(split, c4, columns, q, t);
    c4 += (split + i + 1) * columns;
    // c4_aijk belongs to row i of block j of the cubic part
    const double *from = t;
    double *to = cubic;
    for (int64_t j = 0; j < n; j++) {
      for (int64_t k = 0; j >= i && k < n - j; k++)
        to[i * (n - j) + k] += *from++;
      to += (j + 1) * (n - j);
    }
  }
}

PASS void pass_restrict(const thrum_model *model, int64_t split, const double *q,
                        double *restricted, double *work) {
  const int64_t n = model->rank - split, pairs = thrum_pair_count(n);
  restrict_low(model, split, q, restricted, restricted + n, work);
  if (n > 0)
    restrict_cubic(model, split, q, restricted + n + pairs, work);
}

/* Whole lanes may go past the diagonal. */
PASS void pass_rank_two(int64_t n, bool lower, const double *a, const double *b, const double *c,
                        const double *d, double *matrix) {
  for (int64_t i = 0; i < n; i++) {
    const v8 ai = v8_set1(a[i]), ci = v8_set1(c[i]);
    const int64_t last = lower ? i + 1 : n;
    double *row = matrix + i * n;
    int64_t j = 0;
    for (; j < last && j + 8 <= n; j += 8) {
      const v8 more = v8_add(v8_mul(ai, v8_load(b + j)), v8_mul(ci, v8_load(d + j)));
      v8_store(row + j, v8_add(v8_load(row + j), more));
    }
    for (; j < last; j++)
      row[j] += a[i] * b[j] + c[i] * d[j];
  }
}

#define THRUM_KERNEL_TABLE(id)                                                                     \
  {                                                                                                \
    id, pass_energy, pass_force, pass_forces, pass_tangent, pass_tangent_vector, pass_restrict,    \
        pass_gradient, pass_hessian, pass_pairs, pass_rank_two                                     \
  }
