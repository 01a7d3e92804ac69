/* The passes of runtime/kernel.h over a restricted form, in the order of thrum/model.h, over
 * vectors of 8 lanes, for a file that has included runtime/kernel_lanes.h; and the table of all
 * passes. Cost: the bytes of the coefficients, once; 4 (gradient) or 6 (Hessian) operations each.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "kernel.h"
#include "kernel_packed.h"
// it needs the packed blocks
#include "kernel_model.h"
#include "kernel_rows.h"
// it needs the rows
#include "kernel_triangle.h"

/* a, padded with zeros, into `padded`. */
INLINE void pad(int64_t n, const double *a, double *padded) {
  for (int64_t c = 0; c < thrum_padded(n); c += 8)
    v8_store(padded + c, v8_load_range(a + c, 0, n - c));
}

/* m_kl = q_k q_l for padded q; zeros after them. */
INLINE void pair_monomials(int64_t n, const double *q, double *m) {
  for (int64_t k = 0; k < n; k++) {
    const v8 q_k = v8_set1(q[k]);
    // a run's last vector spills into the next run, which is written later
    for (int64_t c = 0; c < n - k; c += 8)
      v8_store(m + c, v8_mul(q_k, v8_load(q + k + c)));
    m += n - k;
  }
  v8_store(m, v8_zero());
}

/* x_i = q_i q_j, i <= j. */
INLINE void row_monomials(int64_t j, const double *q, double *x) {
  const v8 q_j = v8_set1(q[j]);
  for (int64_t c = 0; c <= j; c += 8)
    v8_store(x + c, v8_mul(v8_load(q + c), q_j));
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
  double *lanes; /* 8 a row */
} scratch;

INLINE scratch cut(int64_t n, double *work) {
  const int64_t pairs = thrum_padded(thrum_pair_count(n)), vector = thrum_padded(n);
  scratch s;
  for (int64_t k = 0; k < THRUM_KERNEL_VECTORS; k++)
    s.vectors[k] = work + k * vector;
  s.lanes = work + THRUM_KERNEL_VECTORS * vector;
  work = s.lanes + 8 * vector;
  for (int64_t k = 0; k < THRUM_KERNEL_PAIR_ARRAYS; k++)
    s.pairs[k] = work + k * pairs;
  return s;
}

PASS double pass_gradient(const thrum_form *f, const double *q_given, double *gradient,
                          double *work) {
  const int64_t n = f->n;
  const scratch t = cut(n, work);
  double *q = t.vectors[0], *g = t.vectors[1], *x = t.vectors[2], *sums = t.vectors[3];
  double *more = t.vectors[4], *m = t.pairs[0], *w = t.pairs[1], *y = t.pairs[2];
  pad(n, q_given, q);
  zeros(g, n);
  zeros(sums, n);
  zeros(w, thrum_pair_count(n));
  pair_monomials(n, q, m);
  side s = {q, m, g, w, x, y, t.lanes, NULL, NULL, 0};
  block b = first_block(f);
  for (int64_t j = 0; j < n; j++) {
    row_monomials(j, q, x);
    block_both(j + 1, &b, &s);
    s.y += j + 1;
    next_block(f, j, &b);
  }
  lower_pairs(n, y, q, g, sums);
  upper_pairs(n, 0, n, w, q, q, g, more);
  for (int64_t i = 0; i < n; i++)
    gradient[i] += g[i] + (sums[i] + more[i]);
  return lanes_dot(n, q, sums);
}

PASS double pass_pairs(int64_t n, const double *w, const double *q_given, double *gradient,
                       double *work) {
  const scratch t = cut(n, work);
  double *q = t.vectors[0], *g = t.vectors[1], *sums = t.vectors[2];
  pad(n, q_given, q);
  zeros(g, n);
  zeros(sums, n);
  upper_pairs(n, 0, n, w, q, q, g, sums);
  for (int64_t i = 0; i < n; i++)
    gradient[i] += g[i] + sums[i];
  return lanes_dot(n, q, sums);
}

/* hessian = half + half^T, with w on the upper part of half. */
INLINE void symmetrise(int64_t n, const double *w, double *hessian) {
  for (int64_t k = 0; k < n; k++)
    for (int64_t l = k; l < n; l++) {
      const double half = hessian[k * n + l] + *w++;
      hessian[k * n + l] = hessian[l * n + k] = half + (l == k ? half : hessian[l * n + k]);
    }
}

/* The lists of the Hessian, one for each row a: over coordinates from a on and over pairs of them,
 * at their absolute places; and spare ones. */
typedef struct lists {
  double *g3[THRUM_RANK_MAX], *g4[THRUM_RANK_MAX];
  double *each3[THRUM_RANK_MAX], *each4[THRUM_RANK_MAX]; /* the same, but one spare */
  double *spare3, *spare4;
} lists;

/* All zero, cut from `at`. */
INLINE void lists_make(int64_t n, double *at, lists *l) {
  const int64_t vector = thrum_padded(n), pairs = thrum_padded(thrum_pair_count(n));
  double *begin = at;
  for (int64_t a = 0, first = 0; a < n; first += n - a, a++) {
    l->g3[a] = l->each3[a] = at;
    l->g4[a] = l->each4[a] = at + vector - first / 8 * 8;
    at += vector + pairs - first / 8 * 8;
  }
  l->spare3 = at;
  l->spare4 = at + vector;
  zeros(begin, at + vector + pairs - begin);
}

/* Block a has been added to list a without its own row a, which is in the spare list:
 * w += q_a list, list += spare, spare = 0. */
INLINE void list_done(int64_t lo, int64_t hi, double q_a, double *list, double *spare, double *w) {
  const v8 q = v8_set1(q_a);
  for (int64_t c = lo / 8 * 8; c < hi; c += 8) {
    const v8 before = v8_load(list + c);
    if (w)
      v8_store(w + c, v8_add(v8_load(w + c), v8_mul(q, before)));
    v8_store(list + c, v8_add(before, v8_load(spare + c)));
    v8_store(spare + c, v8_zero());
  }
}

PASS void pass_hessian(const thrum_form *f, const double *q_given, double *hessian, double *work) {
  const int64_t n = f->n, pairs = thrum_pair_count(n);
  const scratch t = cut(n, work);
  double *q = t.vectors[0], *y = t.vectors[1], *g = t.vectors[2], *sums = t.vectors[3];
  double *m = t.pairs[0], *w = t.pairs[1];
  lists l;
  lists_make(n, work + thrum_kernel_work(n), &l);
  pad(n, q_given, q);
  zeros(w, pairs);
  pair_monomials(n, q, m);
  // half of it now, half + half^T at the end
  for (int64_t c = 0; c < n * n; c++)
    hessian[c] *= 0.5;
  block b = first_block(f);
  for (int64_t a = 0; a < n; a++) {
    // y_ia is the coefficient of q_i q_a; list a gets sum_i q_i B_ia, list i gets q_a B_ia
    const side s = {q, m, l.g3[a], l.g4[a], q, y, t.lanes, l.each3, l.each4, q[a]};
    l.each3[a] = l.spare3;
    l.each4[a] = l.spare4;
    block_each(a + 1, &b, &s);
    l.each3[a] = l.g3[a];
    l.each4[a] = l.g4[a];
    // w is q_a times the list before the rows a are in
    list_done(b.low3, n, q[a], l.g3[a], l.spare3, NULL);
    list_done(b.low4, pairs, q[a], l.g4[a], l.spare4, w);
    for (int64_t i = 0; i <= a; i++)
      hessian[a * n + i] += y[i];
    next_block(f, a, &b);
  }
  // the mixed derivatives by q_a and the columns: the pair gradient of all that meets q_a
  for (int64_t a = 0; a < n; a++) {
    zeros(g, n);
    upper_pairs(n, a, n, l.g4[a], q, q, g, sums);
    for (int64_t k = a; k < n; k++)
      hessian[a * n + k] += l.g3[a][k] + (g[k] + sums[k]);
  }
  symmetrise(n, w, hessian);
}

/* w += sum_a q_a (row a) over `rows` rows. */
INLINE void add_block(int64_t rows, const double *b, int64_t columns, const double *q, double *w) {
  rows4 unused = rows_zero();
  int64_t a = 0;
  for (; a + 4 <= rows; a += 4) {
    const rows4 x = rows_set(4, q + a);
    sweep(4, false, true, &unused, b + a * columns, columns, 0, columns, w, &x, w, NULL);
  }
  for (; a < rows; a++) {
    const rows4 x = rows_set(1, q + a);
    sweep(1, false, true, &unused, b + a * columns, columns, 0, columns, w, &x, w, NULL);
  }
}

/* The cubic part of V with the first `split` coordinates held: c3, and the rows a < split of c4. */
INLINE void restrict_cubic(const thrum_model *model, int64_t split, const double *q, double *cubic,
                           double *t) {
  const int64_t n = model->rank - split;
  const double *c3 = model->c3 + thrum_c3_index(model->rank, 0, split, split);
  const double *c4 = model->c4 + thrum_c4_index(model->rank, 0, split, split, split);
  double *kept = cubic;
  for (int64_t j = 0; j < n; j++) {
    const int64_t size = (j + 1) * (n - j);
    memcpy(kept, c3 + split * (n - j), (size_t)size * sizeof *kept);
    c3 += (split + j + 1) * (n - j);
    kept += size;
  }
  for (int64_t i = 0; i < n; i++) {
    const int64_t columns = thrum_pair_count(n - i);
    zeros(t, columns);
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

PASS void pass_restrict(const thrum_model *model, int64_t split, const double *q,
                        double *restricted, double *work) {
  const int64_t n = model->rank - split, pairs = thrum_pair_count(n);
  restrict_low(model, split, q, restricted, restricted + n, work);
  if (n > 0)
    restrict_cubic(model, split, q, restricted + n + pairs, work);
}

/* Whole lanes may go past the diagonal. */
PASS void pass_rank_two(int64_t n, bool lower, const double *a, const double *b, const double *c,
                        const double *d, double *matrix) {
  for (int64_t i = 0; i < n; i++) {
    const v8 ai = v8_set1(a[i]), ci = v8_set1(c[i]);
    const int64_t last = lower ? i + 1 : n;
    double *row = matrix + i * n;
    int64_t j = 0;
    for (; j < last && j + 8 <= n; j += 8) {
      const v8 more = v8_add(v8_mul(ai, v8_load(b + j)), v8_mul(ci, v8_load(d + j)));
      v8_store(row + j, v8_add(v8_load(row + j), more));
    }
    for (; j < last; j++)
      row[j] += a[i] * b[j] + c[i] * d[j];
  }
}

#define THRUM_KERNEL_TABLE(id)                                                                     \
  {                                                                                                \
    id, pass_energy, pass_force, pass_forces, pass_tangent, pass_tangent_vector, pass_restrict,    \
        pass_gradient, pass_hessian, pass_pairs, pass_rank_two                                     \
  }
