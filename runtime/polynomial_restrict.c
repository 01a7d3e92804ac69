/* V with the explicit coordinates held: a polynomial of degree 4 in the implicit ones, design 5.
 *
 * With E = {0..split-1} at q_E, V(q_E, .) is contracted once a step; an iteration of the implicit
 * solve then sees rank - split coordinates only. Sorted indices make every part a block product:
 *   quartic    the block of c4 with all indices in I, left where it is
 *   cubic      c3 in I + sum_a q_a c4_aijk: the rows a < split of the blocks over j >= split
 *   quadratic  1/2 omega^2 + sum_a q_a c3_akl + w_kl, where w = sum_{a<=b} q_a q_b c4_ab..
 *   linear     sum_{a<=b} q_a q_b c3_abl + sum_c q_c w_cl
 * Cost: 2 operations per coefficient outside the pure quartic block, each read once.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "polynomial.h"

#include <string.h>

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

int64_t thrum_restricted_count(int64_t n) {
  return n + thrum_pair_count(n) + thrum_c3_count(n);
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

/* The blocks j < split: w (all pairs) and w3 (rank) get their transposed products with q_i q_j. */
static void contract_low(const thrum_model *model, int64_t split, const double *q, double *w3,
                         double *w, double *x) {
  int64_t rank = model->rank, pairs = thrum_pair_count(rank);
  const double *c3 = model->c3, *c4 = model->c4;
  for (int64_t j = 0; j < split; j++) {
    int64_t rows = j + 1, columns = thrum_pair_count(rank - j);
    for (int64_t i = 0; i < rows; i++)
      x[i] = q[i] * q[j];
    thrum_kernel_transposed(rows, rank - j, c3, x, w3 + j);
    thrum_kernel_transposed(rows, columns, c4, x, w + (pairs - columns));
    c3 += rows * (rank - j);
    c4 += rows * columns;
  }
}

/* The blocks j >= split: their rows i < split go one degree down, their others are kept. */
static void contract_high(const thrum_model *model, int64_t split, const double *q,
                          double *quadratic, double *cubic, double *t) {
  int64_t rank = model->rank, n = rank - split;
  if (n == 0)
    return;
  const double *c3 = model->c3 + thrum_c3_index(rank, 0, split, split);
  const double *c4 = model->c4 + thrum_c4_index(rank, 0, split, split, split);
  double *kept = cubic;
  for (int64_t j = 0; j < n; j++) {
    int64_t size = (j + 1) * (n - j);
    thrum_kernel_transposed(split, n - j, c3, q, quadratic);
    memcpy(kept, c3 + split * (n - j), (size_t)size * sizeof *kept);
    c3 += (split + j + 1) * (n - j);
    quadratic += n - j;
    kept += size;
  }
  for (int64_t j = 0; j < n && split > 0; j++) {
    int64_t columns = thrum_pair_count(n - j);
    memset(t, 0, (size_t)columns * sizeof *t);
    thrum_kernel_transposed(split, columns, c4, q, t);
    scatter_cubic(n, j, t, cubic);
    c4 += (split + j + 1) * columns;
  }
}

double thrum_polynomial_restrict(const thrum_model *model, int32_t split, const double *q,
                                 double *restricted, double *work) {
  int64_t rank = model->rank, n = rank - split, pairs = thrum_pair_count(rank);
  double *linear = restricted, *quadratic = linear + n, *cubic = quadratic + thrum_pair_count(n);
  double *w = work, *t = w + pairs, *w3 = t + pairs, *x = w3 + rank, constant = 0;
  memset(w, 0, (size_t)pairs * sizeof *w);
  memset(w3, 0, (size_t)rank * sizeof *w3);
  contract_low(model, split, q, w3, w, x);

  // pairs (c, l) of w: both held gives the constant, one held the linear, none the quadratic term
  memcpy(linear, w3 + split, (size_t)n * sizeof *linear);
  const double *row = w;
  for (int64_t c = 0; c < split; c++) {
    constant += (0.5 * model->omega2[c] * q[c] + w3[c]) * q[c];
    constant += thrum_kernel_dot(split - c, row, q + c) * q[c];
    thrum_kernel_axpy(n, q[c], row + (split - c), linear);
    row += rank - c;
  }
  memcpy(quadratic, row, (size_t)thrum_pair_count(n) * sizeof *quadratic);
  for (int64_t k = 0, diagonal = 0; k < n; diagonal += n - k, k++)
    quadratic[diagonal] += 0.5 * model->omega2[split + k];
  contract_high(model, split, q, quadratic, cubic, t);
  return constant;
}
