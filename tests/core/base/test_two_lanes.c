/* Tests of sums in 4 lanes: their order is the one that is written down, whatever the processor
 * has, so that bits are the same on every machine.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "core/base/two_lanes.h"

enum { MOST = 23 };

/* A number in [-1, 1), the same in every run. */
static double next(void) {
  static uint64_t state = 42;
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) / 4503599627370496.0 - 1;
}

/* Numbers of very different sizes: another order of a sum has other bits. */
static void fill(double *x, int count) {
  for (int n = 0; n < count; n++)
    x[n] = ldexp(next(), (int)(20.0 * next()));
}

/* The order that the header promises. */
static double in_lanes(int n, const double *a, const double *b) {
  double lane[4] = {0.0, 0.0, 0.0, 0.0}, rest = 0.0;
  const int whole = n - n % 4;
  for (int i = 0; i < whole; i++)
    lane[i % 4] += a[i] * b[i];
  for (int i = whole; i < n; i++)
    rest += a[i] * b[i];
  return ((lane[0] + lane[2]) + (lane[1] + lane[3])) + rest;
}

static void rows_are_summed_in_four_lanes(void **context) {
  (void)context;
  double rows[3 * MOST], x[MOST], y[MOST], u[3], v[3], w[3];
  for (int n = 0; n <= MOST; n++) {
    fill(rows, 3 * n);
    fill(x, n);
    fill(y, n);
    thrum_rows_times(n, rows, x, u);
    thrum_rows_times_both(n, rows, y, x, w, v);
    for (int axis = 0; axis < 3; axis++) {
      assert_true(u[axis] == in_lanes(n, rows + axis * n, x));
      assert_true(v[axis] == u[axis]);
      assert_true(w[axis] == in_lanes(n, rows + axis * n, y));
    }
  }
}

static void a_push_is_that_of_each_coordinate(void **context) {
  (void)context;
  double rows[3 * MOST], f[3], w[MOST], x[MOST], pushed[MOST], loaded[MOST];
  for (int n = 0; n <= MOST; n++) {
    fill(rows, 3 * n);
    fill(f, 3);
    fill(w, n);
    fill(x, n);
    memcpy(pushed, x, sizeof x);
    memcpy(loaded, x, sizeof x);

    // each coordinate by itself, to the bit
    thrum_rows_push(n, rows, f, w, pushed);
    thrum_rows_push(n, rows, f, NULL, loaded);
    for (int i = 0; i < n; i++) {
      const double sum = rows[i] * f[0] + rows[n + i] * f[1] + rows[2 * n + i] * f[2];
      assert_true(pushed[i] == x[i] + w[i] * sum);
      assert_true(loaded[i] == x[i] + sum);
    }
  }
}

static void a_square_is_symmetric_and_that_of_its_rows(void **context) {
  (void)context;
  double rows[3 * MOST], w[MOST], square[9];
  for (int n = 0; n <= MOST; n++) {
    fill(rows, 3 * n);
    for (int i = 0; i < n; i++)
      w[i] = fabs(next());
    thrum_rows_square(n, rows, w, square);

    // by plain sums, to the rounding of their terms
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) {
        double sum = 0.0, size = 0.0;
        for (int i = 0; i < n; i++) {
          const double term = w[i] * rows[a * n + i] * rows[b * n + i];
          sum += term;
          size += fabs(term);
        }
        assert_true(fabs(square[3 * a + b] - sum) <= 1e-14 * size);
        assert_true(square[3 * a + b] == square[3 * b + a]);
      }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rows_are_summed_in_four_lanes),
      cmocka_unit_test(a_push_is_that_of_each_coordinate),
      cmocka_unit_test(a_square_is_symmetric_and_that_of_its_rows),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
