/* Tests of the position form of imexv (design (7)): its equations, its ends, the exact solution of
 * a linear body, its symplectic and reversible step, momenta at whole steps, and its monitor.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"
#include "thrum/polynomial.h"

enum { RANK = 6, LOW = 2 };

static const double start_q[RANK] = {0.3, -0.1, 0.15, 0.05, -0.04, 0.02};
static const double start_p[RANK] = {-0.2, 0.4, 0.1, -0.3, 0.2, 0.1};
static const double push[RANK] = {0.5, -0.4, 0.3, -0.2, 0.1, 0.6};

static void make_model(random_model *m) {
  random_model_make(m, 21, RANK, 1.0, 12.0, 0.5);
}

static thrum_state_def make_def(int32_t explicit_count, double dt) {
  thrum_state_def def = imexv_def();
  def.split_form = THRUM_FORM_POSITION;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = explicit_count;
  def.dt = dt;
  def.adaptive = def.fallback = 0;
  def.tolerance = 1e-14;
  return def;
}

/* --- its equations ---------------------------------------------------------------------------- */

/* Makes step (7) as it is written, with damping at rest; the implicit modes by a fixed point, which
 * converges for small h omega. */
static void plain_step(const thrum_model *model, const thrum_state_def *def, double *q, double *p,
                       const double *f, double *work) {
  const double h = def->dt;
  double middle[RANK], force[RANK], d[RANK] = {0};
  for (int i = 0; i < RANK; i++)
    middle[i] = i < def->explicit_count ? q[i] + h / 2 * p[i] : 0;

  // the implicit modes see the explicit ones at the middle of the step
  for (int k = 0; k < 200; k++) {
    for (int i = def->explicit_count; i < RANK; i++)
      middle[i] = q[i] + d[i] / 2;
    thrum_internal_force(model, middle, force, work);
    for (int i = def->explicit_count; i < RANK; i++) {
      const double damping = def->damping_alpha + def->damping_beta * model->omega2[i];
      d[i] = h * p[i] - h * h / 2 * (force[i] + damping * d[i] / h - f[i]);
    }
  }

  // with the force there both halves of the step follow
  for (int i = 0; i < RANK; i++) {
    const double damping = def->damping_alpha + def->damping_beta * model->omega2[i];
    if (i < def->explicit_count) {
      p[i] = ((1 - h / 2 * damping) * p[i] - h * (force[i] - f[i])) / (1 + h / 2 * damping);
      q[i] = middle[i] + h / 2 * p[i];
    } else {
      q[i] += d[i];
      p[i] = 2 * d[i] / h - p[i];
    }
  }
}

static void it_equals_its_equations_for_every_split(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof(double));
  for (int split = 0; split <= RANK; split++) {
    thrum_state_def def = make_def(split, 0.05);
    def.damping_alpha = 0.1;
    def.damping_beta = 0.005;

    // the plain equations and the state start alike
    thrum_state *state = state_make(&m.model, &def);
    double q[RANK], p[RANK], q_now[RANK], p_now[RANK];
    memcpy(q, start_q, sizeof q);
    memcpy(p, start_p, sizeof p);
    state_put(&m.model, state, start_q, start_p);
    state_push(&m.model, state, push);

    for (int k = 0; k < 100; k++) {
      plain_step(&m.model, &def, q, p, push, work);
      state_steps(&m.model, state, 1);
      state_read(&m.model, state, q_now, p_now);
      assert_true(largest_difference(q, q_now, RANK) < 1e-11);
      assert_true(largest_difference(p, p_now, RANK) < 1e-10);
    }

    state_free(state);
  }
  free(work);
  random_model_free(&m);
}

/* The q of verlet are the midpoints of the drifts, as its momenta are half a step before its q. */
static void without_implicit_modes_it_is_verlet_half_a_drift_later(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof(double));
  thrum_state_def def = make_def(RANK, 0.02);
  thrum_state *position = state_make(&m.model, &def);
  def.integrator = THRUM_INTEGRATOR_VERLET;
  thrum_state *verlet = state_make(&m.model, &def);

  // p of verlet half a step before its q is the p of the position form
  double middle[RANK], p[RANK], q[RANK], force[RANK], now[RANK];
  for (int i = 0; i < RANK; i++)
    middle[i] = start_q[i] + def.dt / 2 * start_p[i];
  thrum_internal_force(&m.model, middle, force, work);
  for (int i = 0; i < RANK; i++)
    p[i] = start_p[i] - def.dt / 2 * force[i];
  state_put(&m.model, position, start_q, start_p);
  state_put(&m.model, verlet, middle, p);

  for (int k = 0; k < 300; k++) {
    state_steps(&m.model, position, 1);
    state_steps(&m.model, verlet, 1);
    state_read(&m.model, position, q, p);
    state_read(&m.model, verlet, now, NULL);
    for (int i = 0; i < RANK; i++)
      middle[i] = q[i] + def.dt / 2 * p[i];
    assert_true(largest_difference(middle, now, RANK) < 1e-11);
  }

  state_free(position);
  state_free(verlet);
  free(work);
  random_model_free(&m);
}

static void without_explicit_modes_it_is_midpoint_bit_for_bit(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(0, 0.1);
  def.damping_alpha = 0.05;
  thrum_state *position = state_make(&m.model, &def);
  def.integrator = THRUM_INTEGRATOR_MIDPOINT;
  thrum_state *midpoint = state_make(&m.model, &def);

  // the same start, load and number of steps
  double q[2][RANK], p[2][RANK];
  state_put(&m.model, position, start_q, start_p);
  state_put(&m.model, midpoint, start_q, start_p);
  state_push(&m.model, position, push);
  state_push(&m.model, midpoint, push);
  state_steps(&m.model, position, 300);
  state_steps(&m.model, midpoint, 300);
  state_read(&m.model, position, q[0], p[0]);
  state_read(&m.model, midpoint, q[1], p[1]);
  assert_memory_equal(q[0], q[1], sizeof q[0]);
  assert_memory_equal(p[0], p[1], sizeof p[0]);

  state_free(position);
  state_free(midpoint);
  random_model_free(&m);
}

/* An explicit mode turns by 2 asin(h omega/2) a step, on an ellipse of its own, and an implicit one
 * by 2 atan(h omega/2) on the exact one. */
static void a_linear_body_follows_the_closed_form(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 1, RANK, 1.0, 30.0, INFINITY);
  const thrum_state_def def = make_def(LOW, 0.2);
  thrum_state *state = state_make(&m.model, &def);
  state_put(&m.model, state, start_q, start_p);

  // the closed form holds at any step, not only at the end
  for (int k = 1; k <= 500; k++) {
    double q[RANK], p[RANK];
    state_steps(&m.model, state, 1);
    state_read(&m.model, state, q, p);
    for (int i = 0; i < RANK; i++) {
      const double omega = sqrt(m.omega2[i]), half = def.dt * omega / 2;
      const double turn = 2 * k * (i < LOW ? asin(half) : atan(half));
      const double flat = i < LOW ? sqrt(1 - half * half) : 1;
      const double q_exact = start_q[i] * cos(turn) + flat * start_p[i] / omega * sin(turn);
      const double p_exact = start_p[i] * cos(turn) - start_q[i] * omega / flat * sin(turn);
      assert_true(fabs(q[i] - q_exact) < 1e-11 && fabs(p[i] - p_exact) < 1e-10);
    }
  }

  state_free(state);
  random_model_free(&m);
}

/* --- its geometry ----------------------------------------------------------------------------- */

static void step_map(const thrum_model *model, thrum_state *state, const double *z, double *image) {
  state_put(model, state, z, z + RANK);
  state_steps(model, state, 1);
  state_read(model, state, image, image + RANK);
}

/* Computes the largest entry of A^T J A - J, where A is the Jacobian of a step by differences of
 * order 6. */
static double symplectic_defect(int32_t split) {
  static const double weight[3] = {3. / 4, -3. / 20, 1. / 60};
  random_model m;
  make_model(&m);
  const thrum_state_def def = make_def(split, 0.1);
  thrum_state *state = state_make(&m.model, &def);

  // column by column, the derivative by each coordinate of (q, p)
  double jacobian[2 * RANK][2 * RANK], worst = 0;
  const double s = 4e-3;
  for (int j = 0; j < 2 * RANK; j++) {
    double column[2 * RANK] = {0};
    for (int n = 0; n < 3; n++)
      for (int side = -1; side <= 1; side += 2) {
        double z[2 * RANK], image[2 * RANK];
        memcpy(z, start_q, sizeof start_q);
        memcpy(z + RANK, start_p, sizeof start_p);
        z[j] += side * (n + 1) * s;
        step_map(&m.model, state, z, image);
        for (int i = 0; i < 2 * RANK; i++)
          column[i] += side * weight[n] * image[i] / s;
      }
    for (int i = 0; i < 2 * RANK; i++)
      jacobian[i][j] = column[i];
  }

  // A^T J A - J with J = (0 1; -1 0)
  for (int a = 0; a < 2 * RANK; a++)
    for (int b = 0; b < 2 * RANK; b++) {
      double sum = b == a + RANK ? -1 : a == b + RANK ? 1 : 0;
      for (int i = 0; i < RANK; i++)
        sum += jacobian[i][a] * jacobian[i + RANK][b] - jacobian[i + RANK][a] * jacobian[i][b];
      worst = fmax(worst, fabs(sum));
    }

  state_free(state);
  random_model_free(&m);
  return worst;
}

static void its_step_is_symplectic_for_every_split(void **context) {
  (void)context;
  for (int32_t split = 0; split <= RANK; split++) {
    const double defect = symplectic_defect(split);
    if (!(defect < 1e-10))
      fail_msg("split %d: defect %.3e", (int)split, defect);
  }
}

static void its_steps_run_backwards(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  for (int32_t split = 0; split <= RANK; split++) {
    const thrum_state_def def = make_def(split, 0.1);
    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, start_q, start_p);
    state_steps(&m.model, state, 200);

    // the way back begins with the momentum reversed
    double q[RANK], p[RANK];
    state_read(&m.model, state, q, p);
    for (int i = 0; i < RANK; i++)
      p[i] = -p[i];
    state_put(&m.model, state, q, p);
    state_steps(&m.model, state, 200);
    state_read(&m.model, state, q, p);
    for (int i = 0; i < RANK; i++)
      p[i] = -p[i];
    assert_true(largest_difference(q, start_q, RANK) < 1e-8);
    assert_true(largest_difference(p, start_p, RANK) < 1e-7);
    state_free(state);
  }
  random_model_free(&m);
}

/* --- momenta ---------------------------------------------------------------------------------- */

static void its_momenta_are_of_whole_steps(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  const thrum_state_def def = make_def(LOW, 0.05);
  thrum_state *state = state_make(&m.model, &def);
  double q[RANK], p[RANK], now[RANK];

  // no shift of half a step rounds what was set, nor a change of the time step what was reached
  state_put(&m.model, state, start_q, start_p);
  state_read(&m.model, state, q, p);
  assert_memory_equal(p, start_p, sizeof p);
  state_steps(&m.model, state, 50);
  state_read(&m.model, state, q, p);
  assert_int_equal(thrum_state_set_dt(&m.model, state, 0.02, NULL), THRUM_OK);
  state_read(&m.model, state, NULL, now);
  assert_memory_equal(p, now, sizeof p);

  // a state that is set to them goes on as the one that they are of, to the tolerance of its solves
  thrum_state *other = state_make(&m.model, &def);
  assert_int_equal(thrum_state_set_dt(&m.model, other, 0.02, NULL), THRUM_OK);
  state_put(&m.model, other, q, p);
  state_steps(&m.model, state, 50);
  state_steps(&m.model, other, 50);
  state_read(&m.model, state, q, p);
  state_read(&m.model, other, NULL, now);
  assert_true(largest_difference(p, now, RANK) < 1e-8);

  state_free(state);
  state_free(other);
  random_model_free(&m);
}

static void a_copy_steps_to_the_same_bits(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
    thrum_state_def def = make_def(LOW, 0.1);
    def.adaptive = def.fallback = 1;
    def.damping_form = (thrum_damping_form)form;
    def.damping_beta = 0.01;
    thrum_state *state = state_make(&m.model, &def), *copy = state_make(&m.model, &def);
    state_put(&m.model, state, start_q, start_p);
    state_push(&m.model, state, push);
    state_steps(&m.model, state, 100);

    // the kept bytes alone, with NaN in the scratch behind them
    const size_t kept = thrum_state_kept_bytes(state);
    memset((unsigned char *)copy + kept, 0xff, thrum_state_bytes(copy) - kept);
    memcpy(copy, state, kept);
    state_steps(&m.model, state, 300);
    state_steps(&m.model, copy, 300);
    assert_memory_equal(state, copy, kept);

    state_free(state);
    state_free(copy);
  }
  random_model_free(&m);
}

/* --- monitor ---------------------------------------------------------------------------------- */

static void a_gentle_run_is_left_alone_by_the_monitor(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(LOW, 0.05);
  thrum_state *alone = state_make(&m.model, &def);
  def.adaptive = def.fallback = 1;
  thrum_state *monitored = state_make(&m.model, &def);
  state_put(&m.model, alone, start_q, start_p);
  state_put(&m.model, monitored, start_q, start_p);
  state_steps(&m.model, alone, 20000);
  state_steps(&m.model, monitored, 20000);

  // the same bits, and nothing is counted
  double q[2][RANK], p[2][RANK];
  state_read(&m.model, alone, q[0], p[0]);
  state_read(&m.model, monitored, q[1], p[1]);
  assert_memory_equal(q[0], q[1], sizeof q[0]);
  assert_memory_equal(p[0], p[1], sizeof p[0]);
  const thrum_state_report report = thrum_state_report_get(monitored);
  assert_int_equal(report.scheme, THRUM_SCHEME_POSITION);
  assert_int_equal(report.corrections + report.scheme_switches + report.split_changes, 0);
  assert_true(report.stability_number_peak > 0 && report.balance_peak > 0);
  assert_true(report.balance_peak < 0.03);

  state_free(alone);
  state_free(monitored);
  random_model_free(&m);
}

/* With all modes explicit a large motion is beyond the stability limit. */
static void a_motion_beyond_its_limit_is_lost_alone_and_kept_by_the_monitor(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  const double large[RANK] = {4};
  for (int monitored = 0; monitored < 2; monitored++) {
    thrum_state_def def = make_def(RANK, 0.1);
    def.adaptive = def.fallback = monitored;
    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, large, NULL);
    const double first = state_energy(&m.model, state).total;
    thrum_status status = THRUM_OK;
    double most = 0;
    for (int k = 0; k < 5000 && status >= 0; k++) {
      status = thrum_step(&m.model, state, NULL);
      thrum_energies energies;
      if (status >= 0 && thrum_state_energies(&m.model, state, &energies, NULL) >= 0)
        most = fmax(most, energies.total / first);
    }

    // alone the run is lost; the monitor changes the scheme or the split
    if (!monitored) {
      assert_true(status < 0 || most > 100);
    } else {
      const thrum_state_report report = thrum_state_report_get(state);
      assert_true(status >= 0 && most < 1.5);
      assert_true(report.scheme_switches + report.split_changes > 0);
    }
    state_free(state);
  }
  random_model_free(&m);
}

/* After a switch damping takes the energy away, and the position form returns. */
static void it_returns_after_a_switch(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(LOW, 0.3);
  def.adaptive = def.fallback = 1;
  def.damping_alpha = 0.02;
  thrum_state *state = state_make(&m.model, &def);

  // a motion beyond the limit of stability
  const double large[RANK] = {4, 2, 1};
  state_put(&m.model, state, large, NULL);
  bool switched = false;
  for (int k = 0; k < 40000; k++) {
    state_steps(&m.model, state, 1);
    switched = switched || thrum_state_report_get(state).scheme == THRUM_SCHEME_ENERGY;
  }

  assert_true(switched);
  assert_int_equal(thrum_state_report_get(state).scheme, THRUM_SCHEME_POSITION);
  state_free(state);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(it_equals_its_equations_for_every_split),
      cmocka_unit_test(without_implicit_modes_it_is_verlet_half_a_drift_later),
      cmocka_unit_test(without_explicit_modes_it_is_midpoint_bit_for_bit),
      cmocka_unit_test(a_linear_body_follows_the_closed_form),
      cmocka_unit_test(its_step_is_symplectic_for_every_split),
      cmocka_unit_test(its_steps_run_backwards),
      cmocka_unit_test(its_momenta_are_of_whole_steps),
      cmocka_unit_test(a_copy_steps_to_the_same_bits),
      cmocka_unit_test(a_gentle_run_is_left_alone_by_the_monitor),
      cmocka_unit_test(a_motion_beyond_its_limit_is_lost_alone_and_kept_by_the_monitor),
      cmocka_unit_test(it_returns_after_a_switch),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
