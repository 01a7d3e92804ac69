/* The passes of runtime/batch/batch_kernel.h, for a file that has defined
 *
 *   vs                  one number of each of LANES states
 *   LANES               number of states
 *   ROWS, ROWS_FEW      rows of a block taken at once, 1 to 8; ROWS_FEW where each has more
 * products INLINE, PASS        as for core/polynomial/kernel_lanes.h vs_zero, vs_set1(s),
 * vs_load(p), vs_store(p, a), vs_mul(a, b), vs_div(a, b), vs_add(a, b) vs_set1_single(p)   one
 * float vs_keep(a) a, which the compiler keeps in a register vs_again(p)         p, through which
 * the compiler loads a number again for each use
 *
 * A sum over columns has eight partial sums, column mod 8, as core/polynomial/kernel_private.h
 * says; here they are eight registers, and no sum runs across the lanes of one. The passes over a
 * whole model read it packed (core/polynomial/packed.h). Cost: for each coefficient and LANES
 * states 4 operations (force, gradient, tangent by pairs), 2 (restrict_to), 6 (Hessian), 8 (tangent
 * times vector).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "core/polynomial/packed.h"
#include "runtime/batch/batch_kernel.h"
#include "runtime/batch/batch_rows.inl"

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

/* Multiplies a row of which every state has its own: y += row m and w += x row, in the order of the
 * columns. */
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

/* Adds the gradient of sum w_ba q_b q^_a over the runs first..last-1: h_a += q_b w_ba, lifted, and
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

/* Block 0 of an order and the step from a block to the next, c; with all rows and columns. */
INLINE batch_block block_first(const thrum_model *model, bool mirrored) {
  batch_block k = {.b = {model->packed, model->packed_single}};
  k.b = packed_at(&k.b, mirrored ? model->packed_count : 0);
  k.whole = k.vectors = thrum_pack_vectors(0);
  k.all = k.rows = model->rank;
  k.scale = vs_set1(1.0);
  return k;
}

INLINE void block_next(int64_t n, int64_t c, batch_block *k) {
  k->b = packed_at(&k->b, 8 * k->all * k->whole);
  k->whole = k->vectors = thrum_pack_vectors(c);
  k->all = k->rows = n - c;
  k->first = 0;
}

/* m_ba = a_b b^_a (+ b_b a^_a if `mixed`) over the runs below `last` of lifted vectors, with zeros
 * up to the end of the last vector. */
INLINE void monomials(bool mixed, int64_t last, const double *a, const double *b, double *m) {
  for (int64_t k = 0; k < last; k++) {
    const vs a_k = vs_load(a + (k + 1) * LANES), b_k = vs_load(b + (k + 1) * LANES);
    for (int64_t c = 0; c < (k + 2) * LANES; c += LANES, m += LANES) {
      const vs product = vs_mul(a_k, vs_load(b + c));
      vs_store(m, mixed ? vs_add(product, vs_mul(b_k, vs_load(a + c))) : product);
    }
  }
  for (int k = 0; k < 8; k++)
    vs_store(m + k * LANES, vs_zero());
}

/* g_d += q_c y_d over the rows of a block; sum += y_d q_d. The arrays begin at the block's first
 * row. */
INLINE void lower_block(int64_t rows, const double *y, vs q_c, const double *q, sums8 *sum,
                        double *g) {
#define X(k)                                                                                       \
  if (t + k < rows) {                                                                              \
    const int64_t at = (t + k) * LANES;                                                            \
    const vs y_d = vs_load(y + at);                                                                \
    vs_store(g + at, vs_add(vs_load(g + at), vs_mul(q_c, y_d)));                                   \
    sum->s[k] = vs_add(sum->s[k], vs_mul(y_d, vs_load(q + at)));                                   \
  }
  for (int64_t t = 0; t < rows; t += 8) {
    EACH_COLUMN(X)
  }
#undef X
}

/* The arrays of an evaluation at a point z in mirrored coordinates, by mode (n) and by column; z is
 * `lifted` without the entries before it. */
typedef struct evaluation {
  double *m, *w, *y, *g, *s, *h, *lifted;
  const double *z;
  double *end;
} evaluation;

INLINE evaluation evaluation_of(int64_t n, double *work) {
  const int64_t columns = thrum_batch_columns(n) * LANES, vector = n * LANES;
  evaluation e = {.m = work, .w = work + columns, .y = work + 2 * columns};
  e.g = e.y + vector;
  e.s = e.g + vector;
  e.h = e.s + vector;
  e.lifted = e.h + vector + LANES;
  e.z = e.lifted + LANES;
  e.end = e.lifted + vector + LANES;
  return e;
}

/* Writes entries first..n-1 of z from q, zeros before them, and `one` before those. */
INLINE void mirror(int64_t n, int64_t first, const double *q, double one, double *lifted) {
  vs_store(lifted, vs_set1(one));
  for (int64_t d = 0; d < n; d++)
    vs_store(lifted + (d + 1) * LANES, d < first ? vs_zero() : vs_load(q + (n - 1 - d) * LANES));
}

/* Begins an evaluation at q that needs w from its `plain`-th vector on. */
INLINE void evaluation_begin(int64_t n, int64_t plain, const double *q, const evaluation *e) {
  mirror(n, 0, q, 1.0, e->lifted);
  monomials(false, n, e->lifted, e->lifted, e->m);
  clear(e->w + 8 * plain * LANES, thrum_batch_columns(n) - 8 * plain);
  clear(e->g, n);
  clear(e->h, n + 1);
}

/* The blocks of the mirrored order with the arrays of an evaluation as operands. */
INLINE batch_block evaluation_blocks(const thrum_model *model, const evaluation *e) {
  batch_block k = block_first(model, true);
  k.m = e->m;
  k.w = e->w;
  k.y = e->y;
  return k;
}

/* Entry k of a gradient: (g + h) + (s + more), the latter in y. */
INLINE vs evaluation_entry(const evaluation *e, int64_t k) {
  const int64_t at = k * LANES;
  return vs_add(vs_add(vs_load(e->g + at), vs_load(e->h + at + LANES)),
                vs_add(vs_load(e->s + at), vs_load(e->y + at)));
}

/* 1/2 omega^2 q^2 of all modes. */
INLINE vs quadratic_energy(const thrum_model *model, const double *q) {
  vs quadratic = vs_zero();
  for (int64_t i = 0; i < model->rank; i++) {
    const vs q_i = vs_load(q + i * LANES);
    quadratic = vs_add(quadratic, vs_mul(vs_mul(vs_set1(0.5 * model->omega2[i]), q_i), q_i));
  }
  return quadratic;
}

INLINE vs linear_force(const thrum_model *model, const double *q, int64_t i) {
  return vs_mul(vs_set1(model->omega2[i]), vs_load(q + i * LANES));
}

// these need evaluations
#include "runtime/batch/batch_model.inl"
#include "runtime/batch/batch_part.inl"
#include "runtime/batch/batch_restricted.inl"

PASS void ask_for(const double *from, size_t bytes) {
  for (size_t k = 0; k < bytes; k += 64)
    _mm_prefetch((const char *)from + k, _MM_HINT_T1);
}

/* Initialiser of the table of passes in this file. */
#define THRUM_BATCH_TABLE                                                                          \
  {                                                                                                \
    .lanes = LANES, .force = pass_force, .tangent_pairs = pass_tangent_pairs,                      \
    .force_part = pass_force_part, .tangent_vector_part = pass_tangent_vector_part,                \
    .restrict_to = pass_restrict, .restricted_gradient = pass_restricted_gradient,                 \
    .restricted_hessian = pass_restricted_hessian, .ask_for = ask_for,                             \
  }
