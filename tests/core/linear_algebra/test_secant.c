/* Tests of how BFGS learns an inverse Jacobian in a solve, and of the sums over modes.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "core/base/lane_sums.h"
#include "core/linear_algebra/secant.h"

enum { N = 12, MOST = 100 };

/* Makes a symmetric matrix, with `definite` added to its diagonal. */
static void make_matrix(random_state *random, double definite, double *matrix) {
  random_vector(random, N * N, 1, matrix);
  for (int i = 0; i < N; i++) {
    matrix[N * i + i] += definite;
    for (int j = 0; j < i; j++)
      matrix[N * j + i] = matrix[N * i + j];
  }
}

static void multiply(const double *matrix, const double *x, double *y) {
  for (int i = 0; i < N; i++) {
    y[i] = 0;
    for (int j = 0; j < N; j++)
      y[i] += matrix[N * i + j] * x[j];
  }
}

/* Makes one iteration of quasi-Newton on matrix x = b, from x with its residual and direction. */
static void iterate(const double *matrix, const double *b, thrum_secant *h, double *x,
                    double *residual, double *direction) {
  double step[N], change[N], image[N], next[N];
  for (int i = 0; i < N; i++) {
    step[i] = -direction[i];
    x[i] += step[i];
  }

  // the change of the residual over the step is what is learnt
  multiply(matrix, x, next);
  for (int i = 0; i < N; i++) {
    next[i] -= b[i];
    change[i] = next[i] - residual[i];
  }

  thrum_secant_apply(h, next, image);
  thrum_secant_learn(h, step, change, next, image);

  memcpy(residual, next, sizeof next);
  memcpy(direction, image, sizeof image);

  // H y = s, and what learning brought up to date is H of the residual
  double learnt[N];
  thrum_secant_apply(h, change, learnt);
  assert_true(largest_difference(learnt, step, N) < 1e-12);
  thrum_secant_apply(h, residual, learnt);
  assert_true(largest_difference(learnt, image, N) < 1e-12);
}

static void what_is_learnt_maps_each_change_to_its_step_and_can_be_folded(void **context) {
  (void)context;
  const thrum_kernel *by = &thrum_kernel_reference;
  random_state random = {4};
  double matrix[N * N], base[N * N] = {0}, pairs[2 * THRUM_SECANT_PAIRS * N] = {0};
  double b[N], x[N] = {0}, residual[N], direction[N], before[N], after[N];

  // a positive definite system, and a rough inverse to begin with
  make_matrix(&random, N, matrix);
  random_vector(&random, N, 1, b);
  for (int i = 0; i < N; i++) {
    base[N * i + i] = 0.8 / N;
    residual[i] = -b[i];
  }

  // as many iterations as there are pairs to keep
  thrum_secant h = {by, base, pairs, N, N, 0};
  thrum_secant_apply(&h, residual, direction);
  for (int k = 0; k < THRUM_SECANT_PAIRS; k++)
    iterate(matrix, b, &h, x, residual, direction);
  assert_int_equal(h.count, THRUM_SECANT_PAIRS);

  // folded into the base, the pairs still act as before
  thrum_secant_apply(&h, b, before);
  thrum_secant_fold(by, pairs, N, N, h.count, base);
  h.count = 0;
  thrum_secant_apply(&h, b, after);
  assert_true(largest_difference(before, after, N) < 1e-13);

  // and the base stays symmetric
  for (int i = 0; i < N; i++)
    for (int j = 0; j < i; j++)
      assert_true(base[N * i + j] == base[N * j + i]);
}

static void a_step_without_positive_curvature_teaches_nothing(void **context) {
  (void)context;
  double base[4] = {1, 0, 0, 1}, pairs[2 * THRUM_SECANT_PAIRS * 2] = {0};
  thrum_secant h = {&thrum_kernel_reference, base, pairs, 2, 2, 0};
  const double step[2] = {1, 0}, against[2] = {-1, 3}, none[2] = {0, 1}, bad[2] = {NAN, 0};
  const double *changes[3] = {against, none, bad};

  // the curvature along the step is negative, zero, or no number
  for (int k = 0; k < 3; k++) {
    double image[2] = {5, 6};
    thrum_secant_learn(&h, step, changes[k], step, image);
    assert_int_equal(h.count, 0);
    assert_true(image[0] == 5 && image[1] == 6);
  }

  for (int i = 0; i < 2 * THRUM_SECANT_PAIRS * 2; i++)
    assert_true(pairs[i] == 0);
}

/* The sums run in a fixed order, which no compiler changes. */
static void sums_over_the_modes_run_in_eight_lanes(void **context) {
  (void)context;
  double a[MOST], b[MOST], w[MOST];
  random_state random = {7};
  random_vector(&random, MOST, 1, a);
  random_vector(&random, MOST, 1, b);
  random_vector(&random, MOST, 1, w);

  // every count, so that the last lanes are filled to every degree
  for (int n = 0; n <= MOST; n++) {
    volatile double lane[4][8] = {{0}};

    for (int i = 0; i < n; i++) {
      lane[0][i % 8] += a[i] * b[i];
      lane[1][i % 8] += a[i] * b[i] * w[i];
      lane[2][i % 8] += (a[i] + b[i]) * w[i];
      lane[3][i % 8] += (a[i] - b[i]) * w[i];
    }

    // the lanes are added in a fixed order, so the bits are the same
    const double sums[4] = {thrum_sum_of(n, a, b, NULL), thrum_sum_of(n, a, b, w),
                            thrum_sum_both(n, a, b, w), thrum_sum_less(n, a, b, w)};
    for (int k = 0; k < 4; k++) {
      const double even = (lane[k][0] + lane[k][4]) + (lane[k][2] + lane[k][6]);
      const double odd = (lane[k][1] + lane[k][5]) + (lane[k][3] + lane[k][7]);
      assert_true(sums[k] == even + odd);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_is_learnt_maps_each_change_to_its_step_and_can_be_folded),
      cmocka_unit_test(sums_over_the_modes_run_in_eight_lanes),
      cmocka_unit_test(a_step_without_positive_curvature_teaches_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
