/* Canonical signs and clusters of eigenvectors, see eigen.h. O(rows count^2) in a cluster.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "precompute/basis/eigen.h"

typedef struct frame {
  int64_t rows, row_step, column_step;
  double *vectors;
} frame;

static double *entry(const frame *f, int64_t row, int64_t column) {
  return f->vectors + row * f->row_step + column * f->column_step;
}

// the first row whose norm over the columns [first, end) is the largest, within 1e-6
static int64_t pivot_row(const frame *f, int64_t first, int64_t end) {
  double largest = 0;
  for (int pass = 0; pass < 2; pass++)
    for (int64_t row = 0; row < f->rows; row++) {
      double square = 0;
      for (int64_t c = first; c < end; c++)
        square += *entry(f, row, c) * *entry(f, row, c);
      if (pass == 0)
        largest = square > largest ? square : largest;
      else if (square >= largest * (1 - 2e-6))
        return row;
    }
  return 0;
}

// turns the columns [first, end) by plane rotations until the pivot row lives in the first alone
static void gather_row(const frame *f, int64_t pivot, int64_t first, int64_t end) {
  for (int64_t c = first + 1; c < end; c++) {
    const double a = *entry(f, pivot, first), b = *entry(f, pivot, c), r = hypot(a, b);
    if (!(r > 0))
      continue;
    for (int64_t row = 0; row < f->rows; row++) {
      double *p = entry(f, row, first), *q = entry(f, row, c);
      const double turned = (a * *p + b * *q) / r;
      *q = (a * *q - b * *p) / r;
      *p = turned;
    }
  }
  if (*entry(f, pivot, first) < 0)
    for (int64_t row = 0; row < f->rows; row++)
      *entry(f, row, first) = -*entry(f, row, first);
}

void thrum_eigen_canonicalise(int64_t rows, int64_t count, const double *values, double gap,
                              double *vectors, int64_t row_step, int64_t column_step) {
  const frame f = {rows, row_step, column_step, vectors};
  for (int64_t first = 0, end; first < count; first = end) {
    for (end = first + 1; end < count && values[end] - values[end - 1] <= gap;)
      end++;
    for (int64_t c = first; c < end; c++)
      gather_row(&f, pivot_row(&f, c, end), c, end);
  }
}
