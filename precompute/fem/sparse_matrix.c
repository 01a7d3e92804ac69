/* Sparse symmetric matrices, see sparse_matrix.h. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/sparse_matrix.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"

#define PRODUCT_COLUMNS 8 /* side by side: a line of the cache */
_Static_assert(THRUM_PRODUCT_WORK == 2 * PRODUCT_COLUMNS, "room for columns and their products");

thrum_status thrum_sparse_create(int64_t size, int64_t entries, thrum_sparse *matrix,
                                 thrum_error *error) {
  thrum_sparse made = {.size = size};
  const char *what = "a sparse matrix";
  thrum_status status = thrum_reserve(&made.begin, size + 1, sizeof *made.begin, what, error);
  THRUM_THEN(status, thrum_reserve(&made.row, entries + 1, sizeof *made.row, what, error));
  THRUM_THEN(status, thrum_reserve(&made.value, entries + 1, sizeof *made.value, what, error));
  if (status >= 0)
    *matrix = made;
  else
    thrum_sparse_free(&made);
  return status;
}

void thrum_sparse_free(thrum_sparse *matrix) {
  free(matrix->begin);
  free(matrix->row);
  free(matrix->value);
  *matrix = (thrum_sparse){0};
}

// one column; every entry below the diagonal, which comes first, stands for its mirror image too
static void multiply_one(const thrum_sparse *matrix, const double *x, double *product) {
  for (int64_t j = 0; j < matrix->size; j++) {
    const int64_t first = matrix->begin[j], end = matrix->begin[j + 1];
    double sum = matrix->value[first] * x[j];
    for (int64_t e = first + 1; e < end; e++) {
      const int64_t i = matrix->row[e];
      sum += matrix->value[e] * x[i];
      product[i] += matrix->value[e] * x[j];
    }
    product[j] += sum;
  }
}

// the same for columns that lie side by side, in the same order of operations
static void multiply_plain(const thrum_sparse *matrix, const double (*x)[PRODUCT_COLUMNS],
                           double (*product)[PRODUCT_COLUMNS]) {
  for (int64_t j = 0; j < matrix->size; j++) {
    const int64_t first = matrix->begin[j], end = matrix->begin[j + 1];
    double sum[PRODUCT_COLUMNS], at_j[PRODUCT_COLUMNS];
    for (int c = 0; c < PRODUCT_COLUMNS; c++) {
      at_j[c] = x[j][c];
      sum[c] = matrix->value[first] * at_j[c];
    }
    for (int64_t e = first + 1; e < end; e++) {
      const double value = matrix->value[e];
      const double *in = x[matrix->row[e]];
      double *out = product[matrix->row[e]];
      for (int c = 0; c < PRODUCT_COLUMNS; c++) {
        sum[c] += value * in[c];
        out[c] += value * at_j[c];
      }
    }
    for (int c = 0; c < PRODUCT_COLUMNS; c++)
      product[j][c] += sum[c];
  }
}

// the same operations, and so the same bits, with all columns in one register
#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>

__attribute__((target("avx512f"))) static void multiply_avx512(const thrum_sparse *matrix,
                                                               const double (*x)[PRODUCT_COLUMNS],
                                                               double (*product)[PRODUCT_COLUMNS]) {
  for (int64_t j = 0; j < matrix->size; j++) {
    const int64_t first = matrix->begin[j], end = matrix->begin[j + 1];
    const __m512d at_j = _mm512_loadu_pd(x[j]);
    __m512d sum = _mm512_mul_pd(_mm512_set1_pd(matrix->value[first]), at_j);
    for (int64_t e = first + 1; e < end; e++) {
      const __m512d value = _mm512_set1_pd(matrix->value[e]);
      double *out = product[matrix->row[e]];
      sum = _mm512_add_pd(sum, _mm512_mul_pd(value, _mm512_loadu_pd(x[matrix->row[e]])));
      _mm512_storeu_pd(out, _mm512_add_pd(_mm512_loadu_pd(out), _mm512_mul_pd(value, at_j)));
    }
    _mm512_storeu_pd(product[j], _mm512_add_pd(_mm512_loadu_pd(product[j]), sum));
  }
}

static void multiply_packed(const thrum_sparse *matrix, const double (*x)[PRODUCT_COLUMNS],
                            double (*product)[PRODUCT_COLUMNS]) {
  (__builtin_cpu_supports("avx512f") ? multiply_avx512 : multiply_plain)(matrix, x, product);
}
#else
static void multiply_packed(const thrum_sparse *matrix, const double (*x)[PRODUCT_COLUMNS],
                            double (*product)[PRODUCT_COLUMNS]) {
  multiply_plain(matrix, x, product);
}
#endif

// up to PRODUCT_COLUMNS columns, which read the matrix together; work: THRUM_PRODUCT_WORK a row
static void multiply_together(const thrum_sparse *matrix, const double *x, int64_t columns,
                              double *product, double *work) {
  const int64_t n = matrix->size;
  double(*in)[PRODUCT_COLUMNS] = (double(*)[PRODUCT_COLUMNS])work;
  double(*out)[PRODUCT_COLUMNS] = in + n;

  // columns that are not there are zero
  memset(in, 0, columns < PRODUCT_COLUMNS ? sizeof *in * (size_t)n : 0);
  for (int64_t i = 0; i < n; i++)
    for (int64_t c = 0; c < columns; c++)
      in[i][c] = x[c * n + i];
  memset(out, 0, sizeof *out * (size_t)n);
  multiply_packed(matrix, (const double(*)[PRODUCT_COLUMNS])in, out);
  for (int64_t i = 0; i < n; i++)
    for (int64_t c = 0; c < columns; c++)
      product[c * n + i] = out[i][c];
}

void thrum_sparse_product_in(const thrum_sparse *matrix, const double *x, int64_t columns,
                             double *product, double *work) {
  const int64_t n = matrix->size;

  // from three columns on it pays to copy them
  int64_t c = 0;
  while (columns - c >= 3 && work != NULL) {
    const int64_t width = columns - c < PRODUCT_COLUMNS ? columns - c : PRODUCT_COLUMNS;
    multiply_together(matrix, x + c * n, width, product + c * n, work);
    c += width;
  }

  memset(product + c * n, 0, sizeof *product * (size_t)(n * (columns - c)));
  for (; c < columns; c++)
    multiply_one(matrix, x + c * n, product + c * n);
}

void thrum_sparse_product(const thrum_sparse *matrix, const double *x, int64_t columns,
                          double *product) {
  // without memory column by column, with the same bits
  double *work = NULL;
  if (columns >= 3)
    (void)thrum_reserve(&work, matrix->size * THRUM_PRODUCT_WORK, sizeof *work, "", NULL);
  thrum_sparse_product_in(matrix, x, columns, product, work);
  free(work);
}

double thrum_sparse_norm(const thrum_sparse *matrix, double *work) {
  const int64_t n = matrix->size;
  memset(work, 0, sizeof *work * (size_t)n);
  for (int64_t j = 0; j < n; j++)
    for (int64_t e = matrix->begin[j]; e < matrix->begin[j + 1]; e++) {
      const double size = matrix->value[e] < 0 ? -matrix->value[e] : matrix->value[e];
      work[j] += size;
      if (matrix->row[e] != j)
        work[matrix->row[e]] += size;
    }
  double norm = 0;
  for (int64_t j = 0; j < n; j++)
    norm = work[j] > norm ? work[j] : norm;
  thrum_ranks_largest(matrix->ranks, &norm, 1);
  return norm;
}
