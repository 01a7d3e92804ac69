/* Damping of single modes (`damping` of a model): where it is the same for all modes, each
 * integrator does with it what it does with alpha. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

enum { RANK = 5, STEPS = 60 };

static void run(const thrum_model *model, const thrum_state_def *def, double *q, double *p,
                double *dissipated) {
  double start[RANK] = {0.1, -0.2, 0.05, 0.1, -0.05}, speed[RANK] = {0.3, 0.1, -0.2, 0, 0.1};
  thrum_state *state = state_make(model, def);
  state_put(model, state, start, speed);
  state_steps(model, state, STEPS);
  state_read(model, state, q, p);
  *dissipated = thrum_state_report_get(state).dissipated;
  state_free(state);
}

static void the_same_damping_of_all_modes_is_that_of_the_mass(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 8, RANK, 1, 20, 2);
  const double rates[RANK] = {0.7, 0.7, 0.7, 0.7, 0.7};
  thrum_model damped = m.model;
  damped.damping = rates;
  for (int n = 0; n < INTEGRATOR_COUNT; n++)
    for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
      thrum_state_def def = thrum_default_state_def();
      def.integrator = every_integrator[n];
      def.dt = 0.01;
      def.damping_beta = form == THRUM_DAMPING_TANGENT ? 1e-3 : 0;
      def.damping_form = (thrum_damping_form)form;
      if (def.integrator == THRUM_INTEGRATOR_MANIFOLD)
        continue; // its slaves are damped by alpha, and not by this
      double q[RANK], p[RANK], other_q[RANK], other_p[RANK], taken = 0, other_taken = 0;
      run(&damped, &def, q, p, &taken);
      def.damping_alpha = 0.7;
      run(&m.model, &def, other_q, other_p, &other_taken);
      assert_true(largest_difference(q, other_q, RANK) < 1e-11);
      assert_true(largest_difference(p, other_p, RANK) < 1e-10);
      assert_true(taken > 0);
      assert_true(fabs(taken - other_taken) < 1e-9);
    }
  random_model_free(&m);
}

static void a_mode_alone_decays_by_its_own_ratio(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 8, 2, 2, 3, INFINITY);
  const double rates[2] = {2 * 0.05 * 2, 0};
  thrum_model damped = m.model;
  damped.damping = rates;
  thrum_state_def def = thrum_default_state_def();
  def.dt = 1e-3;
  thrum_state *state = state_make(&damped, &def);
  state_put(&damped, state, (const double[]){1, 1}, (const double[]){0, 0});
  state_steps(&damped, state, 4000);
  double q[2], p[2];
  state_read(&damped, state, q, p);

  // q = e^-at (cos bt + a/b sin bt), a = 0.1, b = sqrt(4 - a^2); the other mode swings on
  const double a = 0.1, b = sqrt(4 - a * a), t = 4;
  assert_true(fabs(q[0] - exp(-a * t) * (cos(b * t) + a / b * sin(b * t))) < 1e-6);
  assert_true(fabs(q[1] - cos(3 * t)) < 1e-6);
  state_free(state);
  random_model_free(&m);
}

static void a_locked_model_has_none(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 8, 2, 2, 3, INFINITY);
  thrum_model lower = {0};
  size_t size = 0;
  assert_int_equal(thrum_model_lock_size(&m.model, 1, &size, NULL), THRUM_OK);
  const double rates[2] = {1, 1};
  m.model.damping = rates;
  void *memory = aligned_alloc(64, size);
  memset(memory, 0xff, size);
  const thrum_model *locked = &lower;
  assert_int_equal(thrum_model_lock(memory, size, &m.model, 1, &locked, NULL), THRUM_OK);
  assert_null(locked->damping);
  free(memory);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_same_damping_of_all_modes_is_that_of_the_mass),
      cmocka_unit_test(a_locked_model_has_none),
      cmocka_unit_test(a_mode_alone_decays_by_its_own_ratio),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
