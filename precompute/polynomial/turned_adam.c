/* Descent by noisy slopes, see turned_adam.h.
 *
 * Every tenth step adds its slope to the mean products, and the eigenvectors follow by one step of
 * orthogonal iteration. The mean of slopes turns with them; the mean of squares belongs to the
 * eigenvectors, which change slowly, and stays.
 *
 * Cost: two products of rows x columns^2 a step, and two more and 4 columns^3 every tenth.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/polynomial/turned_adam.h"

#include <cblas.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "precompute/fem/lapack_status.h"

#define MEAN_DECAY 0.95    /* of the mean of slopes, */
#define SQUARE_DECAY 0.95  /* of that of their squares, */
#define PRODUCT_DECAY 0.95 /* and of that of their products */
#define TURN_STEPS 10      /* from one product to the next */

#define ROWS THRUM_GROUP_ROWS

thrum_turned_adam thrum_turned_adam_begin(int64_t groups, int64_t columns, float rate,
                                          thrum_scope *memory) {
  thrum_turned_adam adam = {
      .groups = groups, .columns = columns, .rate = rate, .kept_mean = 1, .kept_square = 1};
#define NEED(count) thrum_scope_allocate(memory, (count), sizeof(float))
  adam.mean = NEED(ROWS * groups * columns);
  adam.square = NEED(ROWS * groups * columns);
  adam.turned = NEED(ROWS * groups * columns);
  adam.product = NEED(columns * columns);
  adam.turn = NEED(columns * columns);
  adam.next = NEED(columns * columns);
  adam.change = NEED(columns * columns);
  adam.factors = NEED(columns);
  adam.group_product = NEED(ROWS * ROWS * groups);
  adam.group_turn = NEED(ROWS * ROWS * groups);
  adam.rows = NEED(ROWS * columns);
#undef NEED
  if (memory->status < 0)
    return adam;

  // no turn yet
  for (int64_t i = 0; i < columns; i++)
    adam.turn[i * columns + i] = 1;
  for (int64_t p = 0; p < groups; p++)
    for (int k = 0; k < ROWS; k++)
      adam.group_turn[ROWS * ROWS * p + (ROWS + 1) * k] = 1;
  return adam;
}

/* to (rows x columns) = weight to + scale a b, of a square matrix b or its transpose. */
static void multiply(const thrum_turned_adam *adam, int64_t rows, float scale, const float *a,
                     CBLAS_TRANSPOSE transposed, const float *b, float weight, float *to) {
  const int n = (int)adam->columns;
  cblas_sgemm(CblasRowMajor, CblasNoTrans, transposed, (int)rows, n, n, scale, a, n, b, n, weight,
              to, n);
}

/* The eigenvectors of the columns follow the mean product, and the mean of slopes follows them. */
static thrum_status turn_columns(thrum_turned_adam *adam, thrum_error *error) {
  const int n = (int)adam->columns;
  const int64_t rows = ROWS * adam->groups;

  // orthogonal columns of the mean product times the eigenvectors before
  multiply(adam, n, 1, adam->product, CblasNoTrans, adam->turn, 0, adam->next);
  static const char text[] = "the slopes of the cubature points have no eigenvectors";
  const lapack_int factored = LAPACKE_sgeqrf(LAPACK_ROW_MAJOR, n, n, adam->next, n, adam->factors);
  THRUM_TRY(thrum_lapack_status(factored, THRUM_NOT_CONVERGED, text, error));
  const lapack_int formed = LAPACKE_sorgqr(LAPACK_ROW_MAJOR, n, n, n, adam->next, n, adam->factors);
  THRUM_TRY(thrum_lapack_status(formed, THRUM_NOT_CONVERGED, text, error));

  // the mean of slopes in them
  cblas_sgemm(CblasRowMajor, CblasTrans, CblasNoTrans, n, n, n, 1, adam->turn, n, adam->next, n, 0,
              adam->change, n);
  multiply(adam, rows, 1, adam->mean, CblasNoTrans, adam->change, 0, adam->turned);
  memcpy(adam->mean, adam->turned, (size_t)(rows * n) * sizeof(float));
  memcpy(adam->turn, adam->next, (size_t)n * (size_t)n * sizeof(float));
  return THRUM_OK;
}

/* Rows k of group p, each of them the sum over l of m_lk (of the transpose: m_kl) times row l. */
static void multiply_group(const thrum_turned_adam *adam, int64_t p, const float *m,
                           bool transposed, float *x) {
  const int64_t n = adam->columns, stride = adam->groups * n;
  memset(adam->rows, 0, (size_t)(ROWS * n) * sizeof(float));
  for (int k = 0; k < ROWS; k++)
    for (int l = 0; l < ROWS; l++) {
      const float factor = transposed ? m[ROWS * k + l] : m[ROWS * l + k];
      const float *from = x + l * stride + p * n;
      float *restrict to = adam->rows + k * n;
      for (int64_t i = 0; i < n; i++)
        to[i] += factor * from[i];
    }
  for (int k = 0; k < ROWS; k++)
    memcpy(x + k * stride + p * n, adam->rows + k * n, (size_t)n * sizeof(float));
}

/* All groups in their eigenvectors, or back. */
static void multiply_groups(const thrum_turned_adam *adam, bool back, float *x) {
  for (int64_t p = 0; p < adam->groups; p++)
    multiply_group(adam, p, adam->group_turn + ROWS * ROWS * p, back, x);
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

/* Makes the columns of q orthonormal, each by those before it, twice against rounding. Where one
 * depends on those before it q becomes `before`, and false is returned. */
static bool orthonormal(float *q, const float *before) {
  for (int k = 0; k < ROWS; k++) {
    for (int turn = 0; turn < 2; turn++) {
      for (int l = 0; l < k; l++) {
        float along = 0;
        for (int j = 0; j < ROWS; j++)
          along += q[ROWS * j + l] * q[ROWS * j + k];
        for (int j = 0; j < ROWS; j++)
          q[ROWS * j + k] -= along * q[ROWS * j + l];
      }
      float square = 0;
      for (int j = 0; j < ROWS; j++)
        square += q[ROWS * j + k] * q[ROWS * j + k];
      const float length = sqrtf(square);
      if (!(length > 0)) {
        memcpy(q, before, ROWS * ROWS * sizeof *q);
        return false;
      }
      for (int j = 0; j < ROWS; j++)
        q[ROWS * j + k] /= length;
    }
  }
  return true;
}

/* The same of the rows of a group. */
static void turn_group(thrum_turned_adam *adam, int64_t p) {
  float *of = adam->group_turn + ROWS * ROWS * p, next[ROWS * ROWS], change[ROWS * ROWS];
  small_product(adam->group_product + ROWS * ROWS * p, false, of, next);
  if (!orthonormal(next, of))
    return;
  small_product(of, true, next, change);
  multiply_group(adam, p, change, false, adam->mean);
  memcpy(of, next, sizeof next);
}

/* The products of this slope join the means, and the eigenvectors follow. */
static thrum_status turn(thrum_turned_adam *adam, const float *slope, thrum_error *error) {
  const int n = (int)adam->columns, groups = (int)adam->groups, rows = ROWS * groups;
  const float keep = (float)PRODUCT_DECAY;
  cblas_sgemm(CblasRowMajor, CblasTrans, CblasNoTrans, n, n, rows, 1 - keep, slope, n, slope, n,
              keep, adam->product, n);
  for (int p = 0; p < groups; p++)
    cblas_sgemm(CblasRowMajor, CblasNoTrans, CblasTrans, ROWS, ROWS, n, 1 - keep, slope + p * n,
                groups * n, slope + p * n, groups * n, keep, adam->group_product + ROWS * ROWS * p,
                ROWS);
  THRUM_TRY(turn_columns(adam, error));
  for (int p = 0; p < groups; p++)
    turn_group(adam, p);
  return THRUM_OK;
}

thrum_status thrum_turned_adam_step(thrum_turned_adam *adam, const float *slope, double share,
                                    float *x, thrum_error *error) {
  if (adam->done % TURN_STEPS == 0)
    THRUM_TRY(turn(adam, slope, error));
  adam->done++;

  // means begin at zero, which is made up for
  adam->kept_mean *= MEAN_DECAY;
  adam->kept_square *= SQUARE_DECAY;
  const float rate = (float)(adam->rate * share / (1 - adam->kept_mean));
  const float whole = (float)(1 / (1 - adam->kept_square)), least = adam->least;
  const float new_mean = (float)(1 - MEAN_DECAY), new_square = (float)(1 - SQUARE_DECAY);

  // a step of Adam in the eigenvectors
  const int64_t rows = ROWS * adam->groups;
  multiply(adam, rows, 1, slope, CblasNoTrans, adam->turn, 0, adam->turned);
  multiply_groups(adam, false, adam->turned);
  float *restrict mean = adam->mean, *restrict square = adam->square, *restrict at = adam->turned;
  for (int64_t i = 0; i < rows * adam->columns; i++) {
    mean[i] += new_mean * (at[i] - mean[i]);
    square[i] += new_square * (at[i] * at[i] - square[i]);
    at[i] = mean[i] / (sqrtf(square[i] * whole) + least);
  }
  multiply_groups(adam, true, adam->turned);
  multiply(adam, rows, -rate, adam->turned, CblasTrans, adam->turn, 1, x);
  return THRUM_OK;
}
