/* The polynomial in other coordinates q = S q', design 3: with the products of pairs
 * x = (q_i q_j), i <= j, its parts are q^T D x and x^T C x, and x = W x' with
 *   W_(kl)(ab) = S_ka S_lb + S_kb S_la (a < b),  S_ka S_la (a = b),
 * so D' = S^T D W and C' = W^T C W; then every entry goes to the monomial that it multiplies.
 * Cost: 4 m^3 by BLAS-3, m = r (r + 1) / 2.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/polynomial/change_of_basis.h"

#include <cblas.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/polynomial/polynomial_reduce.h"
#include "thrum/model.h"
#include "thrum/polynomial.h"

typedef struct change_work {
  int64_t rank, pairs;
  const double *change;
  double *pair;   /* W, pairs x pairs */
  double *form;   /* D or C: at most pairs x pairs */
  double *result; /* the same of D' or C', and what leads there */
} change_work;

static void fill_pairs(change_work *t) {
  const int64_t r = t->rank;
  double *out = t->pair;
  for (int64_t k = 0; k < r; k++)
    for (int64_t l = k; l < r; l++)
      for (int64_t a = 0; a < r; a++)
        for (int64_t b = a; b < r; b++) {
          const double *row = t->change + k * r, *column = t->change + l * r;
          *out++ = a == b ? row[a] * column[a] : row[a] * column[b] + row[b] * column[a];
        }
}

// result = left^T form W; left is rows x rows
static void transform(change_work *t, const double *left, int64_t rows) {
  const int m = (int)t->pairs, n = (int)rows;
  cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, n, m, m, 1, t->form, m, t->pair, m, 0,
              t->result, m);
  cblas_dgemm(CblasRowMajor, CblasTrans, CblasNoTrans, n, m, n, 1, left, n, t->result, m, 0,
              t->form, m);
}

static void change_cubic(change_work *t, const double *c3, double *changed) {
  const int64_t r = t->rank;
  int64_t pair = 0;
  for (int64_t k = 0; k < r; k++)
    for (int64_t l = k; l < r; l++, pair++)
      for (int64_t i = 0; i < r; i++)
        t->form[i * t->pairs + pair] = i <= k ? c3[thrum_c3_index(r, i, k, l)] : 0;

  transform(t, t->change, r);
  memset(changed, 0, sizeof *changed * (size_t)thrum_c3_count(r));

  // every entry goes to the monomial that it multiplies
  for (int64_t i = 0; i < r; i++) {
    const double *row = t->form + i * t->pairs;
    for (int64_t k = 0; k < r; k++)
      for (int64_t l = k; l < r; l++) {
        int64_t index[3] = {i, k, l};
        thrum_indices_sort(index, 3);
        changed[thrum_c3_index(r, index[0], index[1], index[2])] += *row++;
      }
  }
}

static void change_quartic(change_work *t, const double *c4, double *changed) {
  const int64_t r = t->rank;
  double *out = t->form;

  // a monomial i <= j <= k <= l stands at ((i, j), (k, l)) alone
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = i; j < r; j++)
      for (int64_t k = 0; k < r; k++)
        for (int64_t l = k; l < r; l++)
          *out++ = j <= k ? c4[thrum_c4_index(r, i, j, k, l)] : 0;

  transform(t, t->pair, t->pairs);
  memset(changed, 0, sizeof *changed * (size_t)thrum_c4_count(r));

  // every entry goes to the monomial that it multiplies
  const double *next = t->form;
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = i; j < r; j++)
      for (int64_t k = 0; k < r; k++)
        for (int64_t l = k; l < r; l++) {
          int64_t index[4] = {i, j, k, l};
          thrum_indices_sort(index, 4);
          changed[thrum_c4_index(r, index[0], index[1], index[2], index[3])] += *next++;
        }
}

thrum_status thrum_polynomial_change_basis(int64_t rank, const double *change, const double *c3,
                                           const double *c4, double *changed3, double *changed4,
                                           thrum_error *error) {
  // the work needs forms over pairs of coordinates
  const int64_t pairs = rank * (rank + 1) / 2;
  change_work t = {.rank = rank, .pairs = pairs, .change = change};
  thrum_scope memory = thrum_scope_begin("the changed polynomial", error);
  t.pair = thrum_scope_allocate(&memory, pairs * pairs, sizeof(double));
  t.form = thrum_scope_allocate(&memory, pairs * pairs, sizeof(double));
  t.result = thrum_scope_allocate(&memory, pairs * pairs, sizeof(double));

  // the products of the change, pair by pair, serve both degrees
  if (memory.status >= 0) {
    fill_pairs(&t);
    change_cubic(&t, c3, changed3);
    change_quartic(&t, c4, changed4);
  }
  thrum_scope_free(&memory);
  return memory.status;
}
