/* The matrix of second derivatives, see coefficients.h. SPDX-License-Identifier: Apache-2.0 */
#include "accelerator/coefficients.h"

#include "thrum/polynomial.h"

static int64_t pair_of(int64_t rank, int64_t i, int64_t j) {
  const int64_t a = i < j ? i : j, b = i < j ? j : i;
  return a * rank - a * (a - 1) / 2 + b - a;
}

// deriving by two factors of a monomial leaves the others; a square gives a factor of two
static void derive(float *row, int64_t rank, int64_t a, int64_t b, double coefficient) {
  row[pair_of(rank, a, b)] += (float)(a == b ? 2 * coefficient : coefficient);
}

void second_derivatives(const thrum_model *model, float *matrix, int64_t columns, int64_t first) {
  const int64_t r = model->rank;
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = i; j < r; j++)
      for (int64_t k = j; k < r; k++) {
        const double cubic = model->c3[thrum_c3_index(r, i, j, k)];
        derive(matrix + k * columns, r, i, j, cubic);
        derive(matrix + j * columns, r, i, k, cubic);
        derive(matrix + i * columns, r, j, k, cubic);
        for (int64_t l = k; l < r; l++) {
          const double quartic = model->c4[thrum_c4_index(r, i, j, k, l)];
          derive(matrix + (first + pair_of(r, k, l)) * columns, r, i, j, quartic);
          derive(matrix + (first + pair_of(r, j, l)) * columns, r, i, k, quartic);
          derive(matrix + (first + pair_of(r, j, k)) * columns, r, i, l, quartic);
          derive(matrix + (first + pair_of(r, i, l)) * columns, r, j, k, quartic);
          derive(matrix + (first + pair_of(r, i, k)) * columns, r, j, l, quartic);
          derive(matrix + (first + pair_of(r, i, j)) * columns, r, k, l, quartic);
        }
      }
}
