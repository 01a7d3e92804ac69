/* backward-euler, semi-implicit-euler and rk4 are tested against their equations, their order, and
 * the closed form of what they take from a linear mode.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"
#include "thrum/polynomial.h"

enum { RANK = 4 };

static const double start_q[RANK] = {0.3, -0.1, 0.15, 0.05};
static const double start_p[RANK] = {-0.2, 0.4, 0.1, -0.3};
static const double push[RANK] = {0.3, -0.2, 0.1, 0.4};

static const thrum_integrator compared[3] = {
    THRUM_INTEGRATOR_BACKWARD_EULER, THRUM_INTEGRATOR_SEMI_IMPLICIT_EULER, THRUM_INTEGRATOR_RK4};

static thrum_state_def make_def(thrum_integrator integrator, double dt) {
  thrum_state_def def = imexv_def();
  def.integrator = integrator;
  def.dt = dt;
  def.tolerance = 1e-13;
  return def;
}

static void set_damping(thrum_state_def *def, int damped) {
  def->damping_alpha = damped ? 0.4 : 0.0;
  def->damping_beta = damped ? 0.01 : 0.0;
  def->damping_form = damped == 2 ? THRUM_DAMPING_TANGENT : THRUM_DAMPING_REST;
}

/* --- order ------------------------------------------------------------------------------------ */

static double error_of(const thrum_model *model, thrum_state_def def, const double *q_ref,
                       const double *p_ref, double time, int64_t steps) {
  double q[RANK], p[RANK];
  def.dt = time / (double)steps;
  thrum_state *state = state_make(model, &def);
  state_put(model, state, start_q, start_p);
  state_steps(model, state, steps);
  state_read(model, state, q, p);
  state_free(state);
  return fmax(largest_difference(q, q_ref, RANK), largest_difference(p, p_ref, RANK));
}

static void the_eulers_are_of_order_one_and_runge_kutta_of_order_four(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 7, RANK, 1.0, 6.0, 0.5);
  const double time = 1.0;
  const test_load none = {0, 1};
  for (int n = 0; n < 3; n++)
    for (int damped = 0; damped < 3; damped++) {
      thrum_state_def def = make_def(compared[n], 1.0);
      set_damping(&def, damped);
      double q_ref[RANK], p_ref[RANK];
      memcpy(q_ref, start_q, sizeof q_ref);
      memcpy(p_ref, start_p, sizeof p_ref);
      reference_advance(&m.model, &def, &none, 0, time / 8000, 8000, q_ref, p_ref);

      // steps at which the error is far above rounding
      const int64_t steps = n == 2 ? 40 : 1600;
      const double coarse = error_of(&m.model, def, q_ref, p_ref, time, steps);
      const double fine = error_of(&m.model, def, q_ref, p_ref, time, 2 * steps);
      const double order = log2(coarse / fine), expected = n == 2 ? 4.0 : 1.0;
      if (!(fabs(order - expected) < 0.15))
        fail_msg("%s, damping %d: order %.3f", thrum_integrator_name(compared[n]), damped, order);
    }
  random_model_free(&m);
}

/* --- a linear mode ---------------------------------------------------------------------------- */

/* By how much a step multiplies the energy of a linear mode with this h omega. */
static double factor_of(thrum_integrator integrator, double z) {
  random_model m;
  random_model_make(&m, 1, 1, z / 0.05, z / 0.05, INFINITY);
  const thrum_state_def def = make_def(integrator, 0.05);
  thrum_state *state = state_make(&m.model, &def);
  const double q = 0.7, p = -3.0;
  state_put(&m.model, state, &q, &p);
  const double before = state_energy(&m.model, state).total;
  state_steps(&m.model, state, 1);
  const double after = state_energy(&m.model, state).total;
  state_free(state);
  random_model_free(&m);
  return after / before;
}

static void a_linear_mode_loses_what_the_closed_form_says(void **context) {
  (void)context;
  static const double z[5] = {0.01, 0.3, 1.0, 2.0, 2.7};
  for (int n = 0; n < 5; n++) {
    const double square = z[n] * z[n];
    const double euler = 1.0 / (1.0 + square);
    const double rk4 = 1.0 - pow(square, 3) / 72.0 + pow(square, 4) / 576.0;
    assert_true(fabs(factor_of(THRUM_INTEGRATOR_BACKWARD_EULER, z[n]) - euler) < 1e-12);
    assert_true(fabs(factor_of(THRUM_INTEGRATOR_SEMI_IMPLICIT_EULER, z[n]) - euler) < 1e-12);
    assert_true(fabs(factor_of(THRUM_INTEGRATOR_RK4, z[n]) - rk4) < 1e-12);
  }
}

static void runge_kutta_is_stable_up_to_root_eight(void **context) {
  (void)context;
  assert_true(factor_of(THRUM_INTEGRATOR_RK4, 2.828) < 1.0);
  assert_true(factor_of(THRUM_INTEGRATOR_RK4, 2.829) > 1.0);
}

/* --- equations -------------------------------------------------------------------------------- */

/* R(q) + D(at) p - f into `total`. */
static void forces(const thrum_model *model, const thrum_state_def *def, const double *q,
                   const double *p, double *total) {
  double *work = random_alloc((int64_t)thrum_work_count(model), sizeof(double));
  double product[RANK];
  thrum_internal_force(model, q, total, work);
  thrum_tangent_product(model, q, p, product, work);
  free(work);
  for (int i = 0; i < RANK; i++) {
    const double stiff =
        def->damping_form == THRUM_DAMPING_TANGENT ? product[i] : model->omega2[i] * p[i];
    total[i] += def->damping_alpha * p[i] + def->damping_beta * stiff - push[i];
  }
}

static void backward_euler_solves_its_equation(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 7, RANK, 1.0, 60.0, 0.5);
  for (int damped = 0; damped < 3; damped++) {
    thrum_state_def def = make_def(THRUM_INTEGRATOR_BACKWARD_EULER, 0.05);
    set_damping(&def, damped);
    thrum_state *state = state_make(&m.model, &def);

    // under a constant load
    state_put(&m.model, state, start_q, start_p);
    state_push(&m.model, state, push);
    double q[2][RANK], p[2][RANK], total[RANK];

    // both equations hold with the forces at the end of the step
    for (int k = 0; k < 30; k++) {
      state_read(&m.model, state, q[0], p[0]);
      state_steps(&m.model, state, 1);
      state_read(&m.model, state, q[1], p[1]);
      forces(&m.model, &def, q[1], p[1], total);
      for (int i = 0; i < RANK; i++) {
        assert_true(fabs(q[1][i] - q[0][i] - def.dt * p[1][i]) < 1e-11);
        assert_true(fabs(p[1][i] - p[0][i] + def.dt * total[i]) < 1e-9);
      }
    }
    state_free(state);
  }
  random_model_free(&m);
}

static void semi_implicit_euler_solves_its_linear_system(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 7, RANK, 1.0, 60.0, 0.5);
  double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof(double));
  for (int damped = 0; damped < 3; damped++) {
    thrum_state_def def = make_def(THRUM_INTEGRATOR_SEMI_IMPLICIT_EULER, 0.05);
    set_damping(&def, damped);
    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, start_q, start_p);
    state_push(&m.model, state, push);
    double q[2][RANK], p[2][RANK], total[RANK], change[RANK], turned[RANK], carried[RANK];
    for (int k = 0; k < 30; k++) {
      state_read(&m.model, state, q[0], p[0]);
      state_steps(&m.model, state, 1);
      state_read(&m.model, state, q[1], p[1]);

      // (1 + h D + h^2 T) (p' - p) + h (R + D p + h T p - f), all at the start of the step
      forces(&m.model, &def, q[0], p[0], total);
      for (int i = 0; i < RANK; i++)
        change[i] = p[1][i] - p[0][i];
      thrum_tangent_product(&m.model, q[0], change, turned, work);
      thrum_tangent_product(&m.model, q[0], p[0], carried, work);
      for (int i = 0; i < RANK; i++) {
        const double stiff = damped == 2 ? turned[i] : m.model.omega2[i] * change[i];
        const double damping = def.damping_alpha * change[i] + def.damping_beta * stiff;
        const double left = change[i] + def.dt * damping + def.dt * def.dt * turned[i] +
                            def.dt * (total[i] + def.dt * carried[i]);
        assert_true(fabs(left) < 1e-10);
        assert_true(fabs(q[1][i] - q[0][i] - def.dt * p[1][i]) < 1e-14);
      }
    }
    state_free(state);
  }
  free(work);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_eulers_are_of_order_one_and_runge_kutta_of_order_four),
      cmocka_unit_test(a_linear_mode_loses_what_the_closed_form_says),
      cmocka_unit_test(runge_kutta_is_stable_up_to_root_eight),
      cmocka_unit_test(backward_euler_solves_its_equation),
      cmocka_unit_test(semi_implicit_euler_solves_its_linear_system),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
