/* The passes in plain C, for every machine: what the faster kernels are tested against, and the
 * order of every sum (runtime/kernel.h) written out.
 *
 * Coefficients lie in blocks over j (thrum/model.h): block j of c4 is a matrix B with rows i <= j
 * and columns (k,l), j <= k <= l. With x_i = q_i q_j and m_kl = q_k q_l its share of V is x^T B m,
 * so one pass that forms y_ij = B m and adds B^T x to w gives V = sum y_ij q_i q_j and its
 * gradient, the pair gradient of y at w held and of w at y held. Block j of c3 is the same with
 * columns k and m = q, and its B^T x is a gradient. (Hessian) v is the derivative of that along v.
 * In the Hessian the second derivatives of x and m meet y and w; the mixed ones are X + X^T, where
 * row a of X is the pair gradient of sum_i q_i B_ia + sum_j q_j B_aj.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "kernel.h"
#include "pack.h"

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#define LANES 8

static double lanes_sum(const double lane[LANES]) {
  return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
}

/* lanes += row . m and w += x row over the columns lo..hi-1; the row begins at column lo. */
static void row_both(int64_t lo, int64_t hi, const double *restrict row, const double *restrict m,
                     double x, double *restrict w, double *restrict lane) {
  int64_t c = lo;
  row -= lo;
  for (; c < hi && c % LANES != 0; c++) {
    lane[c % LANES] += row[c] * m[c];
    w[c] += x * row[c];
  }
  for (; c + LANES <= hi; c += LANES)
    for (int s = 0; s < LANES; s++) {
      lane[s] += row[c + s] * m[c + s];
      w[c + s] += x * row[c + s];
    }
  for (int s = 0; c + s < hi; s++) {
    lane[s] += row[c + s] * m[c + s];
    w[c + s] += x * row[c + s];
  }
}

static void row_product(int64_t lo, int64_t hi, const double *restrict row,
                        const double *restrict m, double *restrict lane) {
  int64_t c = lo;
  row -= lo;
  for (; c < hi && c % LANES != 0; c++)
    lane[c % LANES] += row[c] * m[c];
  for (; c + LANES <= hi; c += LANES)
    for (int s = 0; s < LANES; s++)
      lane[s] += row[c + s] * m[c + s];
  for (int s = 0; c + s < hi; s++)
    lane[s] += row[c + s] * m[c + s];
}

static void axpy(int64_t count, double s, const double *restrict a, double *restrict b) {
  for (int64_t c = 0; c < count; c++)
    b[c] += s * a[c];
}

static double dot(int64_t n, const double *a, const double *b) {
  double lane[LANES] = {0};
  row_product(0, n, a, b, lane);
  return lanes_sum(lane);
}

/* m_kl = q_k q_l over the pairs of n coordinates. */
static void pair_monomials(int64_t n, const double *q, double *m) {
  for (int64_t k = 0; k < n; k++)
    for (int64_t l = k; l < n; l++)
      *m++ = q[k] * q[l];
}

/* The pair gradient of w over the coordinates from `first` on, rows below `last`, added to g and
 * put in s; w starts at its row `first`. */
static void upper_pairs(int64_t n, int64_t first, int64_t last, const double *w, const double *q,
                        const double *m, double *g, double *s) {
  for (int64_t k = first; k < last; k++) {
    double lane[LANES] = {0};
    row_both(k, n, w, m, q[k], g, lane);
    s[k] = lanes_sum(lane);
    w += n - k;
  }
}

/* The same for y_ij, j outermost, i <= j. */
static void lower_pairs(int64_t n, const double *y, const double *q, double *g, double *s) {
  for (int64_t j = 0; j < n; j++) {
    double lane[LANES] = {0};
    row_both(0, j + 1, y, q, q[j], g, lane);
    s[j] = lanes_sum(lane);
    y += j + 1;
  }
}

static double reference_gradient(const thrum_form *f, const double *q, double *gradient,
                                 double *work) {
  const int64_t n = f->n, pairs = thrum_pair_count(n);
  double *m = work, *w = m + pairs, *y = w + pairs, *g = y + pairs, *sums = g + n;
  double *more = sums + n, *to = y;
  const double *c3 = f->c3, *c4 = f->c4;
  pair_monomials(n, q, m);
  memset(w, 0, (size_t)pairs * sizeof *w);
  memset(g, 0, (size_t)n * sizeof *g);
  for (int64_t j = 0; j < n; j++) {
    const int64_t columns = thrum_pair_count(n - j);
    c4 += f->skip * columns;
    for (int64_t i = 0; i <= j; i++) {
      double lane[LANES] = {0};
      const double x = q[i] * q[j];
      row_both(j, n, c3, q, x, g, lane);
      row_both(pairs - columns, pairs, c4, m, x, w, lane);
      *to++ = lanes_sum(lane);
      c3 += n - j;
      c4 += columns;
    }
  }
  lower_pairs(n, y, q, g, sums);
  upper_pairs(n, 0, n, w, q, q, g, more);
  for (int64_t i = 0; i < n; i++)
    gradient[i] += g[i] + (sums[i] + more[i]);
  return dot(n, q, sums);
}

static double reference_pairs(int64_t n, const double *w, const double *q, double *gradient,
                              double *work) {
  double *g = work, *sums = g + n;
  memset(g, 0, (size_t)n * sizeof *g);
  upper_pairs(n, 0, n, w, q, q, g, sums);
  for (int64_t i = 0; i < n; i++)
    gradient[i] += g[i] + sums[i];
  return dot(n, q, sums);
}

/* g += sum_{j>=a} q_j (row a of block j), over columns of c3 and of c4. Starts with the first row
 * of block a at c3 and c4. */
static void add_rows(const thrum_form *f, int64_t a, const double *c3, const double *c4,
                     const double *q, double *g3, double *g4) {
  const int64_t n = f->n, pairs = thrum_pair_count(n);
  for (int64_t j = a; j < n; j++) {
    const int64_t columns = thrum_pair_count(n - j);
    axpy(n - j, q[j], c3 + a * (n - j), g3 + j);
    axpy(columns, q[j], c4 + a * columns, g4 + (pairs - columns));
    c3 += (j + 1) * (n - j);
    c4 += (j + 1) * columns + f->skip * thrum_pair_count(n - j - 1);
  }
}

static void reference_hessian(const thrum_form *f, const double *q, double *hessian, double *work) {
  const int64_t n = f->n, pairs = thrum_pair_count(n);
  double *m = work, *w = m + pairs, *g4 = w + pairs, *g3 = g4 + pairs, *g = g3 + n, *sums = g + n;
  const double *c3 = f->c3, *c4 = f->c4;
  pair_monomials(n, q, m);
  memset(w, 0, (size_t)pairs * sizeof *w);
  // half of it now, half + half^T at the end
  for (int64_t t = 0; t < n * n; t++)
    hessian[t] *= 0.5;
  for (int64_t a = 0; a < n; a++) {
    const int64_t columns = thrum_pair_count(n - a), first = pairs - columns;
    double *row = hessian + a * n;
    c4 += f->skip * columns;
    memset(g3, 0, (size_t)n * sizeof *g3);
    memset(g, 0, (size_t)n * sizeof *g);
    memset(g4 + first, 0, (size_t)columns * sizeof *g4);
    for (int64_t i = 0; i <= a; i++) {
      double lane[LANES] = {0};
      row_both(a, n, c3 + i * (n - a), q, q[i], g3, lane);
      row_both(first, pairs, c4 + i * columns, m, q[i], g4, lane);
      // the coefficient of q_i q_a: once off the diagonal, twice (half + half^T) on it
      row[i] += lanes_sum(lane);
    }
    // w = sum_j q_j sum_i q_i B_ij, before the rows of later blocks are added
    axpy(columns, q[a], g4 + first, w + first);
    add_rows(f, a, c3, c4, q, g3, g4);
    upper_pairs(n, a, n, g4 + first, q, q, g, sums);
    for (int64_t k = a; k < n; k++)
      row[k] += g3[k] + (g[k] + sums[k]);
    c3 += (a + 1) * (n - a);
    c4 += (a + 1) * columns;
  }
  for (int64_t k = 0; k < n; k++)
    for (int64_t l = k; l < n; l++)
      hessian[k * n + l] += *w++;
  for (int64_t k = 0; k < n; k++)
    for (int64_t l = k; l < n; l++)
      hessian[k * n + l] = hessian[l * n + k] = hessian[k * n + l] + hessian[l * n + k];
}

/* cubic[block j, row i] += t[pair (j, k)] for j >= i, all indices counted from the split. */
static void scatter_cubic(int64_t n, int64_t i, const double *t, double *cubic) {
  for (int64_t j = 0; j < n; j++) {
    double *row = cubic + i * (n - j);
    for (int64_t k = 0; j >= i && k < n - j; k++)
      row[k] += *t++;
    cubic += (j + 1) * (n - j);
  }
}

/* The cubic part of V with the first `split` coordinates held: c3, and the rows a < split of c4. */
static void restrict_cubic(const thrum_model *model, int64_t split, const double *q, double *cubic,
                           double *t) {
  const int64_t rank = model->rank, n = rank - split;
  const double *c3 = model->c3 + thrum_c3_index(rank, 0, split, split);
  const double *c4 = model->c4 + thrum_c4_index(rank, 0, split, split, split);
  double *kept = cubic;
  for (int64_t j = 0; j < n; j++) {
    const int64_t size = (j + 1) * (n - j);
    memcpy(kept, c3 + split * (n - j), (size_t)size * sizeof *kept);
    c3 += (split + j + 1) * (n - j);
    kept += size;
  }
  for (int64_t i = 0; i < n; i++) {
    const int64_t columns = thrum_pair_count(n - i);
    memset(t, 0, (size_t)columns * sizeof *t);
    for (int64_t a = 0; a < split; a++)
      axpy(columns, q[a], c4 + a * columns, t);
    scatter_cubic(n, i, t, cubic);
    c4 += (split + i + 1) * columns;
  }
}

/* Rows of the packed order, one after the other: begin, then next until it is false. */
typedef struct walk {
  const thrum_model *model;
  int64_t at, c, d; /* where block c begins, and the row */
  double *row;
} walk;

static bool walk_next(walk *k) {
  if (k->d > k->c) {
    k->d--;
  } else {
    // the first row of the next block
    if (k->d >= 0)
      k->at += 8 * (k->model->rank - k->c) * thrum_pack_vectors(k->c);
    k->c++;
    k->d = k->model->rank - 1;
  }
  if (k->c == k->model->rank)
    return false;
  thrum_pack_row(k->model, k->c, k->d, k->at, k->row);
  return true;
}

static walk walk_begin(const thrum_model *model, double *row) {
  const walk k = {model, 0, -1, -1, row};
  return k;
}

/* A point: m by column, w, and by coordinate q, q with 1 before it, and what gradients are made of.
 */
typedef struct evaluation {
  double *m, *w, *q, *lifted, *g, *h, *s, *more, *lanes;
} evaluation;

/* Cuts its arrays, all zero, from *work. */
static evaluation evaluation_make(int64_t n, double one, const double *q, double **work) {
  const int64_t columns = thrum_pack_first(n);
  double *at = *work;
  const evaluation e = {at,
                        at + columns,
                        at + 2 * columns,
                        at + 2 * columns + n,
                        at + 2 * columns + 2 * n + 1,
                        at + 2 * columns + 3 * n + 1,
                        at + 2 * columns + 4 * n + 2,
                        at + 2 * columns + 5 * n + 2,
                        at + 2 * columns + 6 * n + 2};
  *work = e.lanes + LANES * n;
  memset(at, 0, (size_t)(*work - at) * sizeof *at);
  memcpy(e.q, q, (size_t)n * sizeof *q);
  memcpy(e.lifted + 1, q, (size_t)n * sizeof *q);
  e.lifted[0] = one;
  return e;
}

/* m_ba = q_b q_a over the first runs, or its derivative along v. */
static void columns_of(int64_t last, const evaluation *e, const evaluation *v, double *m) {
  for (int64_t b = 0; b < last; b++)
    for (int64_t a = 0; a < b + 2; a++)
      *m++ = v ? e->q[b] * v->lifted[a] + v->q[b] * e->lifted[a] : e->q[b] * e->lifted[a];
}

/* y of row d of block c: g_d += q_c y, lanes of s_c += y q_d. */
static void take_row(int64_t n, int64_t c, int64_t d, double y, const double *q, double *g,
                     double *lanes) {
  g[d] += q[c] * y;
  lanes[LANES * c + (n - 1 - d) % LANES] += y * q[d];
}

/* The gradient of w: h_a += q_b w_ba, s_b = sum w_ba q_a (+ v and dw likewise), by lifted entries.
 */
static void take_columns(int64_t last, const double *w, const double *q, const double *lifted,
                         double *h, double *lanes) {
  for (int64_t b = 0; b < last; b++) {
    row_both(0, b + 2, w, lifted, q[b], h, lanes + LANES * b);
    w += b + 2;
  }
}

static void sums_of(int64_t count, double *lanes, double *s) {
  for (int64_t b = 0; b < count; b++)
    s[b] = lanes_sum(lanes + LANES * b);
  memset(lanes, 0, (size_t)(LANES * count) * sizeof *lanes);
}

static double evaluation_end(int64_t n, const evaluation *e, double *gradient) {
  sums_of(n, e->lanes, e->s);
  take_columns(n, e->w, e->q, e->lifted, e->h, e->lanes);
  sums_of(n, e->lanes, e->more);
  for (int64_t i = 0; i < n; i++)
    gradient[i] += (e->g[i] + e->h[i + 1]) + (e->s[i] + e->more[i]);
  return dot(n, e->q, e->s);
}

static double reference_energy(const thrum_model *model, const double *q, double *work) {
  const int64_t n = model->rank, columns = thrum_pack_first(n);
  walk k = walk_begin(model, work);
  work += columns;
  const evaluation e = evaluation_make(n, 1.0, q, &work);
  columns_of(n, &e, NULL, e.m);
  while (walk_next(&k)) {
    double lane[LANES] = {0};
    row_product(0, thrum_pack_columns(k.c), k.row, e.m, lane);
    take_row(n, k.c, k.d, lanes_sum(lane), e.q, e.g, e.lanes);
  }
  sums_of(n, e.lanes, e.s);
  return dot(n, e.q, e.s);
}

static double reference_force(const thrum_model *model, const double *q, double *gradient,
                              double *work) {
  const int64_t n = model->rank, columns = thrum_pack_first(n);
  walk k = walk_begin(model, work);
  work += columns;
  const evaluation e = evaluation_make(n, 1.0, q, &work);
  columns_of(n, &e, NULL, e.m);
  while (walk_next(&k)) {
    double lane[LANES] = {0};
    row_both(0, thrum_pack_columns(k.c), k.row, e.m, q[k.c] * q[k.d], e.w, lane);
    take_row(n, k.c, k.d, lanes_sum(lane), e.q, e.g, e.lanes);
  }
  return evaluation_end(n, &e, gradient);
}

static void reference_forces(const thrum_model *model, const double *const q[2],
                             double *const gradient[2], double value[2], double *work) {
  for (int point = 0; point < 2; point++)
    value[point] = reference_force(model, q[point], gradient[point], work);
}

static void reference_tangent_vector(const thrum_model *model, const double *q, const double *v,
                                     double *product, double *work) {
  const int64_t n = model->rank, columns = thrum_pack_first(n);
  walk k = walk_begin(model, work);
  work += columns;
  const evaluation e = evaluation_make(n, 1.0, q, &work), u = evaluation_make(n, 0.0, v, &work);
  columns_of(n, &e, NULL, e.m);
  columns_of(n, &e, &u, u.m);
  // every line is the derivative along v of a line of reference_force
  while (walk_next(&k)) {
    const int64_t c = k.c, d = k.d;
    double lane[LANES] = {0}, other[LANES] = {0};
    row_both(0, thrum_pack_columns(c), k.row, e.m, q[c] * q[d], e.w, lane);
    row_both(0, thrum_pack_columns(c), k.row, u.m, q[c] * v[d] + v[c] * q[d], u.w, other);
    const double y = lanes_sum(lane), dy = lanes_sum(other);
    double *lanes = e.lanes + LANES * c;
    e.g[d] = (e.g[d] + v[c] * y) + q[c] * dy;
    lanes[(n - 1 - d) % LANES] += y * v[d];
    // in the lanes all rows of a block under v go before those under q
    u.g[d] = dy;
    for (int64_t t = n - 1; d == c && t >= c; t--)
      lanes[(n - 1 - t) % LANES] += u.g[t] * q[t];
  }
  sums_of(n, e.lanes, e.s);
  take_columns(n, e.w, u.q, u.lifted, e.h, e.lanes);
  take_columns(n, u.w, e.q, e.lifted, e.h, e.lanes);
  sums_of(n, e.lanes, e.more);
  for (int64_t i = 0; i < n; i++)
    product[i] += (e.g[i] + e.h[i + 1]) + (e.s[i] + e.more[i]);
}

/* hessian = half + half^T, with half of w on its lower triangle. */
static void tangent_close(int64_t n, const double *w, double *hessian) {
  for (int64_t b = 0; b < n; b++) {
    w++;
    for (int64_t a = 0; a <= b; a++) {
      const double half = hessian[b * n + a] + *w++;
      hessian[b * n + a] = hessian[a * n + b] = half + (a == b ? half : hessian[a * n + b]);
    }
  }
}

static double reference_tangent(const thrum_model *model, const double *q, double *gradient,
                                double *hessian, double *work) {
  const int64_t n = model->rank, columns = thrum_pack_first(n);
  walk k = walk_begin(model, work);
  double *l = work + columns, *lists = l + columns, *at = lists;
  double *list[THRUM_RANK_MAX];
  for (int64_t d = 0; d < n; at += thrum_pack_columns(d), d++)
    list[d] = at;
  memset(l, 0, (size_t)(at - l) * sizeof *l);
  const evaluation e = evaluation_make(n, 1.0, q, &at);
  columns_of(n, &e, NULL, e.m);
  // half of it now, half + half^T at the end
  for (int64_t t = 0; t < n * n; t++)
    hessian[t] *= 0.5;
  while (walk_next(&k)) {
    const int64_t c = k.c, count = thrum_pack_columns(c);
    double lane[LANES] = {0};
    // y_dc is the coefficient of q_d q_c; list d gets q_c B_dc, list c gets sum_d q_d B_dc
    row_both(0, count, k.row, e.m, q[k.d], l, lane);
    axpy(count, q[c], k.row, list[k.d]);
    const double y = lanes_sum(lane);
    take_row(n, c, k.d, y, e.q, e.g, e.lanes);
    hessian[k.d * n + c] += y;
    if (k.d == c) {
      axpy(count, q[c], l, e.w);
      axpy(count, 1.0, l, list[c]);
      memset(l, 0, (size_t)count * sizeof *l);
    }
  }
  // the mixed derivatives by q_d and the columns: the gradient of all that meets q_d
  double *lanes = at, *h = lanes + LANES * n, *s = h + n + 1;
  memset(lanes, 0, (size_t)(LANES * n) * sizeof *lanes);
  for (int64_t d = 0; d < n; d++) {
    memset(h, 0, (size_t)(d + 2) * sizeof *h);
    take_columns(d + 1, list[d], e.q, e.lifted, h, lanes);
    sums_of(d + 1, lanes, s);
    for (int64_t t = 0; t <= d; t++)
      hessian[d * n + t] += h[t + 1] + s[t];
  }
  tangent_close(n, e.w, hessian);
  return gradient ? evaluation_end(n, &e, gradient) : 0.0;
}

static void reference_restrict(const thrum_model *model, int64_t split, const double *q_given,
                               double *restricted, double *work) {
  const int64_t rank = model->rank, n = rank - split, held = thrum_pack_first(split);
  double *quadratic = restricted + n, *t = work;
  walk k = walk_begin(model, work);
  work += thrum_pack_first(rank);
  double *q = work;
  work += rank;
  memset(q, 0, (size_t)rank * sizeof *q);
  memcpy(q, q_given, (size_t)split * sizeof *q);
  const evaluation e = evaluation_make(rank, 1.0, q, &work);
  columns_of(split, &e, NULL, e.m);
  while (walk_next(&k)) {
    const int64_t c = k.c, d = k.d;
    double lane[LANES] = {0};
    if (d < split)
      continue;
    row_product(0, c < split ? thrum_pack_columns(c) : held, k.row, e.m, lane);
    const double y = lanes_sum(lane);
    // with c held too the term is linear
    if (c < split)
      e.g[d] += q[c] * y;
    else
      quadratic[(thrum_pair_count(n) - thrum_pair_count(rank - c)) + (d - c)] =
          y + (d == c ? 0.5 * model->omega2[c] : 0.0);
  }
  memcpy(restricted, e.g + split, (size_t)n * sizeof *restricted);
  if (n > 0)
    restrict_cubic(model, split, q_given, quadratic + thrum_pair_count(n), t);
}

static void reference_rank_two(int64_t n, bool lower, const double *a, const double *b,
                               const double *c, const double *d, double *matrix) {
  for (int64_t i = 0; i < n; i++)
    for (int64_t j = 0; j < (lower ? i + 1 : n); j++)
      matrix[i * n + j] += a[i] * b[j] + c[i] * d[j];
}

const thrum_kernel thrum_kernel_reference = {
    THRUM_KERNEL_REFERENCE, reference_energy,         reference_force,    reference_forces,
    reference_tangent,      reference_tangent_vector, reference_restrict, reference_gradient,
    reference_hessian,      reference_pairs,          reference_rank_two};
