/* Tests of external loads: forces and displacements against plain loops over the basis, and mean
 * loads against windows of whole steps, impulses and quadrature.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/support/random_model.h"
#include "thrum/displacement.h"
#include "thrum/external_load.h"

enum { RANK = 11, VERTICES = 23 };

static void make_body(random_model *m) {
  random_model_make(m, 5, RANK, 10, 100, INFINITY);
  random_model_add_mesh(m, 6, VERTICES);
}

static void assert_near(double a, double b, double tolerance) {
  if (!(fabs(a - b) <= tolerance))
    fail_msg("%.17g is not %.17g to %g", a, b, tolerance);
}

/* Returns the entry of U for a vertex, an axis and a coordinate. */
static double basis_at(const random_model *m, int64_t vertex, int axis, int64_t coordinate) {
  return m->basis[(3 * vertex + axis) * m->model.rank + coordinate];
}

static void vertex_force_is_its_rows_of_the_basis(void **state) {
  (void)state;
  random_model m;
  make_body(&m);
  const double force[3] = {2, -3, 0.5};

  for (int64_t vertex = 0; vertex < VERTICES; vertex++) {
    // the force is added to what is there
    double reduced[RANK];
    for (int64_t i = 0; i < RANK; i++)
      reduced[i] = (double)i;
    assert_int_equal(thrum_load_add_vertex(&m.model, vertex, force, reduced, NULL), THRUM_OK);

    // the rows of the vertex times the force
    for (int64_t i = 0; i < RANK; i++) {
      double expected = (double)i;
      for (int axis = 0; axis < 3; axis++)
        expected += force[axis] * basis_at(&m, vertex, axis, i);
      assert_near(reduced[i], expected, 1e-14);
    }
  }
  random_model_free(&m);
}

static void field_is_the_sum_of_its_vertex_forces(void **state) {
  (void)state;
  random_model m;
  make_body(&m);
  random_state random = {8};
  double forces[3 * VERTICES], whole[RANK] = {0}, parts[RANK] = {0};
  random_vector(&random, 3 * VERTICES, 10, forces);
  assert_int_equal(thrum_load_add_field(&m.model, forces, whole, NULL), THRUM_OK);
  for (int64_t v = 0; v < VERTICES; v++)
    assert_int_equal(thrum_load_add_vertex(&m.model, v, forces + 3 * v, parts, NULL), THRUM_OK);
  for (int64_t i = 0; i < RANK; i++)
    assert_near(whole[i], parts[i], 1e-13);
  random_model_free(&m);
}

static void force_on_a_held_vertex_does_nothing(void **state) {
  (void)state;
  random_model m;
  make_body(&m);
  double reduced[RANK] = {0};
  assert_int_equal(thrum_load_add_vertex(&m.model, 0, (double[3]){1, 2, 3}, reduced, NULL),
                   THRUM_OK);
  for (int64_t i = 0; i < RANK; i++)
    assert_true(reduced[i] == 0);
  random_model_free(&m);
}

static void gravity_is_axis_mass_times_acceleration(void **state) {
  (void)state;
  random_model m;
  make_body(&m);
  const double g[3] = {0.5, 2, -9.81};
  double reduced[RANK] = {0};
  assert_int_equal(thrum_load_add_gravity(&m.model, g, reduced, NULL), THRUM_OK);
  for (int64_t i = 0; i < RANK; i++) {
    double expected = 0;
    for (int axis = 0; axis < 3; axis++)
      expected += g[axis] * m.axis_mass[axis * RANK + i];
    assert_near(reduced[i], expected, 1e-13);
  }
  random_model_free(&m);
}

static void displacement_of_any_range_is_the_basis_times_q(void **state) {
  (void)state;
  random_model m;
  make_body(&m);

  // random reduced coordinates
  random_state random = {4};
  double q[RANK];
  random_vector(&random, RANK, 1, q);

  // every range of vertices, with a marker behind it
  for (int64_t first = 0; first <= VERTICES; first++)
    for (int64_t count = 0; count <= VERTICES - first; count++) {
      double u[3 * VERTICES + 1];
      u[3 * count] = -77;
      assert_int_equal(thrum_displacement(&m.model, q, first, count, u, NULL), THRUM_OK);
      assert_true(u[3 * count] == -77);

      // each row of the range is the product of its row of the basis
      for (int64_t row = 0; row < 3 * count; row++) {
        double expected = 0;
        for (int64_t i = 0; i < RANK; i++)
          expected += basis_at(&m, first + row / 3, (int)(row % 3), i) * q[i];
        assert_near(u[row], expected, 1e-14 * RANK);
      }
    }
  random_model_free(&m);
}

/* The virtual work is the same in both coordinates: f . (U q) = (U^T f) . q. */
static void force_and_displacement_are_transposes(void **state) {
  (void)state;
  random_model m;
  make_body(&m);

  // a random displacement and random forces
  random_state random = {12};
  double q[RANK], forces[3 * VERTICES], u[3 * VERTICES], reduced[RANK] = {0}, left = 0, right = 0;
  random_vector(&random, RANK, 1, q);
  random_vector(&random, 3 * VERTICES, 1, forces);

  // the reduced load and the displacement come from the functions under test
  assert_int_equal(thrum_load_add_field(&m.model, forces, reduced, NULL), THRUM_OK);
  assert_int_equal(thrum_displacement(&m.model, q, 0, VERTICES, u, NULL), THRUM_OK);

  // the work in physical and in reduced coordinates
  for (int64_t i = 0; i < 3 * VERTICES; i++)
    left += forces[i] * u[i];
  for (int64_t i = 0; i < RANK; i++)
    right += reduced[i] * q[i];
  assert_near(left, right, 1e-12);
  random_model_free(&m);
}

static void assert_untouched(const double *values, int64_t count) {
  for (int64_t i = 0; i < count; i++)
    assert_true(values[i] == 7);
}

static void vertices_out_of_range_are_refused_and_outputs_kept(void **state) {
  (void)state;
  random_model m;
  make_body(&m);

  // outputs with a known value
  const double force[3] = {1, 1, 1}, q[RANK] = {1};
  double out[3 * VERTICES];
  for (int64_t i = 0; i < 3 * VERTICES; i++)
    out[i] = 7;

  // vertices that do not exist
  thrum_error error = {.status = THRUM_OK};
  const int64_t bad_vertices[] = {-1, VERTICES, INT64_MAX, INT64_MIN};
  for (int c = 0; c < 4; c++)
    assert_int_equal(thrum_load_add_vertex(&m.model, bad_vertices[c], force, out, &error),
                     THRUM_INVALID_ARGUMENT);
  assert_int_equal(error.status, THRUM_INVALID_ARGUMENT);
  thrum_load_add_vertex(&m.model, VERTICES, force, out, &error);
  assert_string_equal(error.message, "vertex 23 is outside 0..22");

  // ranges that leave the mesh, also by overflow
  const int64_t bad_ranges[][2] = {{-1, 1}, {0, VERTICES + 1},      {VERTICES, 1},
                                   {3, -1}, {1, INT64_MAX},         {INT64_MAX, 1},
                                   {0, -1}, {INT64_MAX, INT64_MAX}, {VERTICES + 1, 0}};
  for (size_t c = 0; c < sizeof bad_ranges / sizeof bad_ranges[0]; c++)
    assert_int_equal(
        thrum_displacement(&m.model, q, bad_ranges[c][0], bad_ranges[c][1], out, &error),
        THRUM_INVALID_ARGUMENT);

  assert_untouched(out, 3 * VERTICES);
  random_model_free(&m);
}

static void forces_that_are_not_finite_are_refused_and_outputs_kept(void **state) {
  (void)state;
  random_model m;
  make_body(&m);

  // outputs with a known value
  double out[RANK], forces[3 * VERTICES] = {0};
  for (int64_t i = 0; i < RANK; i++)
    out[i] = 7;

  // the message names the axis and the vertex
  thrum_error error = {.status = THRUM_OK};
  forces[3 * 20 + 1] = NAN;
  assert_int_equal(thrum_load_add_field(&m.model, forces, out, &error), THRUM_BAD_VALUE);
  assert_string_equal(error.message, "component y of the force at vertex 20 is not finite");

  // a single force and a gravity
  assert_int_equal(thrum_load_add_vertex(&m.model, 3, (double[3]){0, 0, INFINITY}, out, &error),
                   THRUM_BAD_VALUE);
  assert_int_equal(thrum_load_add_gravity(&m.model, (double[3]){NAN, 0, 0}, out, &error),
                   THRUM_BAD_VALUE);

  assert_untouched(out, RANK);
  random_model_free(&m);
}

static void model_without_a_basis_is_missing_it(void **state) {
  (void)state;
  random_model m;
  random_model_make(&m, 5, RANK, 10, 100, INFINITY);

  // outputs with a known value
  const double three[3] = {1, 1, 1}, q[RANK] = {1};
  double out[RANK];
  for (int64_t i = 0; i < RANK; i++)
    out[i] = 7;

  // every function that needs the basis says that it is missing
  thrum_error error;
  assert_int_equal(thrum_load_add_vertex(&m.model, 0, three, out, &error), THRUM_MISSING);
  assert_int_equal(thrum_load_add_field(&m.model, three, out, &error), THRUM_MISSING);
  assert_int_equal(thrum_load_add_gravity(&m.model, three, out, &error), THRUM_MISSING);
  assert_int_equal(thrum_displacement(&m.model, q, 0, 0, out, &error), THRUM_MISSING);
  assert_int_equal(thrum_displacement(&m.model, q, 0, 0, out, NULL), THRUM_MISSING);
  assert_untouched(out, RANK);
  random_model_free(&m);
}

/* Returns in how many of the first `steps` steps the load acts, and the sum of its means. */
static int64_t count_steps(const thrum_load *load, double dt, int64_t steps, double *sum) {
  int64_t count = 0;
  *sum = 0;
  for (int64_t k = 0; k < steps; k++) {
    double mean = thrum_load_mean(load, k, dt);
    count += mean != 0;
    *sum += mean;
  }
  return count;
}

static void windows_of_whole_steps_count_them_exactly(void **state) {
  (void)state;
  double sum;

  // a window of one step, and one of a hundred
  thrum_load load = {.shape = THRUM_LOAD_CONSTANT, .until = 0.003};
  assert_int_equal(count_steps(&load, 0.003, 1000, &sum), 1);
  assert_true(sum == 1 && thrum_load_mean(&load, 0, 0.003) == 1);
  load.until = 0.3;
  assert_int_equal(count_steps(&load, 0.003, 1000, &sum), 100);
  assert_true(sum == 100);

  // every window of whole steps from every step, with ends as a user would type them
  for (int from = 0; from < 40; from++)
    for (int length = 1; length < 40; length++) {
      load.from = from * 3e-3;
      load.until = (from + length) * 3e-3;
      assert_int_equal(count_steps(&load, 0.003, 100, &sum), length);
      assert_true(sum == length);
      assert_true(thrum_load_mean(&load, from, 0.003) == 1);
      assert_true(thrum_load_mean(&load, from + length, 0.003) == 0);
    }
}

static void window_keeps_its_impulse_at_any_step(void **state) {
  (void)state;
  const double steps[] = {0.01, 0.005, 0.003, 0.001, 0.00037, 0.1};
  const double windows[][2] = {{0, 0.003}, {0, 0.3}, {0.0125, 0.0131}, {0.02, 0.0999}};
  for (size_t w = 0; w < sizeof windows / sizeof windows[0]; w++)
    for (size_t s = 0; s < sizeof steps / sizeof steps[0]; s++) {
      thrum_load load = {
          .shape = THRUM_LOAD_CONSTANT, .from = windows[w][0], .until = windows[w][1]};
      double sum;
      count_steps(&load, steps[s], 2000, &sum);
      // an end moves by at most 1e-6 of a step
      assert_near(sum * steps[s], load.until - load.from, 2e-6 * steps[s] + 1e-15);
    }
  thrum_load load = {.shape = THRUM_LOAD_CONSTANT, .until = 0.003};
  assert_near(thrum_load_mean(&load, 0, 0.01), 0.3, 1e-15);
  assert_true(thrum_load_mean(&load, 1, 0.01) == 0);
}

static void windows_may_be_endless_empty_or_reversed(void **state) {
  (void)state;
  thrum_load load = {.shape = THRUM_LOAD_CONSTANT, .from = 0.006, .until = INFINITY};
  assert_true(thrum_load_mean(&load, 0, 0.003) == 0 && thrum_load_mean(&load, 1, 0.003) == 0);
  assert_true(thrum_load_mean(&load, 2, 0.003) == 1);
  assert_true(thrum_load_mean(&load, INT64_C(1) << 40, 0.003) == 1);
  load.from = -INFINITY;
  assert_true(thrum_load_mean(&load, 0, 0.003) == 1);
  load.from = load.until = 0.0045;
  assert_true(thrum_load_mean(&load, 1, 0.003) == 0);
  load.until = 0.001;
  for (int64_t k = 0; k < 4; k++)
    assert_true(thrum_load_mean(&load, k, 0.003) == 0);
}

static void nonsense_gives_no_load_rather_than_nan(void **state) {
  (void)state;

  // every combination of odd values in the window, the frequency and the time step
  const double odd[] = {NAN, INFINITY, -INFINITY, 0, -1, 1e308, 1e-320};
  enum { ODD = sizeof odd / sizeof odd[0] };
  for (int shape = 0; shape < 2; shape++)
    for (int a = 0; a < ODD; a++)
      for (int b = 0; b < ODD; b++)
        for (int c = 0; c < ODD; c++)
          for (int d = 0; d < ODD; d++) {
            thrum_load load = {.shape = (thrum_load_shape)shape,
                               .from = odd[a],
                               .until = odd[b],
                               .frequency = odd[c]};
            double mean = thrum_load_mean(&load, 3, odd[d]);
            assert_true(mean >= -1 && mean <= 1);
          }

  // a time step or a window without a meaning gives the mean zero
  thrum_load load = {.shape = THRUM_LOAD_CONSTANT, .until = 1};
  assert_true(thrum_load_mean(&load, 3, 0) == 0);
  assert_true(thrum_load_mean(&load, 3, -1) == 0);
  load.from = NAN;
  assert_true(thrum_load_mean(&load, 3, 0.01) == 0);
}

/* Applies Simpson's rule to the part of the step that the window covers. */
static double mean_by_quadrature(const thrum_load *load, int64_t step, double dt) {
  enum { INTERVALS = 2000 };
  double a = fmax((double)step * dt, load->from), b = fmin((double)(step + 1) * dt, load->until);
  if (b <= a)
    return 0;
  double sum = 0, pi = acos(-1);
  for (int s = 0; s <= INTERVALS; s++) {
    double t = a + (b - a) * s / INTERVALS;
    double weight = s == 0 || s == INTERVALS ? 1 : s % 2 ? 4 : 2;
    sum += weight * sin(2 * pi * load->frequency * (t - load->from));
  }
  return sum * (b - a) / (3 * INTERVALS) / dt;
}

static void sine_mean_agrees_with_quadrature(void **state) {
  (void)state;
  const thrum_load loads[] = {
      {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = 1},
      {.shape = THRUM_LOAD_SINE, .from = 0.0123, .until = 0.0567, .frequency = 7},
      {.shape = THRUM_LOAD_SINE, .until = 0.3, .frequency = 1e-3},
      {.shape = THRUM_LOAD_SINE, .from = 0.01, .until = 1, .frequency = 333},
      {.shape = THRUM_LOAD_SINE, .from = 0.005, .until = 0.007, .frequency = 100}};
  const double steps[] = {0.01, 0.003, 0.001};
  for (size_t l = 0; l < sizeof loads / sizeof loads[0]; l++)
    for (size_t s = 0; s < 3; s++)
      for (int64_t k = 0; k < 60; k++)
        assert_near(thrum_load_mean(&loads[l], k, steps[s]),
                    mean_by_quadrature(&loads[l], k, steps[s]), 1e-10);
}

static void a_ramp_rises_evenly_to_its_end(void **state) {
  (void)state;
  const thrum_load ramp = {.shape = THRUM_LOAD_RAMP, .from = 0.05, .until = 0.25};
  double impulse = 0;
  for (int64_t k = 0; k < 40; k++) {
    const double middle = 0.01 * ((double)k + 0.5);
    const double expected = middle > 0.05 && middle < 0.25 ? (middle - 0.05) / 0.2 : 0;
    assert_near(thrum_load_mean(&ramp, k, 0.01), expected, 1e-14);
    impulse += 0.01 * thrum_load_mean(&ramp, k, 0.01);
  }
  assert_near(impulse, 0.1, 1e-14);

  // one that begins and ends within a step keeps its impulse; one that never ends never rises
  const thrum_load within = {.shape = THRUM_LOAD_RAMP, .from = 0.052, .until = 0.058};
  assert_near(0.01 * thrum_load_mean(&within, 5, 0.01), 0.003, 1e-16);
  const thrum_load endless = {.shape = THRUM_LOAD_RAMP, .until = INFINITY};
  assert_true(thrum_load_mean(&endless, 5, 0.01) == 0);
}

static void sine_over_a_whole_turn_has_no_mean(void **state) {
  (void)state;
  thrum_load load = {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = 100};
  for (int64_t k = 0; k < 20; k++)
    assert_near(thrum_load_mean(&load, k, 0.01), 0, 1e-15);
  load.frequency = 0;
  assert_true(thrum_load_mean(&load, 5, 0.01) == 0);
}

/* The mean of a step is the mean of the means of its halves: nothing is counted twice or lost. */
static void mean_of_a_step_is_the_mean_of_its_halves(void **state) {
  (void)state;
  const thrum_load loads[] = {
      {.shape = THRUM_LOAD_CONSTANT, .from = 0.0101, .until = 0.0789},
      {.shape = THRUM_LOAD_SINE, .from = 0.0101, .until = 0.0789, .frequency = 11},
      {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = 1}};
  for (size_t l = 0; l < sizeof loads / sizeof loads[0]; l++)
    for (int64_t k = 0; k < 50; k++)
      assert_near(thrum_load_mean(&loads[l], k, 0.003),
                  0.5 * (thrum_load_mean(&loads[l], 2 * k, 0.0015) +
                         thrum_load_mean(&loads[l], 2 * k + 1, 0.0015)),
                  1e-12);
}

static void sine_keeps_its_phase_late_in_a_long_run(void **state) {
  (void)state;
  // 1 Hz at 0.005 s: step 200 n begins period n
  thrum_load load = {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = 1};
  for (int64_t k = 0; k < 200; k++)
    assert_near(thrum_load_mean(&load, 200 * INT64_C(1000000) + k, 0.005),
                thrum_load_mean(&load, k, 0.005), 1e-9);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(vertex_force_is_its_rows_of_the_basis),
      cmocka_unit_test(field_is_the_sum_of_its_vertex_forces),
      cmocka_unit_test(force_on_a_held_vertex_does_nothing),
      cmocka_unit_test(gravity_is_axis_mass_times_acceleration),
      cmocka_unit_test(displacement_of_any_range_is_the_basis_times_q),
      cmocka_unit_test(force_and_displacement_are_transposes),

      // what is refused
      cmocka_unit_test(vertices_out_of_range_are_refused_and_outputs_kept),
      cmocka_unit_test(forces_that_are_not_finite_are_refused_and_outputs_kept),
      cmocka_unit_test(model_without_a_basis_is_missing_it),

      // means of loads over time
      cmocka_unit_test(windows_of_whole_steps_count_them_exactly),
      cmocka_unit_test(window_keeps_its_impulse_at_any_step),
      cmocka_unit_test(windows_may_be_endless_empty_or_reversed),
      cmocka_unit_test(nonsense_gives_no_load_rather_than_nan),
      cmocka_unit_test(a_ramp_rises_evenly_to_its_end),
      cmocka_unit_test(sine_mean_agrees_with_quadrature),
      cmocka_unit_test(sine_over_a_whole_turn_has_no_mean),
      cmocka_unit_test(mean_of_a_step_is_the_mean_of_its_halves),
      cmocka_unit_test(sine_keeps_its_phase_late_in_a_long_run),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
