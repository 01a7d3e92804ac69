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

static double reference_value(const thrum_form *f, const double *q, double *work) {
  const int64_t n = f->n, pairs = thrum_pair_count(n);
  double *m = work, *y = m + pairs, *g = y + pairs, *sums = g + n, *to = y;
  const double *c3 = f->c3, *c4 = f->c4;
  pair_monomials(n, q, m);
  for (int64_t j = 0; j < n; j++) {
    const int64_t columns = thrum_pair_count(n - j);
    c4 += f->skip * columns;
    for (int64_t i = 0; i <= j; i++) {
      double lane[LANES] = {0};
      row_product(j, n, c3, q, lane);
      row_product(pairs - columns, pairs, c4, m, lane);
      *to++ = lanes_sum(lane);
      c3 += n - j;
      c4 += columns;
    }
  }
  memset(g, 0, (size_t)n * sizeof *g);
  lower_pairs(n, y, q, g, sums);
  return dot(n, q, sums);
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

static void reference_product(const thrum_form *f, const double *q, const double *v,
                              double *product, double *work) {
  const int64_t n = f->n, pairs = thrum_pair_count(n);
  double *m = work, *dm = m + pairs, *w = dm + pairs, *dw = w + pairs, *y = dw + pairs;
  double *dy = y + pairs, *g = dy + pairs, *dg = g + n, *sums = dg + n;
  double *to = y, *dto = dy;
  const double *c3 = f->c3, *c4 = f->c4;
  pair_monomials(n, q, m);
  for (int64_t k = 0, t = 0; k < n; k++)
    for (int64_t l = k; l < n; l++)
      dm[t++] = q[k] * v[l] + v[k] * q[l];
  memset(w, 0, (size_t)(2 * pairs) * sizeof *w);
  memset(g, 0, (size_t)(2 * n) * sizeof *g);
  // every line is the derivative along v of a line of reference_gradient
  for (int64_t j = 0; j < n; j++) {
    const int64_t columns = thrum_pair_count(n - j), first = pairs - columns;
    c4 += f->skip * columns;
    for (int64_t i = 0; i <= j; i++) {
      double lane[LANES] = {0}, dlane[LANES] = {0};
      const double x = q[i] * q[j], dx = q[i] * v[j] + v[i] * q[j];
      row_both(j, n, c3, q, x, g, lane);
      row_both(j, n, c3, v, dx, dg, dlane);
      row_both(first, pairs, c4, m, x, w, lane);
      row_both(first, pairs, c4, dm, dx, dw, dlane);
      *to++ = lanes_sum(lane);
      *dto++ = lanes_sum(dlane);
      c3 += n - j;
      c4 += columns;
    }
  }
  lower_pairs(n, y, v, dg, sums);
  lower_pairs(n, dy, q, dg, sums + n);
  upper_pairs(n, 0, n, w, v, v, dg, sums + 2 * n);
  upper_pairs(n, 0, n, dw, q, q, dg, sums + 3 * n);
  for (int64_t i = 0; i < n; i++)
    product[i] += dg[i] + ((sums[i] + sums[n + i]) + (sums[2 * n + i] + sums[3 * n + i]));
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

/* The blocks j >= split: their rows i < split go one degree down, their others are kept. */
static void contract_high(const thrum_model *model, int64_t split, const double *q,
                          double *quadratic, double *cubic, double *t) {
  const int64_t rank = model->rank, n = rank - split;
  const double *c3 = model->c3 + thrum_c3_index(rank, 0, split, split);
  const double *c4 = model->c4 + thrum_c4_index(rank, 0, split, split, split);
  double *kept = cubic;
  for (int64_t j = 0; j < n; j++) {
    const int64_t size = (j + 1) * (n - j);
    for (int64_t i = 0; i < split; i++)
      axpy(n - j, q[i], c3 + i * (n - j), quadratic);
    memcpy(kept, c3 + split * (n - j), (size_t)size * sizeof *kept);
    c3 += (split + j + 1) * (n - j);
    quadratic += n - j;
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

static double reference_contract(const thrum_model *model, int64_t split, const double *q_given,
                                 double *restricted, double *work) {
  const int64_t rank = model->rank, n = rank - split, all = thrum_pair_count(rank);
  double *linear = restricted, *quadratic = linear + n, *cubic = quadratic + thrum_pair_count(n);
  double *w = work, *t = w + all, *w3 = t + all, *g = w3 + rank, *sums = g + rank;
  double *q = sums + rank, constant = 0;
  const double *c3 = model->c3, *c4 = model->c4;
  memset(w, 0, (size_t)all * sizeof *w);
  memset(w3, 0, (size_t)(2 * rank) * sizeof *w3);
  memset(q, 0, (size_t)rank * sizeof *q);
  memcpy(q, q_given, (size_t)split * sizeof *q);
  // the blocks j < split
  for (int64_t j = 0; j < split; j++) {
    const int64_t columns = thrum_pair_count(rank - j);
    for (int64_t i = 0; i <= j; i++) {
      axpy(rank - j, q[i] * q[j], c3, w3 + j);
      axpy(columns, q[i] * q[j], c4, w + (all - columns));
      c3 += rank - j;
      c4 += columns;
    }
  }
  // pairs (c, l) of w: both held gives the constant, one held the linear, none the quadratic term
  upper_pairs(rank, 0, split, w, q, q, g, sums);
  for (int64_t c = 0; c < split; c++)
    constant += ((0.5 * model->omega2[c] * q[c] + w3[c]) + sums[c]) * q[c];
  for (int64_t k = 0; k < n; k++)
    linear[k] = w3[split + k] + g[split + k];
  memcpy(quadratic, w + (all - thrum_pair_count(n)),
         (size_t)thrum_pair_count(n) * sizeof *quadratic);
  for (int64_t k = 0, diagonal = 0; k < n; diagonal += n - k, k++)
    quadratic[diagonal] += 0.5 * model->omega2[split + k];
  if (n > 0)
    contract_high(model, split, q, quadratic, cubic, t);
  return constant;
}

const thrum_kernel thrum_kernel_reference = {
    THRUM_KERNEL_REFERENCE, reference_value, reference_gradient, reference_hessian,
    reference_product,      reference_pairs, reference_contract};
