/* Tests of what the Newton methods of contact have in common: sums have the bits of plain C
 * whatever the processor has, a step solves its system, and a search ends near the minimum.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "contact/contact_newton.h"
#include "tests/support/random_model.h"

enum { MOST = 56 };

/* A system of m unknowns, to which rows are added. */
typedef struct system_of_rows {
  int64_t m, stride;
  double ways[3 * MOST], pushed[3 * MOST];
  double matrix[MOST * MOST], plain[MOST * MOST];
} system_of_rows;

static system_of_rows begin(int64_t m) {
  system_of_rows s = {.m = m, .stride = THRUM_NEWTON_STRIDE(m)};
  for (int64_t p = 0; p < m; p++)
    s.matrix[p * s.stride + p] = s.plain[p * s.stride + p] = 1.0;
  return s;
}

/* Adds a row of a random symmetric change to both sums, that of plain C one element after the
 * other. */
static void add(system_of_rows *s, random_state *random) {
  double change[9], pushed[3][MOST];

  // the row and its change at random
  for (int axis = 0; axis < 3; axis++)
    for (int64_t q = 0; q < s->m; q++)
      s->ways[axis * s->stride + q] = random_uniform(random);
  for (int a = 0; a < 3; a++)
    for (int b = a; b < 3; b++)
      change[3 * a + b] = change[3 * b + a] = random_uniform(random) + (a == b ? 3.0 : 0.0);
  const thrum_newton_columns at = {.count = {s->stride, 0}};
  thrum_newton_add(&at, s->ways, change, s->pushed, s->stride, s->matrix);

  // in plain C
  const double *b0 = s->ways, *b1 = b0 + s->stride, *b2 = b1 + s->stride;
  for (int a = 0; a < 3; a++)
    for (int64_t q = 0; q < s->m; q++)
      pushed[a][q] =
          0.0 + (change[3 * a] * b0[q] + change[3 * a + 1] * b1[q] + change[3 * a + 2] * b2[q]);
  for (int64_t p = 0; p < s->m; p++)
    for (int64_t q = p; q < s->m; q++)
      s->plain[p * s->stride + q] +=
          pushed[0][p] * b0[q] + pushed[1][p] * b1[q] + pushed[2][p] * b2[q];
}

static void sums_have_the_bits_of_plain_c(void **context) {
  (void)context;
  random_state random = {3};
  for (int64_t m = 1; m <= MOST; m++) {
    system_of_rows s = begin(m);
    for (int n = 0; n < 5; n++)
      add(&s, &random);
    for (int64_t p = 0; p < m; p++)
      assert_memory_equal(s.matrix + p * s.stride + p, s.plain + p * s.stride + p,
                          (size_t)(m - p) * sizeof(double));
  }
}

static void a_step_solves_its_system(void **context) {
  (void)context;
  random_state random = {5};
  double gradient[MOST], step[MOST];
  for (int64_t m = 1; m <= MOST; m++) {
    system_of_rows s = begin(m);
    for (int n = 0; n < 9; n++)
      add(&s, &random);
    for (int64_t q = 0; q < m; q++)
      gradient[q] = random_uniform(&random);
    assert_true(thrum_newton_step(m, s.matrix, gradient, step));

    // what is left of it, by the sum that was not overwritten
    for (int64_t p = 0; p < m; p++) {
      double left = gradient[p], size = fabs(gradient[p]);
      for (int64_t q = 0; q < m; q++) {
        const double element = p <= q ? s.plain[p * s.stride + q] : s.plain[q * s.stride + p];
        left += element * step[q];
        size += fabs(element * step[q]);
      }
      assert_true(fabs(left) <= 1e-12 * size);
    }
  }
}

static void what_has_no_factor_is_refused(void **context) {
  (void)context;
  const double gradient[2] = {1.0, 1.0}, none[2] = {NAN, 1.0};
  double step[2];
  const double wrong[4][2] = {{0.0, 1.0}, {-1.0, 1.0}, {NAN, 1.0}, {1.0, INFINITY}};
  for (int n = 0; n < 4; n++) {
    double matrix[8] = {wrong[n][0], 0, 0, 0, 0, wrong[n][1]};
    assert_false(thrum_newton_step(2, matrix, gradient, step));
  }
  double matrix[8] = {1, 0, 0, 0, 0, 1};
  assert_false(thrum_newton_step(2, matrix, none, step));
}

/* The slope of (share - at)^2 / 2, which turns steeper beyond its minimum. */
static double slope_at(const void *at, double share) {
  const double off = share - *(const double *)at;
  return off > 0.0 ? 40.0 * off : off;
}

static void a_search_ends_near_the_minimum(void **context) {
  (void)context;
  for (double at = 0.05; at < 1.5; at += 0.05) {
    const double share = thrum_newton_search(slope_at, &at, slope_at(&at, 0.0));
    assert_true(share > 0.0 && share <= 1.0);
    if (at >= 1.0)
      assert_true(share == 1.0);
    else
      assert_true(fabs(slope_at(&at, share)) <= 0.3 * at * (1 + 1e-12));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(sums_have_the_bits_of_plain_c),
      cmocka_unit_test(a_step_solves_its_system),
      cmocka_unit_test(what_has_no_factor_is_refused),
      cmocka_unit_test(a_search_ends_near_the_minimum),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
