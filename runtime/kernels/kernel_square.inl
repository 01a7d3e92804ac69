/* The passes of core/polynomial/kernel_private.h over a square matrix, for a file that has
 * included core/polynomial/kernel_lanes.h.
 *
 * A pass takes up to four vectors of columns, which stay in registers while it runs over the rows
 * or over the pairs of vectors.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdbool.h>
#include <stdint.h>

#define SQUARE_VECTORS 4

/* CALL(vectors) with a number that the compiler knows, so that it unrolls. */
#define SQUARE_CASES(vectors, CALL)                                                                \
  switch (vectors) {                                                                               \
  case 1:                                                                                          \
    CALL(1);                                                                                       \
    break;                                                                                         \
  case 2:                                                                                          \
    CALL(2);                                                                                       \
    break;                                                                                         \
  case 3:                                                                                          \
    CALL(3);                                                                                       \
    break;                                                                                         \
  default:                                                                                         \
    CALL(SQUARE_VECTORS);                                                                          \
  }

/* The same for all rows begin..end-1 of n and the columns from `first` on, or for the lower
 * triangle in whole vectors, which may reach past the diagonal. */
#define SQUARE_ROWS(n, lower, CALL)                                                                \
  for (int64_t first = 0; first < n; first += 8 * SQUARE_VECTORS) {                                \
    const int64_t most = square_vectors(n - first);                                                \
    int64_t vectors = lower ? 1 : most, end;                                                       \
    for (int64_t begin = lower ? first : 0; begin < n; begin = end, vectors++) {                   \
      end = vectors < most ? begin + 8 : n;                                                        \
      SQUARE_CASES(vectors, CALL)                                                                  \
    }                                                                                              \
  }

/* Number of vectors for these columns, at most the number taken at once. */
INLINE int64_t square_vectors(int64_t columns) {
  return columns < 8 * SQUARE_VECTORS ? (columns + 7) / 8 : SQUARE_VECTORS;
}

/* Loads vector k of `vectors`, of which only the last may be partial. */
INLINE v8 square_load(const double *p, int k, int vectors, v8_mask last) {
  return k + 1 < vectors ? v8_load(p + 8 * k) : v8_load_mask(p + 8 * k, last);
}

INLINE void square_store(double *p, int k, int vectors, int64_t columns, v8 a) {
  if (k + 1 < vectors)
    v8_store(p + 8 * k, a);
  else
    v8_store_first(p + 8 * k, a, columns - 8 * k);
}

/* Adds up the products in the columns from `first` on. */
INLINE void product_columns(int vectors, int64_t rows, int64_t n, int64_t first,
                            const double *matrix, const double *x, double *y) {
  const v8_mask last = v8_range(0, n - first - 8 * (vectors - 1));
  v8 sum[SQUARE_VECTORS];
  for (int k = 0; k < vectors; k++)
    sum[k] = v8_zero();
  for (int64_t i = 0; i < rows; i++) {
    const v8 x_i = v8_set1(x[i]);
    for (int k = 0; k < vectors; k++)
      sum[k] = v8_add(sum[k], v8_mul(x_i, square_load(matrix + i * n + first, k, vectors, last)));
  }
  for (int k = 0; k < vectors; k++)
    square_store(y + first, k, vectors, n - first, sum[k]);
}

PASS void pass_product(int64_t rows, int64_t n, const double *matrix, const double *x, double *y) {
#define CALL(vectors) product_columns(vectors, rows, n, first, matrix, x, y)
  for (int64_t first = 0; first < n; first += 8 * SQUARE_VECTORS)
    SQUARE_CASES(square_vectors(n - first), CALL)
#undef CALL
}

/* Corrects rows begin..end-1 in the columns from `first` on. */
INLINE void rank_two_rows(int vectors, int64_t n, int64_t first, int64_t begin, int64_t end,
                          const thrum_two *t, double *matrix) {
  const v8_mask last = v8_range(0, n - first - 8 * (vectors - 1));
  for (int64_t i = begin; i < end; i++) {
    // the row's part stays in registers while all pairs are taken from it
    double *row = matrix + i * n + first;
    v8 sum[SQUARE_VECTORS];
    for (int k = 0; k < vectors; k++)
      sum[k] = square_load(row, k, vectors, last);

    // a b^T + c d^T, one pair after the other
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

PASS void pass_rank_two(int64_t n, bool lower, const thrum_two *t, double *matrix) {
#define CALL(vectors) rank_two_rows(vectors, n, first, begin, end, t, matrix)
  SQUARE_ROWS(n, lower, CALL)
#undef CALL
}

/* --- sweep ------------------------------------------------------------------------------------ */

/* Pivots k and l = k + 1, one of each pair of lanes: all lanes but two, and one lane. */
static const union {
  uint64_t bits[16];
  double lanes[16];
} sweep_others = {{~0ULL, ~0ULL, ~0ULL, ~0ULL, ~0ULL, ~0ULL, ~0ULL, ~0ULL, 0, 0, ~0ULL, ~0ULL,
                   ~0ULL, ~0ULL, ~0ULL, ~0ULL}};
static const double sweep_unit[16] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0};

/* Scratch of a sweep, each array as long as a row of the matrix.
 *
 * f is the column of pivot k, and s that of l after k was swept, both without these two entries; m
 * and n are f and s divided by minus the pivots. Row i gets m_i f + n_i s added, and rows and
 * columns k and l become row_k and row_l. */
typedef struct sweep_pair {
  double *least, *f, *s, *m, *n, *row_k, *row_l, *raw_k, *raw_l;
} sweep_pair;

INLINE sweep_pair sweep_cut(int64_t stride, double *work) {
  const sweep_pair p = {work,
                        work + stride,
                        work + 2 * stride,
                        work + 3 * stride,
                        work + 4 * stride,
                        work + 5 * stride,
                        work + 6 * stride,
                        work + 7 * stride,
                        work + 8 * stride};
  return p;
}

/* Replaces lanes k and l of a vector by two numbers. */
INLINE v8 sweep_put(v8 a, int64_t k, double at_k, double at_l) {
  const v8 e_k = v8_load(sweep_unit + 8 - k), e_l = v8_load(sweep_unit + 7 - k);
  const v8 both = v8_add(v8_mul(v8_set1(at_k), e_k), v8_mul(v8_set1(at_l), e_l));
  return v8_add(v8_and(a, v8_load(sweep_others.lanes + 8 - k)), both);
}

/* Fills the columns of the next two pivots; false where a pivot is too small. Rows of the matrix
 * hold up to column `whole`, from there on its columns do. */
INLINE bool sweep_columns(int64_t n, int64_t k, int64_t whole, const double *matrix,
                          const sweep_pair *p) {
  // both pivots, the second as the first one's sweep leaves it; a small one ends the sweep
  const int64_t stride = thrum_whole(n), lane = k % 8;
  const double *row_k = matrix + k * stride, *row_l = row_k + stride;
  const double pivot_k = row_k[k], beside = row_k[k + 1];
  if (!(p->least[k] > 0.0 && pivot_k > p->least[k]))
    return false;
  const double minus_k = -1.0 / pivot_k, factor = beside * minus_k;
  const double pivot_l = row_l[k + 1] + factor * beside;
  if (!(p->least[k + 1] > 0.0 && pivot_l > p->least[k + 1]))
    return false;
  const double minus_l = -1.0 / pivot_l, corner = factor * minus_l;

  // rows below `whole` hold what the columns had there
  for (int64_t i = whole; i < n; i++) {
    p->raw_k[i] = matrix[i * stride + k];
    p->raw_l[i] = matrix[i * stride + k + 1];
  }

  // the columns before and after the sweep, eight entries at a time
  for (int64_t i = 0; i < stride; i += 8) {
    v8 f = v8_load(i < whole ? row_k + i : p->raw_k + i);
    v8 s = v8_load(i < whole ? row_l + i : p->raw_l + i);
    const v8 m = v8_mul(f, v8_set1(minus_k));
    s = v8_add(s, v8_mul(v8_set1(factor), f));
    v8 n_i = v8_mul(s, v8_set1(minus_l));
    v8 new_l = v8_mul(n_i, v8_set1(-1.0));
    v8 new_k = v8_add(v8_mul(v8_set1(factor), new_l), v8_mul(m, v8_set1(-1.0)));

    // the pivots' own entries
    if (i == k - lane) {
      f = sweep_put(f, lane, -1.0, 0.0);
      s = sweep_put(s, lane, -factor, -1.0);
      new_k = sweep_put(new_k, lane, minus_k + factor * corner, corner);
      new_l = sweep_put(new_l, lane, corner, minus_l);
    }

    v8_store(p->f + i, f);
    v8_store(p->s + i, s);
    v8_store(p->m + i, m);
    v8_store(p->n + i, n_i);
    v8_store(p->row_k + i, new_k);
    v8_store(p->row_l + i, new_l);
  }
  return true;
}

/* Corrects rows begin..end-1 in the columns from `first` on. */
INLINE void sweep_rows(int vectors, int64_t stride, int64_t first, int64_t begin, int64_t end,
                       int64_t k, const sweep_pair *p, double *matrix) {
  // factors of the columns, and a mask that clears the pivots' own entries
  v8 f[SQUARE_VECTORS], s[SQUARE_VECTORS], others[SQUARE_VECTORS];
  for (int v = 0; v < vectors; v++) {
    const int64_t lane = k - first - 8 * v;
    f[v] = v8_load(p->f + first + 8 * v);
    s[v] = v8_load(p->s + first + 8 * v);
    others[v] = v8_load(sweep_others.lanes + (lane >= 0 && lane < 8 ? 8 - lane : 0));
  }

  // each row loses its multiples of both pivots' rows
  for (int64_t i = begin; i < end; i++) {
    double *row = matrix + i * stride + first;
    const v8 m = v8_set1(p->m[i]), n_i = v8_set1(p->n[i]);
    for (int v = 0; v < vectors; v++) {
      const v8 added = v8_add(v8_mul(m, f[v]), v8_mul(n_i, s[v]));
      v8_store(row + 8 * v, v8_add(v8_and(v8_load(row + 8 * v), others[v]), added));
    }
  }
}

PASS int64_t pass_sweep(int64_t n, double *matrix, double *work) {
  const int64_t stride = thrum_whole(n);
  const sweep_pair p = sweep_cut(stride, work);

  // a pivot counts as lost where it is small relative to its first value
  for (int64_t i = 0; i < n; i++)
    p.least[i] = THRUM_SMALL_PIVOT * matrix[i * stride + i];
  for (int64_t i = n; i < stride; i++)
    p.raw_k[i] = p.raw_l[i] = 0.0;

  // two pivots at a time halve the passes over the matrix
  for (int64_t k = 0; k < n; k += 2) {
    const int64_t whole = k / 8 * 8 + 8;
    if (!sweep_columns(n, k, whole, matrix, &p))
      return k;
#define CALL(vectors) sweep_rows(vectors, stride, first, begin, end, k, &p, matrix)
    SQUARE_ROWS(n, true, CALL)
#undef CALL

    // the pivots' own rows, which the pass over the others left out
    for (int64_t i = 0; i < whole; i += 8) {
      v8_store(matrix + k * stride + i, v8_load(p.row_k + i));
      v8_store(matrix + (k + 1) * stride + i, v8_load(p.row_l + i));
    }
  }
  return n;
}
