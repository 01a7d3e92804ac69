/* Sums of rows; see wide.h. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "response/wide.h"

/* The loops; static, for gcc exports the forms of a function that is not. */
WIDE static void add_rows(int64_t rows, int64_t columns, const double *restrict matrix,
                          const double *restrict x, double *restrict y) {
  const double *a = matrix;
  int64_t i = 0;

  // eight rows in a pass, added in ascending order
  for (; i + 8 <= rows; i += 8, a += 8 * columns) {
    const double *w = x + i;
    for (int64_t c = 0; c < columns; c++) {
      const double four =
          (((y[c] + w[0] * a[c]) + w[1] * a[columns + c]) + w[2] * a[2 * columns + c]) +
          w[3] * a[3 * columns + c];
      y[c] = (((four + w[4] * a[4 * columns + c]) + w[5] * a[5 * columns + c]) +
              w[6] * a[6 * columns + c]) +
             w[7] * a[7 * columns + c];
    }
  }
  for (; i < rows; i++, a += columns)
    for (int64_t c = 0; c < columns; c++)
      y[c] += x[i] * a[c];
}

void thrum_wide_product(int64_t rows, int64_t columns, const double *matrix, const double *x,
                        double *y) {
  add_rows(rows, columns, matrix, x, y);
}

/* The sums of even and of odd m, with cosines and with sines, into out, of two waves each at a
 * time; then what they are at the four places. */
WIDE static void sum_waves(int64_t count, int64_t columns, const double *restrict even,
                           const double *restrict odd, const double *restrict c,
                           const double *restrict s, double by, double *const out[4]) {
  double *restrict even_c = out[0], *restrict odd_c = out[1], *restrict even_s = out[2],
                   *restrict odd_s = out[3];
  for (int64_t k = 0; k < columns; k++) {
    even_c[k] = c[0] * even[k];
    even_s[k] = odd_c[k] = odd_s[k] = 0;
  }
  int64_t m = 1;
  for (; m + 3 < count; m += 4) {
    const double *a = even + m * columns, *b = odd + m * columns;
    for (int64_t k = 0; k < columns; k++)
      odd_c[k] = (odd_c[k] + c[m] * a[k]) + c[m + 2] * a[2 * columns + k];
    for (int64_t k = 0; k < columns; k++)
      even_c[k] = (even_c[k] + c[m + 1] * a[columns + k]) + c[m + 3] * a[3 * columns + k];
    for (int64_t k = 0; k < columns; k++)
      odd_s[k] = (odd_s[k] + s[m] * b[k]) + s[m + 2] * b[2 * columns + k];
    for (int64_t k = 0; k < columns; k++)
      even_s[k] = (even_s[k] + s[m + 1] * b[columns + k]) + s[m + 3] * b[3 * columns + k];
  }
  for (; m < count; m++) {
    const double *a = even + m * columns, *b = odd + m * columns;
    double *restrict with_c = m % 2 == 0 ? even_c : odd_c, *restrict with_s =
                                                               m % 2 == 0 ? even_s : odd_s;
    for (int64_t k = 0; k < columns; k++) {
      with_c[k] += c[m] * a[k];
      with_s[k] += s[m] * b[k];
    }
  }
  for (int64_t k = 0; k < columns; k++) {
    const double sum_c = by * (even_c[k] + odd_c[k]), less_c = by * (even_c[k] - odd_c[k]);
    const double sum_s = by * (even_s[k] + odd_s[k]), less_s = by * (even_s[k] - odd_s[k]);
    even_c[k] = sum_c + sum_s;
    odd_c[k] = less_c + less_s;
    even_s[k] = sum_c - sum_s;
    odd_s[k] = less_c - less_s;
  }
}

void thrum_wide_waves(int64_t count, int64_t columns, const double *even, const double *odd,
                      const double *cosines, const double *sines, double by, double *const out[4]) {
  sum_waves(count, columns, even, odd, cosines, sines, by, out);
}
