/* Descent by noisy slopes, see soap.h.
 *
 * Every tenth step adds its slope to the mean products, and the eigenvectors follow by one step of
 * orthogonal iteration. The mean of slopes is taken into the new ones; the mean of squares belongs
 * to the eigenvectors, which change slowly, and stays.
 *
 * Cost: two products of rows x columns^2 a step, and two more and 4 columns^3 every tenth.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/polynomial/soap.h"

#include <cblas.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "precompute/fem/lapack_status.h"

#define MEAN_DECAY 0.95    /* of the mean of slopes, */
#define SQUARE_DECAY 0.95  /* of that of their squares, */
#define PRODUCT_DECAY 0.95 /* and of that of their products */
#define UPDATE_STEPS 10    /* from one product to the next */

#define ROWS THRUM_GROUP_ROWS

thrum_soap thrum_soap_begin(int64_t groups, int64_t columns, float rate, thrum_scope *memory) {
  thrum_soap soap = {
      .groups = groups, .columns = columns, .rate = rate, .kept_mean = 1, .kept_square = 1};
#define NEED(count) thrum_scope_allocate(memory, (count), sizeof(float))
  soap.mean = NEED(ROWS * groups * columns);
  soap.square = NEED(ROWS * groups * columns);
  soap.projected = NEED(ROWS * groups * columns);
  soap.product = NEED(columns * columns);
  soap.vectors = NEED(columns * columns);
  soap.next = NEED(columns * columns);
  soap.change = NEED(columns * columns);
  soap.factors = NEED(columns);
  soap.group_product = NEED(ROWS * ROWS * groups);
  soap.group_vectors = NEED(ROWS * ROWS * groups);
  soap.rows = NEED(ROWS * columns);
#undef NEED
  if (memory->status < 0)
    return soap;

  // the eigenvectors begin as those of the identity
  for (int64_t i = 0; i < columns; i++)
    soap.vectors[i * columns + i] = 1;
  for (int64_t p = 0; p < groups; p++)
    for (int k = 0; k < ROWS; k++)
      soap.group_vectors[ROWS * ROWS * p + (ROWS + 1) * k] = 1;
  return soap;
}

/* to (rows x columns) = weight to + scale a b, of a square matrix b or its transpose. */
static void multiply(const thrum_soap *soap, int64_t rows, float scale, const float *a,
                     CBLAS_TRANSPOSE transposed, const float *b, float weight, float *to) {
  const int n = (int)soap->columns;
  cblas_sgemm(CblasRowMajor, CblasNoTrans, transposed, (int)rows, n, n, scale, a, n, b, n, weight,
              to, n);
}

/* The eigenvectors of the columns follow the mean product, and the mean of slopes follows them. */
static thrum_status update_columns(thrum_soap *soap, thrum_error *error) {
  const int n = (int)soap->columns;
  const int64_t rows = ROWS * soap->groups;

  // orthogonal columns of the mean product times the eigenvectors before
  multiply(soap, n, 1, soap->product, CblasNoTrans, soap->vectors, 0, soap->next);
  static const char text[] = "the slopes of the cubature points have no eigenvectors";
  const lapack_int factored = LAPACKE_sgeqrf(LAPACK_ROW_MAJOR, n, n, soap->next, n, soap->factors);
  THRUM_TRY(thrum_lapack_status(factored, THRUM_NOT_CONVERGED, text, error));
  const lapack_int formed = LAPACKE_sorgqr(LAPACK_ROW_MAJOR, n, n, n, soap->next, n, soap->factors);
  THRUM_TRY(thrum_lapack_status(formed, THRUM_NOT_CONVERGED, text, error));

  // the mean of slopes in them
  cblas_sgemm(CblasRowMajor, CblasTrans, CblasNoTrans, n, n, n, 1, soap->vectors, n, soap->next, n,
              0, soap->change, n);
  multiply(soap, rows, 1, soap->mean, CblasNoTrans, soap->change, 0, soap->projected);
  memcpy(soap->mean, soap->projected, (size_t)(rows * n) * sizeof(float));
  memcpy(soap->vectors, soap->next, (size_t)n * (size_t)n * sizeof(float));
  return THRUM_OK;
}

/* Rows k of group p, each of them the sum over l of m_lk (of the transpose: m_kl) times row l. */
static void multiply_group(const thrum_soap *soap, int64_t p, const float *m, bool transposed,
                           float *x) {
  const int64_t n = soap->columns, stride = soap->groups * n;
  memset(soap->rows, 0, (size_t)(ROWS * n) * sizeof(float));
  for (int k = 0; k < ROWS; k++)
    for (int l = 0; l < ROWS; l++) {
      const float factor = transposed ? m[ROWS * k + l] : m[ROWS * l + k];
      const float *from = x + l * stride + p * n;
      float *restrict to = soap->rows + k * n;
      for (int64_t i = 0; i < n; i++)
        to[i] += factor * from[i];
    }
  for (int k = 0; k < ROWS; k++)
    memcpy(x + k * stride + p * n, soap->rows + k * n, (size_t)n * sizeof(float));
}

/* All groups in their eigenvectors, or back. */
static void multiply_groups(const thrum_soap *soap, bool back, float *x) {
  for (int64_t p = 0; p < soap->groups; p++)
    multiply_group(soap, p, soap->group_vectors + ROWS * ROWS * p, back, x);
}

/* to = a b, or of the transpose of a. */
static void small_product(const float *a, bool transposed, const float *b, float *to) {
  for (int k = 0; k < ROWS; k++)
    for (int l = 0; l < ROWS; l++) {
      float sum = 0;
      for (int j = 0; j < ROWS; j++)
        sum += (transposed ? a[ROWS * j + k] : a[ROWS * k + j]) * b[ROWS * j + l];
      to[ROWS * k + l] = sum;
    }
}

/* Makes column k of q orthogonal to the columns before it, and of unit length; false where it
 * depends on them. */
static bool orthonormal_column(float *q, int k) {
  for (int l = 0; l < k; l++) {
    float along = 0;
    for (int j = 0; j < ROWS; j++)
      along += q[ROWS * j + l] * q[ROWS * j + k];
    for (int j = 0; j < ROWS; j++)
      q[ROWS * j + k] -= along * q[ROWS * j + l];
  }

  // what is left of it
  float square = 0;
  for (int j = 0; j < ROWS; j++)
    square += q[ROWS * j + k] * q[ROWS * j + k];
  const float length = sqrtf(square);
  for (int j = 0; j < ROWS && length > 0; j++)
    q[ROWS * j + k] /= length;
  return length > 0;
}

/* Makes the columns of q orthonormal, each by those before it, twice against rounding. Where one
 * depends on those before it q becomes `before`, and false is returned. */
static bool orthonormal(float *q, const float *before) {
  for (int n = 0; n < 2 * ROWS; n++)
    if (!orthonormal_column(q, n / 2)) {
      memcpy(q, before, ROWS * ROWS * sizeof *q);
      return false;
    }
  return true;
}

/* The same of the rows of a group. */
static void update_group(thrum_soap *soap, int64_t p) {
  float *of = soap->group_vectors + ROWS * ROWS * p, next[ROWS * ROWS], change[ROWS * ROWS];
  small_product(soap->group_product + ROWS * ROWS * p, false, of, next);
  if (!orthonormal(next, of))
    return;
  small_product(of, true, next, change);
  multiply_group(soap, p, change, false, soap->mean);
  memcpy(of, next, sizeof next);
}

/* The products of this slope join the means, and the eigenvectors follow. */
static thrum_status update(thrum_soap *soap, const float *slope, thrum_error *error) {
  const int n = (int)soap->columns, groups = (int)soap->groups, rows = ROWS * groups;
  const float keep = (float)PRODUCT_DECAY;
  cblas_sgemm(CblasRowMajor, CblasTrans, CblasNoTrans, n, n, rows, 1 - keep, slope, n, slope, n,
              keep, soap->product, n);
  for (int p = 0; p < groups; p++)
    cblas_sgemm(CblasRowMajor, CblasNoTrans, CblasTrans, ROWS, ROWS, n, 1 - keep, slope + p * n,
                groups * n, slope + p * n, groups * n, keep, soap->group_product + ROWS * ROWS * p,
                ROWS);
  THRUM_TRY(update_columns(soap, error));
  for (int p = 0; p < groups; p++)
    update_group(soap, p);
  return THRUM_OK;
}

thrum_status thrum_soap_step(thrum_soap *soap, const float *slope, double share, float *x,
                             thrum_error *error) {
  if (soap->done % UPDATE_STEPS == 0)
    THRUM_TRY(update(soap, slope, error));
  soap->done++;

  // means begin at zero, which is made up for
  soap->kept_mean *= MEAN_DECAY;
  soap->kept_square *= SQUARE_DECAY;
  const float rate = (float)(soap->rate * share / (1 - soap->kept_mean));
  const float whole = (float)(1 / (1 - soap->kept_square)), least = soap->least;
  const float new_mean = (float)(1 - MEAN_DECAY), new_square = (float)(1 - SQUARE_DECAY);

  // a step of Adam in the eigenvectors
  const int64_t rows = ROWS * soap->groups;
  multiply(soap, rows, 1, slope, CblasNoTrans, soap->vectors, 0, soap->projected);
  multiply_groups(soap, false, soap->projected);
  float *restrict mean = soap->mean, *restrict square = soap->square,
                  *restrict at = soap->projected;
  for (int64_t i = 0; i < rows * soap->columns; i++) {
    mean[i] += new_mean * (at[i] - mean[i]);
    square[i] += new_square * (at[i] * at[i] - square[i]);
    at[i] = mean[i] / (sqrtf(square[i] * whole) + least);
  }
  multiply_groups(soap, true, soap->projected);
  multiply(soap, rows, -rate, soap->projected, CblasTrans, soap->vectors, 1, x);
  return THRUM_OK;
}
