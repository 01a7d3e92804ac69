/* Frequency matching of the energy integrator (design 7) is tested against theorems: linear modes
 * with h omega <= 1 move as they do in closed form, with a constant load and after a change of h
 * too; with damping they decay at their own rate; energy, balance, order and reversal stay those of
 * the step without it. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "runtime/guard/frequency_matching.h"

enum { RANK = 6 };

static const double start_q[RANK] = {0.3, -0.1, 0.15, 0.05, -0.04, 0.02};
static const double start_p[RANK] = {-0.2, 0.4, 0.1, -0.3, 0.2, 0.1};
static const double push[RANK] = {0.5, -0.4, 0.3, -0.2, 0.1, 0.6};

static thrum_state_def make_def(double dt, int32_t matched) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  def.dt = dt;
  def.frequency_matched = matched;
  return def;
}

/* --- linear modes ----------------------------------------------------------------------------- */

/* Moves q, p of undamped linear modes by t under a constant load. */
static void move_exactly(const thrum_model *model, const double *f, double t, double *q,
                         double *p) {
  for (int i = 0; i < RANK; i++) {
    const double omega = sqrt(model->omega2[i]), rest = f[i] / model->omega2[i];
    const double c = cos(omega * t), s = sin(omega * t), away = q[i] - rest, p_start = p[i];
    q[i] = rest + c * away + s * p_start / omega;
    p[i] = c * p_start - s * omega * away;
  }
}

static void linear_modes_move_as_in_closed_form(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 1, RANK, 1.0, 19.9, INFINITY);
  const thrum_state_def def = make_def(0.05, 1);
  thrum_state *state = state_make(&m.model, &def);
  double q[2][RANK], p[2][RANK];
  memcpy(q[1], start_q, sizeof q[1]);
  memcpy(p[1], start_p, sizeof p[1]);
  state_put(&m.model, state, start_q, start_p);
  state_push(&m.model, state, push);

  // thousands of steps each of three lengths; h omega up to 0.995
  static const double lengths[3] = {0.05, 0.021, 0.003};
  for (int n = 0; n < 3; n++) {
    assert_int_equal(thrum_state_set_dt(&m.model, state, lengths[n], NULL), THRUM_OK);
    state_steps(&m.model, state, 5000);
    move_exactly(&m.model, push, 5000 * lengths[n], q[1], p[1]);
    state_read(&m.model, state, q[0], p[0]);
    assert_true(largest_difference(q[0], q[1], RANK) < 1e-11);
    assert_true(largest_difference(p[0], p[1], RANK) < 1e-10);
  }
  state_free(state);
  random_model_free(&m);
}

/* Contact and damping ask for the answer of one mode; it is that of a step of all of them. */
static void one_mode_is_stepped_as_all_are_together(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 1, RANK, 1.0, 19.9, INFINITY);
  const thrum_state_def def = make_def(0.05, 1);
  thrum_state *state = state_make(&m.model, &def);
  assert_int_equal(thrum_matched_modes(&m.model, state), RANK);

  // two modes that follow softer ones are stepped by the trapezoidal rule
  state->following[0] = 1u << 2 | 1u << 4;
  double stretch[RANK], inverse[RANK], speed[RANK];
  thrum_match_steps(&m.model, state, RANK, stretch, inverse, speed);
  for (int i = 0; i < RANK; i++) {
    const thrum_matched_step one = thrum_matched_step_of(&m.model, state, i);
    const bool follows = i == 2 || i == 4;
    assert_true((one.stretch == 1 && one.inverse == 1 && one.speed == 1) == follows);
    assert_true(fabs(one.stretch - stretch[i]) <= 1e-15 * stretch[i]);
    assert_true(fabs(one.inverse - inverse[i]) <= 1e-15 * inverse[i]);
    assert_true(fabs(one.speed - speed[i]) <= 1e-15 * speed[i]);
  }
  state_free(state);
  random_model_free(&m);
}

/* The rate [1/s] at which a damped linear mode loses its amplitude, and the cos of its angle in a
 * step, from q at four times. */
static void decay_of(const thrum_state_def *def, double omega, double *rate, double *cosine) {
  random_model m;
  random_model_make(&m, 1, 1, omega, omega, INFINITY);
  thrum_state *state = state_make(&m.model, def);
  double q[4];
  q[0] = 0.7;
  const double p = 0.3;
  state_put(&m.model, state, q, &p);
  for (int k = 1; k < 4; k++) {
    state_steps(&m.model, state, 1);
    state_read(&m.model, state, &q[k], NULL);
  }

  // q'' - trace q' + det q = 0 at two times in turn
  const double below = q[1] * q[1] - q[0] * q[2];
  const double det = (q[2] * q[2] - q[1] * q[3]) / below;
  *cosine = 0.5 * (q[1] * q[2] - q[0] * q[3]) / below / sqrt(det);
  *rate = -0.5 * log(det) / def->dt;
  state_free(state);
  random_model_free(&m);
}

static void damped_modes_decay_at_their_own_rate(void **context) {
  (void)context;
  const double h = 0.05;
  for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++)
    for (double z = 0.1; z < 1.0; z += 0.2)
      for (double ratio = 0.01; ratio < 0.2; ratio *= 4) {
        // half of the damping by mass, half by stiffness
        const double omega = z / h, expected = ratio * omega;
        double rate[2], cosine[2];
        for (int matched = 0; matched < 2; matched++) {
          thrum_state_def def = make_def(h, matched);
          def.tolerance = 1e-13;
          def.damping_alpha = ratio * omega;
          def.damping_beta = ratio / omega;
          def.damping_form = (thrum_damping_form)form;
          decay_of(&def, omega, &rate[matched], &cosine[matched]);
        }

        // to (h D)^2/12, whatever h omega is; by the trapezoidal rule it is too slow by z^2/4
        const double left = 2 * ratio * z;
        assert_true(fabs(rate[1] / expected - 1) < 0.1 * left * left + 1e-9);
        assert_true(fabs(rate[0] / expected - 1 / (1 + 0.25 * z * z)) < 0.1 * left * left + 1e-9);

        // the angle to ratio^2 z^2/6 of it
        const double angle = z * sqrt(1 - ratio * ratio);
        assert_true(fabs(acos(cosine[1]) / angle - 1) < 0.2 * ratio * ratio * z * z + 1e-9);
      }
}

/* V = 1/2 w0^2 q0^2 + 1/2 (w1 q1 + a q0^2)^2 + 1/2 b q0^4: the second mode follows the first in so
 * far as a^2 is much of a^2 + b. */
static void modes_that_follow_softer_ones_keep_the_trapezoidal_rule(void **context) {
  (void)context;
  for (int follows = 0; follows < 2; follows++) {
    random_model m;
    random_model_make(&m, 1, 2, 1.0, 10.0, INFINITY);
    const double a = 2.0, b = follows ? 0.9 * a * a : 9 * a * a;
    m.c3[thrum_c3_index(2, 0, 0, 1)] = 10.0 * a;
    m.c4[thrum_c4_index(2, 0, 0, 0, 0)] = 0.5 * (a * a + b);
    const thrum_state_def def = make_def(0.05, 1);

    // the first mode keeps its frequency, the second only if it does not follow
    thrum_state *state = state_make(&m.model, &def);
    thrum_stepped_mode modes[2];
    assert_int_equal(thrum_state_stepped_modes(&m.model, state, modes, NULL), THRUM_OK);
    const double trapezoidal = atan(0.25) / (pi * def.dt);
    assert_true(fabs(modes[0].stepped_hertz - modes[0].hertz) < 1e-13);
    assert_true(fabs(modes[1].stepped_hertz - (follows ? trapezoidal : modes[1].hertz)) < 1e-12);
    state_free(state);
    random_model_free(&m);
  }
}

/* --- nonlinear motion ------------------------------------------------------------------------- */

static void energy_is_conserved_over_long_runs(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  const thrum_state_def def = make_def(0.08, 1);
  thrum_state *state = state_make(&m.model, &def);
  state_put(&m.model, state, start_q, start_p);
  const double first = state_energy(&m.model, state).total;
  for (int k = 0; k < 100000; k++) {
    state_steps(&m.model, state, 1);
    if (!(fabs(state_energy(&m.model, state).total / first - 1) < 1e-12))
      fail_msg("step %d: %.3e of the energy", k, state_energy(&m.model, state).total / first - 1);
  }
  state_free(state);
  random_model_free(&m);
}

/* The energy changes by the work of the loads less what the report says is dissipated, while h
 * changes as well. */
static void work_and_dissipation_account_for_the_energy(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
    thrum_state_def def = make_def(0.05, 1);
    def.damping_alpha = 0.05;
    def.damping_beta = 0.004;
    def.damping_form = (thrum_damping_form)form;
    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, start_q, start_p);
    const double first = state_energy(&m.model, state).total;
    double work = 0, most = first;
    for (int k = 0; k < 4000; k++) {
      double f[RANK], q[2][RANK];
      for (int i = 0; i < RANK; i++)
        f[i] = push[i] * sin(0.11 * k);
      if (k % 100 == 0)
        assert_int_equal(thrum_state_set_dt(&m.model, state, 0.02 + 0.03 * (k / 100 % 3), NULL),
                         THRUM_OK);
      state_push(&m.model, state, f);
      state_read(&m.model, state, q[0], NULL);
      state_steps(&m.model, state, 1);
      state_read(&m.model, state, q[1], NULL);
      for (int i = 0; i < RANK; i++)
        work += f[i] * (q[1][i] - q[0][i]);

      // the balance holds in every step
      const double now = state_energy(&m.model, state).total;
      const double lost = thrum_state_report_get(state).dissipated;
      most = fmax(most, fmax(now, fabs(work)));
      if (!(fabs(now - first - work + lost) < 1e-11 * most))
        fail_msg("step %d: off by %.3e of %.3e J", k, now - first - work + lost, most);
    }
    state_free(state);
  }
  random_model_free(&m);
}

static void it_is_of_order_two(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  static const test_load none = {0, 0};
  double q[RANK], p[RANK], error[3];

  // a reference by Runge-Kutta with much smaller steps
  thrum_state_def def = make_def(0, 1);
  def.tolerance = 1e-13;
  def.damping_alpha = 0.05;
  def.damping_beta = 0.004;
  memcpy(q, start_q, sizeof q);
  memcpy(p, start_p, sizeof p);
  reference_advance(&m.model, &def, &none, 0, 1e-3, 2000, q, p);

  // each run halves h
  for (int n = 0; n < 3; n++) {
    double found[RANK];
    def.dt = 0.04 / (1 << n);
    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, start_q, start_p);
    state_steps(&m.model, state, 50 << n);
    state_read(&m.model, state, found, NULL);
    error[n] = largest_difference(found, q, RANK);
    state_free(state);
  }
  assert_true(error[0] / error[1] > 3.5 && error[0] / error[1] < 4.6);
  assert_true(error[1] / error[2] > 3.8 && error[1] / error[2] < 4.2);
  random_model_free(&m);
}

static void it_runs_backwards(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  thrum_state_def def = make_def(0.08, 1);
  def.tolerance = 1e-13;
  thrum_state *state = state_make(&m.model, &def);
  state_put(&m.model, state, start_q, start_p);

  // there and back: the momentum is turned at each end
  double q[RANK], p[RANK];
  for (int way = 0; way < 2; way++) {
    state_steps(&m.model, state, 200);
    state_read(&m.model, state, q, p);
    for (int i = 0; i < RANK; i++)
      p[i] = -p[i];
    state_put(&m.model, state, q, p);
  }
  assert_true(largest_difference(q, start_q, RANK) < 1e-8);
  assert_true(largest_difference(p, start_p, RANK) < 1e-7);
  state_free(state);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(linear_modes_move_as_in_closed_form),
      cmocka_unit_test(one_mode_is_stepped_as_all_are_together),
      cmocka_unit_test(damped_modes_decay_at_their_own_rate),
      cmocka_unit_test(modes_that_follow_softer_ones_keep_the_trapezoidal_rule),
      cmocka_unit_test(energy_is_conserved_over_long_runs),
      cmocka_unit_test(work_and_dissipation_account_for_the_energy),
      cmocka_unit_test(it_is_of_order_two),
      cmocka_unit_test(it_runs_backwards),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
