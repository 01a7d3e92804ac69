/* Tests of steps at their limits: singular Jacobians, numbers near the end of their range, extreme
 * kicks. The models have one mode, so that the limit is met exactly. The dense solver and the test
 * for finite numbers beneath the steps are tested too.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include <float.h>

#include "core/base/finite.h"
#include "core/linear_algebra/dense.h"
#include "thrum/polynomial.h"

/* V = w2/2 q^2 + c3 q^3 + c4 q^4. */
static void make_mode(random_model *m, double w2, double c3, double c4) {
  random_model_make(m, 1, 1, 1.0, 1.0, INFINITY);
  m->omega2[0] = w2;
  m->c3[0] = c3;
  m->c4[0] = c4;
}

static thrum_state_def make_def(thrum_integrator integrator, double dt) {
  thrum_state_def def = imexv_def();
  def.integrator = integrator;
  def.dt = dt;
  return def;
}

/* --- finite numbers --------------------------------------------------------------------------- */

/* One number among others, at each place of rows of each length that leaves a rest. */
static bool finite_among_others(double x) {
  static const double others[] = {0.0, -0.0, DBL_MAX, -DBL_MAX, DBL_MIN, DBL_TRUE_MIN, -1.0};
  enum { MOST = 19, OTHERS = sizeof others / sizeof others[0] };
  double row[MOST];
  int found = 0, asked = 0;
  for (int n = 1; n <= MOST; n++)
    for (int at = 0; at < n; at++, asked++) {
      for (int i = 0; i < n; i++)
        row[i] = others[(n + i) % OTHERS];
      row[at] = x;
      found += thrum_all_finite(row, n);
    }

  // the place makes no difference
  assert_true(found == 0 || found == asked);
  return found > 0;
}

static void numbers_that_are_not_finite_are_found_among_others(void **context) {
  (void)context;
  assert_true(finite_among_others(1.0) && finite_among_others(DBL_MAX));
  assert_true(finite_among_others(-DBL_MAX) && finite_among_others(DBL_TRUE_MIN));
  assert_false(finite_among_others(INFINITY) || finite_among_others(-INFINITY));
  assert_false(finite_among_others(NAN) || finite_among_others(-(double)NAN));
  assert_true(thrum_all_finite(NULL, 0));
}

/* --- the dense solver ------------------------------------------------------------------------- */

static void an_indefinite_system_with_a_zero_diagonal_is_solved(void **context) {
  (void)context;
  const double matrix[16] = {0, 2, -1, 4, 2, 0, 3, 1, -1, 3, 0, -2, 4, 1, -2, 0};
  const double x[4] = {1, -2, 3, 0.5};
  double factors[16], solution[4] = {0};
  int32_t pivots[4];

  // the right side of a known solution
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++)
      solution[i] += matrix[4 * i + j] * x[j];

  memcpy(factors, matrix, sizeof factors);
  assert_true(thrum_dense_factor(factors, 4, pivots));
  thrum_dense_solve(factors, 4, pivots, solution);
  assert_true(largest_difference(solution, x, 4) < 1e-14);
}

static void random_systems_are_solved(void **context) {
  (void)context;
  enum { N = 40 };
  random_state random = {8};
  double *matrix = random_alloc(N * N, sizeof *matrix),
         *factors = random_alloc(N * N, sizeof *factors);
  for (int turn = 0; turn < 20; turn++) {
    double x[N], solution[N] = {0};
    int32_t pivots[N];

    // the right side of a known solution
    random_vector(&random, N * N, 1, matrix);
    random_vector(&random, N, 1, x);
    for (int i = 0; i < N; i++)
      for (int j = 0; j < N; j++)
        solution[i] += matrix[N * i + j] * x[j];

    memcpy(factors, matrix, N * N * sizeof *factors);
    assert_true(thrum_dense_factor(factors, N, pivots));
    thrum_dense_solve(factors, N, pivots, solution);
    assert_true(largest_difference(solution, x, N) < 1e-9);
  }

  free(matrix);
  free(factors);
}

static void a_singular_or_non_finite_matrix_is_refused(void **context) {
  (void)context;
  int32_t pivots[2];
  double singular[4] = {1, 2, 2, 4}, zero[4] = {0, 0, 0, 0}, nan_first[4] = {NAN, 1, 1, 1};
  double nan_last[4] = {1, 1, 1, NAN}, infinite[4] = {INFINITY, 1, 1, 1};
  assert_false(thrum_dense_factor(singular, 2, pivots));
  assert_false(thrum_dense_factor(zero, 2, pivots));
  assert_false(thrum_dense_factor(nan_first, 2, pivots));
  assert_false(thrum_dense_factor(nan_last, 2, pivots));
  assert_false(thrum_dense_factor(infinite, 2, pivots));
}

/* --- singular steps --------------------------------------------------------------------------- */

/* The Jacobian 1 + h^2/4 T(q) is zero at the start, where the force is not. */
static void a_step_that_starts_from_a_singular_jacobian_is_solved(void **context) {
  (void)context;
  random_model m;
  make_mode(&m, 2, -1, 0.125);
  const thrum_state_def def = make_def(THRUM_INTEGRATOR_MIDPOINT, 1);

  thrum_state *state = state_make(&m.model, &def);
  const double start = 2;
  double q, p, force, tangent, *work = random_alloc((int64_t)thrum_work_count(&m.model), 8);

  // T = -4 makes the Jacobian of a step of 1 s zero
  thrum_tangent_stiffness(&m.model, &start, &tangent, work);
  assert_true(tangent == -4);

  // full Newton takes the step, which solves the midpoint rule
  state_put(&m.model, state, &start, NULL);
  assert_true(thrum_step(&m.model, state, NULL) >= 0);
  assert_int_equal(thrum_state_report_get(state).newton_steps, 1);
  state_read(&m.model, state, &q, &p);

  const double middle = 0.5 * (start + q);
  thrum_internal_force(&m.model, &middle, &force, work);
  assert_true(fabs(q - start - 0.5 * p) < 1e-9);
  assert_true(fabs(p + force) < 1e-9);

  free(work);
  state_free(state);
  random_model_free(&m);
}

/* With 1 + h/2 beta T(q) = 0 the tangent form of damping has no kick. */
static void a_singular_tangent_damping_is_refused_everywhere(void **context) {
  (void)context;
  random_model m;
  make_mode(&m, 2, -0.5, 0);
  thrum_state_def def = make_def(THRUM_INTEGRATOR_VERLET, 0.5);
  def.damping_form = THRUM_DAMPING_TANGENT;
  def.damping_beta = 1;

  // T = -4 makes 1 + h/2 beta T zero, so the momentum cannot be synchronised
  thrum_state *state = state_make(&m.model, &def);
  const double start = 2;
  double q = 7, p = 7;
  thrum_energies energies;

  state_put(&m.model, state, &start, NULL);

  // every call that needs the synchronised momentum refuses, and changes nothing
  void *kept = state_snapshot(state);
  assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_NOT_CONVERGED);
  assert_int_equal(thrum_state_get(&m.model, state, &q, &p, NULL), THRUM_SINGULAR);
  assert_true(q == 7 && p == 7);
  assert_int_equal(thrum_state_energies(&m.model, state, &energies, NULL), THRUM_SINGULAR);
  assert_int_equal(thrum_state_set_dt(&m.model, state, 0.1, NULL), THRUM_SINGULAR);
  assert_memory_equal(state, kept, thrum_state_kept_bytes(state));

  free(kept);
  state_free(state);
  random_model_free(&m);
}

/* --- the end of the range --------------------------------------------------------------------- */

/* Where q is finite and R(q) is not, q can be read, but nothing else, and the state can be set
 * again.
 */
static void a_state_whose_force_overflows_says_so(void **context) {
  (void)context;
  random_model m;
  make_mode(&m, 1, 0, 1);
  const thrum_state_def def = make_def(THRUM_INTEGRATOR_VERLET, 1);

  thrum_state *state = state_make(&m.model, &def);
  const double kick = 1e120;
  double q = 7, p = 7;
  thrum_energies energies = {7, 7, 7, 7};

  // the first step is free of forces and carries q out of the range of R and V
  state_put(&m.model, state, NULL, &kick);
  assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_ENERGY_GREW);

  // every call that needs the force refuses, and changes neither its outputs nor the state
  void *kept = state_snapshot(state);
  assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_NOT_FINITE);
  assert_int_equal(thrum_state_get(&m.model, state, &q, &p, NULL), THRUM_NOT_FINITE);
  assert_int_equal(thrum_state_energies(&m.model, state, &energies, NULL), THRUM_NOT_FINITE);
  assert_int_equal(thrum_state_set_dt(&m.model, state, 2, NULL), THRUM_NOT_FINITE);
  assert_true(q == 7 && p == 7 && energies.total == 7);
  assert_memory_equal(state, kept, thrum_state_kept_bytes(state));

  // q can still be read, and the state can be set again
  state_read(&m.model, state, &q, NULL);
  assert_true(q == kick);
  state_put(&m.model, state, NULL, NULL);
  assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_OK);

  free(kept);
  state_free(state);
  random_model_free(&m);
}

static void an_energy_that_overflows_is_refused(void **context) {
  (void)context;
  random_model m;
  make_mode(&m, 1, 0, 1);
  const thrum_state_def def = make_def(THRUM_INTEGRATOR_MIDPOINT, 1);
  thrum_state *state = state_make(&m.model, &def);
  const double start = 1e100;
  thrum_energies energies = {7, 7, 7, 7};
  state_put(&m.model, state, &start, NULL);
  assert_int_equal(thrum_state_energies(&m.model, state, &energies, NULL), THRUM_NOT_FINITE);
  assert_true(energies.potential == 7 && energies.total == 7);
  state_free(state);
  random_model_free(&m);
}

/* Newton's full step overflows the residual; shortened ones lead to the solution. */
static void a_kick_beyond_the_range_of_the_residual_is_still_solved(void **context) {
  (void)context;
  random_model m;
  make_mode(&m, 1, 0, 1);
  thrum_state_def def = make_def(THRUM_INTEGRATOR_MIDPOINT, 1);
  def.iterations_max = 2000;

  thrum_state *state = state_make(&m.model, &def);
  const double kick = 1e55;
  double q, p;

  state_put(&m.model, state, NULL, &kick);
  assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_FELL_BACK);
  state_read(&m.model, state, &q, &p);

  // the quartic dominates: q - h p + h^2/2 4 (q/2)^3 = 0 for the increment q, so q^3 = 4 h p
  assert_true(fabs(q / cbrt(4 * kick) - 1) < 1e-9);
  assert_true(fabs(p / kick + 1) < 1e-9);

  // a kick beyond that has no finite trial: refused, and the state stays
  const double beyond = 1e150;
  state_put(&m.model, state, NULL, &beyond);
  void *kept = state_snapshot(state);
  assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_NOT_FINITE);
  assert_memory_equal(state, kept, thrum_state_kept_bytes(state));

  free(kept);
  state_free(state);
  random_model_free(&m);
}

/* The solver has no scale of length of its own: the same motion in units 2^-40 and 2^40 as large
 * takes the same iterations and gives the same bits, scaled. */
static void the_solver_knows_no_unit_of_length(void **context) {
  (void)context;
  enum { RANK = 5, STEPS = 60 };
  double q[3][RANK], p[3][RANK];
  int64_t iterations[3];
  for (int unit = 0; unit < 3; unit++) {
    const double scale = ldexp(1, 40 * (unit - 1));

    // coefficients of the same body in another unit of length
    random_model m;
    random_model_make(&m, 3, RANK, 1, 20, 0.5);
    for (int64_t i = 0; i < m.model.c3_count; i++)
      m.c3[i] /= scale;
    for (int64_t i = 0; i < m.model.c4_count; i++)
      m.c4[i] /= scale * scale;

    // start and load in that unit
    thrum_state_def def = make_def(THRUM_INTEGRATOR_IMEXV, 0.1);
    thrum_state *state = state_make(&m.model, &def);
    double start[RANK] = {0.3, -0.1, 0.15, 0.05, -0.04}, load[RANK] = {0.2, -0.1, 0.3, 0.1, 0.5};
    for (int i = 0; i < RANK; i++) {
      start[i] *= scale;
      load[i] *= scale;
    }

    // the run, and its end in the first unit
    state_put(&m.model, state, start, NULL);
    state_push(&m.model, state, load);
    state_steps(&m.model, state, STEPS);
    state_read(&m.model, state, q[unit], p[unit]);
    for (int i = 0; i < RANK; i++) {
      q[unit][i] /= scale;
      p[unit][i] /= scale;
    }

    iterations[unit] = thrum_state_report_get(state).iterations;
    assert_true(iterations[unit] > STEPS);
    state_free(state);
    random_model_free(&m);
  }

  // powers of two scale without rounding, so the bits must be the same
  for (int unit = 0; unit < 3; unit += 2) {
    assert_int_equal(iterations[unit], iterations[1]);
    assert_memory_equal(q[unit], q[1], sizeof q[1]);
    assert_memory_equal(p[unit], p[1], sizeof p[1]);
  }
}

/* A loaded, damped body comes to rest at its equilibrium and then needs no iteration: the floor of
 * the stop criterion holds where the step itself has vanished. */
static void a_body_settled_under_a_load_needs_no_iterations(void **context) {
  (void)context;
  enum { RANK = 5 };
  random_model m;
  random_model_make(&m, 3, RANK, 1, 20, 0.5);
  const double load[RANK] = {0.2, -0.5, 2, 5, -9};
  double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof(double));
  for (int integrator = 0; integrator < INTEGRATOR_COUNT; integrator++) {
    thrum_state_def def = make_def((thrum_integrator)integrator, 0.05);
    def.damping_alpha = 2;
    def.damping_beta = 0.02;

    thrum_state *state = state_make(&m.model, &def);

    // damping brings the body to rest
    double q[RANK], p[RANK], force[RANK];
    state_push(&m.model, state, load);
    state_steps(&m.model, state, 3000);
    assert_true(thrum_state_report_get(state).iterations_last <= 1);

    // from there on hardly a step needs an iteration
    const int64_t before = thrum_state_report_get(state).iterations;
    state_steps(&m.model, state, 1000);

    // Newmark's stored acceleration goes on alternating at the size of rounding
    const int64_t allowed =
        integrator == THRUM_INTEGRATOR_NEWMARK || integrator == THRUM_INTEGRATOR_FOX_GOODWIN ? 1000
                                                                                             : 100;
    assert_true(thrum_state_report_get(state).iterations - before <= allowed);

    // it rests where the internal force equals the load
    state_read(&m.model, state, q, p);
    thrum_internal_force(&m.model, q, force, work);
    assert_true(largest_difference(force, load, RANK) < 1e-9);
    for (int i = 0; i < RANK; i++)
      assert_true(fabs(p[i]) < 1e-9);

    state_free(state);
  }
  free(work);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(numbers_that_are_not_finite_are_found_among_others),
      cmocka_unit_test(an_indefinite_system_with_a_zero_diagonal_is_solved),
      cmocka_unit_test(random_systems_are_solved),
      cmocka_unit_test(a_singular_or_non_finite_matrix_is_refused),
      cmocka_unit_test(a_step_that_starts_from_a_singular_jacobian_is_solved),
      cmocka_unit_test(a_singular_tangent_damping_is_refused_everywhere),
      cmocka_unit_test(a_state_whose_force_overflows_says_so),
      cmocka_unit_test(an_energy_that_overflows_is_refused),
      cmocka_unit_test(a_kick_beyond_the_range_of_the_residual_is_still_solved),
      cmocka_unit_test(the_solver_knows_no_unit_of_length),
      cmocka_unit_test(a_body_settled_under_a_load_needs_no_iterations),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
