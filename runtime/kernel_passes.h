/* The passes of runtime/kernel.h over vectors of 8 lanes, for a file that has defined
 *
 *   v8          8 doubles, in as many registers as that takes
 *   INLINE      `static inline`, forced, for the instructions in use; PASS the same without inline
 *   v8_zero, v8_set1(s), v8_load(p), v8_store(p, a), v8_mul(a, b), v8_add(a, b)
 *   v8_load_range(p, lo, hi)   lanes lo <= s < hi of p, zero in the others, which are not read
 *   v8_sum(a)                  ((0+4)+(2+6))+((1+5)+(3+7))
 *   stream, stream_open(p), stream_next(&s)   the vectors at p, p + 8, ... one after the other;
 * each may read up to 8 doubles past its own, none before p
 *
 * Rows are taken four at a time, so that m and w are loaded and stored a quarter as often. Columns
 * lie at their absolute places in all arrays, so that vectors of m, w, q and g are always the same
 * eight entries: what one block stores the next one loads whole. Zeros pad the ends.
 * Cost: the bytes of the coefficients, once (twice for the Hessian); 2 (value), 4 (gradient), 6
 * (Hessian), 8 (product) or 2 (contract) operations each.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "kernel.h"

/* Up to four rows, or their sums. */
typedef struct rows4 {
  v8 r0, r1, r2, r3;
} rows4;

/* What a chunk of rows meets: columns m and their results w; x is a number a row. */
typedef struct side {
  const double *m3, *m4; /* by coordinate, by pair */
  double *w3, *w4;
  const double *x; /* by row */
  double *y;       /* by row */
} side;

/* Rows of block j: row i of c3 is c3 + i columns3, its column k at [k]; of c4 likewise by pair. */
typedef struct block {
  const double *c3, *c4;
  int64_t columns3, columns4, low3, low4, high3, high4;
} block;

INLINE int64_t at_least(int64_t a, int64_t b) {
  return a > b ? a : b;
}

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
#define STREAM_COLUMNS 40

/* The columns lo..hi-1 of some rows, the first at b. */
INLINE void sweep(int rows, bool sums, bool adds, rows4 *y, const double *b, int64_t stride,
                  int64_t lo, int64_t hi, const double *m, const rows4 *x, double *w) {
  int64_t c = lo / 8 * 8;
  if (c < lo) {
    const rows4 head = rows_load_range(rows, b + c, stride, lo - c, at_most(hi - c, 8));
    chunk(rows, sums, adds, y, &head, m + c, x, w + c);
    c += 8;
  }
  if (hi - c >= STREAM_COLUMNS) {
    streams4 s = streams_open(rows, b + c, stride);
    for (; c + 16 <= hi; c += 8) {
      const rows4 whole = streams_next(rows, &s);
      chunk(rows, sums, adds, y, &whole, m + c, x, w + c);
    }
  }
  for (; c + 8 <= hi; c += 8) {
    const rows4 whole = rows_load(rows, b + c, stride);
    chunk(rows, sums, adds, y, &whole, m + c, x, w + c);
  }
  if (c < hi) {
    const rows4 tail = rows_load_range(rows, b + c, stride, 0, hi - c);
    chunk(rows, sums, adds, y, &tail, m + c, x, w + c);
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

/* Rows i, i+1, ... of a block. */
INLINE void block_rows(int rows, bool sums, bool adds, const block *b, int64_t i, const side *s) {
  rows4 y = rows_zero(), x = rows_zero();
  if (adds)
    x = rows_set(rows, s->x + i);
  sweep(rows, sums, adds, &y, b->c3 + i * b->columns3, b->columns3, b->low3, b->high3, s->m3, &x,
        s->w3);
  sweep(rows, sums, adds, &y, b->c4 + i * b->columns4, b->columns4, b->low4, b->high4, s->m4, &x,
        s->w4);
  if (sums)
    rows_sum(rows, &y, s->y + i);
}

/* All rows of a block: y_i for each if `sums`, w3 and w4 if `adds`. */
INLINE void block_pass(bool sums, bool adds, int64_t rows, const block *b, const side *s) {
  int64_t i = 0;
  for (; i + 4 <= rows; i += 4)
    block_rows(4, sums, adds, b, i, s);
  if (i + 2 <= rows) {
    block_rows(2, sums, adds, b, i, s);
    i += 2;
  }
  if (i < rows)
    block_rows(1, sums, adds, b, i, s);
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

/* As sweep; the lows ascend, and the highs do. */
INLINE void ragged_sweep(bool sums, rows4 *y, const ragged *b, const double *m, const rows4 *x,
                         double *w) {
  int64_t c = b->lo[0] / 8 * 8;
  for (; c < b->lo[3] && c < b->hi[3]; c += 8) {
    const rows4 head = ragged_load(b, c);
    chunk(4, sums, true, y, &head, m + c, x, w + c);
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

/* The pair gradient of w from row k = first to last - 1: g_l += q_k w_kl; s_k = sum_l w_kl m_l. */
INLINE void upper_pairs(int64_t n, int64_t first, int64_t last, const double *w, const double *q,
                        const double *m, double *g, double *s) {
  const double *row = w + (thrum_pair_count(n) - thrum_pair_count(n - first)) - first;
  int64_t k = first;
  for (; k + 4 <= last; k += 4) {
    ragged b;
    for (int64_t r = 0; r < 4; r++) {
      b.b[r] = row;
      b.lo[r] = k + r;
      b.hi[r] = n;
      row += n - (k + r) - 1;
    }
    rows4 y = rows_zero(), x = rows_set(4, q + k);
    ragged_sweep(true, &y, &b, m, &x, g);
    rows_sum(4, &y, s + k);
  }
  for (; k < last; k++) {
    rows4 y = rows_zero(), x = rows_set(1, q + k);
    sweep(1, true, true, &y, row, 0, k, n, m, &x, g);
    rows_sum(1, &y, s + k);
    row += n - k - 1;
  }
}

/* The same for y_ij, j outermost, i <= j: g_i += q_j y_ij; s_j = sum_i y_ij q_i. */
INLINE void lower_pairs(int64_t n, const double *y, const double *q, double *g, double *s) {
  const double *row = y;
  int64_t j = 0;
  for (; j + 4 <= n; j += 4) {
    ragged b;
    for (int64_t r = 0; r < 4; r++) {
      b.b[r] = row;
      b.lo[r] = 0;
      b.hi[r] = j + r + 1;
      row += j + r + 1;
    }
    rows4 sum = rows_zero(), x = rows_set(4, q + j);
    ragged_sweep(true, &sum, &b, q, &x, g);
    rows_sum(4, &sum, s + j);
  }
  for (; j < n; j++) {
    rows4 sum = rows_zero(), x = rows_set(1, q + j);
    sweep(1, true, true, &sum, row, 0, 0, j + 1, q, &x, g);
    rows_sum(1, &sum, s + j);
    row += j + 1;
  }
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
} scratch;

INLINE scratch cut(int64_t n, double *work) {
  const int64_t pairs = thrum_padded(thrum_pair_count(n)), vector = thrum_padded(n);
  scratch s;
  for (int64_t k = 0; k < THRUM_KERNEL_VECTORS; k++)
    s.vectors[k] = work + k * vector;
  work += THRUM_KERNEL_VECTORS * vector;
  for (int64_t k = 0; k < THRUM_KERNEL_PAIR_ARRAYS; k++)
    s.pairs[k] = work + k * pairs;
  return s;
}

PASS double pass_value(const thrum_form *f, const double *q_given, double *work) {
  const int64_t n = f->n;
  const scratch t = cut(n, work);
  double *q = t.vectors[0], *g = t.vectors[1], *sums = t.vectors[2];
  double *m = t.pairs[0], *y = t.pairs[1];
  pad(n, q_given, q);
  clear(g, n);
  clear(sums, n);
  pair_monomials(false, n, q, q, m);
  side s = {q, m, NULL, NULL, NULL, y};
  block b = first_block(f);
  for (int64_t j = 0; j < n; j++) {
    block_pass(true, false, j + 1, &b, &s);
    s.y += j + 1;
    next_block(f, j, &b);
  }
  lower_pairs(n, y, q, g, sums);
  return dot(n, q, sums);
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
  side s = {q, m, g, w, x, y};
  block b = first_block(f);
  for (int64_t j = 0; j < n; j++) {
    row_monomials(false, j, q, q, x);
    block_pass(true, true, j + 1, &b, &s);
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

/* g += sum_{j>=a} q_j (row a of block j), from block a on, over columns of c3 and of c4. */
INLINE void add_rows(const thrum_form *f, int64_t a, block b, const double *q, double *g3,
                     double *g4) {
  const int64_t n = f->n;
  int64_t j = a;
  rows4 unused = rows_zero();
  for (; j + 4 <= n; j += 4) {
    ragged cubic, quartic;
    for (int64_t r = 0; r < 4; r++) {
      cubic.b[r] = b.c3 + a * b.columns3;
      cubic.lo[r] = b.low3;
      cubic.hi[r] = b.high3;
      quartic.b[r] = b.c4 + a * b.columns4;
      quartic.lo[r] = b.low4;
      quartic.hi[r] = b.high4;
      next_block(f, j + r, &b);
    }
    const rows4 x = rows_set(4, q + j);
    ragged_sweep(false, &unused, &cubic, g3, &x, g3);
    ragged_sweep(false, &unused, &quartic, g4, &x, g4);
  }
  for (; j < n; j++) {
    const rows4 x = rows_set(1, q + j);
    sweep(1, false, true, &unused, b.c3 + a * b.columns3, 0, b.low3, b.high3, g3, &x, g3);
    sweep(1, false, true, &unused, b.c4 + a * b.columns4, 0, b.low4, b.high4, g4, &x, g4);
    next_block(f, j, &b);
  }
}

/* hessian = half + half^T, with w on the upper part of half. */
INLINE void symmetrise(int64_t n, const double *w, double *hessian) {
  for (int64_t k = 0; k < n; k++)
    for (int64_t l = k; l < n; l++) {
      const double half = hessian[k * n + l] + *w++;
      hessian[k * n + l] = hessian[l * n + k] = half + (l == k ? half : hessian[l * n + k]);
    }
}

PASS void pass_hessian(const thrum_form *f, const double *q_given, double *hessian, double *work) {
  const int64_t n = f->n, pairs = thrum_pair_count(n);
  const scratch t = cut(n, work);
  double *q = t.vectors[0], *g3 = t.vectors[1], *y = t.vectors[2], *g = t.vectors[3];
  double *sums = t.vectors[4], *m = t.pairs[0], *w = t.pairs[1], *g4 = t.pairs[2];
  pad(n, q_given, q);
  clear(w, pairs);
  pair_monomials(false, n, q, q, m);
  // half of it now, half + half^T at the end
  for (int64_t c = 0; c < n * n; c++)
    hessian[c] *= 0.5;
  block b = first_block(f);
  for (int64_t a = 0; a < n; a++) {
    double *row = hessian + a * n;
    const int64_t first = b.low4 / 8 * 8;
    clear(g3, n);
    clear(g, n);
    clear(g4 + first, pairs - first);
    // y_ia is the coefficient of q_i q_a; g4 gets sum_i q_i B_ia, and w q_a times that
    const side s = {q, m, g3, g4, q, y};
    block_pass(true, true, a + 1, &b, &s);
    const v8 q_a = v8_set1(q[a]);
    for (int64_t c = first; c < pairs; c += 8)
      v8_store(w + c, v8_add(v8_load(w + c), v8_mul(q_a, v8_load(g4 + c))));
    // the mixed derivatives by q_a and the columns: the pair gradient of all that meets q_a
    add_rows(f, a, b, q, g3, g4);
    upper_pairs(n, a, n, g4, q, q, g, sums);
    for (int64_t i = 0; i <= a; i++)
      row[i] += y[i];
    for (int64_t k = a; k < n; k++)
      row[k] += g3[k] + (g[k] + sums[k]);
    next_block(f, a, &b);
  }
  symmetrise(n, w, hessian);
}

/* Two sides at once: two rows and two (m, x) at a time. */
INLINE void sweep_twice(int rows, rows4 y[2], const double *b, int64_t stride, int64_t lo,
                        int64_t hi, const double *const m[2], const rows4 x[2],
                        double *const w[2]) {
  for (int64_t c = lo / 8 * 8; c < hi; c += 8) {
    const bool whole = c >= lo && c + 8 <= hi;
    const rows4 part = whole ? rows_load(rows, b + c, stride)
                             : rows_load_range(rows, b + c, stride, lo - c, hi - c);
    chunk(rows, true, true, &y[0], &part, m[0] + c, &x[0], w[0] + c);
    chunk(rows, true, true, &y[1], &part, m[1] + c, &x[1], w[1] + c);
  }
}

INLINE void block_rows_twice(int rows, const block *b, int64_t i, const side s[2]) {
  rows4 y[2] = {rows_zero(), rows_zero()};
  const rows4 x[2] = {rows_set(rows, s[0].x + i), rows_set(rows, s[1].x + i)};
  sweep_twice(rows, y, b->c3 + i * b->columns3, b->columns3, b->low3, b->high3,
              (const double *const[]){s[0].m3, s[1].m3}, x, (double *const[]){s[0].w3, s[1].w3});
  sweep_twice(rows, y, b->c4 + i * b->columns4, b->columns4, b->low4, b->high4,
              (const double *const[]){s[0].m4, s[1].m4}, x, (double *const[]){s[0].w4, s[1].w4});
  rows_sum(rows, &y[0], s[0].y + i);
  rows_sum(rows, &y[1], s[1].y + i);
}

PASS void pass_product(const thrum_form *f, const double *q_given, const double *v_given,
                       double *product, double *work) {
  const int64_t n = f->n, pairs = thrum_pair_count(n);
  const scratch t = cut(n, work);
  double *const *a = t.vectors, *const *p = t.pairs;
  double *q = a[0], *v = a[1], *x = a[2], *dx = a[3], *g[2] = {a[4], a[5]};
  double *w = p[0], *dw = p[1], *m = p[2], *dm = p[3], *y = p[4], *dy = p[5];
  pad(n, q_given, q);
  pad(n, v_given, v);
  clear(g[0], n);
  clear(g[1], n);
  clear(w, pairs);
  clear(dw, pairs);
  pair_monomials(false, n, q, q, m);
  pair_monomials(true, n, q, v, dm);
  // every line is the derivative along v of a line of pass_gradient
  side s[2] = {{q, m, g[0], w, x, y}, {v, dm, g[1], dw, dx, dy}};
  block b = first_block(f);
  for (int64_t j = 0; j < n; j++) {
    row_monomials(false, j, q, q, x);
    row_monomials(true, j, q, v, dx);
    int64_t i = 0;
    for (; i + 2 <= j + 1; i += 2)
      block_rows_twice(2, &b, i, s);
    if (i < j + 1)
      block_rows_twice(1, &b, i, s);
    s[0].y += j + 1;
    s[1].y += j + 1;
    next_block(f, j, &b);
  }
  for (int64_t k = 6; k < 10; k++)
    clear(a[k], n);
  lower_pairs(n, y, v, g[1], a[6]);
  lower_pairs(n, dy, q, g[1], a[7]);
  upper_pairs(n, 0, n, w, v, v, g[1], a[8]);
  upper_pairs(n, 0, n, dw, q, q, g[1], a[9]);
  for (int64_t i = 0; i < n; i++)
    product[i] += g[1][i] + ((a[6][i] + a[7][i]) + (a[8][i] + a[9][i]));
}

/* The blocks j < split: w (pairs) and w3 (coordinates) get their products with q_i q_j. */
INLINE void contract_low(const thrum_form *f, int64_t split, const double *q, double *x, double *w3,
                         double *w) {
  const side s = {NULL, NULL, w3, w, x, NULL};
  block b = first_block(f);
  for (int64_t j = 0; j < split; j++) {
    row_monomials(false, j, q, q, x);
    block_pass(false, true, j + 1, &b, &s);
    next_block(f, j, &b);
  }
}

/* w += sum_a q_a (row a) over `rows` rows. */
INLINE void add_block(int64_t rows, const double *b, int64_t columns, const double *q, double *w) {
  rows4 unused = rows_zero();
  int64_t a = 0;
  for (; a + 4 <= rows; a += 4) {
    const rows4 x = rows_set(4, q + a);
    sweep(4, false, true, &unused, b + a * columns, columns, 0, columns, w, &x, w);
  }
  for (; a < rows; a++) {
    const rows4 x = rows_set(1, q + a);
    sweep(1, false, true, &unused, b + a * columns, columns, 0, columns, w, &x, w);
  }
}

/* The blocks j >= split: their rows a < split go one degree down, their others are kept.
 * `quadratic` is padded. */
INLINE void contract_high(const thrum_model *model, int64_t split, const double *q,
                          double *quadratic, double *cubic, double *t) {
  const int64_t n = model->rank - split;
  const double *c3 = model->c3 + thrum_c3_index(model->rank, 0, split, split);
  const double *c4 = model->c4 + thrum_c4_index(model->rank, 0, split, split, split);
  double *kept = cubic;
  for (int64_t j = 0; j < n; j++) {
    const int64_t size = (j + 1) * (n - j);
    add_block(split, c3, n - j, q, quadratic);
    memcpy(kept, c3 + split * (n - j), (size_t)size * sizeof *kept);
    c3 += (split + j + 1) * (n - j);
    quadratic += n - j;
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

PASS double pass_contract(const thrum_model *model, int64_t split, const double *q_given,
                          double *restricted, double *work) {
  const int64_t rank = model->rank, n = rank - split, pairs = thrum_pair_count(n);
  const thrum_form f = {rank, model->c3, model->c4, 0};
  const scratch t = cut(rank, work);
  double *const *a = t.vectors, *q = a[0], *x = a[1], *w3 = a[2], *g = a[3], *sums = a[4];
  double *w = t.pairs[0], *quadratic = t.pairs[1];
  pad(split, q_given, q);
  // the held ones padded up to the rank: no other coordinate may enter
  for (int64_t c = thrum_padded(split); c < thrum_padded(rank); c += 8)
    v8_store(q + c, v8_zero());
  clear(w, thrum_pair_count(rank));
  clear(w3, rank);
  clear(g, rank);
  contract_low(&f, split, q, x, w3, w);
  // pairs (c, l) of w: both held gives the constant, one held the linear, none the quadratic term
  upper_pairs(rank, 0, split, w, q, q, g, sums);
  double constant = 0;
  for (int64_t c = 0; c < split; c++)
    constant += ((0.5 * model->omega2[c] * q[c] + w3[c]) + sums[c]) * q[c];
  for (int64_t k = 0; k < n; k++)
    restricted[k] = w3[split + k] + g[split + k];
  pad(pairs, w + (thrum_pair_count(rank) - pairs), quadratic);
  for (int64_t k = 0, diagonal = 0; k < n; diagonal += n - k, k++)
    quadratic[diagonal] += 0.5 * model->omega2[split + k];
  if (n > 0)
    contract_high(model, split, q, quadratic, restricted + n + pairs, t.pairs[2]);
  memcpy(restricted + n, quadratic, (size_t)pairs * sizeof *restricted);
  return constant;
}

#define THRUM_KERNEL_TABLE(id)                                                                     \
  { id, pass_value, pass_gradient, pass_hessian, pass_product, pass_pairs, pass_contract }
