/* The passes of runtime/kernel.h over a square matrix, for a file that has included
 * runtime/kernel_lanes.h.
 *
 * Columns are taken in up to four vectors, which stay in registers while the rows, or the pairs of
 * vectors, go by.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdbool.h>
#include <stdint.h>

#define SQUARE_VECTORS 4

/* Vectors that hold so many columns, but no more than are taken at once. */
INLINE int64_t square_vectors(int64_t columns) {
  return columns < 8 * SQUARE_VECTORS ? (columns + 7) / 8 : SQUARE_VECTORS;
}

/* Vector k of so many, of which only the last may not be whole. */
INLINE v8 square_load(const double *p, int k, int vectors, v8_mask last) {
  return k + 1 < vectors ? v8_load(p + 8 * k) : v8_load_mask(p + 8 * k, last);
}

INLINE void square_store(double *p, int k, int vectors, int64_t columns, v8 a) {
  if (k + 1 < vectors)
    v8_store(p + 8 * k, a);
  else
    v8_store_first(p + 8 * k, a, columns - 8 * k);
}

/* The columns from `first` on. */
INLINE void product_columns(int vectors, int64_t n, int64_t first, const double *matrix,
                            const double *x, double *y) {
  const v8_mask last = v8_range(0, n - first - 8 * (vectors - 1));
  v8 sum[SQUARE_VECTORS];
  for (int k = 0; k < vectors; k++)
    sum[k] = v8_zero();
  for (int64_t i = 0; i < n; i++) {
    const v8 x_i = v8_set1(x[i]);
    for (int k = 0; k < vectors; k++)
      sum[k] = v8_add(sum[k], v8_mul(x_i, square_load(matrix + i * n + first, k, vectors, last)));
  }
  for (int k = 0; k < vectors; k++)
    square_store(y + first, k, vectors, n - first, sum[k]);
}

PASS void pass_product(int64_t n, const double *matrix, const double *x, double *y) {
  for (int64_t first = 0; first < n; first += 8 * SQUARE_VECTORS)
    switch (square_vectors(n - first)) {
#define X(k)                                                                                       \
  case k + 1:                                                                                      \
    if (k < SQUARE_VECTORS)                                                                        \
      product_columns(k + 1, n, first, matrix, x, y);                                              \
    break;
      EACH_8(X)
#undef X
    }
}

/* Rows begin..end-1, the columns from `first` on. */
INLINE void rank_two_rows(int vectors, int64_t n, int64_t first, int64_t begin, int64_t end,
                          const thrum_two *t, double *matrix) {
  const v8_mask last = v8_range(0, n - first - 8 * (vectors - 1));
  for (int64_t i = begin; i < end; i++) {
    double *row = matrix + i * n + first;
    v8 sum[SQUARE_VECTORS];
    for (int k = 0; k < vectors; k++)
      sum[k] = square_load(row, k, vectors, last);
    for (int64_t p = 0, at = 0; p < t->count; p++, at += t->stride) {
      const v8 a = v8_set1(t->a[at + i]), c = v8_set1(t->c[at + i]);
      const double *b = t->b + at + first, *d = t->d + at + first;
      for (int k = 0; k < vectors; k++) {
        const v8 b_k = square_load(b, k, vectors, last), d_k = square_load(d, k, vectors, last);
        sum[k] = v8_add(sum[k], v8_add(v8_mul(a, b_k), v8_mul(c, d_k)));
      }
    }
    for (int k = 0; k < vectors; k++)
      square_store(row, k, vectors, n - first, sum[k]);
  }
}

/* Whole vectors may go past the diagonal. */
PASS void pass_rank_two(int64_t n, bool lower, const thrum_two *t, double *matrix) {
  for (int64_t first = 0; first < n; first += 8 * SQUARE_VECTORS) {
    const int64_t most = square_vectors(n - first);
    int64_t vectors = lower ? 1 : most, end;
    for (int64_t begin = lower ? first : 0; begin < n; begin = end) {
      end = vectors < most ? begin + 8 : n;
      switch (vectors) {
#define X(k)                                                                                       \
  case k + 1:                                                                                      \
    if (k < SQUARE_VECTORS)                                                                        \
      rank_two_rows(k + 1, n, first, begin, end, t, matrix);                                       \
    break;
        EACH_8(X)
#undef X
      }
      vectors++;
    }
  }
}
