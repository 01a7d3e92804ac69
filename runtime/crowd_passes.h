/* The passes of runtime/crowd.h, for a file that has defined
 *
 *   vs                  a number of each of LANES states
 *   LANES               states
 *   ROWS, ROWS_OWN      rows of a block taken at once, 1 to 8, and with a state's own besides
 *   INLINE, PASS        as for runtime/kernel_lanes.h
 *   vs_zero, vs_set1(s), vs_load(p), vs_store(p, a), vs_mul(a, b), vs_add(a, b)
 *   vs_set1_single(p)   one float
 *   vs_keep(a)          a, in a register from now on
 *   vs_again(p)         p; a number there may be loaded anew for each use
 *
 * A sum over columns has eight partial sums, column mod 8, as runtime/kernel.h says; here they are
 * eight registers, and no sum is taken across one. The passes over a whole model read it packed
 * (runtime/pack.h).
 * Cost: for each coefficient and LANES states 4 operations (force, gradient), 2 (restrict_to).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "crowd.h"
#include "crowd_rows.h"
#include "pack.h"

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

/* A row of which every state has its own: y += row m and w += x row, in the order of columns. */
INLINE void own_columns(int64_t count, const double *row, vs x, const double *m, double *w,
                        sums8 *y) {
#define X(k)                                                                                       \
  if (c + k < count) {                                                                             \
    const int64_t at = (c + k) * LANES;                                                            \
    const vs b = vs_load(row + at);                                                                \
    y->s[k] = vs_add(y->s[k], vs_mul(b, vs_load(m + at)));                                         \
    vs_store(w + at, vs_add(vs_load(w + at), vs_mul(x, b)));                                       \
  }
  for (int64_t c = 0; c < count; c += 8) {
    EACH_COLUMN(X)
  }
#undef X
}

/* The gradient of sum w_ba q_b q^_a over the runs first..last-1: h_a += q_b w_ba, lifted, and
 * s_b = sum_a w_ba q^_a. */
INLINE void upper(int64_t first, int64_t last, const double *w, const double *q,
                  const double *lifted, double *h, double *s) {
  w += thrum_pack_first(first) * LANES;
  for (int64_t b = first; b < last; w += (b + 2) * LANES, b++) {
    sums8 sum = sums_zero();
    own_columns(b + 2, w, vs_load(q + b * LANES), lifted, h, &sum);
    vs_store(s + b * LANES, sums_total(&sum));
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

/* Block 0 of an order, and on to block c; all of its rows and columns wanted. */
INLINE crowd_block block_first(const thrum_model *model, bool mirrored) {
  crowd_block k = {.b = {model->packed, model->packed_single}};
  k.b = packed_at(&k.b, mirrored ? model->packed_count : 0);
  k.whole = k.vectors = thrum_pack_vectors(0);
  k.all = k.rows = model->rank;
  k.step = mirrored ? 1 : -1;
  k.scale = vs_set1(1.0);
  return k;
}

INLINE void block_next(int64_t n, int64_t c, crowd_block *k) {
  k->b = packed_at(&k->b, 8 * k->all * k->whole);
  k->whole = k->vectors = thrum_pack_vectors(c);
  k->all = k->rows = n - c;
  k->first = 0;
}

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

/* g_d += q_c y_d over the rows of a block, d from `d` on by `step`; returns sum_d y_d q_d. */
INLINE vs lower_block(int64_t rows, int64_t d, int64_t step, const double *y, vs q_c,
                      const double *q, double *g) {
  sums8 sum = sums_zero();
#define X(k)                                                                                       \
  if (t + k < rows) {                                                                              \
    const int64_t at = (d + (t + k) * step) * LANES;                                               \
    const vs y_d = vs_load(y + (t + k) * LANES);                                                   \
    vs_store(g + at, vs_add(vs_load(g + at), vs_mul(q_c, y_d)));                                   \
    sum.s[k] = vs_add(sum.s[k], vs_mul(y_d, vs_load(q + at)));                                     \
  }
  for (int64_t t = 0; t < rows; t += 8) {
    EACH_COLUMN(X)
  }
#undef X
  return sums_total(&sum);
}

/* q in mirrored coordinates, with 1 before it. */
INLINE const double *mirror(int64_t n, const double *q, double *lifted) {
  vs_store(lifted, vs_set1(1.0));
  for (int64_t d = 0; d < n; d++)
    vs_store(lifted + (d + 1) * LANES, vs_load(q + (n - 1 - d) * LANES));
  return lifted + LANES;
}

/* The arrays of a gradient. */
typedef struct evaluation {
  double *m, *w, *y, *g, *s, *h, *lifted, *own_y;
  const double *z;
} evaluation;

INLINE evaluation evaluation_begin(int64_t n, const double *q, double *work) {
  const int64_t columns = thrum_crowd_columns(n) * LANES, vector = n * LANES;
  evaluation e = {.m = work, .w = work + columns, .y = work + 2 * columns};
  e.g = e.y + vector;
  e.s = e.g + vector;
  e.h = e.s + vector;
  e.lifted = e.h + vector + LANES;
  e.own_y = e.lifted + vector + LANES;
  e.z = mirror(n, q, e.lifted);
  monomials(n, e.lifted, e.m);
  clear(e.w, thrum_crowd_columns(n));
  clear(e.g, n);
  clear(e.h, n + 1);
  return e;
}

/* Entry k of a gradient: (g + h) + (s + more), the latter in y. */
INLINE vs evaluation_entry(const evaluation *e, int64_t k) {
  const int64_t at = k * LANES;
  return vs_add(vs_add(vs_load(e->g + at), vs_load(e->h + at + LANES)),
                vs_add(vs_load(e->s + at), vs_load(e->y + at)));
}

PASS void pass_force_part(const thrum_model *model, int64_t split, const double *q, double *force,
                          double *energy, double *work) {
  const int64_t n = model->rank, implicit = n - split;
  const evaluation e = evaluation_begin(n, q, work);
  crowd_block k = block_first(model, true);
  k.m = e.m;
  k.w = e.w;
  k.y = e.y;
  k.plain = thrum_pack_first(implicit) / 8;
  for (int64_t c = 0; c < n; c++) {
    k.q = e.z + c * LANES;
    k.scale = vs_load(k.q);
    if (c < implicit)
      block_sums(&k);
    else
      block_both(&k);
    vs_store(e.s + c * LANES, lower_block(n - c, c, 1, e.y, k.scale, e.z, e.g));
    block_next(n, c + 1, &k);
  }
  const vs value = dot(n, e.z, e.s);
  vs quadratic = vs_zero();
  for (int64_t i = 0; i < n; i++) {
    const vs q_i = vs_load(q + i * LANES);
    quadratic = vs_add(quadratic, vs_mul(vs_mul(vs_set1(0.5 * model->omega2[i]), q_i), q_i));
  }
  vs_store(energy, vs_add(quadratic, value));
  // y is free
  upper(implicit, n, e.w, e.z, e.lifted, e.h, e.y);
  for (int64_t i = 0; i < split; i++) {
    const vs linear = vs_mul(vs_set1(model->omega2[i]), vs_load(q + i * LANES));
    vs_store(force + i * LANES, vs_add(linear, evaluation_entry(&e, n - 1 - i)));
  }
}

/* Linear and quadratic terms; the latter's places are those of the columns (b,-1) of rows c. */
INLINE void restrict_low(const thrum_model *model, int64_t split, const double *q,
                         double *restricted, double *work) {
  const int64_t rank = model->rank, n = rank - split, columns = thrum_crowd_columns(rank);
  double *m = work, *y = m + columns * LANES, *lifted = y + rank * LANES;
  crowd_block k = block_first(model, false);
  k.q = q + (rank - 1) * LANES;
  k.m = m;
  k.y = y;
  lift(split, q, lifted);
  monomials(split, lifted, m);
  clear(restricted, thrum_restricted_first(n));
  for (int64_t c = 0; c < split; c++) {
    k.rows = n;
    block_sums(&k);
    const vs q_c = vs_load(q + c * LANES);
    for (int64_t i = 0; i < n * LANES; i += LANES)
      vs_store(restricted + i, vs_add(vs_load(restricted + i), vs_mul(q_c, vs_load(y + i))));
    block_next(rank, c + 1, &k);
  }
  double *row = restricted + thrum_restricted_count(n) * LANES;
  for (int64_t c = n - 1; c >= 0; c--) {
    row -= 8 * thrum_pack_vectors(c) * LANES;
    k.vectors = (thrum_pack_first(split) + 7) / 8;
    block_sums(&k);
    for (int64_t d = 0; d <= c; d++) {
      const vs rest = vs_set1(d == c ? 0.5 * model->omega2[rank - 1 - c] : 0.0);
      vs_store(row + thrum_pack_first(d) * LANES, vs_add(vs_load(y + d * LANES), rest));
    }
    block_next(rank, rank - c, &k);
  }
}

PASS void pass_restrict(const thrum_model *model, int64_t split, const double *q,
                        double *restricted, double *work) {
  const int64_t rank = model->rank, n = rank - split;
  double *z = work, *row = restricted + thrum_restricted_first(n) * LANES;
  for (int64_t d = n; d < rank; d++)
    vs_store(z + d * LANES, vs_load(q + (rank - 1 - d) * LANES));
  crowd_block k = block_first(model, true);
  for (int64_t c = 0; c < n; c++) {
    const int64_t columns = 8 * thrum_pack_vectors(c);
    clear(row, columns);
    k.first = n - c;
    k.q = z + c * LANES;
    k.w = row;
    block_adds(&k);
    row += columns * LANES;
    block_next(rank, c + 1, &k);
  }
  restrict_low(model, split, q, restricted, work);
}

PASS void pass_restricted_gradient(const thrum_model *model, int64_t split,
                                   const double *restricted, const double *q, double *gradient,
                                   double *value, double *work) {
  const int64_t n = model->rank - split;
  const evaluation e = evaluation_begin(n, q, work);
  const double *row = restricted + thrum_restricted_first(n) * LANES;
  crowd_block k = block_first(model, true);
  k.m = e.m;
  k.w = e.w;
  k.y = e.y;
  k.own_y = e.own_y;
  for (int64_t c = 0; c < n; c++) {
    k.rows = n - c;
    k.q = e.z + c * LANES;
    k.scale = vs_load(k.q);
    k.own = row;
    block_own(&k);
    const vs own = vs_add(vs_load(restricted + c * LANES), vs_load(e.own_y));
    vs_store(e.s + c * LANES, vs_add(own, lower_block(n - c, c, 1, e.y, k.scale, e.z, e.g)));
    row += 8 * thrum_pack_vectors(c) * LANES;
    block_next(model->rank, c + 1, &k);
  }
  upper(0, n, e.w, e.z, e.lifted, e.h, e.y);
  for (int64_t i = 0; i < n; i++)
    vs_store(gradient + i * LANES, evaluation_entry(&e, n - 1 - i));
  vs_store(value, dot(n, e.z, e.s));
}

#define THRUM_CROWD_TABLE                                                                          \
  { LANES, pass_force_part, pass_restrict, pass_restricted_gradient }
