/* The answers of thrum_state_stepped_modes are compared with linear runs: the angle and the
 * amplitude of each mode are fitted to four samples of q, of which two are exactly determined.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

enum { RANK = 6 };

static thrum_state_def make_def(thrum_integrator integrator) {
  thrum_state_def def = imexv_def();
  def.integrator = integrator;
  def.dt = 0.05;
  def.tolerance = 1e-14;
  def.adaptive = def.fallback = 0;
  return def;
}

/* Runs linear modes of h omega = 0.1 to `last`, and compares each that vibrates with its figures.
 */
static void expect_figures(const thrum_state_def *def, double last) {
  random_model m;
  random_model_make(&m, 3, RANK, 0.1 / def->dt, last / def->dt, INFINITY);
  static const double start_q[RANK] = {0.3, -0.2, 0.25, 0.1, -0.3, 0.2};
  static const double start_p[RANK] = {0.4, 2.0, -3.0, 4.0, 5.0, -6.0};
  thrum_state *state = state_make(&m.model, def);
  state_put(&m.model, state, start_q, start_p);
  thrum_stepped_mode modes[RANK];
  assert_int_equal(thrum_state_stepped_modes(&m.model, state, modes, NULL), THRUM_OK);

  double q[4][RANK];
  for (int k = 0; k < 4; k++) {
    state_read(&m.model, state, q[k], NULL);
    state_steps(&m.model, state, 1);
  }
  state_free(state);

  for (int i = 0; i < RANK; i++) {
    assert_true(fabs(modes[i].hertz - sqrt(m.model.omega2[i]) / (2 * pi)) < 1e-12);

    // q'' - trace q' + det q = 0 at two times in turn
    const double a = q[0][i], b = q[1][i], c = q[2][i], d = q[3][i];
    const double trace = (b * c - a * d) / (b * b - a * c);
    const double det = (c * c - b * d) / (b * b - a * c);
    const double angle = acos(0.5 * trace / sqrt(det)), factor = sqrt(det);
    const double stepped = 2 * pi * def->dt * modes[i].stepped_hertz;
    if (!(fabs(stepped - angle) < 1e-7 && fabs(modes[i].factor - factor) < 1e-9))
      fail_msg("%s, mode %d: angle %.10f, not %.10f; factor %.10f, not %.10f",
               thrum_integrator_name(def->integrator), i, stepped, angle, modes[i].factor, factor);
  }
  random_model_free(&m);
}

static void linear_runs_vibrate_as_is_said(void **context) {
  (void)context;
  for (int n = 0; n < INTEGRATOR_COUNT; n++) {
    const thrum_state_def def = make_def(every_integrator[n]);
    const bool limited = every_integrator[n] == THRUM_INTEGRATOR_VERLET ||
                         every_integrator[n] == THRUM_INTEGRATOR_RK4;
    expect_figures(&def, limited ? 1.9 : 7.0);
  }

  thrum_state_def plain = make_def(THRUM_INTEGRATOR_ENERGY);
  plain.frequency_matched = 0;
  expect_figures(&plain, 7.0);

  // every form of the split, and a Newmark that drains
  for (int form = THRUM_FORM_THESIS; thrum_split_form_name((thrum_split_form)form); form++) {
    thrum_state_def def = make_def(THRUM_INTEGRATOR_IMEXV);
    def.split_form = (thrum_split_form)form;
    expect_figures(&def, 7.0);
  }
  thrum_state_def def = make_def(THRUM_INTEGRATOR_NEWMARK);
  def.newmark_beta = 0.4;
  def.newmark_gamma = 0.6;
  expect_figures(&def, 5.0);
}

static void the_closed_forms_of_the_documentation_hold(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 3, RANK, 1.0, 60.0, INFINITY);
  for (int n = 0; n < 3; n++) {
    static const thrum_integrator three[3] = {THRUM_INTEGRATOR_ENERGY, THRUM_INTEGRATOR_VERLET,
                                              THRUM_INTEGRATOR_BACKWARD_EULER};
    const thrum_state_def def = make_def(three[n]);
    thrum_state *state = state_make(&m.model, &def);
    thrum_stepped_mode modes[RANK];
    assert_int_equal(thrum_state_stepped_modes(&m.model, state, modes, NULL), THRUM_OK);
    for (int i = 0; i < RANK; i++) {
      const double z = def.dt * sqrt(m.model.omega2[i]), half = z / 2;
      const double trapezoidal = 2 * atan(half), matched = z <= 1 ? z : trapezoidal;
      const double angle = n == 0 ? matched : n == 1 ? 2 * asin(half) : atan(z);

      // beyond h omega = 2 Verlet grows, by a known factor, and asin has no value
      if (n == 1 && half > 1) {
        assert_true(isnan(modes[i].stepped_hertz));
        assert_true(fabs(modes[i].factor - pow(half + sqrt(half * half - 1), 2)) < 1e-9);
        continue;
      }
      assert_true(fabs(modes[i].stepped_hertz - angle / (2 * pi * def.dt)) < 1e-9);
      assert_true(fabs(modes[i].factor - (n == 2 ? 1 / sqrt(1 + z * z) : 1)) < 1e-12);
    }
    state_free(state);
  }
  random_model_free(&m);
}

/* Of a step as long as numbers go every figure is a number, or the frequency none: no vibration. */
static void the_longest_step_has_figures_too(void **context) {
  (void)context;
  for (int n = 0; n < INTEGRATOR_COUNT; n++)
    for (int k = 0; k < 2; k++) {
      random_model m;
      random_model_make(&m, 3, RANK, 1, 7, INFINITY);
      thrum_state_def def = make_def(every_integrator[n]);
      def.dt = k == 0 ? 1.7e308 : 1e160;
      thrum_state *state = NULL;
      if (thrum_state_create(&m.model, &def, &state, NULL) >= 0) {
        thrum_stepped_mode modes[RANK];
        assert_int_equal(thrum_state_stepped_modes(&m.model, state, modes, NULL), THRUM_OK);
        for (int i = 0; i < RANK; i++)
          if (!isfinite(modes[i].hertz) || !isfinite(modes[i].factor))
            fail_msg("%s, mode %d: factor %g", thrum_integrator_name(def.integrator), i,
                     modes[i].factor);
        thrum_state_destroy(state);
      }
      random_model_free(&m);
    }
}

static void nothing_is_written_for_a_state_of_another_model(void **context) {
  (void)context;
  random_model m, other;
  random_model_make(&m, 3, RANK, 1.0, 6.0, INFINITY);
  random_model_make(&other, 3, RANK - 1, 1.0, 6.0, INFINITY);
  const thrum_state_def def = make_def(THRUM_INTEGRATOR_ENERGY);
  thrum_state *state = state_make(&m.model, &def);
  thrum_stepped_mode modes[RANK] = {{7, 7, 7}};
  assert_int_equal(thrum_state_stepped_modes(&other.model, state, modes, NULL),
                   THRUM_MODEL_MISMATCH);
  assert_int_equal(thrum_state_stepped_modes(&m.model, state, NULL, NULL), THRUM_INVALID_ARGUMENT);
  assert_true(modes[0].hertz == 7);
  state_free(state);
  random_model_free(&other);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(linear_runs_vibrate_as_is_said),
      cmocka_unit_test(the_closed_forms_of_the_documentation_hold),
      cmocka_unit_test(the_longest_step_has_figures_too),
      cmocka_unit_test(nothing_is_written_for_a_state_of_another_model),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
