/* Tests of amplitudes, peaks, shared forces and sums of loads, each against its definition.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "thrum/thrum.h"

#define VERTICES 37
#define RANK 5

static double basis[3 * VERTICES * RANK];
static thrum_model model;

/* A basis of numbers in [-1, 1] from a linear congruential generator; vertex 0 is held. */
static int make_basis(void **state) {
  (void)state;
  uint64_t seed = 2011;
  for (int n = 3 * RANK; n < 3 * VERTICES * RANK; n++) {
    seed = seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    basis[n] = (double)(int64_t)(seed >> 11) / 4503599627370496.0 - 1;
  }
  model = (thrum_model){.rank = RANK, .vertex_count = VERTICES, .basis = basis};
  return 0;
}

static double displacement_of(const double *q, int64_t vertex) {
  double u[3];
  assert_int_equal(thrum_displacement(&model, q, vertex, 1, u, NULL), THRUM_OK);
  return sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
}

static double furthest(const double *q, int64_t *vertex) {
  double largest = 0;
  for (int64_t v = 0; v < VERTICES; v++) {
    const double length = displacement_of(q, v);
    if (length > largest) {
      largest = length;
      *vertex = v;
    }
  }
  return largest;
}

static void a_mode_moves_its_furthest_vertex_by_the_amplitude(void **state) {
  (void)state;
  for (int64_t mode = 0; mode < RANK; mode++) {
    for (int sign = -1; sign <= 1; sign += 2) {
      double q[RANK] = {0};
      int64_t vertex = -1;
      assert_int_equal(thrum_mode_add(&model, mode, sign * 0.02, q, NULL), THRUM_OK);
      assert_true(fabs(furthest(q, &vertex) - 0.02) < 1e-16);
      assert_true(sign * q[mode] > 0);
      for (int64_t i = 0; i < RANK; i++)
        assert_true(i == mode || q[i] == 0);
    }
  }
}

static void vertices_and_states_out_of_range_are_refused_and_outputs_left_alone(void **state) {
  (void)state;
  double q[RANK] = {1, 2, 3, 4, 5};
  const double before[RANK] = {1, 2, 3, 4, 5};
  static const double nothing[3 * VERTICES * RANK];
  const thrum_model bare = {.rank = RANK},
                    still = {.rank = RANK, .vertex_count = VERTICES, .basis = nothing};
  assert_int_equal(thrum_mode_add(&model, -1, 1, q, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_mode_add(&model, RANK, 1, q, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_mode_add(&bare, 0, 1, q, NULL), THRUM_MISSING);
  assert_int_equal(thrum_mode_add(&still, 0, 1, q, NULL), THRUM_BAD_VALUE);
  assert_int_equal(thrum_mode_add(&model, 0, NAN, q, NULL), THRUM_BAD_VALUE);
  assert_int_equal(thrum_basis_extents(&bare, q, NULL), THRUM_MISSING);
  assert_memory_equal(q, before, sizeof q);
}

static void the_running_peak_is_the_largest_displacement_so_far(void **state) {
  (void)state;
  double extents[RANK], peak = 0, expected = 0;
  int64_t vertex = -1, expected_vertex = -1;
  assert_int_equal(thrum_basis_extents(&model, extents, NULL), THRUM_OK);

  for (int n = 0; n < 400; n++) {
    // a motion whose amplitude grows slowly
    double q[RANK];
    for (int i = 0; i < RANK; i++)
      q[i] = 0.01 * (1 + 0.005 * n) * sin(0.37 * n * (i + 1) + i);

    // the largest displacement by a search over all vertices
    int64_t here = -1;
    const double length = furthest(q, &here);
    if (length > expected) {
      expected = length;
      expected_vertex = here;
    }

    // the running peak agrees in size and vertex
    assert_int_equal(thrum_displacement_peak(&model, extents, q, &peak, &vertex, NULL), THRUM_OK);
    assert_true(fabs(peak - expected) <= 1e-15);
    assert_int_equal(vertex, expected_vertex);
  }
}

static void a_shared_force_is_the_sum_of_its_shares(void **state) {
  (void)state;

  // a force shared among a group, and its shares added one by one
  static const int32_t group[4] = {0, 3, 17, 36};
  const double force[3] = {3, -5, 7};
  double shared[RANK] = {1, 1, 1, 1, 1}, summed[RANK] = {1, 1, 1, 1, 1};
  assert_int_equal(thrum_load_add_shared(&model, group, 4, force, shared, NULL), THRUM_OK);
  for (int n = 0; n < 4; n++) {
    const double share[3] = {force[0] / 4, force[1] / 4, force[2] / 4};
    assert_int_equal(thrum_load_add_vertex(&model, group[n], share, summed, NULL), THRUM_OK);
  }
  for (int i = 0; i < RANK; i++)
    assert_true(fabs(shared[i] - summed[i]) < 1e-14);

  // a force on all vertices: the mean row of the basis times the force
  double all[RANK] = {0};
  assert_int_equal(thrum_load_add_shared(&model, NULL, 0, force, all, NULL), THRUM_OK);
  for (int i = 0; i < RANK; i++) {
    double expected = 0;
    for (int64_t n = 0; n < 3 * VERTICES; n++)
      expected += basis[n * RANK + i] * force[n % 3] / VERTICES;
    assert_true(fabs(all[i] - expected) < 1e-13);
  }
}

static void a_vertex_out_of_range_leaves_the_force_alone(void **state) {
  (void)state;
  static const int32_t beyond[2] = {1, VERTICES}, below[2] = {1, -1};
  const double force[3] = {1, 1, 1}, before[RANK] = {1, 2, 3, 4, 5};
  double reduced[RANK] = {1, 2, 3, 4, 5};
  const thrum_model bare = {.rank = RANK};
  assert_int_equal(thrum_load_add_shared(&model, beyond, 2, force, reduced, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_load_add_shared(&model, below, 2, force, reduced, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_load_add_shared(&model, beyond, 0, force, reduced, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_load_add_shared(&bare, NULL, 0, force, reduced, NULL), THRUM_MISSING);
  assert_memory_equal(reduced, before, sizeof reduced);
}

static void loads_sum_with_their_means(void **state) {
  (void)state;

  // a window, a sine and a load that starts late
  const thrum_load loads[3] = {
      {.shape = THRUM_LOAD_CONSTANT, .until = 0.0045},
      {.shape = THRUM_LOAD_SINE, .from = 0.01, .until = INFINITY, .frequency = 7},
      {.shape = THRUM_LOAD_CONSTANT, .from = 0.006, .until = INFINITY}};
  const double directions[3 * 2] = {1, 2, -3, 4, 5, -6};

  // the sum replaces what was there
  for (int64_t step = 0; step < 40; step++) {
    double sum[2] = {99, 99}, expected[2] = {0, 0};
    thrum_load_sum(loads, directions, 3, 2, step, 0.003, sum);
    for (int n = 0; n < 6; n++)
      expected[n % 2] += directions[n] * thrum_load_mean(&loads[n / 2], step, 0.003);
    assert_true(fabs(sum[0] - expected[0]) < 1e-15 && fabs(sum[1] - expected[1]) < 1e-15);
  }

  // without loads the sum is zero
  double none[2] = {99, 99};
  thrum_load_sum(NULL, NULL, 0, 2, 0, 0.003, none);
  assert_true(none[0] == 0 && none[1] == 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_mode_moves_its_furthest_vertex_by_the_amplitude),
      cmocka_unit_test(vertices_and_states_out_of_range_are_refused_and_outputs_left_alone),
      cmocka_unit_test(the_running_peak_is_the_largest_displacement_so_far),
      cmocka_unit_test(a_shared_force_is_the_sum_of_its_shares),
      cmocka_unit_test(a_vertex_out_of_range_leaves_the_force_alone),
      cmocka_unit_test(loads_sum_with_their_means),
  };
  return cmocka_run_group_tests(tests, make_basis, NULL);
}
