/* The passes in plain C, for every machine: what the faster kernels are tested against, and the
 * order of every sum (core/polynomial/kernel_private.h) written out.
 *
 * Coefficients lie in blocks (core/polynomial/packed.h): block c is a matrix B with rows d >= c
 * and columns (b,a), a <= b <= c. With x_d = q_d q_c and m_ba = q_b q_a its share of V is x^T B m,
 * so one pass that forms y = B m and adds B^T x to w gives V = sum y_dc q_d q_c and its gradient,
 * the gradient of y's sum at w held and of w's at y held. (Hessian) v is the derivative of that
 * along v. In the Hessian the second derivatives of x and m meet y and w; the mixed ones are X +
 * X^T, where row d of X is the gradient of all columns that meet q_d.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <string.h>

#include "core/base/lane_sums.h"
#include "core/polynomial/kernel_private.h"
#include "core/polynomial/packed.h"

#define LANES 8

/* lanes += row . m and w += x row. */
static void row_both(int64_t count, const double *restrict row, const double *restrict m, double x,
                     double *restrict w, double *restrict lane) {
  int64_t c = 0;
  for (; c + LANES <= count; c += LANES)
    for (int s = 0; s < LANES; s++) {
      lane[s] += row[c + s] * m[c + s];
      w[c + s] += x * row[c + s];
    }
  for (int s = 0; c + s < count; s++) {
    lane[s] += row[c + s] * m[c + s];
    w[c + s] += x * row[c + s];
  }
}

static void row_product(int64_t count, const double *restrict row, const double *restrict m,
                        double *restrict lane) {
  int64_t c = 0;
  for (; c + LANES <= count; c += LANES)
    for (int s = 0; s < LANES; s++)
      lane[s] += row[c + s] * m[c + s];
  for (int s = 0; c + s < count; s++)
    lane[s] += row[c + s] * m[c + s];
}

static void axpy(int64_t count, double s, const double *restrict a, double *restrict b) {
  for (int64_t c = 0; c < count; c++)
    b[c] += s * a[c];
}

/* Rows of a packed order, one after the other: begin, then next until it is false. */
typedef struct walk {
  const thrum_model *model;
  bool mirrored;
  int64_t blocks;   /* before the end */
  int64_t at, c, d; /* where block c begins, and the row */
  double *row;      /* after walk_read */
} walk;

static bool walk_next(walk *k) {
  const int64_t n = k->model->rank;
  if (k->mirrored ? k->d + 1 < n : k->d > k->c) {
    k->d += k->mirrored ? 1 : -1;
    return true;
  }
  // the first row of the next block
  if (k->c >= 0)
    k->at += 8 * (n - k->c) * thrum_pack_vectors(k->c);
  k->c++;
  k->d = k->mirrored ? k->c : n - 1;
  return k->c < k->blocks;
}

static void walk_read(walk *k) {
  (k->mirrored ? thrum_pack_row_mirrored : thrum_pack_row)(k->model, k->c, k->d, k->at, k->row);
}

/* Cuts a row from *work. */
static walk walk_begin(const thrum_model *model, bool mirrored, int64_t blocks, double **work) {
  const int64_t d = mirrored ? model->rank - 1 : -1;
  const walk k = {model, mirrored, blocks, 0, -1, d, *work};
  *work += thrum_pack_first(model->rank);
  return k;
}

/* A point: m by column, w, and by coordinate q, q with 1 before it, and what gradients are made of.
 */
typedef struct evaluation {
  double *m, *w, *q, *lifted, *g, *h, *s, *more, *lanes;
} evaluation;

/* Cuts its arrays, all zero, from *work; q may be NULL, to be filled in. */
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

  // q once as it is, and once with the factor of cubic terms before it
  for (int64_t i = 0; q && i < n; i++)
    e.q[i] = e.lifted[i + 1] = q[i];
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
    row_both(b + 2, w, lifted, q[b], h, lanes + LANES * b);
    w += b + 2;
  }
}

static void sums_of(int64_t count, double *lanes, double *s) {
  for (int64_t b = 0; b < count; b++)
    s[b] = thrum_lanes_sum(lanes + LANES * b);
  memset(lanes, 0, (size_t)(LANES * count) * sizeof *lanes);
}

static double evaluation_end(int64_t n, const evaluation *e, double *gradient) {
  sums_of(n, e->lanes, e->s);
  take_columns(n, e->w, e->q, e->lifted, e->h, e->lanes);
  sums_of(n, e->lanes, e->more);
  for (int64_t i = 0; i < n; i++)
    gradient[i] += (e->g[i] + e->h[i + 1]) + (e->s[i] + e->more[i]);
  return thrum_sum_of(n, e->q, e->s, NULL);
}

static double reference_energy(const thrum_model *model, const double *q, double *work) {
  const int64_t n = model->rank;
  walk k = walk_begin(model, false, n, &work);
  const evaluation e = evaluation_make(n, 1.0, q, &work);
  columns_of(n, &e, NULL, e.m);
  while (walk_next(&k)) {
    walk_read(&k);
    double lane[LANES] = {0};
    row_product(thrum_pack_columns(k.c), k.row, e.m, lane);
    take_row(n, k.c, k.d, thrum_lanes_sum(lane), e.q, e.g, e.lanes);
  }
  sums_of(n, e.lanes, e.s);
  return thrum_sum_of(n, e.q, e.s, NULL);
}

static double reference_force(const thrum_model *model, const double *q, double *gradient,
                              double *work) {
  const int64_t n = model->rank;
  walk k = walk_begin(model, false, n, &work);
  const evaluation e = evaluation_make(n, 1.0, q, &work);
  columns_of(n, &e, NULL, e.m);
  while (walk_next(&k)) {
    walk_read(&k);
    double lane[LANES] = {0};
    row_both(thrum_pack_columns(k.c), k.row, e.m, q[k.c] * q[k.d], e.w, lane);
    take_row(n, k.c, k.d, thrum_lanes_sum(lane), e.q, e.g, e.lanes);
  }
  return evaluation_end(n, &e, gradient);
}

static void reference_forces(const thrum_model *model, const double *const q[2],
                             double *const gradient[2], double value[2], double *work) {
  for (int point = 0; point < 2; point++)
    value[point] = reference_force(model, q[point], gradient[point], work);
}

/* y = B m, by pairs; row and w have any content. */
static void pairs_product(const thrum_model *model, const double *m, double *row, double *w,
                          double *y) {
  const int64_t columns = thrum_pack_first(model->rank);
  memset(w, 0, (size_t)columns * sizeof *w);
  for (int64_t k = 0; k < columns; k++) {
    const int64_t first = k / LANES * LANES, own = first + LANES;
    double lane[LANES] = {0};
    thrum_pairs_row(model, k, row);
    row_product((own < columns ? own : columns) - first, row + first, m + first, lane);
    if (own < columns)
      row_both(columns - own, row + own, m + own, m[k], w + own, lane);
    y[k] = thrum_lanes_sum(lane);
  }
  axpy(columns, 1.0, w, y);
}

/* The first step of both: returns y = B m at q. */
static double *pairs_at(const thrum_model *model, const double *q, double **work, evaluation *e) {
  const int64_t n = model->rank, rows = thrum_pairs_rows(n);
  double *row = *work, *y = row + rows;
  *work = y + rows;
  *e = evaluation_make(n, 1.0, q, work);
  columns_of(n, e, NULL, e->m);
  pairs_product(model, e->m, row, e->w, y);
  return y;
}

static double tangent_by_pairs(const thrum_model *model, const double *q, double *gradient,
                               double *hessian, double *work) {
  // y = B m, the second derivatives in their runs
  const int64_t n = model->rank;
  evaluation e;
  const double *y = pairs_at(model, q, &work, &e);
  const double *run = y + 1;

  // rows of the Hessian from the runs, and their mirror images
  for (int64_t d = 0; d < n; run += d + 2, d++) {
    for (int64_t a = 0; a < d; a++)
      hessian[d * n + a] = hessian[a * n + d] = hessian[d * n + a] + run[a];
    hessian[d * n + d] += 2.0 * run[d];
  }

  // the gradient follows from the same y
  if (!gradient)
    return 0.0;
  take_columns(n, y, e.q, e.lifted, e.h, e.lanes);
  sums_of(n, e.lanes, e.more);
  for (int64_t i = 0; i < n; i++)
    gradient[i] += (e.h[i + 1] + e.more[i]) / 3.0;
  return thrum_sum_of(thrum_pack_first(n), e.m, y, NULL) / 6.0;
}

/* T v is the gradient of sum y_ba q_b q_a with y held, at v, where v_{-1} = 0. */
static void tangent_vector_by_pairs(const thrum_model *model, const double *q, const double *v,
                                    double *product, double *work) {
  const int64_t n = model->rank;
  evaluation e;
  const double *y = pairs_at(model, q, &work, &e);
  memcpy(e.lifted + 1, v, (size_t)n * sizeof *v);
  e.lifted[0] = 0.0;
  take_columns(n, y, v, e.lifted, e.h, e.lanes);
  sums_of(n, e.lanes, e.more);
  for (int64_t i = 0; i < n; i++)
    product[i] += e.h[i + 1] + e.more[i];
}

static void reference_tangent_vector(const thrum_model *model, const double *q, const double *v,
                                     double *product, double *work) {
  // small ranks have their products by pairs
  const int64_t n = model->rank;
  if (n <= THRUM_PAIRS_VECTOR_RANK_MOST) {
    tangent_vector_by_pairs(model, q, v, product, work);
    return;
  }

  // coordinates and monomials at q and along v
  walk k = walk_begin(model, false, n, &work);
  const evaluation e = evaluation_make(n, 1.0, q, &work), u = evaluation_make(n, 0.0, v, &work);
  columns_of(n, &e, NULL, e.m);
  columns_of(n, &e, &u, u.m);

  // every line is the derivative along v of a line of reference_force
  while (walk_next(&k)) {
    const int64_t c = k.c, d = k.d;
    walk_read(&k);
    double lane[LANES] = {0}, other[LANES] = {0};
    row_both(thrum_pack_columns(c), k.row, e.m, q[c] * q[d], e.w, lane);
    row_both(thrum_pack_columns(c), k.row, u.m, q[c] * v[d] + v[c] * q[d], u.w, other);

    // row sums of one meet the coordinates of the other
    const double y = thrum_lanes_sum(lane), dy = thrum_lanes_sum(other);
    double *lanes = e.lanes + LANES * c;
    e.g[d] = (e.g[d] + v[c] * y) + q[c] * dy;
    lanes[(n - 1 - d) % LANES] += y * v[d];
    // in the lanes all rows of a block under v go before those under q
    u.g[d] = dy;
    for (int64_t t = n - 1; d == c && t >= c; t--)
      lanes[(n - 1 - t) % LANES] += u.g[t] * q[t];
  }

  // columns of both, then the product
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

/* The mixed derivatives by q_d and the columns: the gradient of all that meets q_d. Scratch at
 * `at`.
 */
static void tangent_lists(int64_t n, double *const *list, const evaluation *e, double *at,
                          double *hessian) {
  double *lanes = at, *h = lanes + LANES * n, *s = h + n + 1;
  memset(lanes, 0, (size_t)(LANES * n) * sizeof *lanes);
  for (int64_t d = 0; d < n; d++) {
    memset(h, 0, (size_t)(d + 2) * sizeof *h);
    take_columns(d + 1, list[d], e->q, e->lifted, h, lanes);
    sums_of(d + 1, lanes, s);
    for (int64_t t = 0; t <= d; t++)
      hessian[d * n + t] += h[t + 1] + s[t];
  }
}

static double reference_tangent(const thrum_model *model, const double *q, double *gradient,
                                double *hessian, double *work) {
  // small ranks have their products by pairs
  const int64_t n = model->rank, columns = thrum_pack_first(n);
  if (thrum_pairs_count(n) > 0)
    return tangent_by_pairs(model, q, gradient, hessian, work);

  // a list of columns for each coordinate, and one for the block
  walk k = walk_begin(model, false, n, &work);
  double *l = work, *lists = l + columns, *at = lists;
  double *list[THRUM_RANK_MAX];
  for (int64_t d = 0; d < n; at += thrum_pack_columns(d), d++)
    list[d] = at;
  memset(l, 0, (size_t)(at - l) * sizeof *l);

  // coordinates and monomials
  const evaluation e = evaluation_make(n, 1.0, q, &at);
  columns_of(n, &e, NULL, e.m);

  // half of it now, half + half^T at the end
  for (int64_t t = 0; t < n * n; t++)
    hessian[t] *= 0.5;

  // each row
  while (walk_next(&k)) {
    const int64_t c = k.c, count = thrum_pack_columns(c);
    walk_read(&k);
    double lane[LANES] = {0};

    // y_dc is the coefficient of q_d q_c; list d gets q_c B_dc, list c gets sum_d q_d B_dc
    row_both(count, k.row, e.m, q[k.d], l, lane);
    axpy(count, q[c], k.row, list[k.d]);
    const double y = thrum_lanes_sum(lane);
    take_row(n, c, k.d, y, e.q, e.g, e.lanes);
    hessian[k.d * n + c] += y;

    // the end of a block: what met q_c
    if (k.d == c) {
      axpy(count, q[c], l, e.w);
      axpy(count, 1.0, l, list[c]);
      memset(l, 0, (size_t)count * sizeof *l);
    }
  }

  tangent_lists(n, list, &e, at, hessian);
  tangent_close(n, e.w, hessian);
  return gradient ? evaluation_end(n, &e, gradient) : 0.0;
}

/* The same in mirrored coordinates, those before z_first zero. */
static evaluation evaluation_mirrored(int64_t n, int64_t first, double one, const double *q,
                                      double **work) {
  const evaluation e = evaluation_make(n, one, NULL, work);
  for (int64_t k = 0; k < n; k++)
    e.q[k] = e.lifted[k + 1] = k < first ? 0.0 : q[n - 1 - k];
  return e;
}

/* The runs from `first` on. */
static void take_last_columns(int64_t first, int64_t last, const double *w, const double *q,
                              const double *lifted, double *h, double *lanes) {
  for (int64_t b = first; b < last; b++)
    row_both(b + 2, w + thrum_pack_first(b), lifted, q[b], h, lanes + LANES * b);
}

static double reference_force_part(const thrum_model *model, int64_t split, const double *q,
                                   double *gradient, double *work) {
  // mirrored coordinates, so that those asked for come last, and monomials
  const int64_t n = model->rank, implicit = n - split, plain = thrum_pack_first(implicit) / 8 * 8;
  walk k = walk_begin(model, true, n, &work);
  const evaluation e = evaluation_mirrored(n, 0, 1.0, q, &work);
  const double *z = e.q;
  columns_of(n, &e, NULL, e.m);

  // each row: held coordinates have sums alone, the others hand w to the columns too
  while (walk_next(&k)) {
    const int64_t c = k.c, d = k.d, count = thrum_pack_columns(c),
                  sums = c < implicit ? count : plain;
    walk_read(&k);
    double lane[LANES] = {0};
    row_product(sums, k.row, e.m, lane);
    row_both(count - sums, k.row + sums, e.m + sums, z[c] * z[d], e.w + sums, lane);

    // the sum meets both coordinates of its row
    const double y = thrum_lanes_sum(lane);
    e.g[d] += z[c] * y;
    e.lanes[LANES * c + (d - c) % LANES] += y * z[d];
  }

  // columns, then the gradient that is asked for
  sums_of(n, e.lanes, e.s);
  take_last_columns(implicit, n, e.w, z, e.lifted, e.h, e.lanes);
  sums_of(n, e.lanes, e.more);
  for (int64_t i = implicit; i < n; i++)
    gradient[n - 1 - i] += (e.g[i] + e.h[i + 1]) + (e.s[i] + e.more[i]);
  return thrum_sum_of(n, z, e.s, NULL);
}

static void reference_tangent_vector_part(const thrum_model *model, int64_t split, const double *q,
                                          const double *v_given, double *product, double *work) {
  // mirrored coordinates, so that those asked for come last, and monomials at q and along v
  const int64_t n = model->rank, implicit = n - split, plain = thrum_pack_first(implicit) / 8 * 8;
  walk k = walk_begin(model, true, n, &work);
  const evaluation e = evaluation_mirrored(n, 0, 1.0, q, &work);
  const evaluation u = evaluation_mirrored(n, implicit, 0.0, v_given, &work);
  const double *z = e.q, *v = u.q;
  columns_of(n, &e, NULL, e.m);
  columns_of(n, &e, &u, u.m);

  // every line is the derivative along v of a line of reference_force_part
  while (walk_next(&k)) {
    const int64_t c = k.c, d = k.d, count = thrum_pack_columns(c) - plain;
    if (c < implicit)
      continue;
    walk_read(&k);
    double lane[LANES] = {0}, other[LANES] = {0}, *lanes = e.lanes + LANES * c;
    row_product(plain, k.row, e.m, lane);
    row_both(count, k.row + plain, e.m + plain, z[c] * z[d], e.w + plain, lane);
    row_both(count, k.row + plain, u.m + plain, z[c] * v[d] + v[c] * z[d], u.w + plain, other);
    const double y = thrum_lanes_sum(lane), dy = thrum_lanes_sum(other);

    // row sums of one meet the coordinates of the other
    e.g[d] = (e.g[d] + v[c] * y) + z[c] * dy;
    lanes[(d - c) % LANES] += y * v[d];
    // in the lanes all rows of a block under v go before those under q
    u.g[d] = dy;
    for (int64_t t = c; d == n - 1 && t < n; t++)
      lanes[(t - c) % LANES] += u.g[t] * z[t];
  }

  // columns of both, then the product that is asked for
  sums_of(n, e.lanes, e.s);
  take_last_columns(implicit, n, e.w, v, u.lifted, e.h, e.lanes);
  take_last_columns(implicit, n, u.w, z, e.lifted, e.h, e.lanes);
  sums_of(n, e.lanes, e.more);
  for (int64_t i = implicit; i < n; i++)
    product[n - 1 - i] += (e.g[i] + e.h[i + 1]) + (e.s[i] + e.more[i]);
}

/* Linear and quadratic terms; the latter's places are those of the columns (b,-1) of rows c. */
static void restrict_low(const thrum_model *model, int64_t split, const double *q_given,
                         double *restricted, double *work) {
  // the held coordinates, the others zero, and their monomials
  const int64_t rank = model->rank, n = rank - split, held = thrum_pack_first(split);
  walk k = walk_begin(model, false, rank, &work);
  double *q = work;
  work += rank;
  memset(q, 0, (size_t)rank * sizeof *q);
  memcpy(q, q_given, (size_t)split * sizeof *q);
  const evaluation e = evaluation_make(rank, 1.0, q, &work);
  columns_of(split, &e, NULL, e.m);

  // where the row of each free coordinate lies in the restriction
  double *rows[THRUM_RANK_MAX], *row = restricted + thrum_restricted_first(n);
  for (int64_t c = 0; c < n; row += 8 * thrum_pack_vectors(c), c++)
    rows[c] = row;

  // each row that has a free coordinate, in its columns that are held
  while (walk_next(&k)) {
    const int64_t c = k.c, d = k.d;
    double lane[LANES] = {0};
    if (d < split)
      continue;
    walk_read(&k);
    row_product(c < split ? thrum_pack_columns(c) : held, k.row, e.m, lane);
    const double y = thrum_lanes_sum(lane);

    // with c held too the term is linear
    if (c < split)
      e.g[d] += q[c] * y;
    else
      rows[rank - 1 - c][thrum_pack_first(rank - 1 - d)] =
          y + (d == c ? 0.5 * model->omega2[c] : 0.0);
  }

  // the linear terms come first
  memset(restricted, 0, (size_t)thrum_restricted_first(n) * sizeof *restricted);
  for (int64_t i = 0; i < n; i++)
    restricted[i] = e.g[rank - 1 - i];
}

static void reference_restrict(const thrum_model *model, int64_t split, const double *q,
                               double *restricted, double *work) {
  const int64_t rank = model->rank, n = rank - split;
  double *row = restricted + thrum_restricted_first(n), *free_work = work;
  memset(restricted, 0, (size_t)thrum_restricted_count(n) * sizeof *restricted);
  walk k = walk_begin(model, true, n, &free_work);
  while (walk_next(&k)) {
    if (k.d >= n) {
      walk_read(&k);
      axpy(thrum_pack_columns(k.c), q[rank - 1 - k.d], k.row, row);
    }
    if (k.d == rank - 1)
      row += 8 * thrum_pack_vectors(k.c);
  }
  restrict_low(model, split, q, restricted, work);
}

static double reference_restricted_gradient(const thrum_model *model, int64_t split,
                                            const double *restricted, const double *q,
                                            double *gradient, double *work) {
  // coordinates and monomials, and the restriction's own rows
  const int64_t n = model->rank - split;
  const double *row = restricted + thrum_restricted_first(n);
  walk k = walk_begin(model, true, n, &work);
  const evaluation e = evaluation_mirrored(n, 0, 1.0, q, &work);
  const double *z = e.q;
  columns_of(n, &e, NULL, e.m);

  // the first row of a block comes with the restriction's own one
  while (walk_next(&k)) {
    const int64_t c = k.c, count = thrum_pack_columns(c);
    double lane[LANES] = {0}, own[LANES] = {0};
    if (k.d == c) {
      row_both(count, row, e.m, z[c], e.w, own);
      e.s[c] = restricted[c] + thrum_lanes_sum(own);
      row += 8 * thrum_pack_vectors(c);
    }

    // each row of the model's block
    if (k.d >= n)
      continue;
    walk_read(&k);
    row_both(count, k.row, e.m, z[c] * z[k.d], e.w, lane);
    const double y = thrum_lanes_sum(lane);
    e.g[k.d] += z[c] * y;
    e.lanes[LANES * c + (k.d - c) % LANES] += y * z[k.d];
  }

  // the sums meet the coordinates
  for (int64_t c = 0; c < n; c++)
    e.s[c] += thrum_lanes_sum(e.lanes + LANES * c);
  memset(e.lanes, 0, (size_t)(LANES * n) * sizeof *e.lanes);

  // columns, then gradient and value
  take_columns(n, e.w, z, e.lifted, e.h, e.lanes);
  sums_of(n, e.lanes, e.more);
  for (int64_t i = 0; i < n; i++)
    gradient[n - 1 - i] = (e.g[i] + e.h[i + 1]) + (e.s[i] + e.more[i]);
  return thrum_sum_of(n, z, e.s, NULL);
}

static void reference_restricted_hessian(const thrum_model *model, int64_t split,
                                         const double *restricted, const double *q, double *hessian,
                                         double *work) {
  // a list of columns for each coordinate, and one for the block
  const int64_t n = model->rank - split, columns = thrum_pack_first(n);
  const double *row = restricted + thrum_restricted_first(n);
  walk k = walk_begin(model, true, n, &work);
  double *l = work, *at = l + columns, *list[THRUM_RANK_MAX];
  for (int64_t d = 0; d < n; at += thrum_pack_columns(d), d++)
    list[d] = at;
  memset(l, 0, (size_t)(at - l) * sizeof *l);

  // coordinates and monomials
  const evaluation e = evaluation_mirrored(n, 0, 1.0, q, &at);
  const double *z = e.q;
  columns_of(n, &e, NULL, e.m);
  memset(hessian, 0, (size_t)(n * n) * sizeof *hessian);

  // a block begins with the restriction's own row
  while (walk_next(&k)) {
    const int64_t c = k.c, count = thrum_pack_columns(c);
    double lane[LANES] = {0};
    if (k.d == c)
      memcpy(l, row, (size_t)count * sizeof *l);

    // each row of the model's block adds to its entry and to the list of q_d
    if (k.d < n) {
      walk_read(&k);
      row_both(count, k.row, e.m, z[k.d], l, lane);
      axpy(count, z[c], k.row, list[k.d]);
      hessian[k.d * n + c] += thrum_lanes_sum(lane);
    }

    // the end of a block: what met q_c
    if (k.d == model->rank - 1) {
      axpy(count, z[c], l, e.w);
      axpy(count, 1.0, l, list[c]);
      row += 8 * thrum_pack_vectors(c);
    }
  }

  tangent_lists(n, list, &e, at, hessian);
  tangent_close(n, e.w, hessian);

  // coordinates were mirrored, so entries change places with those at the other end
  for (int64_t i = 0; 2 * i < n * n; i++) {
    const double kept = hessian[i];
    hessian[i] = hessian[n * n - 1 - i];
    hessian[n * n - 1 - i] = kept;
  }
}

static void reference_product(int64_t rows, int64_t n, const double *matrix, const double *x,
                              double *y) {
  memset(y, 0, (size_t)n * sizeof *y);
  for (int64_t i = 0; i < rows; i++)
    axpy(n, x[i], matrix + i * n, y);
}

static void reference_rank_two(int64_t n, bool lower, const thrum_two *t, double *matrix) {
  for (int64_t k = 0, at = 0; k < t->count; k++, at += t->stride)
    for (int64_t i = 0; i < n; i++)
      for (int64_t j = 0; j < (lower ? i + 1 : n); j++)
        matrix[i * n + j] += t->a[at + i] * t->b[at + j] + t->c[at + i] * t->d[at + j];
}

/* a and b in lanes k and k + 1 of a vector, which takes the sign off its zeros. */
static void put_pair(int64_t k, double a, double b, double *vector) {
  for (int64_t i = 0; i < LANES; i++) {
    const double kept = i == k || i == k + 1 ? 0.0 : vector[i];
    vector[i] = kept + (a * (i == k ? 1.0 : 0.0) + b * (i == k + 1 ? 1.0 : 0.0));
  }
}

static int64_t reference_sweep(int64_t n, double *matrix, double *work) {
  const int64_t stride = thrum_whole(n);
  double *least = work, *f = least + stride, *s = f + stride, *m = s + stride;
  double *m_l = m + stride, *row_k = m_l + stride, *row_l = row_k + stride;

  // a pivot that falls below these has lost its digits
  for (int64_t i = 0; i < n; i++)
    least[i] = THRUM_SMALL_PIVOT * matrix[i * stride + i];

  // two pivots at a time, as the kernels with vectors do
  for (int64_t k = 0; k < n; k += 2) {
    const double *now_k = matrix + k * stride, *now_l = now_k + stride;
    const double beside = now_k[k + 1], minus_k = -1.0 / now_k[k], factor = beside * minus_k;
    const double pivot_l = now_l[k + 1] + factor * beside;
    if (!(least[k] > 0.0 && now_k[k] > least[k] && least[k + 1] > 0.0 && pivot_l > least[k + 1]))
      return k;

    // both pivots' columns, and the rows that they become
    const double minus_l = -1.0 / pivot_l, corner = factor * minus_l;
    const int64_t lane = k % LANES, own = k - lane;
    for (int64_t i = 0; i < stride; i++) {
      // rows are whole in whole vectors up to the pivots' own, then columns are
      const bool whole = i / 8 <= k / 8;
      f[i] = whole ? now_k[i] : i < n ? matrix[i * stride + k] : 0.0;
      s[i] = (whole ? now_l[i] : i < n ? matrix[i * stride + k + 1] : 0.0) + factor * f[i];
      m[i] = f[i] * minus_k;
      m_l[i] = s[i] * minus_l;
      row_l[i] = m_l[i] * -1.0;
      row_k[i] = factor * row_l[i] + m[i] * -1.0;
    }

    // their own two by two block
    put_pair(lane, -1.0, 0.0, f + own);
    put_pair(lane, -factor, -1.0, s + own);
    put_pair(lane, minus_k + factor * corner, corner, row_k + own);
    put_pair(lane, corner, minus_l, row_l + own);
    for (int64_t i = 0; i < n; i++) {
      double *row = matrix + i * stride;
      row[k] = row[k + 1] = 0.0;
      for (int64_t j = 0; j < (i / 8 + 1) * 8; j++)
        row[j] += m[i] * f[j] + m_l[i] * s[j];
    }

    for (int64_t j = 0; j < (k / 8 + 1) * 8; j++) {
      matrix[k * stride + j] = row_k[j];
      matrix[(k + 1) * stride + j] = row_l[j];
    }
  }
  return n;
}

const thrum_kernel thrum_kernel_reference = {
    .id = THRUM_KERNEL_REFERENCE,
    .energy = reference_energy,
    .force = reference_force,
    .forces = reference_forces,
    .tangent = reference_tangent,
    .tangent_vector = reference_tangent_vector,
    .force_part = reference_force_part,
    .tangent_vector_part = reference_tangent_vector_part,
    .restrict_to = reference_restrict,
    .restricted_gradient = reference_restricted_gradient,
    .restricted_hessian = reference_restricted_hessian,
    .product = reference_product,
    .rank_two = reference_rank_two,
    .sweep = reference_sweep,
};
