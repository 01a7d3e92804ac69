/* Products of blocks of packed coefficients (core/polynomial/packed.h) with vectors of several
 * states, for a file that has defined the macros listed in runtime/batch/batch_passes.inl.
 *
 * A pass takes ROWS rows at a time, so that the states' numbers of a column are loaded once for all
 * of them. It takes the columns of two residues mod 8 at a time, the two whose partial sums are
 * added first, so that the sums of all these rows stay in registers.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/polynomial/packed.h"
#include "runtime/batch/batch_kernel.h"

#define EACH_COLUMN(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7)

/* Packed coefficients in double or single precision; the other pointer is NULL. */
typedef struct packed {
  const double *d;
  const float *f;
} packed;

INLINE packed packed_at(const packed *b, int64_t at) {
  const packed here = {b->d ? b->d + at : NULL, b->f ? b->f + at : NULL};
  return here;
}

/* The same coefficients behind a pointer that the compiler cannot trace, so that it loads them
 * again instead of keeping them in registers. */
INLINE packed packed_again(const packed *b) {
  const packed here = {vs_again(b->d), b->f};
  return here;
}

INLINE vs packed_one(bool single, const packed *b, int64_t at) {
  return single ? vs_set1_single(b->f + at) : vs_set1(b->d[at]);
}

/* Which products a pass makes with the rows of a block. */
typedef enum work_on {
  WORK_SUMS,   /* adds to y */
  WORK_STARTS, /* writes w without reading it */
  WORK_ADDS,   /* adds to w */
  WORK_BOTH,   /* adds to y and w */
  WORK_OVER,   /* adds to y and writes w, which begins with the own row */
  WORK_OWN     /* adds to y and w, with a row of each state's own before the others */
} work_on;

/* A block of rows and its operands. It has `whole` vectors of columns, of which a pass takes those
 * in [begin, vectors), and `all` rows, of which it takes those in [first, rows). x = scale z; z and
 * y are by row, m and w by column. Vectors before the `plain`-th contribute to y alone. */
typedef struct batch_block {
  packed b;
  int64_t whole, begin, vectors, plain, all, first, rows;
  vs scale; /* x of the own row */
  const double *m, *z;
  double *w, *y;
  const double *own; /* coefficients of the own row, by column */
  double *own_y;
} batch_block;

/* Rows that are taken at once and their operands. They are copied from the block because a store
 * could change it as far as the compiler knows. */
typedef struct tile {
  packed b, again; /* the same coefficients, so that y and w each load their own */
  int64_t stride;  /* from one vector of columns to the next */
  int64_t begin, plain, vectors;
  const double *m, *own;
  double *w;
  vs x[ROWS], own_x;
} tile;

/* Multiplies one column of all rows, the one at `column` of m and w. The sum of the own row stands
 * behind those of the others. */
INLINE void tile_column(bool single, work_on what, int rows, const tile *t, int64_t at,
                        int64_t column, vs *sum) {
  const bool starts = what == WORK_STARTS, sums = what != WORK_ADDS && !starts;
  const bool adds = what != WORK_SUMS;

  // only the operands of the wanted products are loaded
  const vs m_c = sums ? vs_keep(vs_load(t->m + column)) : vs_zero();
  const double *before = what == WORK_OVER ? t->own : t->w;
  vs w_c = adds && !starts ? vs_load(before + column) : vs_zero();

  // the own row's coefficients differ from state to state
  if (what == WORK_OWN) {
    const vs b_c = vs_load(t->own + column);
    sum[rows] = vs_add(sum[rows], vs_mul(b_c, m_c));
    w_c = vs_add(w_c, vs_mul(t->own_x, b_c));
  }

  // the shared coefficients are spread over all states
  for (int r = 0; r < rows; r++) {
    if (sums)
      sum[r] = vs_add(sum[r], vs_mul(packed_one(single, &t->b, at + 8 * r), m_c));
    if (adds)
      w_c = vs_add(w_c, vs_mul(t->x[r], packed_one(single, &t->again, at + 8 * r)));
  }
  if (adds)
    vs_store(t->w + column, w_c);
}

/* Multiplies columns p and p + 4 of every vector; sum[r] gets the sum of row r's two partial sums.
 */
INLINE void tile_pair(bool single, work_on what, int rows, const tile *t, int64_t p, vs *sum) {
  vs low[ROWS + 1], high[ROWS + 1];
  for (int r = 0; r < ROWS + 1; r++)
    low[r] = high[r] = vs_zero();

  // vectors before `plain` give sums alone
  int64_t v = t->begin, at = p + v * t->stride, column = (p + 8 * v) * LANES;
  if (what == WORK_BOTH)
    for (; v < t->plain; v++, at += t->stride, column += 8 * LANES) {
      tile_column(single, WORK_SUMS, rows, t, at, column, low);
      tile_column(single, WORK_SUMS, rows, t, at + 4, column + 4 * LANES, high);
    }

  // the others give what is asked for
  for (; v < t->vectors; v++, at += t->stride, column += 8 * LANES) {
    tile_column(single, what, rows, t, at, column, low);
    tile_column(single, what, rows, t, at + 4, column + 4 * LANES, high);
  }

  // residues p and p + 4 are added first in every kernel
  for (int r = 0; r < ROWS + 1; r++)
    sum[r] = vs_add(low[r], high[r]);
}

/* Multiplies a tile: `rows` rows of the block from `row` on, in all its columns. */
INLINE void tile_work(bool single, work_on what, int rows, const packed *b, int64_t size,
                      const batch_block *k, int64_t row) {
  const bool sums = what != WORK_ADDS && what != WORK_STARTS;
  tile t = {.b = *b, .again = packed_again(b), .stride = 8 * size, .own_x = k->scale};
  t.begin = k->begin;
  t.plain = k->plain;
  t.vectors = k->vectors;
  t.m = k->m;
  t.w = k->w;
  t.own = k->own;

  // the factors of w stay in registers over all columns
  for (int r = 0; r < rows && what != WORK_SUMS; r++)
    t.x[r] = vs_mul(k->scale, vs_load(k->z + (row + r) * LANES));

  // two residues at a time leave registers for all sums
  vs part[4][ROWS + 1];
  for (int64_t p = 0; p < 4; p++)
    tile_pair(single, what, rows, &t, p, part[p]);

// the fixed tree over the residues, as in every kernel
#define TOTAL(r) vs_add(vs_add(part[0][r], part[2][r]), vs_add(part[1][r], part[3][r]))
  for (int r = 0; r < rows && sums; r++)
    vs_store(k->y + (row + r) * LANES, TOTAL(r));
  if (what == WORK_OWN)
    vs_store(k->own_y, TOTAL(rows));
#undef TOTAL
}

/* Multiplies all rows of a block. Its first tile has at most `most` rows and makes the products
 * `begins`; the others make `what`. */
INLINE void block_rows(bool single, work_on begins, int64_t most, work_on what,
                       const batch_block *k) {
  int64_t row = k->first, count;
  for (; row < k->rows; row += count) {
    // rows lie in groups, of which a tile takes some
    const int64_t first = row / THRUM_PACK_ROWS * THRUM_PACK_ROWS;
    const int64_t size = thrum_pack_size(k->all, first);
    const int64_t end = first + size < k->rows ? first + size : k->rows;
    const packed here = packed_at(&k->b, 8 * (first * k->whole + (row - first)));

    const bool begin = begins != what && row == k->first;
    const int64_t limit = begin ? most : ROWS;
    count = end - row < limit ? end - row : limit;

    // a constant number of rows lets the compiler unroll the tile
    switch (count) {
#define X(r)                                                                                       \
  case r + 1:                                                                                      \
    if (r < most && begin)                                                                         \
      tile_work(single, begins, r + 1, &here, size, k, row);                                       \
    else if (r < ROWS)                                                                             \
      tile_work(single, what, r + 1, &here, size, k, row);                                         \
    break;
      EACH_COLUMN(X)
#undef X
    }
  }
}

#define BLOCK_PASS(name, begins, most, what)                                                       \
  PASS void name(const batch_block *k) {                                                           \
    if (k->b.f)                                                                                    \
      block_rows(true, begins, most, what, k);                                                     \
    else                                                                                           \
      block_rows(false, begins, most, what, k);                                                    \
  }

BLOCK_PASS(block_sums, WORK_SUMS, ROWS, WORK_SUMS)
BLOCK_PASS(block_adds, WORK_STARTS, ROWS, WORK_ADDS)
BLOCK_PASS(block_both, WORK_BOTH, ROWS, WORK_BOTH)
BLOCK_PASS(block_over, WORK_OVER, ROWS, WORK_BOTH)
BLOCK_PASS(block_own, WORK_OWN, ROWS_FEW, WORK_BOTH)

/* A row of a block: vector v at v `stride`. */
typedef struct block_row {
  packed b;
  int64_t stride;
} block_row;

/* Row t of block c, which has `all` rows. */
INLINE block_row row_of(const packed *b, int64_t c, int64_t all, int64_t t) {
  const int64_t first = t / THRUM_PACK_ROWS * THRUM_PACK_ROWS;
  const block_row row = {packed_at(b, 8 * (first * thrum_pack_vectors(c) + (t - first))),
                         8 * thrum_pack_size(all, first)};
  return row;
}

/* list = l + sum_c z_c (row c) over `count` blocks, in the columns of the last one; w += z_c l for
 * the last c. */
INLINE void list_rows(bool single, int64_t count, const block_row *rows, const double *z,
                      const double *l, double *list, double *w) {
  const vs last = vs_load(z + (count - 1) * LANES);
  int64_t begin = 0;
  for (int64_t v = 0; v < thrum_pack_vectors(count - 1); v++) {
    // a block has columns up to its own number alone
    while (thrum_pack_vectors(begin) <= v)
      begin++;

    vs sum[8];
    for (int k = 0; k < 8; k++)
      sum[k] = vs_zero();
    for (int64_t c = begin; c < count; c++) {
      const vs z_c = vs_keep(vs_load(z + c * LANES));
      for (int k = 0; k < 8; k++)
        sum[k] =
            vs_add(sum[k], vs_mul(packed_one(single, &rows[c].b, v * rows[c].stride + k), z_c));
    }

    // one pass stores the list and adds its share to w
    for (int k = 0; k < 8; k++) {
      const int64_t column = (8 * v + k) * LANES;
      const vs l_k = vs_load(l + column);
      vs_store(list + column, vs_add(sum[k], l_k));
      vs_store(w + column, vs_add(vs_load(w + column), vs_mul(last, l_k)));
    }
  }
}

PASS void list_of(int64_t count, const block_row *rows, const double *z, const double *l,
                  double *list, double *w) {
  if (rows[0].b.f)
    list_rows(true, count, rows, z, l, list, w);
  else
    list_rows(false, count, rows, z, l, list, w);
}
