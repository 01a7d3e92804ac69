/* Forms in other coordinates, one index after the other. Cost: degree rank^(degree + 1)
 * multiply-adds for all of them. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/parameters/form.h"

#include <string.h>

#include "thrum/model.h"
#include "thrum/polynomial.h"

static int64_t entries(int64_t rank, int degree) {
  int64_t count = 1;
  for (int d = 0; d < degree; d++)
    count *= rank;
  return count;
}

/* The indices of an entry, sorted, and in how many orders they can stand. */
static int64_t sorted(int64_t rank, int degree, int64_t entry, int64_t *index) {
  for (int d = 0; d < degree; d++) {
    int64_t i = entry % rank;
    int at = d;
    entry /= rank;
    for (; at > 0 && index[at - 1] > i; at--)
      index[at] = index[at - 1];
    index[at] = i;
  }
  int64_t orders = 1, run = 1;
  for (int d = 1; d < degree; d++) {
    run = index[d] == index[d - 1] ? run + 1 : 1;
    orders = orders * (d + 1) / run;
  }
  return orders;
}

static int64_t monomial(int64_t rank, int degree, const int64_t *index) {
  return degree == 3 ? thrum_c3_index(rank, index[0], index[1], index[2])
                     : thrum_c4_index(rank, index[0], index[1], index[2], index[3]);
}

void thrum_form_expand(int64_t rank, int degree, const double *monomials, double *form) {
  const int64_t count = entries(rank, degree);
  for (int64_t n = 0; n < count; n++) {
    int64_t index[4] = {0};
    const int64_t orders = sorted(rank, degree, n, index);
    form[n] = monomials[monomial(rank, degree, index)] / (double)orders;
  }
}

void thrum_form_turn_one(int64_t rank, int degree, const double *matrix, const double *form,
                         double *to) {
  const int64_t others = entries(rank, degree - 1);
  for (int64_t n = 0; n < others; n++) {
    double *row = to + n * rank;
    memset(row, 0, (size_t)rank * sizeof *row);
    for (int64_t i = 0; i < rank; i++) {
      const double by = form[i * others + n], *column = matrix + i * rank;
      for (int64_t a = 0; a < rank; a++)
        row[a] += by * column[a];
    }
  }
}

void thrum_form_turn(int64_t rank, int degree, const double *matrix, double *form, double *work) {
  double *from = form, *to = work;
  for (int d = 0; d < degree; d++) {
    thrum_form_turn_one(rank, degree, matrix, from, to);
    double *other = from;
    from = to;
    to = other;
  }
  if (from != form)
    memcpy(form, from, (size_t)entries(rank, degree) * sizeof *form);
}

void thrum_form_collapse(int64_t rank, int degree, const double *form, double *monomials) {
  const int64_t count = entries(rank, degree);
  memset(monomials, 0,
         (size_t)(degree == 3 ? thrum_c3_count(rank) : thrum_c4_count(rank)) * sizeof *monomials);
  for (int64_t n = 0; n < count; n++) {
    int64_t index[4] = {0};
    sorted(rank, degree, n, index);
    monomials[monomial(rank, degree, index)] += form[n];
  }
}
