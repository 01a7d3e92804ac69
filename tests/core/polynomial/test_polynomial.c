/* Tests of the reduced polynomial and its derivatives against theorems that hold for any quartic,
 * against plain loops over the coefficients, and against numbers worked out by hand.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/base/matrix_product.h"
#include "core/polynomial/polynomial_private.h"
#include "tests/support/random_model.h"
#include "thrum/polynomial.h"

enum { RANK_MAX = 41 };

/* The tests use these ranks: all small ones, and some beyond every unrolled loop. */
static const int64_t ranks[] = {1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11,      12,
                                13, 14, 15, 16, 17, 18, 19, 20, 25, 29, RANK_MAX};
enum { RANKS = sizeof ranks / sizeof ranks[0] };

/* A model with random coefficients, points to evaluate it at, and work space with a marker behind.
 */
typedef struct setup {
  random_model m;
  const thrum_model *model;
  int64_t rank;
  size_t work_count;
  double *work;
  double q[RANK_MAX], v[RANK_MAX], force[RANK_MAX], product[RANK_MAX];
  double tangent[RANK_MAX * RANK_MAX];
} setup;

enum { GUARD = 16 };

/* Finds writes past the end of the work space; it is called before the space is freed. */
static void setup_free(setup *s) {
  for (size_t i = 0; i < GUARD; i++)
    assert_true(s->work[s->work_count + i] == -12345.0);
  free(s->work);
  random_model_free(&s->m);
}

static void setup_make(setup *s, int64_t rank) {
  random_model_make_wild(&s->m, (uint64_t)rank, rank);
  s->model = &s->m.model;
  s->rank = rank;
  s->work_count = thrum_work_count(s->model);
  s->work = random_alloc((int64_t)s->work_count + GUARD, sizeof(double));
  // a function that reads the work space before it writes it gives NaN
  for (size_t i = 0; i < s->work_count + GUARD; i++)
    s->work[i] = i < s->work_count ? NAN : -12345.0;
  random_state random = {(uint64_t)rank + 1000};
  random_vector(&random, rank, 1, s->q);
  random_vector(&random, rank, 1, s->v);
}

static double dot(int64_t n, const double *a, const double *b) {
  double sum = 0;
  for (int64_t i = 0; i < n; i++)
    sum += a[i] * b[i];
  return sum;
}

static double norm(int64_t n, const double *a) {
  return sqrt(dot(n, a, a));
}

/* Asserts |a - b| <= tolerance scale, which NaN fails. */
static void assert_near(double a, double b, double scale, double tolerance) {
  if (!(fabs(a - b) <= tolerance * scale))
    fail_msg("%.17g is not %.17g to %g of %g", a, b, tolerance, scale);
}

static void assert_vectors_near(int64_t n, const double *a, const double *b, double tolerance) {
  double scale = norm(n, b) + 1e-300;
  for (int64_t i = 0; i < n; i++)
    assert_near(a[i], b[i], scale, tolerance);
}

/* Returns V by plain loops, and the sum of its absolute terms as the scale of rounding errors. */
static double energy_by_loops(const thrum_model *model, const double *q, double *scale) {
  int64_t r = model->rank;
  double energy = 0, absolute = 0;

  // the quadratic terms
  for (int64_t i = 0; i < r; i++) {
    double term = 0.5 * model->omega2[i] * q[i] * q[i];
    energy += term;
    absolute += fabs(term);

    // the cubic and the quartic terms, each monomial once
    for (int64_t j = i; j < r; j++)
      for (int64_t k = j; k < r; k++) {
        term = model->c3[thrum_c3_index(r, i, j, k)] * q[i] * q[j] * q[k];
        energy += term;
        absolute += fabs(term);
        for (int64_t l = k; l < r; l++) {
          term = model->c4[thrum_c4_index(r, i, j, k, l)] * q[i] * q[j] * q[k] * q[l];
          energy += term;
          absolute += fabs(term);
        }
      }
  }

  *scale = absolute;
  return energy;
}

static void indices_count_up_in_block_order(void **state) {
  (void)state;
  for (int c = 0; c < RANKS; c++) {
    int64_t r = ranks[c], next3 = 0, next4 = 0;
    for (int64_t j = 0; j < r; j++)
      for (int64_t i = 0; i <= j; i++) {
        for (int64_t k = j; k < r; k++)
          assert_int_equal(thrum_c3_index(r, i, j, k), next3++);
        for (int64_t k = j; k < r; k++)
          for (int64_t l = k; l < r; l++)
            assert_int_equal(thrum_c4_index(r, i, j, k, l), next4++);
      }
    assert_int_equal(next3, thrum_c3_count(r));
    assert_int_equal(next4, thrum_c4_count(r));
  }
}

static void counts_are_the_binomials(void **state) {
  (void)state;
  assert_int_equal(thrum_c3_count(30) + thrum_c4_count(30), 45880);
  assert_int_equal(thrum_c3_count(1), 1);
  assert_int_equal(thrum_c4_count(1), 1);
  assert_int_equal(thrum_c4_count(THRUM_RANK_MAX), INT64_C(2896986240));
  assert_int_equal(thrum_restricted_count(0), 0);
  // 3 linear ones, and rows of 2, 5 and 9 quadratic and cubic ones, each in whole vectors
  assert_int_equal(thrum_restricted_count(3), 8 + 8 + 8 + 16);
}

/* The energy is V = q0^2 + 4 q1^2 + (1,2,3,4).(000,001,011,111) +
 * (1,2,3,4,5).(0000,0001,0011,0111,1111). */
static void two_coordinates_give_numbers_worked_out_by_hand(void **state) {
  (void)state;

  // coefficients that count up
  random_model m;
  random_model_make(&m, 1, 2, 1, 1, INFINITY);
  m.omega2[0] = 2;
  m.omega2[1] = 8;
  for (int64_t i = 0; i < 2; i++)
    for (int64_t j = i; j < 2; j++)
      for (int64_t k = j; k < 2; k++) {
        m.c3[thrum_c3_index(2, i, j, k)] = (double)(1 + i + j + k);
        for (int64_t l = k; l < 2; l++)
          m.c4[thrum_c4_index(2, i, j, k, l)] = (double)(1 + i + j + k + l);
      }

  double work[2048], q[2] = {2, 3}, v[2] = {1, -1}, force[2], tangent[4], product[2];
  assert_true(thrum_work_count(&m.model) <= 2048);

  // 4 + 36 + (8 + 24 + 54 + 108) + (16 + 48 + 108 + 216 + 405)
  assert_true(thrum_strain_energy(&m.model, q, work) == 1027.0);
  assert_true(thrum_internal_force(&m.model, q, force, work) == 1027.0);

  // d/dq0: 4 + (12 + 24 + 27) + (32 + 72 + 108 + 108)
  // d/dq1: 24 + (8 + 36 + 108) + (16 + 72 + 216 + 540)
  assert_true(force[0] == 387.0 && force[1] == 1020.0);

  thrum_tangent_stiffness(&m.model, q, tangent, work);
  // d00: 2 + (12 + 12) + (48 + 72 + 54)
  // d01: (8 + 18) + (24 + 72 + 108)
  // d11: 8 + (12 + 72) + (24 + 144 + 540)
  assert_true(tangent[0] == 200.0 && tangent[1] == 230.0);
  assert_true(tangent[2] == 230.0 && tangent[3] == 800.0);

  // the pass for force and tangent together, and the product with a vector
  assert_true(thrum_internal_force_tangent(&m.model, q, force, tangent, work) == 1027.0);
  assert_true(force[0] == 387.0 && force[1] == 1020.0);
  assert_true(tangent[0] == 200.0 && tangent[1] == 230.0 && tangent[3] == 800.0);
  thrum_tangent_product(&m.model, q, v, product, work);
  assert_true(product[0] == -30.0 && product[1] == -570.0);
  random_model_free(&m);
}

static void energy_agrees_with_loops_over_the_coefficients(void **state) {
  (void)state;
  for (int c = 0; c < RANKS; c++) {
    setup s;
    setup_make(&s, ranks[c]);
    double scale, expected = energy_by_loops(s.model, s.q, &scale);
    assert_near(thrum_strain_energy(s.model, s.q, s.work), expected, scale, 1e-14);
    setup_free(&s);
  }
}

static void force_returns_the_bits_of_the_energy(void **state) {
  (void)state;
  for (int c = 0; c < RANKS; c++) {
    setup s;
    setup_make(&s, ranks[c]);
    double energy = thrum_strain_energy(s.model, s.q, s.work);
    assert_true(thrum_internal_force(s.model, s.q, s.force, s.work) == energy);
    setup_free(&s);
  }
}

/* Five-point differences of step 1 are exact for polynomials of degree 4. */
static void force_is_the_exact_difference_of_energies(void **state) {
  (void)state;
  for (int c = 0; c < RANKS; c++) {
    setup s;
    setup_make(&s, ranks[c]);

    // energies at five points along v
    double energy[5], scale = 0;
    for (int e = 0; e < 5; e++) {
      double point[RANK_MAX];
      for (int64_t i = 0; i < s.rank; i++)
        point[i] = s.q[i] + (e - 2) * s.v[i];
      energy[e] = thrum_strain_energy(s.model, point, s.work);
      scale = fmax(scale, fabs(energy[e]));
    }

    // their difference is the force along v
    thrum_internal_force(s.model, s.q, s.force, s.work);
    double slope = (energy[0] - 8 * energy[1] + 8 * energy[3] - energy[4]) / 12;
    assert_near(dot(s.rank, s.force, s.v), slope, scale + norm(s.rank, s.force), 1e-13);
    setup_free(&s);
  }
}

static void tangent_vector_is_the_exact_difference_of_forces(void **state) {
  (void)state;
  for (int c = 0; c < RANKS; c++) {
    setup s;
    setup_make(&s, ranks[c]);

    // forces at five points along v
    double forces[5][RANK_MAX], scale = 0;
    for (int e = 0; e < 5; e++) {
      double point[RANK_MAX];
      for (int64_t i = 0; i < s.rank; i++)
        point[i] = s.q[i] + (e - 2) * s.v[i];
      thrum_internal_force(s.model, point, forces[e], s.work);
      scale = fmax(scale, norm(s.rank, forces[e]));
    }

    // their difference is the tangent times v
    thrum_tangent_product(s.model, s.q, s.v, s.product, s.work);
    for (int64_t i = 0; i < s.rank; i++) {
      double slope = (forces[0][i] - 8 * forces[1][i] + 8 * forces[3][i] - forces[4][i]) / 12;
      assert_near(s.product[i], slope, scale, 1e-13);
    }
    setup_free(&s);
  }
}

/* Returns log2 of the factor by which a Taylor remainder falls when the step is halved. */
static double slope_of(double remainder, double remainder_half) {
  return log2(fabs(remainder) / fabs(remainder_half));
}

static void taylor_remainders_fall_with_their_order(void **state) {
  (void)state;
  for (int c = 0; c < RANKS; c++) {
    setup s;
    setup_make(&s, ranks[c]);

    // the first and the second derivative at q
    double energy = thrum_internal_force(s.model, s.q, s.force, s.work);
    thrum_tangent_product(s.model, s.q, s.v, s.product, s.work);
    double first[2], second[2], of_force[2];

    for (int half = 0; half < 2; half++) {
      // a step along v, and a step of half its length
      double step = half ? 5e-4 : 1e-3, point[RANK_MAX], force[RANK_MAX];
      for (int64_t i = 0; i < s.rank; i++)
        point[i] = s.q[i] + step * s.v[i];

      // the remainders of the energy after the first and after the second derivative
      first[half] = thrum_internal_force(s.model, point, force, s.work) - energy -
                    step * dot(s.rank, s.force, s.v);
      second[half] = first[half] - 0.5 * step * step * dot(s.rank, s.product, s.v);

      // the remainder of the force after its derivative
      for (int64_t i = 0; i < s.rank; i++)
        force[i] -= s.force[i] + step * s.product[i];
      of_force[half] = norm(s.rank, force);
    }

    // the orders are 2, 3 and 2
    assert_near(slope_of(first[0], first[1]), 2, 1, 0.05);
    assert_near(slope_of(second[0], second[1]), 3, 1, 0.05);
    assert_near(slope_of(of_force[0], of_force[1]), 2, 1, 0.05);
    setup_free(&s);
  }
}

static void tangent_is_symmetric_and_times_v_gives_tangent_vector(void **state) {
  (void)state;
  for (int c = 0; c < RANKS; c++) {
    setup s;
    setup_make(&s, ranks[c]);

    // the matrix, and the product without it
    int64_t r = s.rank;
    double expected[RANK_MAX];
    thrum_tangent_stiffness(s.model, s.q, s.tangent, s.work);
    thrum_tangent_product(s.model, s.q, s.v, s.product, s.work);

    // the matrix is symmetric to the bit, and its rows give the product
    for (int64_t i = 0; i < r; i++) {
      for (int64_t j = 0; j < r; j++)
        assert_true(s.tangent[i * r + j] == s.tangent[j * r + i]);
      expected[i] = dot(r, s.tangent + i * r, s.v);
    }
    assert_vectors_near(r, s.product, expected, 1e-13);
    setup_free(&s);
  }
}

static void tangent_brings_the_force_and_the_energy_of_its_point(void **state) {
  (void)state;
  for (int c = 0; c < RANKS; c++) {
    setup s;
    setup_make(&s, ranks[c]);
    const double energy = thrum_internal_force(s.model, s.q, s.force, s.work);
    double force[RANK_MAX], scale = 0;
    energy_by_loops(s.model, s.q, &scale);
    const double found = thrum_internal_force_tangent_by(thrum_kernel_get(THRUM_KERNEL_BEST),
                                                         s.model, s.q, force, s.tangent, s.work);
    assert_near(found, energy, scale, 1e-14);
    assert_vectors_near(s.rank, force, s.force, 1e-13);
    setup_free(&s);
  }
}

static void rest_has_no_energy_no_force_and_the_linear_stiffness(void **state) {
  (void)state;
  for (int c = 0; c < RANKS; c++) {
    setup s;
    setup_make(&s, ranks[c]);
    memset(s.q, 0, sizeof s.q);
    assert_true(thrum_internal_force(s.model, s.q, s.force, s.work) == 0);
    thrum_tangent_stiffness(s.model, s.q, s.tangent, s.work);
    for (int64_t i = 0; i < s.rank; i++) {
      assert_true(s.force[i] == 0);
      for (int64_t j = 0; j < s.rank; j++)
        assert_true(s.tangent[i * s.rank + j] == (i == j ? s.model->omega2[i] : 0));
    }
    setup_free(&s);
  }
}

/* Euler's theorem: a form of degree d has V(s q) = s^d V, R q = d V and T q = (d-1) R. Scaling by
 * powers of two is exact. */
static void check_homogeneous(setup *s, int degree) {
  double scaled[RANK_MAX], force2[RANK_MAX];
  double energy = thrum_internal_force(s->model, s->q, s->force, s->work);

  // energy and force of the scaled coordinates
  for (int64_t i = 0; i < s->rank; i++)
    scaled[i] = 4 * s->q[i];
  double factor = ldexp(1, 2 * degree);
  assert_true(thrum_strain_energy(s->model, scaled, s->work) == factor * energy);
  thrum_internal_force(s->model, scaled, force2, s->work);
  for (int64_t i = 0; i < s->rank; i++)
    assert_true(force2[i] == factor / 4 * s->force[i]);

  // the force along q
  double sum = 0;
  for (int64_t i = 0; i < s->rank; i++)
    sum += fabs(s->force[i] * s->q[i]);
  assert_near(dot(s->rank, s->force, s->q), degree * energy, sum, 1e-13);

  // the tangent along q
  thrum_tangent_product(s->model, s->q, s->q, s->product, s->work);
  for (int64_t i = 0; i < s->rank; i++)
    s->force[i] *= degree - 1;
  assert_vectors_near(s->rank, s->product, s->force, 1e-13);
}

static void one_degree_alone_is_homogeneous(void **state) {
  (void)state;
  for (int c = 0; c < RANKS; c++)
    for (int degree = 2; degree <= 4; degree++) {
      setup s;
      setup_make(&s, ranks[c]);
      if (degree != 2)
        memset(s.m.omega2, 0, (size_t)s.rank * sizeof(double));
      if (degree != 3)
        memset(s.m.c3, 0, (size_t)s.model->c3_count * sizeof(double));
      if (degree != 4)
        memset(s.m.c4, 0, (size_t)s.model->c4_count * sizeof(double));
      check_homogeneous(&s, degree);
      setup_free(&s);
    }
}

static void restricted_polynomial_is_the_polynomial_at_every_split(void **state) {
  (void)state;
  const thrum_kernel *by = thrum_kernel_get(THRUM_KERNEL_BEST);
  for (int c = 0; c < RANKS; c++) {
    setup s;
    setup_make(&s, ranks[c]);

    // the whole polynomial at q
    int64_t r = s.rank;
    double energy = thrum_internal_force(s.model, s.q, s.force, s.work);
    thrum_tangent_stiffness(s.model, s.q, s.tangent, s.work);
    double scale, energy_scale = norm(r, s.force) + fabs(energy);
    energy_by_loops(s.model, s.q, &scale);

    // every split into fixed and free coordinates; a marker ends the restricted coefficients
    for (int32_t split = 0; split <= r; split++) {
      int64_t n = r - split, count = thrum_restricted_count(n);
      double low[RANK_MAX], gradient[RANK_MAX];
      double *hessian = random_alloc(n * n, sizeof(double));
      double *restricted = random_alloc(count + 1, sizeof(double));
      restricted[count] = -12345.0;

      // the coordinates that stay free are not read by the restriction
      for (int64_t i = 0; i < r; i++)
        low[i] = i < split ? s.q[i] : NAN;
      thrum_polynomial_restrict(by, s.model, split, low, restricted, s.work);

      // the energy of the fixed coordinates alone is the constant of the restricted polynomial
      for (int64_t i = split; i < r; i++)
        low[i] = 0;
      double constant = thrum_strain_energy(s.model, low, s.work);
      assert_true(restricted[count] == -12345.0);

      // the gradient is that of the whole
      double value =
          thrum_restricted_gradient(by, s.model, split, restricted, s.q + split, gradient, s.work);
      assert_near(constant + value, energy, scale, 1e-13);
      for (int64_t i = 0; i < n; i++)
        assert_near(gradient[i], s.force[split + i], energy_scale, 1e-12);

      // the Hessian is a block of the tangent
      thrum_restricted_hessian(by, s.model, split, restricted, s.q + split, hessian, s.work);
      for (int64_t i = 0; i < n; i++)
        for (int64_t j = 0; j < n; j++)
          assert_near(hessian[i * n + j], s.tangent[(split + i) * r + split + j],
                      norm(r * r, s.tangent), 1e-13);

      free(restricted);
      free(hessian);
    }
    setup_free(&s);
  }
}

static void the_force_on_the_first_coordinates_is_the_beginning_of_the_whole(void **state) {
  (void)state;
  const thrum_kernel *by = thrum_kernel_get(THRUM_KERNEL_BEST);
  for (int c = 0; c < RANKS; c++) {
    setup s;
    setup_make(&s, ranks[c]);

    // the whole force at q
    int64_t r = s.rank;
    double energy = thrum_internal_force(s.model, s.q, s.force, s.work), scale;
    double energy_scale = norm(r, s.force) + fabs(energy);
    energy_by_loops(s.model, s.q, &scale);

    for (int32_t split = 0; split <= r; split++) {
      // the part of the force stops before the marker
      double force[RANK_MAX], v[RANK_MAX], low[RANK_MAX], whole[RANK_MAX], part[RANK_MAX];
      force[split < r ? split : 0] = -12345.0;
      assert_near(thrum_internal_force_part(by, s.model, split, s.q, force, s.work), energy, scale,
                  1e-13);
      for (int64_t i = 0; i < split; i++)
        assert_near(force[i], s.force[i], energy_scale, 1e-12);
      assert_true(split == r || force[split] == -12345.0);

      // the product with a vector whose other entries are zero; the part must not read them
      for (int64_t i = 0; i < r; i++) {
        v[i] = i < split ? 1.0 / (double)(i + 1) : NAN;
        low[i] = i < split ? v[i] : 0.0;
      }

      thrum_tangent_product(s.model, s.q, low, whole, s.work);
      thrum_tangent_product_part(by, s.model, split, s.q, v, part, s.work);
      for (int64_t i = 0; i < split; i++)
        assert_near(part[i], whole[i], norm(r, whole), 1e-12);
    }
    setup_free(&s);
  }
}

static void energy_of_a_body_is_bounded_from_below(void **state) {
  (void)state;
  random_state random = {9};
  for (int64_t rank = 1; rank <= 8; rank++) {
    random_model m;
    random_model_make(&m, (uint64_t)rank, rank, 10, 300, 0.05);
    double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof(double)), q[8];
    for (int trial = 0; trial < 200; trial++) {
      random_vector(&random, rank, pow(10, 2 * random_uniform(&random) - 1), q);
      assert_true(thrum_strain_energy(&m.model, q, work) > 0);
    }
    free(work);
    random_model_free(&m);
  }
}

/* Sums in the order that polynomial.h promises, literally. */
static double sum_in_lanes(int64_t count, const double *a, const double *b) {
  double lane[8] = {0};
  for (int64_t c = 0; c < count; c++)
    lane[c % 8] += a[c] * b[c];
  return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
}

enum { ROWS = 9, COLUMNS = 45 };

/* Computes y and w of one block from given start values, in the promised order. */
static void block_by_promise(int64_t rows, int64_t columns, const double *block, const double *m,
                             const double *x, double *y, double *w) {
  for (int64_t i = 0; i < rows; i++) {
    y[i] += sum_in_lanes(columns, block + i * columns, m);
    for (int64_t c = 0; c < columns; c++)
      w[c] += x[i] * block[i * columns + c];
  }
}

static void products_keep_the_promised_order_of_summation_bit_for_bit(void **state) {
  (void)state;

  // a block of the largest size, of which every smaller one uses the beginning
  random_state random = {3};
  double block[ROWS * COLUMNS], m[COLUMNS], x[ROWS];
  random_vector(&random, ROWS * COLUMNS, 1, block);
  random_vector(&random, COLUMNS, 1, m);
  random_vector(&random, ROWS, 1, x);

  for (int64_t rows = 0; rows <= ROWS; rows++)
    for (int64_t columns = 0; columns <= COLUMNS; columns++) {
      // both products add to start values
      double y[ROWS], w[COLUMNS], y_b[ROWS], w_b[COLUMNS];
      random_vector(&random, ROWS, 1, y);
      random_vector(&random, COLUMNS, 1, w);
      memcpy(y_b, y, sizeof y_b);
      memcpy(w_b, w, sizeof w_b);

      // the products, and the same sums by the plain loops
      thrum_matrix_product(rows, columns, block, m, y_b);
      thrum_matrix_product_transposed(rows, columns, block, x, w_b);
      block_by_promise(rows, columns, block, m, x, y, w);
      assert_memory_equal(y_b, y, sizeof y_b);
      assert_memory_equal(w_b, w, sizeof w_b);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(indices_count_up_in_block_order),
      cmocka_unit_test(counts_are_the_binomials),
      cmocka_unit_test(two_coordinates_give_numbers_worked_out_by_hand),

      // derivatives agree with differences
      cmocka_unit_test(energy_agrees_with_loops_over_the_coefficients),
      cmocka_unit_test(force_returns_the_bits_of_the_energy),
      cmocka_unit_test(force_is_the_exact_difference_of_energies),
      cmocka_unit_test(tangent_vector_is_the_exact_difference_of_forces),
      cmocka_unit_test(taylor_remainders_fall_with_their_order),
      cmocka_unit_test(tangent_is_symmetric_and_times_v_gives_tangent_vector),
      cmocka_unit_test(tangent_brings_the_force_and_the_energy_of_its_point),

      // special points and parts
      cmocka_unit_test(rest_has_no_energy_no_force_and_the_linear_stiffness),
      cmocka_unit_test(one_degree_alone_is_homogeneous),
      cmocka_unit_test(restricted_polynomial_is_the_polynomial_at_every_split),
      cmocka_unit_test(the_force_on_the_first_coordinates_is_the_beginning_of_the_whole),
      cmocka_unit_test(energy_of_a_body_is_bounded_from_below),
      cmocka_unit_test(products_keep_the_promised_order_of_summation_bit_for_bit),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
