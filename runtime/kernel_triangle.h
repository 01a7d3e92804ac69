/* Gradients of quadratic forms whose coefficients fill a triangle, over vectors of 8 lanes; for a
 * file that has included runtime/kernel_rows.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
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
