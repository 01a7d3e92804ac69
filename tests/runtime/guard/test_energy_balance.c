/* The energy balance of the integrators without an account of their own: what a step says of a
 * state whose energy nothing explains, and what a monitored fox-goodwin does about it.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "core/state/state_layout.h"

enum { RANK = 4, LATE = 16 };

static thrum_state_def make_def(thrum_integrator integrator, double dt) {
  thrum_state_def def = imexv_def();
  def.integrator = integrator;
  def.dt = dt;
  return def;
}

/* --- growth is said -------------------------------------------------------------------------- */

/* Steps until the energy is beyond `limit` times the first, with the statuses on the way right:
 * before it has doubled nothing is said of it, and LATE steps after it has it is. */
static void check_growth(const thrum_model *model, const thrum_state_def *def, double limit) {
  thrum_state *state = state_make(model, def);
  const double p[RANK] = {0.3, 0.2, -0.1, 0.2};
  state_put(model, state, NULL, p);
  const double first = state_energy(model, state).total;
  int64_t doubled = -1, said = -1;
  for (int64_t k = 0; k < 100000; k++) {
    const thrum_status status = thrum_step(model, state, NULL);
    assert_true(status >= 0);
    if (said < 0 && status == THRUM_ENERGY_GREW)
      said = k;

    // never before the energy that is to be seen has doubled
    const double energy = state_energy(model, state).total;
    if (doubled < 0 && energy > 2.0 * first)
      doubled = k;
    if (doubled < 0)
      assert_int_equal(status, THRUM_OK);
    if (energy > limit * first)
      break;
  }
  assert_true(doubled >= 0 && said >= doubled && said <= doubled + LATE);
  assert_true(thrum_state_report_get(state).grown_steps > 0);

  // a start at rest is another motion
  state_put(model, state, NULL, NULL);
  assert_int_equal(thrum_step(model, state, NULL), THRUM_OK);
  state_free(state);
}

static void a_state_that_gains_energy_by_itself_says_so(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 3, RANK, 10.0, 25.0, INFINITY);

  // explicit modes beyond their limit, h omega = 2.05 and 2.9
  thrum_state_def def = make_def(THRUM_INTEGRATOR_VERLET, 2.05 / 25.0);
  check_growth(&m.model, &def, 1e100);
  def = make_def(THRUM_INTEGRATOR_RK4, 2.9 / 25.0);
  check_growth(&m.model, &def, 1e100);

  // Newmark with too small a gamma, and imexv with the thesis' rule for its split
  def = make_def(THRUM_INTEGRATOR_NEWMARK, 0.02);
  def.newmark_gamma = 0.45;
  check_growth(&m.model, &def, 1e100);
  def = make_def(THRUM_INTEGRATOR_IMEXV, 2.05 / 25.0);
  def.split_rule = THRUM_SPLIT_SAMPLING;
  def.adaptive = 0;
  check_growth(&m.model, &def, 1e100);
  random_model_free(&m);
}

static void damping_does_not_hide_growth(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 3, RANK, 10.0, 25.0, INFINITY);
  thrum_state_def def = make_def(THRUM_INTEGRATOR_VERLET, 2.2 / 25.0);
  def.damping_alpha = 1e-3;
  check_growth(&m.model, &def, 1e60);
  random_model_free(&m);
}

/* --- and nothing else is --------------------------------------------------------------------- */

static void motion_that_loads_and_damping_explain_is_not_growth(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 5, RANK, 3.0, 20.0, 4.0);
  for (int n = 0; n < INTEGRATOR_COUNT; n++)
    for (int damped = 0; damped < 3; damped++)
      for (int driven = 0; driven < 3; driven++) {
        thrum_state_def def = make_def(every_integrator[n], 0.02);
        def.damping_alpha = damped ? 0.5 : 0.0;
        def.damping_beta = damped ? 0.002 : 0.0;
        def.damping_form = damped == 2 ? THRUM_DAMPING_TANGENT : THRUM_DAMPING_REST;
        thrum_state *state = state_make(&m.model, &def);

        // constant, near resonance with the first mode, and one kick after another
        for (int64_t k = 0; k < 6000; k++) {
          const double t = (double)k * def.dt;
          const double along = driven == 0   ? 1.0
                               : driven == 1 ? 0.5 * sin(2.9 * t)
                                             : 40.0 * (k % 500 == 0) * (k % 1000 ? -1.0 : 1.0);
          const double force[RANK] = {along, 0.5 * along, 0.2 * along, 0.1 * along};
          state_push(&m.model, state, force);
          const thrum_status status = thrum_step(&m.model, state, NULL);
          if (status != THRUM_OK)
            fail_msg("%s, damping %d, load %d, step %lld: %s",
                     thrum_integrator_name(def.integrator), damped, driven, (long long)k,
                     thrum_status_text(status));
        }
        assert_int_equal(thrum_state_report_get(state).grown_steps, 0);
        state_free(state);
      }
  random_model_free(&m);
}

/* --- fox-goodwin ----------------------------------------------------------------------------- */

static void fox_goodwin_gives_way_before_it_is_lost(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 11, RANK, 4.0, 18.0, 0.5);
  const double p[RANK] = {14.0, 8.0, -6.0, 9.0};
  for (int adaptive = 0; adaptive < 2; adaptive++) {
    thrum_state_def def = make_def(THRUM_INTEGRATOR_FOX_GOODWIN, 0.05);
    def.adaptive = adaptive;
    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, NULL, p);
    const double first = state_energy(&m.model, state).total;

    double worst = 0.0;
    thrum_status last = THRUM_OK;
    for (int k = 0; k < 4000 && worst < 1e6; k++) {
      last = thrum_step(&m.model, state, NULL);
      assert_true(last >= 0);
      worst = fmax(worst, fabs(state_energy(&m.model, state).total / first - 1.0));
    }

    // alone it says that it is lost; monitored it is never far off
    const thrum_state_report report = thrum_state_report_get(state);
    if (!adaptive) {
      assert_true(worst > 1.0 && last == THRUM_ENERGY_GREW && report.switched_steps == 0);
    } else {
      assert_true(worst < 0.35);
      assert_int_equal(last, THRUM_SWITCHED);
      assert_int_equal(report.scheme, THRUM_SCHEME_ENERGY);
      assert_int_equal(report.first_switch + report.switched_steps, report.steps);
      assert_true(fabs(state_energy(&m.model, state).total / first - 1.0) < 1e-9);

      // a new start is its own again
      const double gentle[RANK] = {0.01, 0.0, 0.0, 0.0};
      state_put(&m.model, state, NULL, gentle);
      assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_OK);
      assert_int_equal(thrum_state_report_get(state).scheme, THRUM_SCHEME_FOX_GOODWIN);
    }
    state_free(state);
  }
  random_model_free(&m);
}

/* Energy of the fastest kind of loss: a load of six orders of magnitude comes in gentle motion, and
 * the energy grows a thousandfold in two steps. No status may call that done. */
static void no_status_hides_what_a_sudden_load_spoils(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 11, RANK, 4.0, 18.0, 0.5);
  random_state random = {17};
  int switched = 0;
  for (int n = 0; n < 300; n++) {
    thrum_state_def def = make_def(THRUM_INTEGRATOR_FOX_GOODWIN, 0.02);
    thrum_state *state = state_make(&m.model, &def);
    double p[RANK], q[2][RANK] = {{0}}, force[RANK] = {0}, explained, moved = 0.0, scale;
    random_vector(&random, RANK, pow(10.0, random_uniform(&random)), p);
    state_put(&m.model, state, NULL, p);
    explained = scale = state_energy(&m.model, state).total;

    const double load = pow(10.0, 3.0 + 2.0 * random_uniform(&random));
    for (int k = 0; k < 120; k++) {
      if (k >= 24 && k % 8 == 0)
        random_vector(&random, RANK, load, force);
      state_push(&m.model, state, force);
      const thrum_status status = thrum_step(&m.model, state, NULL);
      assert_true(status >= 0);
      state_read(&m.model, state, q[1], NULL);
      double work = 0.0;
      for (int i = 0; i < RANK; i++) {
        work += force[i] * (q[1][i] - q[0][i]);
        q[0][i] = q[1][i];
      }

      // what the loads explain, with an allowance of twice what the balance has
      explained += work;
      moved += fabs(work);
      scale = fmax(scale, explained);
      const double error = state_energy(&m.model, state).total - explained - 0.2 * moved;
      if (error > 1.5 * scale && status != THRUM_ENERGY_GREW)
        fail_msg("run %d, step %d: %g J beyond %g J, and the step says: %s", n, k, error, scale,
                 thrum_status_text(status));
    }
    switched += thrum_state_report_get(state).switched_steps > 0;
    state_free(state);
  }
  assert_true(switched > 50);
  random_model_free(&m);
}

/* Where a switch does not explain the energy at once, the balance goes on, and has each step. */
static void the_step_of_a_switch_is_in_the_balance(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 11, RANK, 4.0, 18.0, 0.5);
  random_state random = {17};
  int compared = 0;
  for (int n = 0; n < 1500; n++) {
    const thrum_state_def def = make_def(THRUM_INTEGRATOR_FOX_GOODWIN, 0.02);
    thrum_state *state = state_make(&m.model, &def);
    double p[RANK], q[2][RANK] = {{0}}, force[RANK] = {0};
    random_vector(&random, RANK, pow(10.0, random_uniform(&random)), p);
    state_put(&m.model, state, NULL, p);

    // the loads come one after the other, until the switch
    const double load = pow(10.0, 3.0 + 2.0 * random_uniform(&random));
    int64_t switched = 0;
    double explained = 0.0;
    for (int k = 0; k < 120 && switched == 0; k++) {
      if (k >= 24 && k % 8 == 0)
        random_vector(&random, RANK, load, force);
      explained = state->balance.explained;
      state_push(&m.model, state, force);
      assert_true(thrum_step(&m.model, state, NULL) >= 0);
      state_read(&m.model, state, q[1], NULL);
      for (int i = 0; i < RANK; i++)
        explained += force[i] * (q[1][i] - q[0][i]);
      memcpy(q[0], q[1], sizeof q[0]);
      switched = thrum_state_report_get(state).switched_steps;
    }

    if (switched > 0 && state->balance.grew) {
      assert_true(fabs(state->balance.explained / explained - 1.0) < 1e-12);
      compared++;
    }
    state_free(state);
  }
  assert_true(compared > 2);
  random_model_free(&m);
}

static void a_snapshot_of_a_switched_state_goes_on_with_the_same_bits(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 11, RANK, 4.0, 18.0, 0.5);
  const double p[RANK] = {14.0, 8.0, -6.0, 9.0};
  const thrum_state_def def = make_def(THRUM_INTEGRATOR_FOX_GOODWIN, 0.05);
  thrum_state *state = state_make(&m.model, &def), *other = state_make(&m.model, &def);
  state_put(&m.model, state, NULL, p);
  state_steps(&m.model, state, 300);
  assert_int_equal(thrum_state_report_get(state).scheme, THRUM_SCHEME_ENERGY);

  // in another state it goes on as in the first
  const size_t size = thrum_state_snapshot_size(state);
  void *memory = malloc(size);
  assert_non_null(memory);
  assert_int_equal(thrum_state_snapshot(state, memory, size, NULL), THRUM_OK);
  assert_int_equal(thrum_state_restore(&m.model, other, memory, size, NULL), THRUM_OK);
  state_steps(&m.model, state, 50);
  state_steps(&m.model, other, 50);
  assert_memory_equal(state, other, thrum_state_kept_bytes(state));
  free(memory);
  state_free(other);
  state_free(state);
  random_model_free(&m);
}

/* Steps a driven body until it says that it has grown; returns its largest energy. */
static double drive(const thrum_model *model, double gamma, double alpha, double load, bool *said,
                    bool *anew) {
  thrum_state_def def = make_def(THRUM_INTEGRATOR_NEWMARK, 0.02);
  def.newmark_gamma = gamma;
  def.damping_alpha = alpha;
  thrum_state *state = state_make(model, &def);
  const double p[RANK] = {0.3, 0.2, -0.1, 0.2};
  state_put(model, state, NULL, p);
  double most = state_energy(model, state).total;

  *said = *anew = false;
  for (int64_t k = 0; k < 4000 && !*said; k++) {
    const double along = load * sin(2.9 * def.dt * (double)k);
    const double force[RANK] = {along, 0.5 * along, 0.2 * along, 0.1 * along};
    state_push(model, state, force);
    *said = thrum_step(model, state, NULL) == THRUM_ENERGY_GREW;
    *anew = *anew || state->balance.begin != 0;
    most = fmax(most, state_energy(model, state).total);
  }
  state_free(state);
  return most;
}

/* Once loads and damping have moved ten times the energy the balance begins anew. Newmark's method
 * with gamma < 1/2 feeds in a little more or less than damping takes, the slowest growth there is:
 * either the state says so, or its energy stays what it is with gamma = 1/2. */
static void a_balance_that_begins_anew_hides_no_growth(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 3, RANK, 10.0, 25.0, INFINITY);
  int found = 0, found_anew = 0;

  // gamma = 1/2 is the run that cannot grow; slightly below it does
  for (double load = 0.0; load < 15.0; load += 2.0)
    for (double alpha = 0.05; alpha < 0.5; alpha += 0.05) {
      bool said, anew;
      const double stable = drive(&m.model, 0.5, alpha, load, &said, &anew);
      assert_false(said);
      const double most = drive(&m.model, 0.47, alpha, load, &said, &anew);
      assert_true(said || most < 3.0 * stable);
      found += said;
      found_anew += said && anew;
    }
  assert_true(found > 40 && found_anew > 30);
  random_model_free(&m);
}

static void heavy_damping_makes_no_energy(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 11, RANK, 4.0, 18.0, 0.5);
  const double q[RANK] = {0.2, 0.1, -0.1, 0.05};

  // from damping by 1/s to damping within a step
  for (double alpha = 1.0; alpha < 1e7; alpha *= 10.0) {
    thrum_state_def def = make_def(THRUM_INTEGRATOR_FOX_GOODWIN, 0.05);
    def.adaptive = 0;
    def.damping_alpha = alpha;
    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, q, NULL);
    const double first = state_energy(&m.model, state).total;
    for (int k = 0; k < 200; k++) {
      assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_OK);
      if (!(state_energy(&m.model, state).total < 1.02 * first))
        fail_msg("alpha %g, step %d: %g J of %g J", alpha, k, state_energy(&m.model, state).total,
                 first);
    }
    state_free(state);
  }
  random_model_free(&m);
}

/* Staggered momenta that heavy damping turns round in every step dissipate next to nothing there.
 */
static void heavy_damping_of_staggered_modes_is_no_growth(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 11, RANK, 4.0, 18.0, 0.5);
  const double q[RANK] = {0.2, 0.1, -0.1, 0.05};

  // up to damping times of a ten thousandth of a step
  for (double beta = 1e-2; beta < 1e4; beta *= 10.0) {
    thrum_state_def def = make_def(THRUM_INTEGRATOR_VERLET, 0.05);
    def.damping_beta = beta;
    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, q, NULL);
    const double first = state_energy(&m.model, state).total;
    for (int k = 0; k < 200; k++)
      if (thrum_step(&m.model, state, NULL) != THRUM_OK)
        fail_msg("beta %g s, step %d: %g J of %g J", beta, k, state_energy(&m.model, state).total,
                 first);

    // what is gone has been dissipated, but for the zigzag of q that the start leaves
    const double lost = first - state_energy(&m.model, state).total;
    const double dissipated = thrum_state_report_get(state).dissipated;
    assert_true(fabs(lost - dissipated) <= 0.25 * lost);
    state_free(state);
  }
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_state_that_gains_energy_by_itself_says_so),
      cmocka_unit_test(damping_does_not_hide_growth),
      cmocka_unit_test(motion_that_loads_and_damping_explain_is_not_growth),
      cmocka_unit_test(fox_goodwin_gives_way_before_it_is_lost),
      cmocka_unit_test(no_status_hides_what_a_sudden_load_spoils),
      cmocka_unit_test(the_step_of_a_switch_is_in_the_balance),
      cmocka_unit_test(a_snapshot_of_a_switched_state_goes_on_with_the_same_bits),
      cmocka_unit_test(a_balance_that_begins_anew_hides_no_growth),
      cmocka_unit_test(heavy_damping_makes_no_energy),
      cmocka_unit_test(heavy_damping_of_staggered_modes_is_no_growth),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
