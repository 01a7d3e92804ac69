/* Actuators in steps: the account of their work, the order of all integrators, batches, snapshots
 * and equilibria. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/acting_body.h"

#include "thrum/thrum.h"

enum { ACTUATORS = 6 };

static acting_body made; /* of all kinds */

static int make(void **state) {
  (void)state;
  made = act_on(hollow(true, false), all_kinds, 3, 6);
  return 0;
}

static int unmake(void **state) {
  (void)state;
  acting_free(&made);
  return 0;
}

static thrum_state *state_of(const thrum_model *model, thrum_integrator integrator, double dt) {
  thrum_state_def def = thrum_default_state_def();
  thrum_error error = {0};
  thrum_state *state = NULL;
  def.integrator = integrator;
  def.dt = dt;
  if (thrum_state_create(model, &def, &state, &error) < 0)
    fail_msg("%s", error.message);
  return state;
}

/* Levels that move smoothly, of all kinds, at time t. */
static void levels_at(double t, double *levels) {
  for (int k = 0; k < ACTUATORS; k++)
    levels[k] = all_levels[k] * sin((20.0 + 3 * k) * t + k) * 0.5;
}

static double total_of(const thrum_model *model, thrum_state *state) {
  thrum_energies energies;
  assert_int_equal(thrum_state_energies(model, state, &energies, NULL), THRUM_OK);
  return energies.total;
}

static double work_of(const thrum_model *model, const thrum_state *state) {
  double work[ACTUATORS], sum = 0;
  assert_int_equal(thrum_state_actuation_work(model, state, work, NULL), THRUM_OK);
  for (int k = 0; k < ACTUATORS; k++)
    sum += work[k];
  return sum;
}

/* Steps with levels that change each step, or every `hold` steps. */
static void run_steps(const thrum_model *model, thrum_state *state, double dt, int count,
                      int hold) {
  thrum_error error = {0};
  double levels[ACTUATORS];
  for (int n = 0; n < count; n++) {
    if (n % hold == 0) {
      levels_at((n + 0.5) * dt, levels);
      assert_int_equal(thrum_state_set_actuation(model, state, levels, &error), THRUM_OK);
    }
    if (thrum_step(model, state, &error) < 0)
      fail_msg("%s", error.message);
  }
}

/* Theorem: the energy is the work of the actuators, to rounding, where `energy` steps. */
static void energy_is_the_work_of_the_actuators(void **unused) {
  (void)unused;
  const thrum_model *model = &made.found.model;
  for (int hold = 1; hold <= 50; hold += 49) {
    thrum_state *state = state_of(model, THRUM_INTEGRATOR_ENERGY, 1e-3);
    double largest = 0, off = 0;
    for (int n = 0; n < 40; n++) {
      run_steps(model, state, 1e-3, 50, hold);
      const double total = total_of(model, state);
      largest = fmax(largest, total);
      off = fmax(off, fabs(total - work_of(model, state)));
    }
    assert_true(largest > 1e-6);
    assert_true(off < 1e-12 * largest);
    thrum_state_destroy(state);
  }
}

/* Where q is set nothing works. */
static void setting_a_place_does_no_work(void **unused) {
  (void)unused;
  const thrum_model *model = &made.found.model;
  thrum_state *state = state_of(model, THRUM_INTEGRATOR_ENERGY, 1e-3);
  run_steps(model, state, 1e-3, 20, 1);
  const double before = work_of(model, state);
  double q[64] = {0.01, -0.01};
  assert_int_equal(thrum_state_set(model, state, q, NULL, NULL), THRUM_OK);
  assert_true(fabs(work_of(model, state) - before) <= 1e-14 * fabs(before));
  double levels[ACTUATORS], measures[ACTUATORS];
  assert_int_equal(thrum_state_actuation(model, state, levels, NULL), THRUM_OK);
  assert_true(levels[0] != 0);
  assert_int_equal(thrum_state_actuation_measures(model, state, measures, NULL), THRUM_OK);
  assert_true(measures[0] > 0 && measures[0] == measures[1] && measures[5] > 0.3);

  // a step from there has the energy of that place and the work since
  const double start = total_of(model, state);
  assert_int_equal(thrum_step(model, state, NULL), THRUM_OK);
  const double gained = total_of(model, state) - start, done = work_of(model, state) - before;
  assert_true(fabs(gained - done) < 1e-11 * start);
  thrum_state_destroy(state);
}

/* Theorem: all integrators come to the same motion, with the second order of the step. */
static void all_integrators_step_actuators(void **unused) {
  (void)unused;
  static const struct {
    thrum_integrator integrator;
    thrum_split_form form;
    int explicit_count; /* -1: as the def has it */
    double order;
  } all[] = {
      {THRUM_INTEGRATOR_ENERGY, THRUM_FORM_POSITION, -1, 2},
      {THRUM_INTEGRATOR_IMEXV, THRUM_FORM_POSITION, 4, 2},
      {THRUM_INTEGRATOR_IMEXV, THRUM_FORM_THESIS, 4, 2},
      {THRUM_INTEGRATOR_IMEXV, THRUM_FORM_QUADRATIC, -1, 2},
      {THRUM_INTEGRATOR_NEWMARK, THRUM_FORM_POSITION, -1, 2},
      {THRUM_INTEGRATOR_MIDPOINT, THRUM_FORM_POSITION, -1, 2},
      {THRUM_INTEGRATOR_VERLET, THRUM_FORM_POSITION, -1, 2},
      {THRUM_INTEGRATOR_FOX_GOODWIN, THRUM_FORM_POSITION, -1, 2},
      {THRUM_INTEGRATOR_RK4, THRUM_FORM_POSITION, -1, 2},
  };

  // the reference takes steps that are five and ten times as short
  const thrum_model *model = &made.found.model;
  const int64_t r = model->rank;
  const double span = 0.02, fine = 1e-5;
  double reference[64], q[64];
  thrum_state *state = state_of(model, THRUM_INTEGRATOR_RK4, fine);
  run_steps(model, state, fine, (int)(span / fine + 0.5), 1);
  assert_int_equal(thrum_state_get(model, state, reference, NULL, NULL), THRUM_OK);
  thrum_state_destroy(state);

  // half of the step leaves a quarter of the error
  for (size_t n = 0; n < sizeof all / sizeof *all; n++) {
    double off[2];
    for (int half = 0; half < 2; half++) {
      thrum_state_def def = thrum_default_state_def();
      thrum_error error = {0};
      def.integrator = all[n].integrator;
      def.split_form = all[n].form;
      def.dt = half ? 5e-5 : 1e-4;
      def.tolerance = 1e-10;
      if (all[n].explicit_count >= 0) {
        def.split_rule = THRUM_SPLIT_COUNT;
        def.explicit_count = all[n].explicit_count;
      }
      if (thrum_state_create(model, &def, &state, &error) < 0)
        fail_msg("%s", error.message);
      run_steps(model, state, def.dt, (int)(span / def.dt + 0.5), 1);
      assert_int_equal(thrum_state_get(model, state, q, NULL, NULL), THRUM_OK);
      for (int64_t i = 0; i < r; i++)
        q[i] -= reference[i];
      off[half] = norm_of(q, r) / norm_of(reference, r);
      thrum_state_destroy(state);
    }
    if (!(off[0] < 0.02 && off[1] < 0.32 * off[0]))
      fail_msg("integrator %d, form %d: errors %g and %g", (int)all[n].integrator, (int)all[n].form,
               off[0], off[1]);
  }
}

/* A level that stays begins with an energy of zero, as its own cancels what it does. No guard takes
 * the usual error of a scheme for growth beside that, and one beyond its limit is found. */
static void guards_know_what_actuators_exchange(void **unused) {
  (void)unused;
  static const struct {
    thrum_integrator integrator;
    thrum_split_form form;
    double pace; /* of the fastest mode, radians a step */
    bool grows;
  } all[] = {{THRUM_INTEGRATOR_IMEXV, THRUM_FORM_POSITION, 0.3, false},
             {THRUM_INTEGRATOR_IMEXV, THRUM_FORM_THESIS, 0.3, false},
             {THRUM_INTEGRATOR_NEWMARK, THRUM_FORM_POSITION, 0.3, false},
             {THRUM_INTEGRATOR_FOX_GOODWIN, THRUM_FORM_POSITION, 0.3, false},
             {THRUM_INTEGRATOR_VERLET, THRUM_FORM_POSITION, 0.3, false},
             {THRUM_INTEGRATOR_VERLET, THRUM_FORM_POSITION, 2.1, true}};
  const thrum_model *model = &made.found.model;
  double levels[ACTUATORS];
  for (int k = 0; k < ACTUATORS; k++)
    levels[k] = 0.1 * all_levels[k];

  for (size_t n = 0; n < sizeof all / sizeof *all; n++) {
    thrum_state_def def = thrum_default_state_def();
    thrum_error error = {0};
    thrum_state *state = NULL;
    def.integrator = all[n].integrator;
    def.split_form = all[n].form;
    def.dt = all[n].pace / sqrt(model->omega2[model->rank - 1]);
    if (thrum_state_create(model, &def, &state, &error) < 0)
      fail_msg("%s", error.message);
    assert_int_equal(thrum_state_set_actuation(model, state, levels, &error), THRUM_OK);
    for (int k = 0; k < (all[n].grows ? 8 : 100); k++)
      assert_true(thrum_step(model, state, &error) >= 0);
    const thrum_state_report report = thrum_state_report_get(state);
    if (report.switched_steps > 0 || (report.grown_steps > 0) != all[n].grows)
      fail_msg("case %zu: %lld steps switched, %lld grew", n, (long long)report.switched_steps,
               (long long)report.grown_steps);
    thrum_state_destroy(state);
  }
}

/* A batch and a snapshot step to the same bits. */
static void batches_and_snapshots_have_the_same_bits(void **unused) {
  (void)unused;
  const thrum_model *model = &made.found.model;
  thrum_state *states[3];
  thrum_error error = {0};
  size_t size = 0;
  for (int n = 0; n < 3; n++) {
    states[n] = state_of(model, THRUM_INTEGRATOR_IMEXV, 1e-3);
    run_steps(model, states[n], 1e-3, 10, 1);
  }
  assert_int_equal(thrum_batch_size(model, &size, &error), THRUM_OK);
  void *workspace = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_true(thrum_batch_step(model, states, 2, NULL, workspace, size, &error) >= 0);

  // the third goes on from a snapshot of its own
  const size_t bytes = thrum_state_snapshot_size(states[2]);
  void *memory = malloc(bytes);
  assert_int_equal(thrum_state_snapshot(states[2], memory, bytes, &error), THRUM_OK);
  run_steps(model, states[2], 1e-3, 5, 1);
  assert_int_equal(thrum_state_restore(model, states[2], memory, bytes, &error), THRUM_OK);
  assert_true(thrum_step(model, states[2], &error) >= 0);
  double q[2][64];
  thrum_state_get(model, states[0], q[0], NULL, NULL);
  for (int n = 1; n < 3; n++) {
    thrum_state_get(model, states[n], q[1], NULL, NULL);
    assert_memory_equal(q[0], q[1], (size_t)model->rank * sizeof(double));
  }
  assert_true(work_of(model, states[0]) == work_of(model, states[2]));
  free(memory);
  free(workspace);
  for (int n = 0; n < 3; n++)
    thrum_state_destroy(states[n]);
}

/* Boyle: where a gas is at rest against a body, pressure times volume is what it was. */
static void a_gas_follows_boyle(void **unused) {
  (void)unused;
  const thrum_model *model = &made.found.model;
  const int64_t r = model->rank;
  thrum_model acting;
  double levels[ACTUATORS] = {0, 5e3, 0, 0, 0, 0}, force[64], q[64] = {0}, size[ACTUATORS];
  double *memory = need((size_t)thrum_model_actuation_count(model), sizeof *memory);
  double *work = need((size_t)thrum_work_count(model), sizeof *work);
  assert_int_equal(thrum_model_actuate(model, levels, memory, &acting, NULL), THRUM_OK);
  for (int64_t i = 0; i < r; i++)
    q[i] = 0.01 * random_number();
  thrum_state *state = state_of(model, THRUM_INTEGRATOR_ENERGY, 1e-3);
  thrum_state_set(model, state, q, NULL, NULL);
  thrum_state_actuation_measures(model, state, size, NULL);

  // the same force by a pressure of (p + a) V0 / V less the one outside
  const double rest = model->actuator_rest[3], outside = model->actuator_rest[4];
  double same[64], gas[64];
  thrum_internal_force(&acting, q, gas, work);
  levels[0] = (outside + 5e3) * rest / size[1] - outside;
  levels[1] = 0;
  assert_int_equal(thrum_model_actuate(model, levels, memory, &acting, NULL), THRUM_OK);
  thrum_internal_force(&acting, q, same, work);

  // but for the gas, which acts at level 0 too
  levels[0] = outside * rest / size[1] - outside;
  assert_int_equal(thrum_model_actuate(model, levels, memory, &acting, NULL), THRUM_OK);
  thrum_internal_force(&acting, q, force, work);
  levels[0] = levels[1] = 0;
  assert_int_equal(thrum_model_actuate(model, levels, memory, &acting, NULL), THRUM_OK);
  double none[64];
  thrum_internal_force(&acting, q, none, work);
  double bare[64];
  thrum_internal_force(model, q, bare, work);
  for (int64_t i = 0; i < r; i++) {
    assert_true(fabs((same[i] - (none[i] - bare[i])) - gas[i]) < 1e-11 * norm_of(gas, r));
    assert_true(fabs((force[i] - bare[i]) - 2 * (none[i] - bare[i])) < 1e-11 * norm_of(gas, r));
  }
  free(work);
  free(memory);
  thrum_state_destroy(state);
}

static void what_cannot_act_is_refused(void **unused) {
  (void)unused;
  const thrum_model *model = &made.found.model;
  thrum_error error = {0};
  thrum_state *state = state_of(model, THRUM_INTEGRATOR_ENERGY, 1e-3);
  double levels[ACTUATORS] = {NAN};
  int64_t index = -1;
  assert_int_equal(thrum_state_set_actuation(model, state, levels, &error), THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "air"));
  levels[0] = 0;
  levels[1] = -3e4;
  assert_int_equal(thrum_state_set_actuation(model, state, levels, &error), THRUM_BAD_VALUE);
  assert_int_equal(thrum_model_actuator(model, "lid", &index, &error), THRUM_OK);
  assert_int_equal(index, 1);
  assert_int_equal(thrum_model_actuator(model, "li", &index, &error), THRUM_MISSING);
  assert_string_equal(thrum_model_actuator_text(model, 3), "heat=swell:1");
  assert_null(thrum_model_actuator_text(model, ACTUATORS));

  // a gas acts at level 0, where coordinates that follow at rest would not have it
  size_t size = 0;
  assert_int_equal(thrum_model_condense_size(model, 3, &size, &error), THRUM_UNSUPPORTED);
  assert_non_null(strstr(error.message, "gas"));

  // a body without any
  thrum_model plain = *model;
  plain.actuator_kind = NULL;
  plain.actuator_count = 0;
  double memory[1];
  assert_int_equal(thrum_model_actuation_count(&plain), 0);
  assert_int_equal(thrum_model_actuate(&plain, NULL, memory, &plain, &error), THRUM_UNSUPPORTED);
  thrum_state_destroy(state);
}

/* A larger body of the same levels, and one of fewer coordinates. */
static void scaled_and_cut_models_keep_their_actuators(void **unused) {
  (void)unused;
  const thrum_model *model = &made.found.model, *other = NULL;
  const int64_t r = model->rank;
  thrum_error error = {0};
  size_t size = 0;
  double *work = need((size_t)thrum_work_count(model), sizeof *work);
  double *memory = need((size_t)thrum_model_actuation_count(model), sizeof *memory);
  double q[64] = {0}, at[64], levels[ACTUATORS];
  memcpy(levels, all_levels, sizeof levels);
  thrum_model acting;
  for (int64_t i = 0; i < 4; i++)
    q[i] = 0.01 * random_number();
  thrum_model_actuate(model, levels, memory, &acting, NULL);
  const double energy = thrum_strain_energy(&acting, q, work);

  // all coordinates but four are zero
  assert_int_equal(thrum_model_lock_size(model, 4, &size, &error), THRUM_OK);
  void *block = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_int_equal(thrum_model_lock(block, size, model, 4, &other, &error), THRUM_OK);
  if (thrum_model_check(other, &error) < 0)
    fail_msg("%s", error.message);
  thrum_model_actuate(other, levels, memory, &acting, NULL);
  assert_true(fabs(thrum_strain_energy(&acting, q, work) / energy - 1) < 1e-12);
  free(block);

  // twice as long and half as dense, under the same pressures: every energy is 8 times as large
  const thrum_model_scaling by = {2, 1, 0.5};
  assert_int_equal(thrum_model_scale_size(model, &size, &error), THRUM_OK);
  block = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_int_equal(thrum_model_scale(block, size, model, &by, &other, &error), THRUM_OK);
  for (int64_t i = 0; i < r; i++)
    at[i] = q[i] * pow(2, 2.5) * sqrt(0.5);
  levels[5] *= 4;
  thrum_model_actuate(other, levels, memory, &acting, NULL);
  assert_true(fabs(thrum_strain_energy(&acting, at, work) / energy - 8) < 1e-11);
  free(block);
  free(memory);
  free(work);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(energy_is_the_work_of_the_actuators),
      cmocka_unit_test(setting_a_place_does_no_work),
      cmocka_unit_test(all_integrators_step_actuators),
      cmocka_unit_test(guards_know_what_actuators_exchange),
      cmocka_unit_test(batches_and_snapshots_have_the_same_bits),
      cmocka_unit_test(a_gas_follows_boyle),
      cmocka_unit_test(what_cannot_act_is_refused),
      cmocka_unit_test(scaled_and_cut_models_keep_their_actuators),
  };
  return cmocka_run_group_tests(tests, make, unmake);
}
