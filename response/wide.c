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
