/* Rows of a block of a restricted form, with what they meet, over vectors of 8 lanes; for a file
 * that has included runtime/kernel_lanes.h.
 *
 * Long rows are taken four at a time, so that m and w are loaded and stored a quarter as often; for
 * short ones m and w stay in registers while the rows go by. Columns lie at their absolute places
 * in all arrays, so that vectors of m, w, q and g are always the same eight entries: what one block
 * stores the next one loads whole. Zeros pad the ends.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "kernel.h"

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
