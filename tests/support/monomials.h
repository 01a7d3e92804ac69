/* The polynomial of a model, summed monomial by monomial. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_MONOMIALS_H
#define THRUM_TESTS_SUPPORT_MONOMIALS_H

#include "thrum/polynomial.h"

static inline double polynomial_of(const thrum_model *model, const double *q) {
  double v = 0;
  const int64_t r = model->rank;
  for (int64_t i = 0; i < r; i++)
    v += model->omega2[i] * q[i] * q[i] / 2;
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = i; j < r; j++)
      for (int64_t k = j; k < r; k++) {
        v += model->c3[thrum_c3_index(r, i, j, k)] * q[i] * q[j] * q[k];
        for (int64_t l = k; l < r; l++)
          v += model->c4[thrum_c4_index(r, i, j, k, l)] * q[i] * q[j] * q[k] * q[l];
      }
  return v;
}

#endif
