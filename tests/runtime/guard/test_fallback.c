/* Tests of the fallback chain (design 8): each level is taken where it must be, is counted, and
 * takes the step that it stands for; a step that fails on all levels leaves no trace.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

enum { RANK = 6, LOW = 2 };

static void make_model(random_model *m) {
  random_model_make(m, 21, RANK, 1.0, 12.0, 0.5);
}

/* With few iterations at a large step, some solves fail. */
static thrum_state_def make_def(thrum_integrator integrator, int32_t iterations) {
  thrum_state_def def = imexv_def();
  def.integrator = integrator;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = LOW;
  def.dt = 0.3;
  def.iterations_max = iterations;
  def.adaptive = 0;
  return def;
}

/* Makes `count` steps of dt/count by `integrator` from q, p under the load f, in place. */
static void shorter_steps(const thrum_model *model, thrum_state_def def,
                          thrum_integrator integrator, int count, const double *f, double *q,
                          double *p) {
  def.integrator = integrator;
  def.dt /= count;
  def.iterations_max = 200;
  def.fallback = 0;

  // so little damping has no effect, but its tangent form makes the steps use the mean force of the
  // path
  def.damping_form = THRUM_DAMPING_TANGENT;
  def.damping_beta = 1e-200;

  thrum_state *state = state_make(model, &def);
  state_put(model, state, q, p);
  state_push(model, state, f);
  state_steps(model, state, count);
  state_read(model, state, q, p);
  state_free(state);
}

typedef struct tally {
  int64_t energy, substeps, failed;
} tally;

/* Returns whether a fallback level's step equals `count` steps of `integrator`. */
static int equals_steps(const thrum_model *model, const thrum_state_def *def,
                        thrum_integrator integrator, int count, const double *f, double q[2][RANK],
                        double p[2][RANK]) {
  double q_other[RANK], p_other[RANK];
  memcpy(q_other, q[0], sizeof q_other);
  memcpy(p_other, p[0], sizeof p_other);
  shorter_steps(model, *def, integrator, count, f, q_other, p_other);
  double size = 0;
  for (int i = 0; i < RANK; i++)
    size = fmax(size, fabs(q[1][i]) + def->dt * fabs(p[1][i]));
  return largest_difference(q_other, q[1], RANK) < 1e-5 * size &&
         def->dt * largest_difference(p_other, p[1], RANK) < 1e-5 * size;
}

/* Runs under hard random kicks, and compares every step that a fallback level took with what it
 * stands for.
 */
static void climb(thrum_integrator integrator, int32_t iterations, uint64_t seed, tally *sum) {
  random_model m;
  make_model(&m);
  const thrum_state_def def = make_def(integrator, iterations);
  const thrum_integrator fallback_level =
      integrator == THRUM_INTEGRATOR_NEWMARK ? integrator : THRUM_INTEGRATOR_ENERGY;

  thrum_state *state = state_make(&m.model, &def);
  random_state random = {seed};
  for (int k = 0; k < 60; k++) {
    // a random state and load, the load large in every third step
    double f[RANK], q[2][RANK], p[2][RANK];
    random_vector(&random, RANK, 1.0, q[0]);
    random_vector(&random, RANK, 4.0, p[0]);
    random_vector(&random, RANK, k % 3 == 0 ? 60.0 : 1.0, f);

    state_put(&m.model, state, q[0], p[0]);
    state_push(&m.model, state, f);
    state_read(&m.model, state, q[0], p[0]);

    // the step, and the levels it took by the counters of the report
    const thrum_state_report before = thrum_state_report_get(state);
    const thrum_status status = thrum_step(&m.model, state, NULL);
    const thrum_state_report after = thrum_state_report_get(state);
    sum->failed += status < 0;
    if (status < 0)
      continue;

    const int64_t energy = after.energy_steps - before.energy_steps;
    const int64_t substeps = after.substep_steps - before.substep_steps;
    const int64_t newton = after.newton_steps - before.newton_steps;

    // what the step made of the energy goes before how it was made
    const bool grew = status == THRUM_ENERGY_GREW;
    assert_true(energy + substeps + newton <= 1);
    assert_true(grew || (status == THRUM_FELL_BACK) == (energy + substeps + newton == 1));

    // a step of the energy integrator, or of the state's own, is equal to one made by it alone
    state_read(&m.model, state, q[1], p[1]);
    if (energy > 0)
      assert_true(equals_steps(&m.model, &def, fallback_level, 1, f, q, p));

    // a step in parts is equal to some power of two of shorter ones
    int equal = substeps == 0;
    for (int count = 2; count <= 256 && !equal; count *= 2)
      equal = equals_steps(&m.model, &def, fallback_level, count, f, q, p);
    assert_true(equal);
  }

  const thrum_state_report report = thrum_state_report_get(state);
  sum->energy += report.energy_steps;
  sum->substeps += report.substep_steps;

  state_free(state);
  random_model_free(&m);
}

static void imexv_takes_one_energy_step_and_then_shorter_ones(void **context) {
  (void)context;
  tally sum = {0, 0, 0};
  for (int32_t iterations = 3; iterations <= 20; iterations++)
    for (uint64_t seed = 1; seed <= 3; seed++)
      climb(THRUM_INTEGRATOR_IMEXV, iterations, seed, &sum);
  if (sum.energy == 0 || sum.substeps == 0)
    fail_msg("%d energy steps, %d steps in parts", (int)sum.energy, (int)sum.substeps);
}

static void fox_goodwin_takes_one_energy_step_and_then_shorter_ones(void **context) {
  (void)context;
  tally sum = {0, 0, 0};
  for (int32_t iterations = 3; iterations <= 10; iterations++)
    climb(THRUM_INTEGRATOR_FOX_GOODWIN, iterations, 1, &sum);
  if (sum.energy == 0 || sum.substeps == 0)
    fail_msg("%d energy steps, %d steps in parts", (int)sum.energy, (int)sum.substeps);
}

static void newmark_and_energy_take_shorter_steps_of_their_own(void **context) {
  (void)context;
  static const thrum_integrator own[2] = {THRUM_INTEGRATOR_NEWMARK, THRUM_INTEGRATOR_ENERGY};
  for (int n = 0; n < 2; n++) {
    tally sum = {0, 0, 0};
    for (int32_t iterations = 2; iterations <= 5; iterations++)
      climb(own[n], iterations, 3, &sum);
    assert_int_equal(sum.energy, 0);
    assert_true(sum.substeps > 0);
  }
}

static void verlet_and_midpoint_have_no_fallback(void **context) {
  (void)context;
  tally sum = {0, 0, 0};
  climb(THRUM_INTEGRATOR_MIDPOINT, 2, 1, &sum);
  assert_int_equal(sum.energy + sum.substeps, 0);
  assert_true(sum.failed > 0);
}

static void without_the_fallback_the_same_run_fails(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  int64_t failed[2] = {0, 0};
  for (int fallback = 0; fallback < 2; fallback++) {
    thrum_state_def def = make_def(THRUM_INTEGRATOR_IMEXV, 3);
    def.fallback = fallback;

    thrum_state *state = state_make(&m.model, &def);

    // the same loads both times
    random_state random = {1};
    for (int k = 0; k < 60; k++) {
      double f[RANK];
      random_vector(&random, RANK, 60.0, f);
      state_push(&m.model, state, f);
      failed[fallback] += thrum_step(&m.model, state, NULL) < 0;
    }

    state_free(state);
  }

  // the fallback saves at least half of the steps that failed
  assert_true(failed[0] > 10 && failed[1] < failed[0] / 2);
  random_model_free(&m);
}

/* Under loads that no fallback level can follow every byte stays, and the state steps on later. */
static void a_step_that_no_fallback_solves_leaves_every_byte(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  static const double hopeless[3] = {1e160, 1e250, 1e305};
  for (int integrator = 0; integrator < INTEGRATOR_COUNT; integrator++)
    for (int form = THRUM_FORM_THESIS; form <= THRUM_FORM_POSITION; form++)
      for (int n = 0; n < 3; n++) {
        thrum_state_def def = make_def((thrum_integrator)integrator, 50);
        def.adaptive = 1;
        def.dt = 0.02;
        def.split_form = (thrum_split_form)form;

        thrum_state *state = state_make(&m.model, &def);

        // some gentle steps, then a load of extreme size
        const double gentle[RANK] = {0.1, 0.2}, f[RANK] = {0, hopeless[n], 0, -hopeless[n], 0, 1};
        state_push(&m.model, state, gentle);
        state_steps(&m.model, state, 20);
        state_push(&m.model, state, f);

        // an explicit force may overflow one step later
        thrum_status status = THRUM_OK;
        void *kept = NULL;
        for (int k = 0; k < 3 && status >= 0; k++) {
          free(kept);
          kept = state_snapshot(state);
          status = thrum_step(&m.model, state, NULL);
        }

        // the failed step left the bytes of the snapshot before it
        assert_true(status == THRUM_NOT_FINITE || status == THRUM_NOT_CONVERGED);
        assert_memory_equal(state, kept, thrum_state_kept_bytes(state));

        // set again, under a gentle load, the state steps on
        state_put(&m.model, state, NULL, NULL);
        state_push(&m.model, state, gentle);
        state_steps(&m.model, state, 5);

        free(kept);
        state_free(state);
      }
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(imexv_takes_one_energy_step_and_then_shorter_ones),
      cmocka_unit_test(fox_goodwin_takes_one_energy_step_and_then_shorter_ones),
      cmocka_unit_test(newmark_and_energy_take_shorter_steps_of_their_own),
      cmocka_unit_test(verlet_and_midpoint_have_no_fallback),
      cmocka_unit_test(without_the_fallback_the_same_run_fails),
      cmocka_unit_test(a_step_that_no_fallback_solves_leaves_every_byte),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
