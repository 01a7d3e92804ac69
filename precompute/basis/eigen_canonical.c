/* Canonical signs and clusters of eigenvectors, see eigen.h. O(rows count^2) in a cluster.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "precompute/basis/eigen.h"

typedef struct frame {
  int64_t rows, row_step, column_step;
  double *vectors;
  const thrum_ranks *ranks; /* whose part the rows are of; NULL: of none */
  const int32_t *component; /* of the part, of each row; NULL: the row itself */
} frame;

static double *entry(const frame *f, int64_t row, int64_t column) {
  return f->vectors + row * f->row_step + column * f->column_step;
}

// a number for each row that is the same whatever part it is met in, and ascends
static int64_t row_number(const frame *f, int64_t row) {
  const int64_t c = f->component != NULL ? f->component[row] : row;
  return f->ranks != NULL ? 3 * (int64_t)f->ranks->vertex[c / 3] + c % 3 : row;
}

static double square_of(const frame *f, int64_t row, int64_t first, int64_t end) {
  double square = 0;
  for (int64_t c = first; c < end; c++)
    square += *entry(f, row, c) * *entry(f, row, c);
  return square;
}

// the first row whose norm over the columns [first, end) is the largest, within 1e-6; where that is
// in another part, the number of rows
static int64_t pivot_row(const frame *f, int64_t first, int64_t end) {
  double largest = 0;
  for (int64_t row = 0; row < f->rows; row++)
    largest = fmax(largest, square_of(f, row, first, end));
  thrum_ranks_largest(f->ranks, &largest, 1);

  int64_t found = 0;
  while (found < f->rows && !(square_of(f, found, first, end) >= largest * (1 - 2e-6)))
    found++;
  if (f->ranks == NULL)
    return found < f->rows ? found : 0;

  // several parts may have such a row: the one with the lowest number counts
  const double number = found < f->rows ? (double)row_number(f, found) : INFINITY;
  double lowest = -number;
  thrum_ranks_largest(f->ranks, &lowest, 1);
  return number <= -lowest ? found : f->rows;
}

// two entries of the pivot row, from a part that owns it
static void pivot_entries(const frame *f, int64_t pivot, int64_t first, int64_t second,
                          double entries[2]) {
  entries[0] = entries[1] = 0;
  if (pivot < f->rows) {
    const int64_t c = f->component != NULL ? f->component[pivot] : pivot;
    if (f->ranks == NULL || f->ranks->own[c / 3]) {
      entries[0] = *entry(f, pivot, first);
      entries[1] = *entry(f, pivot, second);
    }
  }
  thrum_ranks_sum(f->ranks, entries, 2);
}

// turns the columns [first, end) by plane rotations until the pivot row lives in the first alone
static void gather_row(const frame *f, int64_t pivot, int64_t first, int64_t end) {
  double pair[2];

  // a rotation of two columns takes the entry of the second to zero
  for (int64_t c = first + 1; c < end; c++) {
    pivot_entries(f, pivot, first, c, pair);
    const double a = pair[0], b = pair[1], r = hypot(a, b);
    if (!(r > 0))
      continue;
    for (int64_t row = 0; row < f->rows; row++) {
      double *p = entry(f, row, first), *q = entry(f, row, c);
      const double turned = (a * *p + b * *q) / r;
      *q = (a * *q - b * *p) / r;
      *p = turned;
    }
  }

  // what is left of the row is positive
  pivot_entries(f, pivot, first, first, pair);
  if (pair[0] < 0)
    for (int64_t row = 0; row < f->rows; row++)
      *entry(f, row, first) = -*entry(f, row, first);
}

static void canonicalise(const frame *f, int64_t count, const double *values, double gap) {
  for (int64_t first = 0, end; first < count; first = end) {
    for (end = first + 1; end < count && values[end] - values[end - 1] <= gap;)
      end++;
    for (int64_t c = first; c < end; c++)
      gather_row(f, pivot_row(f, c, end), c, end);
  }
}

void thrum_eigen_canonicalise(int64_t rows, int64_t count, const double *values, double gap,
                              double *vectors, int64_t row_step, int64_t column_step) {
  const frame f = {
      .rows = rows, .row_step = row_step, .column_step = column_step, .vectors = vectors};
  canonicalise(&f, count, values, gap);
}

void thrum_eigen_canonicalise_fem(const thrum_fem *fem, bool whole, int64_t count,
                                  const double *values, double gap, double *vectors,
                                  int64_t row_step, int64_t column_step) {
  const frame f = {.rows = whole ? 3 * fem->vertex_count : fem->free_count,
                   .row_step = row_step,
                   .column_step = column_step,
                   .vectors = vectors,
                   .ranks = fem->ranks,
                   .component = whole ? NULL : fem->component};
  canonicalise(&f, count, values, gap);
}
