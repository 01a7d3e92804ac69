/* Dense linear systems in place: A P = L U, with the largest entry of a row as its pivot.
 *
 * Four rows at a time are reduced by the rows above them, four of which go at a time: the inverse
 * of the triangle of their pivots gives the multipliers, and one pass adds their columns behind. So
 * what is loaded serves four rows, and no multiplier waits for the one before it. -L is stored in
 * place of L, for the passes add, the inverse of a pivot in its place, and those triangles behind
 * the rows. Columns of right-hand sides beside the matrix are reduced with it. Cost: 2/3 n^3
 * operations, 2 n^2 for a right-hand side. Source: Golub and Van Loan 2013, Matrix computations,
 * section 3.2.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "response/square_system.h"

#include <math.h>

#include "core/base/matrix_product.h"
#include "response/wide.h"

#define FOUR 4 /* rows at a time */

/* A system: its rows are `width` apart, and have `used` numbers that passes reach. */
typedef struct square {
  double *matrix;
  int64_t n, used, width;
} square;

static square square_of(double *matrix, int64_t n, int64_t count) {
  const int64_t width = thrum_square_width(n, count);
  return (square){matrix, n, width - THRUM_SQUARE_BEHIND, width};
}

/* Where minus the inverse of the triangle of four pivots lies, a row of it behind each of theirs.
 */
static inline double *behind(const square *s, int64_t row) {
  return s->matrix + row * s->width + s->used;
}

/* out = x times that triangle of the rows k .. k + 3. */
static inline void multiply(const square *s, int64_t k, const double *x, double out[FOUR]) {
  for (int j = 0; j < FOUR; j++)
    out[j] = x[0] * behind(s, k)[j];
  for (int i = 1; i < FOUR; i++)
    for (int j = 0; j < FOUR; j++)
      out[j] += x[i] * behind(s, k + i)[j];
}

/* A row += weights w times the four rows from `above` on, from column `from` on. */
static inline void add_four(const double *restrict above, int64_t width, int64_t from, int64_t to,
                            const double *w, double *restrict row) {
  const double *a = above, *b = a + width, *c = b + width, *d = c + width;
  const double wa = w[0], wb = w[1], wc = w[2], wd = w[3];
  for (int64_t j = from; j < to; j++)
    row[j] = (((row[j] + wa * a[j]) + wb * b[j]) + wc * c[j]) + wd * d[j];
}

/* The same of four rows that follow each other, with four weights each. */
static inline void add_four_to_four(const double *restrict above, int64_t width, int64_t from,
                                    int64_t to, const double *w, double *restrict row0,
                                    double *restrict row1, double *restrict row2,
                                    double *restrict row3) {
  const double *a = above, *b = a + width, *c = b + width, *d = c + width;
  const double a0 = w[0], b0 = w[1], c0 = w[2], d0 = w[3];
  const double a1 = w[4], b1 = w[5], c1 = w[6], d1 = w[7];
  const double a2 = w[8], b2 = w[9], c2 = w[10], d2 = w[11];
  const double a3 = w[12], b3 = w[13], c3 = w[14], d3 = w[15];
  for (int64_t j = from; j < to; j++) {
    row0[j] = (((row0[j] + a0 * a[j]) + b0 * b[j]) + c0 * c[j]) + d0 * d[j];
    row1[j] = (((row1[j] + a1 * a[j]) + b1 * b[j]) + c1 * c[j]) + d1 * d[j];
    row2[j] = (((row2[j] + a2 * a[j]) + b2 * b[j]) + c2 * c[j]) + d2 * d[j];
    row3[j] = (((row3[j] + a3 * a[j]) + b3 * b[j]) + c3 * c[j]) + d3 * d[j];
  }
}

static inline void add_rows(const square *s, int64_t above, int64_t from, const double *w,
                            int64_t first, int64_t count) {
  double *rows = s->matrix + first * s->width;
  const double *of = s->matrix + above * s->width;
  if (count == FOUR)
    add_four_to_four(of, s->width, from, s->used, w, rows, rows + s->width, rows + 2 * s->width,
                     rows + 3 * s->width);
  else
    for (int64_t i = 0; i < count; i++)
      add_four(of, s->width, from, s->used, w + FOUR * i, rows + i * s->width);
}

/* Reduces four rows, or the last few, by all rows above the first. A pass begins at a multiple of
 * eight, and the multipliers are stored behind it. */
WIDE static void reduce(const square *s, int64_t first, int64_t count) {
  for (int64_t k = 0; k < first; k += FOUR) {
    double w[FOUR * FOUR];
    for (int64_t i = 0; i < count; i++)
      multiply(s, k, s->matrix + (first + i) * s->width + k, w + FOUR * i);
    add_rows(s, k, (k + FOUR) / 8 * 8, w, first, count);
    for (int64_t i = 0; i < count; i++)
      for (int64_t j = 0; j < FOUR; j++)
        s->matrix[(first + i) * s->width + k + j] = w[FOUR * i + j];
  }
}

/* Reduces a row by those of its four that are done. */
WIDE static void reduce_within(const square *s, int64_t first, int64_t i) {
  const double *a = s->matrix + first * s->width, *b = a + s->width, *c = b + s->width;
  double *restrict row = s->matrix + i * s->width;
  double w[FOUR] = {0};
  for (int64_t k = 0; k < i - first; k++) {
    double value = row[first + k];
    for (int64_t j = 0; j < k; j++)
      value += w[j] * a[j * s->width + first + k];
    w[k] = -value * a[k * s->width + first + k];
  }

  // one pass, behind which the multipliers are stored
  if (i - first == 1)
    for (int64_t j = first; j < s->used; j++)
      row[j] += w[0] * a[j];
  if (i - first == 2)
    for (int64_t j = first; j < s->used; j++)
      row[j] = (row[j] + w[0] * a[j]) + w[1] * b[j];
  if (i - first == 3)
    for (int64_t j = first; j < s->used; j++)
      row[j] = ((row[j] + w[0] * a[j]) + w[1] * b[j]) + w[2] * c[j];
  for (int64_t k = 0; k < i - first; k++)
    row[first + k] = w[k];
}

/* Takes the largest entry that is left in row i as its pivot. */
static bool take_pivot(const square *s, int64_t i, int32_t *columns) {
  double *row = s->matrix + i * s->width, most = fabs(row[i]);
  int64_t best = i;
  for (int64_t j = i + 1; j < s->n; j++)
    if (fabs(row[j]) > most) {
      most = fabs(row[j]);
      best = j;
    }
  columns[i] = (int32_t)best;
  for (int64_t k = 0; k < s->n && best != i; k++) {
    double *other = s->matrix + k * s->width;
    const double kept = other[i];
    other[i] = other[best];
    other[best] = kept;
  }
  if (row[i] == 0 || !isfinite(row[i]))
    return false;
  row[i] = 1 / row[i];
  return true;
}

/* Minus the inverse of the triangle of four rows that are done. */
static void invert(const square *s, int64_t first) {
  for (int64_t j = 0; j < FOUR; j++)
    for (int64_t i = FOUR - 1; i >= 0; i--) {
      const double *row = s->matrix + (first + i) * s->width + first;
      double sum = i == j ? -1 : 0;
      for (int64_t k = i + 1; k <= j; k++)
        sum -= row[k] * behind(s, first + k)[j];
      behind(s, first + i)[j] = i > j ? 0 : sum * row[i];
    }
}

static bool factor(const square *s, int64_t columns_used, int32_t *columns) {
  for (int64_t i = 0; i < s->n; i++)
    for (int64_t j = columns_used; j < s->used; j++)
      s->matrix[i * s->width + j] = 0;
  for (int64_t first = 0; first < s->n; first += FOUR) {
    const int64_t last = first + FOUR < s->n ? first + FOUR : s->n;
    reduce(s, first, last - first);
    for (int64_t i = first; i < last; i++) {
      reduce_within(s, first, i);
      if (!take_pivot(s, i, columns))
        return false;
    }
    if (last == first + FOUR)
      invert(s, first);
  }
  return true;
}

bool thrum_square_factor(double *matrix, int64_t n, int32_t *columns) {
  const square s = square_of(matrix, n, 0);
  return factor(&s, n, columns);
}

int thrum_square_sign(const double *factors, int64_t n, const int32_t *columns) {
  const int64_t width = thrum_square_width(n, 0);
  int sign = 1;
  for (int64_t i = 0; i < n; i++)
    if ((factors[i * width + i] < 0) != (columns[i] != i))
      sign = -sign;
  return sign;
}

void thrum_square_solve(const double *factors, int64_t n, const int32_t *columns, double *x) {
  const int64_t width = thrum_square_width(n, 0);

  // forward with L, whose diagonal is 1 and of which -L is stored
  for (int64_t i = 1; i < n; i++)
    thrum_matrix_product(1, i, factors + i * width, x, x + i);

  // backward with U
  for (int64_t i = n - 1; i >= 0; i--) {
    const double *row = factors + i * width;
    double sum = 0;
    thrum_matrix_product(1, n - 1 - i, row + i + 1, x + i + 1, &sum);
    x[i] = (x[i] - sum) * row[i];
  }

  // the unknowns return to the order of their columns
  for (int64_t i = n - 1; i >= 0; i--)
    if (columns[i] != i) {
      const double kept = x[i];
      x[i] = x[columns[i]];
      x[columns[i]] = kept;
    }
}

/* Backward with U, of the rows first .. last - 1, where those below are solutions. */
WIDE static void substitute(const square *s, int64_t first, int64_t last) {
  for (int64_t k = last; k < s->n; k += FOUR) {
    const int64_t left = s->n - k < FOUR ? s->n - k : FOUR;
    double w[FOUR * FOUR];
    for (int64_t i = first; i < last; i++)
      for (int64_t j = 0; j < FOUR; j++)
        w[FOUR * (i - first) + j] = j < left ? -s->matrix[i * s->width + k + j] : 0;
    if (left == FOUR) {
      add_rows(s, k, s->n, w, first, last - first);
      continue;
    }
    for (int64_t i = first; i < last; i++)
      for (int64_t j = 0; j < left; j++) {
        const double *below = s->matrix + (k + j) * s->width;
        double *restrict row = s->matrix + i * s->width;
        for (int64_t c = s->n; c < s->used; c++)
          row[c] += w[FOUR * (i - first) + j] * below[c];
      }
  }

  // within the four
  for (int64_t i = last - 1; i >= first; i--) {
    double *restrict row = s->matrix + i * s->width;
    for (int64_t k = i + 1; k < last; k++) {
      const double *below = s->matrix + k * s->width;
      for (int64_t c = s->n; c < s->used; c++)
        row[c] -= row[k] * below[c];
    }
    for (int64_t c = s->n; c < s->used; c++)
      row[c] *= row[i];
  }
}

bool thrum_square_eliminate(double *system, int64_t n, int64_t count, int32_t *columns) {
  const square s = square_of(system, n, count);
  if (!factor(&s, n + count, columns))
    return false;
  const int64_t end = (n + FOUR - 1) / FOUR * FOUR;
  for (int64_t first = end - FOUR; first >= 0; first -= FOUR)
    substitute(&s, first, first + FOUR < n ? first + FOUR : n);

  // as of one right-hand side
  for (int64_t i = n - 1; i >= 0; i--)
    for (int64_t c = n; c < n + count && columns[i] != i; c++) {
      double *one = system + i * s.width + c, *other = system + columns[i] * s.width + c;
      const double kept = *one;
      *one = *other;
      *other = kept;
    }
  return true;
}
