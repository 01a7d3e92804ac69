/* The sparse factor in single precision: solutions and modes that it leads to are those of the
 * factor in double precision, of held and of free bodies. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "precompute/basis/eigen.h"
#include "precompute/basis/mode_check.h"
#include "precompute/fem/rigid_modes.h"

typedef struct pair {
  body b;
  thrum_fem fem;
  thrum_sparse stiffness, mass;
  double *rigid, *dual;
  thrum_factor *single, *twice; /* in single and in double precision */
} pair;

static thrum_factor *factor_of(pair *p, bool single) {
  thrum_factor *factor = NULL;
  thrum_support_springs springs;
  if (p->rigid)
    thrum_support_springs_add(&p->fem, &p->stiffness, &springs);

  // single precision takes about half of the memory
  assert_int_equal(thrum_factor_plan(&p->stiffness, &factor, NULL), THRUM_OK);
  const double bytes = thrum_factor_bytes(factor);
  if (single)
    thrum_factor_set_single(factor, &p->stiffness);
  assert_true(thrum_factor_is_single(factor) == single);
  assert_true(single ? thrum_factor_bytes(factor) < 0.7 * bytes
                     : thrum_factor_bytes(factor) == bytes);

  // springs hold a free body while it is factorised
  assert_int_equal(thrum_factor_compute(&p->stiffness, factor, NULL), THRUM_OK);
  if (p->rigid) {
    thrum_support_springs_remove(&springs, &p->stiffness);
    thrum_factor_deflate(factor, THRUM_RIGID_COUNT, p->rigid, p->dual);
  }
  return factor;
}

// stays where it is, as the factors point into it
static pair *pair_make(body b, bool free_body) {
  pair *p = need(1, sizeof *p);
  *p = (pair){.b = b, .fem = body_fem(&b)};
  assert_int_equal(thrum_fem_pattern(&p->fem, &p->stiffness, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&p->fem, NULL, &p->stiffness, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&p->fem, THRUM_MASS_CONSISTENT, &p->stiffness, &p->mass, NULL),
                   THRUM_OK);
  if (free_body) {
    p->rigid = need((size_t)(THRUM_RIGID_COUNT * p->fem.free_count), sizeof *p->rigid);
    p->dual = need((size_t)(THRUM_RIGID_COUNT * p->fem.free_count), sizeof *p->dual);
    assert_int_equal(thrum_rigid_modes(&p->fem, &p->mass, p->rigid, p->dual, NULL), THRUM_OK);
  }
  p->single = factor_of(p, true);
  p->twice = factor_of(p, false);
  return p;
}

static void pair_free(pair *p) {
  thrum_factor_free(p->single);
  thrum_factor_free(p->twice);
  thrum_sparse_free(&p->stiffness);
  thrum_sparse_free(&p->mass);
  thrum_fem_free(&p->fem);
  free(p->rigid);
  free(p->dual);
  body_free(&p->b);
  free(p);
}

// |a - b| / |b| in the norm of the stiffness
static double apart(const pair *p, const double *a, const double *b) {
  const int64_t n = p->fem.free_count;
  double *difference = need((size_t)n, sizeof *difference);
  double *image = need((size_t)n, sizeof *image);
  for (int64_t i = 0; i < n; i++)
    difference[i] = a[i] - b[i];
  thrum_sparse_product(&p->stiffness, difference, 1, image);
  const double error = dot_of(difference, image, n);
  thrum_sparse_product(&p->stiffness, b, 1, image);
  const double size = dot_of(b, image, n);
  free(difference);
  free(image);
  return sqrt(fmax(error, 0) / size);
}

static void check_solutions(pair *p, double most) {
  // more columns than one block, one of them zero, in place
  const int64_t n = p->fem.free_count, columns = 37;
  double *x = need((size_t)(n * columns), sizeof *x), *y = need((size_t)(n * columns), sizeof *y);
  for (int64_t i = 0; i < n * columns; i++)
    x[i] = y[i] = i / n == 5 ? 0 : pow(10, (double)(i / n) - 18) * random_number();
  assert_int_equal(thrum_factor_solve(p->single, x, columns, x, NULL), THRUM_OK);
  assert_int_equal(thrum_factor_solve(p->twice, y, columns, y, NULL), THRUM_OK);

  double worst = 0;
  for (int64_t c = 0; c < columns; c++)
    if (c != 5)
      worst = fmax(worst, apart(p, x + c * n, y + c * n));
  for (int64_t i = 0; i < n; i++)
    assert_true(x[5 * n + i] == 0);
  print_message("%lld components: the solutions differ by %.1e\n", (long long)n, worst);
  assert_true(worst < most);
  assert_true(thrum_factor_solve_flops(p->single) >
              1.5 * thrum_factor_solve_flops(p->twice)); // several passes
  free(x);
  free(y);
  pair_free(p);
}

static void solutions_are_those_of_double_precision(void **state) {
  (void)state;
  check_solutions(pair_make(body_quadratic("beam:8x3x3@1x0.3x0.3", "x<0.001", 0.01, 0.01), false),
                  1e-11);

  // these bodies are so thin that rounding in either precision counts
  check_solutions(pair_make(body_make("beam:200x2x2@10x0.1x0.1,split=6", "x<0.001"), false), 1e-7);
  check_solutions(pair_make(body_quadratic("beam:6x3x2@1x0.3x0.2", NULL, 0, 0), true), 1e-11);
}

/* most: relative distance of two eigenvalues that is allowed */
static void check_modes(pair *p, int64_t count, double most) {
  const int64_t n = p->fem.free_count;
  double *values[2], *vectors[2];
  for (int twice = 0; twice < 2; twice++) {
    int64_t recovered = 0;
    double next = 0;
    values[twice] = need((size_t)count, sizeof(double));
    vectors[twice] = need((size_t)(n * count), sizeof(double));
    assert_int_equal(thrum_eigen_lowest(&p->stiffness, &p->mass, twice ? p->twice : p->single,
                                        count, values[twice], vectors[twice], NULL, NULL),
                     THRUM_OK);
    assert_int_equal(thrum_mode_search(&p->stiffness, &p->mass, twice ? p->twice : p->single, count,
                                       values[twice], vectors[twice], &recovered, &next, NULL),
                     THRUM_OK);
    assert_int_equal(recovered, 0);
  }

  // a vector of an isolated value is unique
  double worst = 0;
  for (int64_t i = 0; i < count; i++) {
    assert_close(values[0][i], values[1][i], most);
    const double *all = values[1];
    if ((i == 0 || all[i] > 1.01 * all[i - 1]) && i + 1 < count && all[i + 1] > 1.01 * all[i])
      worst = fmax(worst, apart(p, vectors[0] + i * n, vectors[1] + i * n));
  }
  print_message("%lld components: the modes differ by %.1e\n", (long long)n, worst);
  assert_true(worst < 1e-8);
  for (int twice = 0; twice < 2; twice++) {
    free(values[twice]);
    free(vectors[twice]);
  }
  pair_free(p);
}

static void modes_are_those_of_double_precision(void **state) {
  (void)state;
  check_modes(pair_make(body_quadratic("beam:8x3x3@1x0.3x0.3", "x<0.001", 0.01, 0.01), false), 10,
              1e-11);

  // the condition of a stiffness grows as the fourth power of the cells along a thin body, so what
  // rounding leaves open, by which processors differ, is about 40^4 2e-16 = 6e-10
  check_modes(pair_make(body_make("beam:40x3x3@1x0.1x0.1", "x<0.001"), false), 20, 6e-10);
  check_modes(pair_make(body_quadratic("beam:6x3x2@1x0.3x0.2", NULL, 0, 0), true), 7, 1e-11);

  // this body is so small that the space of the search is the whole space
  check_modes(pair_make(body_make("beam:2x1x1@2x1x1", "x<0.1"), false), 3, 1e-11);
}

static void a_matrix_that_is_not_positive_definite_is_refused(void **state) {
  (void)state;
  pair *p = pair_make(body_make("beam:4x2x2@1x0.3x0.3", "x<0.001"), false);
  for (int64_t j = 0; j < p->stiffness.size; j++)
    p->stiffness.value[p->stiffness.begin[j]] *= 0.2;
  thrum_factor *factor = NULL;
  assert_int_equal(thrum_factor_plan(&p->stiffness, &factor, NULL), THRUM_OK);
  thrum_factor_set_single(factor, &p->stiffness);
  thrum_error error = {0};
  assert_int_equal(thrum_factor_compute(&p->stiffness, factor, &error), THRUM_SINGULAR);
  p->stiffness.value[0] = -p->stiffness.value[0];
  assert_int_equal(thrum_factor_compute(&p->stiffness, factor, &error), THRUM_SINGULAR);

  // the same plan serves double precision after that
  p->stiffness.value[0] = -p->stiffness.value[0];
  for (int64_t j = 0; j < p->stiffness.size; j++)
    p->stiffness.value[p->stiffness.begin[j]] *= 5;
  thrum_factor_set_single(factor, NULL);
  assert_int_equal(thrum_factor_compute(&p->stiffness, factor, &error), THRUM_OK);
  thrum_factor_free(factor);
  pair_free(p);
}

static void a_product_has_the_bits_of_its_columns(void **state) {
  (void)state;
  pair *p = pair_make(body_make("beam:4x2x2@1x0.3x0.3", "x<0.001"), false);
  const int64_t n = p->fem.free_count;
  double *x = need((size_t)(n * 19), sizeof *x), *all = need((size_t)(n * 19), sizeof *all);
  double *one = need((size_t)n, sizeof *one);
  for (int64_t i = 0; i < n * 19; i++)
    x[i] = random_number();

  // any number of columns, so that every block size is met
  for (int64_t columns = 1; columns <= 19; columns++) {
    thrum_sparse_product(&p->stiffness, x, columns, all);
    for (int64_t c = 0; c < columns; c++) {
      thrum_sparse_product(&p->stiffness, x + c * n, 1, one);
      assert_memory_equal(all + c * n, one, (size_t)n * sizeof *one);
    }
  }

  free(x);
  free(all);
  free(one);
  pair_free(p);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(solutions_are_those_of_double_precision),
      cmocka_unit_test(modes_are_those_of_double_precision),
      cmocka_unit_test(a_matrix_that_is_not_positive_definite_is_refused),
      cmocka_unit_test(a_product_has_the_bits_of_its_columns),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
