/* Steps whose length changes from one to the next: an inverse of one step is turned into that of
 * another, guesses extrapolate in time, and the split is that of the longest step lately.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

enum { RANK = 6 };

static const double start_q[RANK] = {0.3, -0.1, 0.15, 0.05, -0.04, 0.02};
static const double start_p[RANK] = {-0.2, 0.4, 0.1, -0.3, 0.2, 0.1};

/* A length between shortest and longest. */
static double draw(random_state *random, double shortest, double longest) {
  double between;
  random_vector(random, 1, 1.0, &between);
  return 0.5 * (shortest + longest) + 0.5 * (longest - shortest) * between;
}

static void draw_steps(const thrum_model *model, thrum_state *state, random_state *random,
                       double shortest, double longest, int count) {
  for (int k = 0; k < count; k++) {
    assert_int_equal(thrum_state_set_dt(model, state, draw(random, shortest, longest), NULL),
                     THRUM_OK);
    state_steps(model, state, 1);
  }
}

/* The Jacobian of a linear model is the same at every q, so that the inverse of one step gives
 * those of all others exactly: the first solve makes the only one, and where `energy` makes them
 * ahead, the inverse before leaves nothing of a residual. */
static void the_inverse_of_a_linear_model_serves_every_step(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, INFINITY);
  static const struct {
    thrum_integrator integrator;
    thrum_split_form form;
  } schemes[] = {{THRUM_INTEGRATOR_IMEXV, THRUM_FORM_POSITION},
                 {THRUM_INTEGRATOR_IMEXV, THRUM_FORM_THESIS},
                 {THRUM_INTEGRATOR_MIDPOINT, THRUM_FORM_THESIS},
                 {THRUM_INTEGRATOR_NEWMARK, THRUM_FORM_THESIS},
                 {THRUM_INTEGRATOR_FOX_GOODWIN, THRUM_FORM_THESIS},
                 {THRUM_INTEGRATOR_BACKWARD_EULER, THRUM_FORM_THESIS},
                 {THRUM_INTEGRATOR_ENERGY, THRUM_FORM_THESIS}};

  for (size_t n = 0; n < sizeof schemes / sizeof schemes[0]; n++)
    for (int damped = 0; damped < 3; damped++) {
      thrum_state_def def = imexv_def();
      def.integrator = schemes[n].integrator;
      def.split_form = schemes[n].form;
      def.split_rule = THRUM_SPLIT_COUNT;
      def.explicit_count = 2;
      def.adaptive = 0;
      def.dt = 0.1;
      def.damping_form = damped == 2 ? THRUM_DAMPING_TANGENT : THRUM_DAMPING_REST;
      def.damping_alpha = damped ? 0.2 : 0;
      def.damping_beta = damped ? 0.01 : 0;

      // where T of the damping is weighted by mode the inverse is only near
      def.frequency_matched = damped < 2;
      if (def.integrator == THRUM_INTEGRATOR_FOX_GOODWIN && damped == 2)
        continue;
      thrum_state *state = state_make(&m.model, &def);
      state_put(&m.model, state, start_q, start_p);
      state_steps(&m.model, state, 1);

      // what each solve takes is the one correction of the inverse
      random_state random = {3};
      draw_steps(&m.model, state, &random, 0.05, 0.2, 200);
      const thrum_state_report report = thrum_state_report_get(state);
      const bool planned = def.integrator == THRUM_INTEGRATOR_ENERGY && damped < 2;
      const int64_t most = planned ? 1 + 200 / 8 + 1 : 1;
      if (report.factorisations > most || report.newton_steps + report.substep_steps > 0)
        fail_msg("%s, form %d, damping %d: %lld Jacobians, %lld by Newton",
                 thrum_integrator_name(def.integrator), (int)def.split_form, damped,
                 (long long)report.factorisations, (long long)report.newton_steps);
      state_free(state);
    }
  random_model_free(&m);
}

/* Modes do not move between the sets while the length jitters; a step for which they would be
 * unstable moves them at once, and they come back when it has not come again for a while. */
static void the_split_is_that_of_the_longest_step_lately(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  for (int adaptive = 0; adaptive < 2; adaptive++) {
    thrum_state_def def = imexv_def();
    def.split_rule = THRUM_SPLIT_CFL;
    def.adaptive = adaptive;
    def.dt = 0.1; // omega = 1, 3.2, 5.4, 7.6, 9.8, 12: five modes have h omega <= 1
    thrum_state *state = state_make(&m.model, &def);
    const double small[RANK] = {1e-4};
    state_put(&m.model, state, small, NULL);
    assert_int_equal(thrum_state_report_get(state).explicit_modes, 5);

    // shorter steps would let all modes be explicit
    random_state random = {9};
    for (int k = 0; k < 50; k++) {
      draw_steps(&m.model, state, &random, 0.04, 0.06, 9);
      assert_int_equal(thrum_state_set_dt(&m.model, state, 0.1, NULL), THRUM_OK);
      state_steps(&m.model, state, 1);
      assert_int_equal(thrum_state_report_get(state).explicit_modes, 5);
    }

    // one longer step
    assert_int_equal(thrum_state_set_dt(&m.model, state, 0.15, NULL), THRUM_OK);
    assert_int_equal(thrum_state_report_get(state).explicit_modes, 3);
    state_steps(&m.model, state, 1);

    // it is remembered for some hundred steps
    draw_steps(&m.model, state, &random, 0.05, 0.06, 200);
    assert_int_equal(thrum_state_report_get(state).explicit_modes, 3);
    draw_steps(&m.model, state, &random, 0.05, 0.06, 400);
    assert_int_equal(thrum_state_report_get(state).explicit_modes, 6);

    // a step that is much shorter is no jitter
    assert_int_equal(thrum_state_set_dt(&m.model, state, 0.3, NULL), THRUM_OK);
    assert_int_equal(thrum_state_report_get(state).explicit_modes, 2);
    assert_int_equal(thrum_state_set_dt(&m.model, state, 0.05, NULL), THRUM_OK);
    assert_int_equal(thrum_state_report_get(state).explicit_modes, 6);
    assert_int_equal(thrum_state_report_get(state).split_changes, 0);
    state_free(state);
  }
  random_model_free(&m);
}

/* The scheme that the monitor has chosen, its balance and the energy account go on. */
static void a_new_length_does_not_take_a_switch_back(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  thrum_state_def def = imexv_def();
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = RANK;
  def.dt = 0.15;
  thrum_state *state = state_make(&m.model, &def);
  const double fast[RANK] = {9, -7, 8, 6, -9, 7};
  state_put(&m.model, state, NULL, fast);
  random_state random = {4};
  draw_steps(&m.model, state, &random, 0.1, 0.2, 60);

  // the state has switched, and stays where it is
  const thrum_state_report before = thrum_state_report_get(state);
  assert_int_equal(before.scheme, THRUM_SCHEME_ENERGY);
  const double energy = state_energy(&m.model, state).total;
  draw_steps(&m.model, state, &random, 0.1, 0.2, 300);
  const thrum_state_report after = thrum_state_report_get(state);
  assert_int_equal(after.scheme, THRUM_SCHEME_ENERGY);
  assert_int_equal(after.scheme_switches, before.scheme_switches);
  assert_true(fabs(state_energy(&m.model, state).total / energy - 1) < 1e-12);
  state_free(state);
  random_model_free(&m);
}

static void a_snapshot_between_drawn_steps_goes_on_to_the_same_bits(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  for (int i = 0; i < INTEGRATOR_COUNT; i++) {
    thrum_state_def def = imexv_def();
    def.integrator = every_integrator[i];
    def.dt = 0.05;
    thrum_state *state = state_make(&m.model, &def), *other = state_make(&m.model, &def);
    state_put(&m.model, state, start_q, start_p);
    random_state random = {6};
    draw_steps(&m.model, state, &random, 0.02, 0.06, 40);

    // the copy draws the same lengths from there on
    const size_t size = thrum_state_snapshot_size(state);
    void *kept = malloc(size);
    assert_non_null(kept);
    assert_int_equal(thrum_state_snapshot(state, kept, size, NULL), THRUM_OK);
    thrum_error error;
    if (thrum_state_restore(&m.model, other, kept, size, &error) < 0)
      fail_msg("%s: %s", thrum_integrator_name(every_integrator[i]), error.message);
    random_state again = random;
    draw_steps(&m.model, state, &random, 0.02, 0.06, 40);
    draw_steps(&m.model, other, &again, 0.02, 0.06, 40);
    assert_memory_equal(state, other, thrum_state_kept_bytes(state));
    free(kept);
    state_free(state);
    state_free(other);
  }
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_inverse_of_a_linear_model_serves_every_step),
      cmocka_unit_test(the_split_is_that_of_the_longest_step_lately),
      cmocka_unit_test(a_new_length_does_not_take_a_switch_back),
      cmocka_unit_test(a_snapshot_between_drawn_steps_goes_on_to_the_same_bits),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
