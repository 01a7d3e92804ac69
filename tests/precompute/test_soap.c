/* Tests of the descent SOAP: its first step moves each number in the eigenvectors by the rate, its
 * eigenvectors stay orthonormal whatever the slopes are and become those of their products, and it
 * finds the minimum of a function whose numbers depend on each other.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "precompute/polynomial/soap.h"

enum { GROUPS = 3, COLUMNS = 10, ROWS = THRUM_GROUP_ROWS * GROUPS, NUMBERS = ROWS * COLUMNS };

/* A descent from a random place, in memory of its own. */
typedef struct descent {
  thrum_scope memory;
  thrum_soap soap;
  float x[NUMBERS], slope[NUMBERS];
} descent;

static descent *begin(float rate) {
  descent *made = need(1, sizeof *made);
  made->memory = thrum_scope_begin("the test", NULL);
  made->soap = thrum_soap_begin(GROUPS, COLUMNS, rate, &made->memory);
  assert_int_equal(made->memory.status, THRUM_OK);
  made->soap.least = 1e-12f;
  for (int n = 0; n < NUMBERS; n++) {
    made->x[n] = (float)random_number();
    made->slope[n] = (float)random_number();
  }
  return made;
}

static void step(descent *d, double share) {
  thrum_error error;
  assert_int_equal(thrum_soap_step(&d->soap, d->slope, share, d->x, &error), THRUM_OK);
}

static void end(descent *d) {
  thrum_scope_free(&d->memory);
  free(d);
}

/* Adam's first step is the sign of each number. Eigenvectors do not change its length. Columns are
 * more than rows of a group, so that no number is rounding alone. */
static void a_first_step_moves_each_number_by_the_rate(void **state) {
  (void)state;
  const double rate = 0.01;
  descent *d = begin((float)rate);
  float before[NUMBERS];
  memcpy(before, d->x, sizeof before);
  step(d, 0.5);
  double square = 0, along = 0;
  for (int n = 0; n < NUMBERS; n++) {
    square += pow(d->x[n] - before[n], 2);
    along += (d->x[n] - before[n]) * d->slope[n];
  }
  assert_true(fabs(sqrt(square) / (0.5 * rate * sqrt(NUMBERS)) - 1) < 1e-4);
  assert_true(along < 0);
  end(d);
}

/* How far n x n vectors, which are columns, are from orthonormal ones. */
static double off_orthonormal(const float *vectors, int n) {
  double most = 0;
  for (int a = 0; a < n; a++)
    for (int b = 0; b < n; b++) {
      double sum = 0;
      for (int k = 0; k < n; k++)
        sum += (double)vectors[k * n + a] * vectors[k * n + b];
      most = fmax(most, fabs(sum - (a == b)));
    }
  return most;
}

static void eigenvectors_stay_orthonormal(void **state) {
  (void)state;
  descent *d = begin(0.01f);

  // slopes of every size, without one column, without one group, and none at all
  for (int n = 0; n < 300; n++) {
    for (int i = 0; i < NUMBERS; i++) {
      const bool none = i % COLUMNS == 2 || i / COLUMNS % GROUPS == 1 || n % 100 > 50;
      d->slope[i] = none ? 0 : (float)(random_number() * pow(10, 4 * random_number()));
    }
    step(d, 1);
  }
  assert_true(off_orthonormal(d->soap.vectors, COLUMNS) < 1e-5);
  for (int p = 0; p < GROUPS; p++)
    assert_true(off_orthonormal(d->soap.group_vectors + p * THRUM_GROUP_ROWS * THRUM_GROUP_ROWS,
                                THRUM_GROUP_ROWS) < 1e-5);
  for (int i = 0; i < NUMBERS; i++)
    assert_true(isfinite(d->x[i]));
  end(d);
}

/* The slope in the eigenvectors: component (k, i) of group p. */
static double projected(const descent *d, int p, int k, int i) {
  const float *of_rows = d->soap.group_vectors + p * THRUM_GROUP_ROWS * THRUM_GROUP_ROWS;
  double sum = 0;
  for (int l = 0; l < THRUM_GROUP_ROWS; l++)
    for (int j = 0; j < COLUMNS; j++)
      sum += (double)of_rows[l * THRUM_GROUP_ROWS + k] * d->slope[(l * GROUPS + p) * COLUMNS + j] *
             d->soap.vectors[j * COLUMNS + i];
  return sum;
}

/* One slope again and again: the mean of slopes is a share of it in any eigenvectors, while these
 * become those of its products. */
static void means_follow_the_eigenvectors_and_these_the_products(void **state) {
  (void)state;
  descent *d = begin(0.01f);
  for (int n = 0; n < NUMBERS; n++)
    d->slope[n] *= (float)pow(0.7, n % COLUMNS); // so that eigenvalues lie apart
  for (int n = 0; n < 31; n++)
    step(d, 1);
  for (int n = 0; n < NUMBERS; n++) {
    const double wanted = projected(d, n / COLUMNS % GROUPS, n / COLUMNS / GROUPS, n % COLUMNS);
    assert_true(fabs(d->soap.mean[n] / (1 - d->soap.kept_mean) - wanted) < 1e-5);
  }

  // in them the columns are orthogonal
  for (int n = 0; n < 10000; n++)
    step(d, 0);
  double products[COLUMNS][COLUMNS] = {{0}};
  for (int n = 0; n < ROWS; n++)
    for (int a = 0; a < COLUMNS; a++)
      for (int b = 0; b < COLUMNS; b++)
        products[a][b] +=
            projected(d, n % GROUPS, n / GROUPS, a) * projected(d, n % GROUPS, n / GROUPS, b);
  for (int a = 0; a < COLUMNS; a++)
    for (int b = 0; b < a; b++)
      assert_true(fabs(products[a][b]) < 1e-3 * sqrt(products[a][a] * products[b][b]));
  end(d);
}

/* Half the product of x - at with its slope L (x - at) R, of which L mixes the rows of each group
 * and R the columns. */
static double mixed_square(descent *d, const float *at,
                           double left[THRUM_GROUP_ROWS][THRUM_GROUP_ROWS],
                           double right[COLUMNS][COLUMNS]) {
  double off[NUMBERS], sum = 0;
  for (int n = 0; n < NUMBERS; n++)
    off[n] = d->x[n] - at[n];
  for (int n = 0; n < NUMBERS; n++) {
    const int k = n / COLUMNS / GROUPS, p = n / COLUMNS % GROUPS, i = n % COLUMNS;
    double slope = 0;
    for (int l = 0; l < THRUM_GROUP_ROWS; l++)
      for (int j = 0; j < COLUMNS; j++)
        slope += left[k][l] * off[(l * GROUPS + p) * COLUMNS + j] * right[j][i];
    d->slope[n] = (float)slope;
    sum += 0.5 * slope * off[n];
  }
  return sum;
}

/* Rotates rows a and b of a matrix by an angle, and its columns. */
static void rotate(int n, double angle, int a, int b, double *matrix) {
  const double c = cos(angle), s = sin(angle);
  for (int side = 0; side < 2; side++)
    for (int k = 0; k < n; k++) {
      double *p = side ? matrix + k * n + a : matrix + a * n + k;
      double *q = side ? matrix + k * n + b : matrix + b * n + k;
      const double was = *p;
      *p = c * was - s * *q;
      *q = s * was + c * *q;
    }
}

/* A matrix with eigenvalues from 1 down to `least` in random eigenvectors. */
static void mix(int n, double least, double *matrix) {
  memset(matrix, 0, (size_t)(n * n) * sizeof *matrix);
  for (int k = 0; k < n; k++)
    matrix[k * n + k] = pow(least, (double)k / (n - 1));
  for (int a = 0; a < n; a++)
    for (int b = a + 1; b < n; b++)
      rotate(n, 3 * random_number(), a, b, matrix);
}

static void it_finds_the_minimum_where_numbers_depend_on_each_other(void **state) {
  (void)state;
  enum { STEPS = 2000 };
  double left[THRUM_GROUP_ROWS][THRUM_GROUP_ROWS], right[COLUMNS][COLUMNS];
  float at[NUMBERS];
  descent *d = begin(0.03f);
  for (int n = 0; n < NUMBERS; n++)
    at[n] = (float)random_number();
  mix(THRUM_GROUP_ROWS, 1e-2, left[0]);
  mix(COLUMNS, 1e-2, right[0]);

  // the rate falls to zero, so that the descent ends
  const double first = mixed_square(d, at, left, right);
  for (int n = 0; n < STEPS; n++) {
    mixed_square(d, at, left, right);
    step(d, 1 - (double)n / STEPS);
  }
  const double last = mixed_square(d, at, left, right);
  print_message("%.3g of the square is left\n", last / first);
  assert_true(last < 1e-8 * first);
  for (int n = 0; n < NUMBERS; n++)
    assert_true(fabs(d->x[n] - at[n]) < 1e-2);
  end(d);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_first_step_moves_each_number_by_the_rate),
      cmocka_unit_test(eigenvectors_stay_orthonormal),
      cmocka_unit_test(means_follow_the_eigenvectors_and_these_the_products),
      cmocka_unit_test(it_finds_the_minimum_where_numbers_depend_on_each_other),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
