/* A library of the core alone, thrum_core, steps a model: this program links that and libm, and
 * nothing of the runtime. The invariants are those of the schemes (design 5 to 7); a def that asks
 * for what stands above the core is refused.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

/* A def without guards, for this integrator. */
static thrum_state_def def_of(thrum_integrator integrator) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = integrator;
  def.adaptive = def.fallback = def.frequency_matched = 0;
  def.dt = 0.01;
  def.tolerance = 1e-13;
  return def;
}

/* A body of six modes, displaced in the first ones. */
static thrum_state *displaced(const random_model *m, const thrum_state_def *def) {
  double q[RANK_MAX] = {0.02, -0.01, 0.005};
  thrum_state *state;
  thrum_error error;
  assert_int_equal(thrum_state_create(&m->model, def, &state, &error), THRUM_OK);
  assert_int_equal(thrum_state_set(&m->model, state, q, NULL, &error), THRUM_OK);
  return state;
}

static double energy_of(const random_model *m, thrum_state *state) {
  thrum_energies energies;
  assert_int_equal(thrum_state_energies(&m->model, state, &energies, NULL), THRUM_OK);
  return energies.total;
}

static void make(random_model *m) {
  random_model_make(m, 7, 6, 2.0, 60.0, 1.0);
}

/* The largest energy error in 400 steps, over the energy. */
static double energy_error(thrum_integrator integrator) {
  random_model m;
  make(&m);
  const thrum_state_def def = def_of(integrator);
  thrum_state *state = displaced(&m, &def);
  const double start = energy_of(&m, state);
  double most = 0;
  for (int n = 0; n < 400; n++) {
    assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_OK);
    most = fmax(most, fabs(energy_of(&m, state) - start));
  }
  thrum_state_destroy(state);
  random_model_free(&m);
  return most / start;
}

static void energy_keeps_the_energy(void **unused) {
  (void)unused;
  assert_true(energy_error(THRUM_INTEGRATOR_ENERGY) < 1e-11);
}

static void imexv_and_newmark_stay_near_the_energy(void **unused) {
  (void)unused;
  assert_true(energy_error(THRUM_INTEGRATOR_IMEXV) < 0.1);
  assert_true(energy_error(THRUM_INTEGRATOR_NEWMARK) < 0.1);
}

/* Stoermer-Verlet, the midpoint rule and their composition are reversible (Hairer, Lubich & Wanner
 * 2006, V.1): with the momentum turned round, as many steps lead back to where they began. */
static void imexv_steps_back_to_its_start(void **unused) {
  (void)unused;
  random_model m;
  make(&m);
  const thrum_state_def def = def_of(THRUM_INTEGRATOR_IMEXV);
  thrum_state *state = displaced(&m, &def);
  double begun[RANK_MAX], q[RANK_MAX], p[RANK_MAX];
  assert_int_equal(thrum_state_get(&m.model, state, begun, NULL, NULL), THRUM_OK);
  for (int n = 0; n < 2; n++) {
    assert_int_equal(thrum_steps(&m.model, state, 50, NULL, NULL), THRUM_OK);
    assert_int_equal(thrum_state_get(&m.model, state, q, p, NULL), THRUM_OK);
    for (int i = 0; i < m.model.rank; i++)
      p[i] = -p[i];
    if (n == 0)
      assert_int_equal(thrum_state_set(&m.model, state, q, p, NULL), THRUM_OK);
  }
  for (int i = 0; i < m.model.rank; i++)
    assert_true(fabs(q[i] - begun[i]) < 1e-9);
  thrum_state_destroy(state);
  random_model_free(&m);
}

static void a_snapshot_steps_to_the_same_bits(void **unused) {
  (void)unused;
  random_model m;
  make(&m);
  const thrum_state_def def = def_of(THRUM_INTEGRATOR_ENERGY);
  thrum_state *state = displaced(&m, &def);
  assert_int_equal(thrum_steps(&m.model, state, 20, NULL, NULL), THRUM_OK);
  const size_t size = thrum_state_snapshot_size(state);
  void *bytes = malloc(size);
  assert_int_equal(thrum_state_snapshot(state, bytes, size, NULL), THRUM_OK);

  double first[RANK_MAX], second[RANK_MAX];
  assert_int_equal(thrum_steps(&m.model, state, 20, NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_state_get(&m.model, state, first, NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_state_restore(&m.model, state, bytes, size, NULL), THRUM_OK);
  assert_int_equal(thrum_steps(&m.model, state, 20, NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_state_get(&m.model, state, second, NULL, NULL), THRUM_OK);
  assert_memory_equal(first, second, (size_t)m.model.rank * sizeof(double));
  free(bytes);
  thrum_state_destroy(state);
  random_model_free(&m);
}

/* The refusal names the member of the def. */
static void refuses(const random_model *m, const thrum_state_def *def, const char *name) {
  thrum_state *state;
  thrum_error error;
  assert_int_equal(thrum_state_create(&m->model, def, &state, &error), THRUM_UNSUPPORTED);
  assert_int_equal(strncmp(error.message, name, strlen(name)), 0);
}

static void what_is_above_the_core_is_refused(void **unused) {
  (void)unused;
  random_model m;
  make(&m);
  thrum_state_def def = def_of(THRUM_INTEGRATOR_RK4);
  refuses(&m, &def, "integrator");
  def = def_of(THRUM_INTEGRATOR_IMEXV);
  def.split_form = THRUM_FORM_QUADRATIC;
  refuses(&m, &def, "integrator");

  // guards
  def = def_of(THRUM_INTEGRATOR_IMEXV);
  def.adaptive = 1;
  refuses(&m, &def, "adaptive");
  def = def_of(THRUM_INTEGRATOR_NEWMARK);
  def.fallback = 1;
  refuses(&m, &def, "fallback");
  def = def_of(THRUM_INTEGRATOR_ENERGY);
  def.frequency_matched = 1;
  refuses(&m, &def, "frequency_matched");
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(energy_keeps_the_energy),
      cmocka_unit_test(imexv_and_newmark_stay_near_the_energy),
      cmocka_unit_test(imexv_steps_back_to_its_start),
      cmocka_unit_test(a_snapshot_steps_to_the_same_bits),
      cmocka_unit_test(what_is_above_the_core_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
