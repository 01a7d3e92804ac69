/* Blocks of packed coefficients (runtime/pack.h) with what they meet of several states, for a file
 * that has defined what runtime/crowd_passes.h asks for.
 *
 * Rows are taken ROWS at a time, so that what a column has of the states is loaded once for them;
 * columns two residues mod 8 at a time, those whose partial sums are added first, so that the sums
 * of all the rows stay in registers.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "crowd.h"
#include "pack.h"

#define EACH_COLUMN(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7)

/* Packed coefficients from `at` on, in one of two precisions. */
typedef struct packed {
  const double *d;
  const float *f;
} packed;

INLINE packed packed_at(const packed *b, int64_t at) {
  const packed here = {b->d ? b->d + at : NULL, b->f ? b->f + at : NULL};
  return here;
}

/* The same, of which nothing is known: what was loaded from one is loaded again from the other. */
INLINE packed packed_again(const packed *b) {
  const packed here = {vs_again(b->d), b->f};
  return here;
}

INLINE vs packed_one(bool single, const packed *b, int64_t at) {
  return single ? vs_set1_single(b->f + at) : vs_set1(b->d[at]);
}

/* What is done to the rows of a block. */
typedef enum work_on {
  WORK_SUMS, /* y */
  WORK_ADDS, /* w */
  WORK_BOTH, /* both */
  WORK_OWN   /* both, and the row before them is every state's own */
} work_on;

/* A block of rows and what they meet: `whole` vectors of columns, of which the first `vectors` are
 * wanted, and of `all` rows those from `first` to before `rows`. x = scale q, for row t at
 * q + t step LANES. y by row; w by column. The first `plain` vectors give y alone. */
typedef struct crowd_block {
  packed b;
  int64_t whole, vectors, plain, all, first, rows;
  vs scale;
  const double *q;
  int64_t step;
  const double *m;
  double *w, *y;
  const double *own; /* row */
  double *own_y;
} crowd_block;

/* Rows that are taken at once, and what goes with them: behind the last the own row, if any. */
typedef struct tile {
  packed b, again; /* the same coefficients, seen so that each use may load its own */
  int64_t size;    /* of the group that the rows are in */
  vs x[ROWS + 1];
} tile;

/* One column of all rows. */
INLINE void tile_column(bool single, work_on what, int rows, const tile *t, int64_t at,
                        const double *m, double *w, const double *own, vs *sum) {
  const bool sums = what != WORK_ADDS, adds = what != WORK_SUMS;
  const vs m_c = sums ? vs_keep(vs_load(m)) : vs_zero();
  vs w_c = adds ? vs_load(w) : m_c;
  if (what == WORK_OWN) {
    const vs b_c = vs_load(own);
    sum[rows] = vs_add(sum[rows], vs_mul(b_c, m_c));
    w_c = vs_add(w_c, vs_mul(t->x[rows], b_c));
  }
  for (int r = 0; r < rows; r++) {
    if (sums)
      sum[r] = vs_add(sum[r], vs_mul(packed_one(single, &t->b, at + 8 * r), m_c));
    if (adds)
      w_c = vs_add(w_c, vs_mul(t->x[r], packed_one(single, &t->again, at + 8 * r)));
  }
  if (adds)
    vs_store(w, w_c);
}

/* Columns p and p + 4 of every vector; the sum of the rows' two partial sums. */
INLINE void tile_pair(bool single, work_on what, int rows, const tile *t, const crowd_block *k,
                      int64_t p, vs *sum) {
  const bool sums = what != WORK_ADDS, adds = what != WORK_SUMS, own = what == WORK_OWN;
  const double *m = sums ? k->m + p * LANES : NULL, *mine = own ? k->own + p * LANES : NULL;
  double *w = adds ? k->w + p * LANES : NULL;
  vs low[ROWS + 1], high[ROWS + 1];
  for (int r = 0; r < ROWS + 1; r++)
    low[r] = high[r] = vs_zero();
  int64_t v = 0, at = p;
  if (what == WORK_BOTH) {
    for (; v < k->plain; v++, at += 8 * t->size, m += 8 * LANES) {
      tile_column(single, WORK_SUMS, rows, t, at, m, NULL, NULL, low);
      tile_column(single, WORK_SUMS, rows, t, at + 4, m + 4 * LANES, NULL, NULL, high);
    }
    w += 8 * v * LANES;
  }
  for (; v < k->vectors; v++, at += 8 * t->size) {
    tile_column(single, what, rows, t, at, m, w, mine, low);
    tile_column(single, what, rows, t, at + 4, sums ? m + 4 * LANES : NULL,
                adds ? w + 4 * LANES : NULL, own ? mine + 4 * LANES : NULL, high);
    m = sums ? m + 8 * LANES : NULL;
    w = adds ? w + 8 * LANES : NULL;
    mine = own ? mine + 8 * LANES : NULL;
  }
  for (int r = 0; r < ROWS + 1; r++)
    sum[r] = vs_add(low[r], high[r]);
}

INLINE void tile_work(bool single, work_on what, int rows, const packed *b, int64_t size,
                      const crowd_block *k, int64_t row) {
  tile t = {.b = *b, .again = packed_again(b), .size = size};
  for (int r = 0; r < rows && what != WORK_SUMS; r++)
    t.x[r] = vs_mul(k->scale, vs_load(k->q + (row + r) * k->step * LANES));
  if (what == WORK_OWN)
    t.x[rows] = k->scale;
  vs part[4][ROWS + 1];
  for (int64_t p = 0; p < 4; p++)
    tile_pair(single, what, rows, &t, k, p, part[p]);
#define TOTAL(r) vs_add(vs_add(part[0][r], part[2][r]), vs_add(part[1][r], part[3][r]))
  for (int r = 0; r < rows && what != WORK_ADDS; r++)
    vs_store(k->y + (row + r) * LANES, TOTAL(r));
  if (what == WORK_OWN)
    vs_store(k->own_y, TOTAL(rows));
#undef TOTAL
}

INLINE void block_rows(bool single, work_on what, const crowd_block *k) {
  int64_t row = k->first, count;
  for (; row < k->rows; row += count) {
    const int64_t first = row / THRUM_PACK_ROWS * THRUM_PACK_ROWS;
    const int64_t size = thrum_pack_size(k->all, first);
    const int64_t end = first + size < k->rows ? first + size : k->rows;
    const packed here = packed_at(&k->b, 8 * (first * k->whole + (row - first)));
    const bool own = what == WORK_OWN && row == 0;
    const int64_t most = own ? ROWS_OWN : ROWS;
    count = end - row < most ? end - row : most;
    switch (count) {
#define X(r)                                                                                       \
  case r + 1:                                                                                      \
    if (r < ROWS_OWN && own)                                                                       \
      tile_work(single, WORK_OWN, r + 1, &here, size, k, row);                                     \
    else if (r < ROWS)                                                                             \
      tile_work(single, what == WORK_OWN ? WORK_BOTH : what, r + 1, &here, size, k, row);          \
    break;
      EACH_COLUMN(X)
#undef X
    }
  }
}

#define BLOCK_PASS(name, what)                                                                     \
  PASS void name(const crowd_block *k) {                                                           \
    if (k->b.f)                                                                                    \
      block_rows(true, what, k);                                                                   \
    else                                                                                           \
      block_rows(false, what, k);                                                                  \
  }

BLOCK_PASS(block_sums, WORK_SUMS)
BLOCK_PASS(block_adds, WORK_ADDS)
BLOCK_PASS(block_both, WORK_BOTH)
BLOCK_PASS(block_own, WORK_OWN)
