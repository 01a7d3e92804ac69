/* Tests of the quadratic split (design (6)): its equations, its ends, its symplectic step, and
 * where it gives way to the thesis split. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"
#include "thrum/polynomial.h"

enum { RANK = 6, LOW = 2 };

static const double start_q[RANK] = {0.3, -0.1, 0.15, 0.05, -0.04, 0.02};
static const double start_p[RANK] = {-0.2, 0.4, 0.1, -0.3, 0.2, 0.1};
static const double push[RANK] = {0.5, -0.4, 0.3, -0.2, 0.1, 0.6};

static void make_model(random_model *m) {
  random_model_make(m, 21, RANK, 1.0, 12.0, 0.5);
}

static thrum_state_def make_def(thrum_split_form form, int32_t explicit_count, double dt) {
  thrum_state_def def = imexv_def();
  def.split_form = form;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = explicit_count;
  def.dt = dt;
  def.adaptive = 0;
  def.tolerance = 1e-13;
  return def;
}

/* Makes step (6) as it is written, damped as (2), from and to momenta half a step before q. */
static void plain_step(const thrum_model *model, const thrum_state_def *def, double *q, double *p,
                       const double *f_before, const double *f, double *work) {
  const double h = def->dt;
  double force[RANK];
  thrum_internal_force(model, q, force, work);
  for (int i = 0; i < RANK; i++) {
    const double kappa = i < def->explicit_count ? 0 : model->omega2[i];
    const double d = def->damping_alpha + def->damping_beta * model->omega2[i];

    // the mean of the loads before and after, as the step lies between them
    const double load = (f_before[i] + f[i]) / 2;
    const double plus =
        (p[i] * (1 - h * d / 2) - h * (force[i] - kappa * q[i] - load)) / (1 + h * d / 2);
    const double next = ((1 - h * h * kappa / 4) * q[i] + h * plus) / (1 + h * h * kappa / 4);

    p[i] = plus - h * kappa * (q[i] + next) / 2;
    q[i] = next;
  }
}

static void it_equals_its_equations_for_every_split(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof(double));
  const double none[RANK] = {0};
  for (int split = 0; split <= RANK; split++) {
    thrum_state_def def = make_def(THRUM_FORM_QUADRATIC, split, 0.05);
    def.damping_alpha = 0.1;
    def.damping_beta = 0.005;

    thrum_state *state = state_make(&m.model, &def);

    // the momenta of the equations lie half a step before q
    double q[RANK], p[RANK], q_now[RANK], force[RANK];
    memcpy(q, start_q, sizeof q);
    thrum_internal_force(&m.model, q, force, work);

    for (int i = 0; i < RANK; i++) {
      const double d = def.damping_alpha + def.damping_beta * m.omega2[i];
      const double explicit_force = force[i] - (i < split ? 0 : m.omega2[i] * q[i]);
      p[i] = start_p[i] * (1 + def.dt * d / 2) + def.dt / 2 * explicit_force;
    }

    // the load is 0 before the first step
    state_put(&m.model, state, start_q, start_p);
    state_push(&m.model, state, push);
    for (int k = 0; k < 100; k++) {
      plain_step(&m.model, &def, q, p, k == 0 ? none : push, push, work);
      state_steps(&m.model, state, 1);
      state_read(&m.model, state, q_now, NULL);
      assert_true(largest_difference(q, q_now, RANK) < 1e-12);
    }

    // the split is linear in the new state, so there is nothing to iterate
    assert_int_equal(thrum_state_report_get(state).iterations, 0);

    state_free(state);
  }
  free(work);
  random_model_free(&m);
}

static void without_implicit_modes_it_is_verlet_bit_for_bit(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(THRUM_FORM_QUADRATIC, RANK, 0.02);

  thrum_state *quadratic = state_make(&m.model, &def);
  def.integrator = THRUM_INTEGRATOR_VERLET;
  thrum_state *verlet = state_make(&m.model, &def);

  // the same start and number of steps for both
  double q[2][RANK], p[2][RANK];

  state_put(&m.model, quadratic, start_q, start_p);
  state_put(&m.model, verlet, start_q, start_p);
  state_steps(&m.model, quadratic, 300);
  state_steps(&m.model, verlet, 300);
  state_read(&m.model, quadratic, q[0], p[0]);
  state_read(&m.model, verlet, q[1], p[1]);

  assert_memory_equal(q[0], q[1], sizeof q[0]);
  assert_memory_equal(p[0], p[1], sizeof p[0]);

  state_free(quadratic);
  state_free(verlet);
  random_model_free(&m);
}

static void without_explicit_modes_it_is_midpoint_on_a_linear_model(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 1, RANK, 1.0, 30.0, INFINITY);
  thrum_state_def def = make_def(THRUM_FORM_QUADRATIC, 0, 0.2);

  thrum_state *quadratic = state_make(&m.model, &def);
  def.integrator = THRUM_INTEGRATOR_MIDPOINT;
  thrum_state *midpoint = state_make(&m.model, &def);

  double q[2][RANK], p[2][RANK];
  state_put(&m.model, quadratic, start_q, start_p);
  state_put(&m.model, midpoint, start_q, start_p);

  // the two differ by rounding
  for (int k = 0; k < 200; k++) {
    state_steps(&m.model, quadratic, 1);
    state_steps(&m.model, midpoint, 1);
    state_read(&m.model, quadratic, q[0], p[0]);
    state_read(&m.model, midpoint, q[1], p[1]);
    assert_true(largest_difference(q[0], q[1], RANK) < 1e-11);
    assert_true(largest_difference(p[0], p[1], RANK) < 1e-10);
  }

  state_free(quadratic);
  state_free(midpoint);
  random_model_free(&m);
}

/* Makes one step of the synchronised z = (q, p). Synchronising is a shear, so it changes no
 * symplectic form.
 */
static void step_map(const thrum_model *model, thrum_state *state, const double *z, double *image) {
  state_put(model, state, z, z + RANK);
  state_steps(model, state, 1);
  state_read(model, state, image, image + RANK);
}

/* Computes the largest entry of A^T J A - J, where A is the Jacobian of a step by differences of
 * order 6. */
static double symplectic_defect(thrum_split_form form) {
  static const double weight[3] = {3. / 4, -3. / 20, 1. / 60};
  random_model m;
  make_model(&m);
  const thrum_state_def def = make_def(form, LOW, 0.1);
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

static void its_step_is_symplectic_and_that_of_the_thesis_split_is_not(void **context) {
  (void)context;
  const double quadratic = symplectic_defect(THRUM_FORM_QUADRATIC);
  const double thesis = symplectic_defect(THRUM_FORM_THESIS);
  if (!(quadratic < 1e-11 && thesis > 1e-3))
    fail_msg("defects %.3e and %.3e", quadratic, thesis);
}

/* Beyond its bound h^2 lambda_max(T - kappa) < 4 the monitor moves on to the thesis split. */
static void a_large_motion_hands_over_to_the_thesis_split(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(THRUM_FORM_QUADRATIC, LOW, 0.1);
  double large[RANK] = {0};
  for (int monitored = 0; monitored < 2; monitored++) {
    def.adaptive = monitored;
    def.fallback = monitored;

    // a small motion leaves the quadratic split in charge
    thrum_state *state = state_make(&m.model, &def);

    const double small[RANK] = {0.01, -0.01};
    state_put(&m.model, state, small, NULL);
    state_steps(&m.model, state, 2000);
    assert_int_equal(thrum_state_report_get(state).scheme, THRUM_SCHEME_QUADRATIC);

    // the large motion stiffens the body beyond the bound
    large[0] = 4;
    state_put(&m.model, state, large, NULL);

    const double first = state_energy(&m.model, state).total;
    thrum_status status = THRUM_OK;
    for (int k = 0; k < 2000 && status >= 0; k++)
      status = thrum_step(&m.model, state, NULL);

    // unmonitored the run is lost, monitored it keeps its energy in another scheme
    if (!monitored) {
      assert_true(status < 0 || state_energy(&m.model, state).total > 100 * first);
    } else {
      const thrum_state_report report = thrum_state_report_get(state);
      assert_true(status >= 0);
      assert_true(report.scheme_switches > 0 && report.scheme != THRUM_SCHEME_QUADRATIC);
      assert_true(state_energy(&m.model, state).total < 1.5 * first);
    }

    state_free(state);
  }
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(it_equals_its_equations_for_every_split),
      cmocka_unit_test(without_implicit_modes_it_is_verlet_bit_for_bit),
      cmocka_unit_test(without_explicit_modes_it_is_midpoint_on_a_linear_model),
      cmocka_unit_test(its_step_is_symplectic_and_that_of_the_thesis_split_is_not),
      cmocka_unit_test(a_large_motion_hands_over_to_the_thesis_split),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
