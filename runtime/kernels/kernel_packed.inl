/* Blocks of packed coefficients (core/polynomial/packed.h) with what they meet, over vectors of
 * 8 lanes, for a file that has included core/polynomial/kernel_lanes.h.
 *
 * Rows are kept from d = n-1 down ("reversed" vectors), or, of the mirrored order, from c up;
 * columns from -1 up ("lifted" vectors, entry 0 is 1). Coefficients are read in the order in which
 * they lie.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/polynomial/kernel_private.h"
#include "core/polynomial/packed.h"

/* Packed coefficients, in one of two precisions. */
typedef struct coefficients {
  const double *d;
  const float *f;
} coefficients;

/* Operands of a block at one point: monomials m of its columns with the results w, factors x of its
 * rows with the results y. */
typedef struct point {
  const double *m, *x;
  double *w, *y;
} point;

/* A block of packed rows. It has `whole` vectors of columns, of which a pass takes the first
 * `vectors`, and `all` rows, of which it takes those in [first, rows). The first `plain` vectors
 * contribute to sums alone, at the first point. */
typedef struct packed_block {
  coefficients b;
  int64_t at, whole, vectors, plain, all, first, rows;
} packed_block;

/* One more row of a block, with its x and y. */
typedef struct own_row {
  const double *b;
  double x;
  double *y;
} own_row;

/* Lists to which each row is added, times the q of the row. */
typedef struct row_lists {
  double q;
  double *const *list;
} row_lists;

INLINE v8x8 rows_zero8(void) {
  v8x8 s;
#define X(k) s.r[k] = v8_zero();
  EACH_8(X)
#undef X
  return s;
}

INLINE v8x8 rows_set8(int rows, const double *x) {
  v8x8 s = rows_zero8();
#define X(k)                                                                                       \
  if (k < rows)                                                                                    \
    s.r[k] = v8_set1(x[k]);
  EACH_8(X)
#undef X
  return s;
}

/* Prefetch distance, in numbers. Packed coefficients are read in order; where `ahead` is set, a
 * pass prefetches the number that it needs this much later. Measured: it pays where each number
 * takes part in many operations and costs where it takes part in few, except for short runs of few
 * rows of large blocks, where it would gain 5 to 10 %. */
#define AHEAD 128

INLINE v8 coefficient(bool single, bool ahead, const coefficients *b, int64_t at) {
  if (single) {
    if (ahead)
      v8_prefetch(b->f + at + 2 * AHEAD);
    return v8_load_single(b->f + at);
  }
  if (ahead)
    v8_prefetch(b->d + at + AHEAD);
  return v8_load(b->d + at);
}

/* Which products a pass makes with the rows of a block. */
typedef enum work_on {
  WORK_SUMS,  /* y of one point */
  WORK_ADDS,  /* w of one point */
  WORK_BOTH,  /* y and w of one point */
  WORK_OWN,   /* y and w of one point, with a separate row before the first */
  WORK_LISTS, /* y and w, and lists */
  WORK_TWICE  /* y and w of two points */
} work_on;

/* Adds the products of one vector of columns of each row to the rows' sums. */
INLINE void sum_rows(bool single, bool ahead, int rows, const coefficients *b, int64_t at, v8 m,
                     v8x8 *sum) {
#define X(k)                                                                                       \
  if (k < rows)                                                                                    \
    sum->r[k] = v8_add(sum->r[k], v8_mul(coefficient(single, ahead, b, at + 8 * k), m));
  EACH_8(X)
#undef X
}

/* Multiplies `rows` rows of a group of `size`, the first at `at`, at one point: w += B^T x, lists
 * += q times the row; returns the rows' sums and zeros behind them. */
INLINE v8 group_sums(bool single, work_on what, int rows, const packed_block *k, int64_t at,
                     int64_t size, const double *m, const double *x, double *w, const row_lists *l,
                     const own_row *own) {
  // sums and factors of the rows stay in registers over all columns
  const bool sums = what != WORK_ADDS, adds = what != WORK_SUMS;
  v8x8 sum = rows_zero8();
  v8 own_sum = v8_zero();
  const v8x8 factor = adds ? rows_set8(rows, x) : sum;
  const v8 q = l ? v8_set1(l->q) : v8_zero(), own_x = own ? v8_set1(own->x) : v8_zero();
  const coefficients *b = &k->b;

  // the addresses of the lists, which the compiler would read again after each store
  double *list[THRUM_PACK_ROWS] = {NULL};
  for (int r = 0; l && r < rows; r++)
    list[r] = l->list[r];

  // columns that only have sums
  int64_t v = 0;
  if (what == WORK_BOTH)
    for (; v < 8 * k->plain; v += 8, at += 8 * size)
      sum_rows(single, false, rows, b, at, v8_load(m + v), &sum);

  // the others, eight at a time: w and the lists are read and written once for all rows
  for (; v < 8 * k->vectors; v += 8, at += 8 * size) {
    const v8 m_v = sums ? v8_load(m + v) : v8_zero();
    v8 w_v = adds ? v8_load(w + v) : v8_zero();
    if (own) {
      const v8 part = v8_load(own->b + v);
      own_sum = v8_add(own_sum, v8_mul(part, m_v));
      w_v = v8_add(w_v, v8_mul(own_x, part));
    }
#define X(k)                                                                                       \
  if (k < rows) {                                                                                  \
    const v8 part = v8_keep(coefficient(single, l != NULL, b, at + 8 * k));                        \
    if (sums)                                                                                      \
      sum.r[k] = v8_add(sum.r[k], v8_mul(part, m_v));                                              \
    if (adds)                                                                                      \
      w_v = v8_add(w_v, v8_mul(factor.r[k], part));                                                \
    if (l)                                                                                         \
      v8_store(list[k] + v, v8_add(v8_load(list[k] + v), v8_mul(q, part)));                        \
  }
    EACH_8(X)
#undef X
    if (adds)
      v8_store(w + v, w_v);
  }

  if (own)
    *own->y = v8_sum(own_sum);
  return sums ? v8_sums_of(rows, &sum) : v8_zero();
}

/* The same with the sums in y[0..7]. */
INLINE void group_rows(bool single, work_on what, int rows, const packed_block *k, int64_t at,
                       int64_t size, const double *m, const double *x, double *w, double *y,
                       const row_lists *l, const own_row *own) {
  const v8 sums = group_sums(single, what, rows, k, at, size, m, x, w, l, own);
  if (what != WORK_ADDS)
    v8_store(y, sums);
}

/* Multiplies such rows at two points. */
INLINE void group_rows_twice(bool single, int rows, const packed_block *k, int64_t at, int64_t size,
                             int64_t row, const point p[2]) {
  // sums and factors of both points stay in registers
  v8x8 sum = rows_zero8(), sum2 = rows_zero8();
  const v8x8 factor = rows_set8(rows, p[0].x + row), factor2 = rows_set8(rows, p[1].x + row);
  const coefficients *b = &k->b;

  // columns that only have sums at the first point
  int64_t v = 0;
  for (; v < 8 * k->plain; v += 8, at += 8 * size)
    sum_rows(single, true, rows, b, at, v8_load(p[0].m + v), &sum);

  // the others at both points, with each coefficient read once
  for (; v < 8 * k->vectors; v += 8, at += 8 * size) {
    const v8 m = v8_load(p[0].m + v), m2 = v8_load(p[1].m + v);
    v8 w = v8_load(p[0].w + v), w2 = v8_load(p[1].w + v);
#define X(k)                                                                                       \
  if (k < rows) {                                                                                  \
    const v8 part = coefficient(single, true, b, at + 8 * k);                                      \
    sum.r[k] = v8_add(sum.r[k], v8_mul(part, m));                                                  \
    w = v8_add(w, v8_mul(factor.r[k], part));                                                      \
    sum2.r[k] = v8_add(sum2.r[k], v8_mul(part, m2));                                               \
    w2 = v8_add(w2, v8_mul(factor2.r[k], part));                                                   \
  }
    EACH_8(X)
#undef X
    v8_store(p[0].w + v, w);
    v8_store(p[1].w + v, w2);
  }

  v8_store_sums(rows, p[0].y + row, &sum);
  v8_store_sums(rows, p[1].y + row, &sum2);
}

INLINE void group_work(bool single, work_on what, int rows, const packed_block *b, int64_t at,
                       int64_t size, int64_t row, const point *p, const row_lists *l,
                       const own_row *own) {
  if (what == WORK_TWICE) {
    group_rows_twice(single, rows, b, at, size, row, p);
    return;
  }
  row_lists here = {0, NULL};
  if (what == WORK_LISTS)
    here = (row_lists){l->q, l->list + row};
  const double *x = what == WORK_SUMS ? NULL : p->x + row;
  double *y = what == WORK_ADDS ? NULL : p->y + row;
  if (what == WORK_OWN && row == 0)
    group_rows(single, what, rows, b, at, size, p->m, x, p->w, y, NULL, own);
  else
    group_rows(single, what, rows, b, at, size, p->m, x, p->w, y, what == WORK_LISTS ? &here : NULL,
               NULL);
}

/* Multiplies all rows of a block that a pass takes, as many at a time as registers hold. Behind the
 * last row, y is zero up to a multiple of 8; the rows of a group are stored in order, so the next
 * sums overwrite the zeros behind the last ones. */
INLINE void block_work(bool single, work_on what, const packed_block *b, const point *p,
                       const row_lists *l, const own_row *own) {
  // two points have twice as much to hold
  const int64_t most = what == WORK_TWICE ? ROWS_FEW : ROWS_MANY;
  for (int64_t first = b->first / THRUM_PACK_ROWS * THRUM_PACK_ROWS; first < b->rows;
       first += THRUM_PACK_ROWS) {
    // the group's size and how many of its rows the pass takes
    const int64_t size = thrum_pack_size(b->all, first);
    const int64_t wanted = size < b->rows - first ? size : b->rows - first;
    const int64_t begin = b->at + 8 * first * b->whole;

    // a compiled variant for each number of rows
    for (int64_t r = b->first > first ? b->first - first : 0; r < wanted; r += most) {
      const int64_t at = begin + 8 * r, row = first + r;
      switch (wanted - r < most ? wanted - r : most) {
#define X(k)                                                                                       \
  case k + 1:                                                                                      \
    if (k < most)                                                                                  \
      group_work(single, what, k + 1, b, at, size, row, p, l, own);                                \
    break;
        EACH_8(X)
#undef X
      default:
        break;
      }
    }
  }
}

#define BLOCK_PASS(name, what)                                                                     \
  PASS void name##_double(const packed_block *b, const point *p, const row_lists *l,               \
                          const own_row *own) {                                                    \
    block_work(false, what, b, p, l, own);                                                         \
  }                                                                                                \
  PASS void name##_single(const packed_block *b, const point *p, const row_lists *l,               \
                          const own_row *own) {                                                    \
    block_work(true, what, b, p, l, own);                                                          \
  }                                                                                                \
  INLINE void name(const packed_block *b, const point *p, const row_lists *l,                      \
                   const own_row *own) {                                                           \
    if (b->b.f)                                                                                    \
      name##_single(b, p, l, own);                                                                 \
    else                                                                                           \
      name##_double(b, p, l, own);                                                                 \
  }

BLOCK_PASS(packed_sums, WORK_SUMS)
BLOCK_PASS(packed_both, WORK_BOTH)
BLOCK_PASS(packed_lists, WORK_LISTS)
BLOCK_PASS(packed_twice, WORK_TWICE)

INLINE packed_block packed_first(const thrum_model *model) {
  const int64_t vectors = thrum_pack_vectors(0);
  const packed_block b = {.b = {model->packed, model->packed_single},
                          .whole = vectors,
                          .vectors = vectors,
                          .all = model->rank,
                          .rows = model->rank};
  return b;
}

INLINE packed_block packed_mirrored(const thrum_model *model) {
  packed_block b = packed_first(model);
  b.at = model->packed_count;
  return b;
}

/* Steps from a block to the next one, c, with all its rows. */
INLINE void packed_next(int64_t n, int64_t c, packed_block *b) {
  b->at += 8 * b->all * b->whole;
  b->first = 0;
  b->whole = b->vectors = thrum_pack_vectors(c);
  b->all = b->rows = n - c;
}

/* The arrays of a pass, which lie in its scratch. */
typedef struct pack_scratch {
  double *vectors[2][THRUM_PACK_VECTORS]; /* n + 1 numbers, whole lanes and a vector to spare */
  double *columns[2][THRUM_PACK_COLUMNS]; /* one number a column */
  double *blocks[2];                      /* eight lanes a block */
  double *lanes;                          /* eight lanes a run */
  double *more;                           /* further scratch of the tangent */
} pack_scratch;

INLINE pack_scratch pack_cut(int64_t n, double *work) {
  const int64_t vector = thrum_padded(n + 1), columns = thrum_padded(thrum_pack_first(n));

  pack_scratch s;
  s.lanes = work;
  work += 8 * vector;

  // the arrays of the first point come first, so a pass at one point needs less scratch
  for (int which = 0; which < 2; which++) {
    for (int64_t k = 0; k < THRUM_PACK_VECTORS; k++, work += vector)
      s.vectors[which][k] = work;
    for (int64_t k = 0; k < THRUM_PACK_COLUMNS; k++, work += columns)
      s.columns[which][k] = work;
    s.blocks[which] = work;
    work += 8 * vector;
  }

  s.more = work;
  return s;
}

/* Writes q in three orders, plain, reversed and lifted, each with zeros behind its end. */
INLINE void spread(int64_t n, int64_t given, const double *q, double one, double *plain,
                   double *reversed, double *lifted) {
  const int64_t size = thrum_padded(n + 1);
  for (int64_t i = 0; i < size; i += 8) {
    v8_store(plain + i, v8_zero());
    v8_store(reversed + i, v8_zero());
    v8_store(lifted + i, v8_zero());
  }
  lifted[0] = one;
  for (int64_t i = 0; i < given; i++)
    plain[i] = reversed[n - 1 - i] = lifted[i + 1] = q[i];
}

/* Writes the mirrored coordinates of q from z_first on, plain and lifted; the others are zero. */
INLINE void spread_mirrored(int64_t n, int64_t first, const double *q, double one, double *plain,
                            double *lifted) {
  const int64_t size = thrum_padded(n + 1);
  for (int64_t i = 0; i < size; i += 8) {
    v8_store(plain + i, v8_zero());
    v8_store(lifted + i, v8_zero());
  }
  lifted[0] = one;
  for (int64_t k = first; k < n; k++)
    plain[k] = lifted[k + 1] = q[n - 1 - k];
}

/* m_ba = a_b b^_a (+ b_b a^_a if `mixed`, where a^_{-1} is 0 and b_b for it) over the runs below
 * `last`, zeros up to the end of the last vector. */
INLINE void column_monomials(bool mixed, int64_t last, const double *a, const double *lifted_a,
                             const double *b, const double *lifted_b, double *m) {
  for (int64_t k = 0; k < last; k++) {
    const v8 a_k = v8_set1(a[k]), b_k = v8_set1(b[k]);
    // a run's last vector overlaps the next run, which is written later
    for (int64_t c = 0; c < k + 2; c += 8) {
      v8 product = v8_mul(a_k, v8_load(lifted_b + c));
      if (mixed)
        product = v8_add(product, v8_mul(b_k, v8_load(lifted_a + c)));
      v8_store(m + c, product);
    }
    m += k + 2;
  }
  v8_store(m, v8_zero());
}

/* x = s a (+ s2 a2 if `mixed`) over `rows` reversed entries. */
INLINE void row_factors(bool mixed, int64_t rows, double s, const double *a, double s2,
                        const double *a2, double *x) {
  const v8 factor = v8_set1(s), factor2 = v8_set1(s2);
  for (int64_t t = 0; t < rows; t += 8) {
    v8 product = v8_mul(factor, v8_load(a + t));
    if (mixed)
      product = v8_add(product, v8_mul(factor2, v8_load(a2 + t)));
    v8_store(x + t, product);
  }
}

/* y of a block: g += q_c y; returns `sum` plus the lanes of sum_d y_d q_d. */
INLINE v8 lower_block(int64_t rows, const double *y, double q_c, const double *reversed, v8 sum,
                      double *g) {
  const v8 factor = v8_set1(q_c);
  for (int64_t t = 0; t < rows; t += 8) {
    const v8 y_t = v8_load(y + t);
    v8_store(g + t, v8_add(v8_load(g + t), v8_mul(factor, y_t)));
    sum = v8_add(sum, v8_mul(y_t, v8_load(reversed + t)));
  }
  return sum;
}

/* The factors of the sums y of a block's rows: their own coordinates, g += q_c y, and q_c. */
typedef struct row_end {
  double q_c;
  const double *q; /* by row */
  double *g;
} row_end;

/* Multiplies all rows of a block, or has their sums alone; g += q_c y, returns the lanes of
 * sum_d y_d q_d. As block_work and lower_block do; where a group fits into registers its sums stay
 * there. */
INLINE v8 block_meets(bool single, work_on what, const packed_block *b, const point *p,
                      const row_end *end, const own_row *own) {
  if (ROWS_MANY < THRUM_PACK_ROWS) {
    block_work(single, what, b, p, NULL, own);
    return lower_block(b->rows, p->y, end->q_c, end->q, v8_zero(), end->g);
  }

  // a compiled variant for each number of rows
  const v8 q_c = v8_set1(end->q_c);
  v8 total = v8_zero();
  for (int64_t first = 0; first < b->rows; first += THRUM_PACK_ROWS) {
    const int64_t size = thrum_pack_size(b->all, first);
    const int64_t at = b->at + 8 * first * b->whole;
    v8 y = v8_zero();
    switch (size < b->rows - first ? size : b->rows - first) {
#define X(k)                                                                                       \
  case k + 1:                                                                                      \
    y = what == WORK_OWN && first > 0                                                              \
            ? group_sums(single, WORK_BOTH, k + 1, b, at, size, p->m, p->x + first, p->w, NULL,    \
                         NULL)                                                                     \
            : group_sums(single, what, k + 1, b, at, size, p->m,                                   \
                         what == WORK_SUMS ? NULL : p->x + first, p->w, NULL, own);                \
    break;
      EACH_8(X)
#undef X
    default:
      break;
    }
    v8_store(end->g + first, v8_add(v8_load(end->g + first), v8_mul(q_c, y)));
    total = v8_add(total, v8_mul(y, v8_load(end->q + first)));
  }
  return total;
}

/* One vector of run b: returns g + q_b w; adds its products with `lifted` to the run's lanes.
 */
INLINE v8 upper_part(bool starts, v8 part, double q_b, v8 lifted, double *lanes, v8 g) {
  const v8 before = starts ? v8_zero() : v8_load(lanes);
  v8_store(lanes, v8_add(before, v8_mul(part, lifted)));
  return v8_add(g, v8_mul(v8_set1(q_b), part));
}

/* Adds the gradient of sum w_ba q_b q^_a over the runs first..last-1: g_a += q_b w_ba, lifted;
 * lanes of s_b = sum_a w_ba q^_a, from zero if `starts`. */
INLINE void upper_runs(bool starts, int64_t first, int64_t last, const double *w, const double *q,
                       const double *lifted, double *g, double *lanes) {
  // eight columns at a time, which stay in a register over all runs
  for (int64_t c = 0; c <= last; c += 8) {
    const v8 lifted_c = v8_load(lifted + c);
    v8 g_c = v8_load(g + c);
    int64_t b = c - 1 > first ? c - 1 : first;

    // runs that end in this vector of columns, then those that continue
    for (; b < last && b < c + 6; b++) {
      const v8 part = v8_load_range(w + thrum_pack_first(b) + c, 0, b + 2 - c);
      g_c = upper_part(starts && c == 0, part, q[b], lifted_c, lanes + 8 * b, g_c);
    }
    for (; b < last; b++) {
      const v8 part = v8_load(w + thrum_pack_first(b) + c);
      g_c = upper_part(starts && c == 0, part, q[b], lifted_c, lanes + 8 * b, g_c);
    }

    v8_store(g + c, g_c);
  }
}

/* Adds up the lanes of these runs or blocks; behind the last sum there are zeros up to a multiple
 * of 8. */
INLINE void lane_sums(int64_t first, int64_t last, const double *lanes, double *s) {
  for (int64_t b = first; b < last; b += 8) {
    v8x8 sum = rows_zero8();
#define X(k)                                                                                       \
  if (b + k < last)                                                                                \
    sum.r[k] = v8_load(lanes + 8 * (b + k));
    EACH_8(X)
#undef X
    v8_store_sums(8, s + b, &sum);
  }
}

PASS void upper(int64_t first, int64_t last, const double *w, const double *q, const double *lifted,
                double *g, double *lanes, double *s) {
  upper_runs(true, first, last, w, q, lifted, g, lanes);
  lane_sums(first, last, lanes, s);
}

INLINE double lanes_dot(int64_t n, const double *a, const double *b) {
  v8 sum = v8_zero();
  for (int64_t c = 0; c < n; c += 8)
    sum = v8_add(sum, v8_mul(v8_load(a + c), v8_load(b + c)));
  return v8_sum(sum);
}

INLINE void zeros(double *a, int64_t count) {
  for (int64_t c = 0; c < count; c += 8)
    v8_store(a + c, v8_zero());
}
