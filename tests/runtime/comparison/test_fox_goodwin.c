/* Newmark with beta by mode is tested against theorems: its frequency and its order, the limit of
 * its stability, its symplectic form, and Newmark where no mode is low.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"
#include "thrum/polynomial.h"

enum { RANK = 3 };

static const double start_q[RANK] = {0.25, -0.1, 0.06};
static const double start_p[RANK] = {-0.2, 0.4, 0.3};

static thrum_state_def make_def(double dt) {
  thrum_state_def def = imexv_def();
  def.integrator = THRUM_INTEGRATOR_FOX_GOODWIN;
  def.dt = dt;
  def.tolerance = 1e-13;
  return def;
}

/* --- a linear mode ---------------------------------------------------------------------------- */

/* cos of the angle that a linear mode advances by in a step, from q at three times. */
static double cosine_of_step(double omega, double dt) {
  random_model m;
  random_model_make(&m, 1, 1, omega, omega, INFINITY);
  const thrum_state_def def = make_def(dt);
  thrum_state *state = state_make(&m.model, &def);
  double q[3];
  q[0] = 0.7;
  state_put(&m.model, state, q, NULL);
  for (int k = 1; k < 3; k++) {
    state_steps(&m.model, state, 1);
    state_read(&m.model, state, &q[k], NULL);
  }
  state_free(state);
  random_model_free(&m);
  return 0.5 * (q[0] + q[2]) / q[1];
}

static void a_linear_mode_has_the_frequency_of_its_closed_form(void **context) {
  (void)context;

  // 2 - 2 cos = z^2 / (1 + beta z^2), beta 1/12 up to z = 1 and 1/4 above
  static const double z[6] = {0.01, 0.3, 0.999, 1.001, 2.5, 8.0};
  for (int n = 0; n < 6; n++) {
    const double square = z[n] * z[n], beta = z[n] <= 1.0 ? 1.0 / 12.0 : 0.25;
    const double expected = 1.0 - 0.5 * square / (1.0 + beta * square);
    assert_true(fabs(cosine_of_step(z[n] / 0.05, 0.05) - expected) < 1e-10);
  }
}

static void a_linear_mode_has_its_frequency_to_order_four(void **context) {
  (void)context;
  double error[2];
  for (int level = 0; level < 2; level++) {
    const double z = 0.8 / (1 << level);
    error[level] = acos(cosine_of_step(z / 0.05, 0.05)) / z - 1.0;
  }
  assert_true(fabs(error[0] - pow(0.8, 4) / 480.0) < 0.1 * error[0]);
  assert_true(log2(error[0] / error[1]) > 3.9 && log2(error[0] / error[1]) < 4.1);
}

/* --- order on a nonlinear model --------------------------------------------------------------- */

/* The largest error of q and p after 2.4 s, with steps at which all modes are low. */
static double error_of(const thrum_model *model, thrum_state_def def, const test_load *load,
                       int64_t steps) {
  enum { SUBSTEPS = 6000 };
  const double time = 2.4;
  double q_ref[RANK], p_ref[RANK], q[RANK], p[RANK], f[RANK];
  memcpy(q_ref, start_q, sizeof q_ref);
  memcpy(p_ref, start_p, sizeof p_ref);
  reference_advance(model, &def, load, 0, time / SUBSTEPS, SUBSTEPS, q_ref, p_ref);

  // the same motion with the scheme, under the mean load of each step
  def.dt = time / (double)steps;
  thrum_state *state = state_make(model, &def);
  state_put(model, state, start_q, start_p);
  for (int64_t k = 0; k < steps; k++) {
    for (int64_t i = 0; i < RANK; i++)
      f[i] = test_load_mean(load, i, (double)k * def.dt, (double)(k + 1) * def.dt);
    state_push(model, state, f);
    state_steps(model, state, 1);
  }
  state_read(model, state, q, p);
  state_free(state);
  return fmax(largest_difference(q, q_ref, RANK), largest_difference(p, p_ref, RANK));
}

static void free_motion_of_low_modes_is_of_order_four_and_else_of_order_two(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 7, RANK, 1.0, 5.0, 0.5);
  static const test_load loads[2] = {{0, 1}, {1.5, 2.3}};
  for (int l = 0; l < 2; l++)
    for (int damped = 0; damped < 3; damped++) {
      thrum_state_def def = make_def(1.0);
      def.damping_alpha = damped ? 0.4 : 0.0;
      def.damping_beta = damped ? 0.01 : 0.0;
      def.damping_form = damped == 2 ? THRUM_DAMPING_TANGENT : THRUM_DAMPING_REST;

      // the smaller order of two halvings counts
      const double coarse = error_of(&m.model, def, &loads[l], 80);
      const double middle = error_of(&m.model, def, &loads[l], 160);
      const double fine = error_of(&m.model, def, &loads[l], 320);
      const double order = fmin(log2(coarse / middle), log2(middle / fine));
      const double expected = l == 0 && damped == 0 ? 4.0 : 2.0;
      if (!(order > expected - 0.15 && order < expected + 0.3))
        fail_msg("load %d, damping %d: order %.3f", l, damped, order);
    }
  random_model_free(&m);
}

/* --- Newmark ---------------------------------------------------------------------------------- */

static void without_low_modes_it_is_newmark_bit_for_bit(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 7, RANK, 3.0, 9.0, 0.5);
  double q[2][RANK], p[2][RANK];
  for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++)
    for (int low = 0; low < 2; low++) {
      thrum_state_def def = make_def(low ? 0.3 : 0.34);
      def.adaptive = 0;
      def.damping_alpha = 0.1;
      def.damping_beta = 0.002;
      def.damping_form = (thrum_damping_form)form;
      for (int n = 0; n < 2; n++) {
        def.integrator = n == 0 ? THRUM_INTEGRATOR_FOX_GOODWIN : THRUM_INTEGRATOR_NEWMARK;
        thrum_state *state = state_make(&m.model, &def);
        random_state random = {5};
        state_put(&m.model, state, start_q, start_p);
        for (int k = 0; k < 60; k++) {
          double f[RANK];
          random_vector(&random, RANK, 1.0, f);
          state_push(&m.model, state, f);
          state_steps(&m.model, state, 1);
        }
        state_read(&m.model, state, q[n], p[n]);
        state_free(state);
      }

      // at 0.3 s the lowest mode is below the bound h omega = 1, and the runs part
      const double apart =
          fmax(largest_difference(q[0], q[1], RANK), largest_difference(p[0], p[1], RANK));
      assert_true(low ? apart > 1e-3 : apart == 0.0);
    }
  random_model_free(&m);
}

/* --- the symplectic form ---------------------------------------------------------------------- */

enum { SIDE = 2 * RANK };
static const double step_h = 0.15; /* two of the frequencies 1, 5, 9 are low */
static const double betas[RANK] = {1.0 / 12.0, 1.0 / 12.0, 0.25};

/* x = (q, p) a step later. */
static void advance(const thrum_model *model, thrum_state *state, const double *x, double *to) {
  state_put(model, state, x, x + RANK);
  state_steps(model, state, 1);
  state_read(model, state, to, to + RANK);
}

/* (q, p) to the canonical pair (z, v): z = q + h^2 B R(q), and p = v + h^2/12 T v on the low
 * modes. */
static void canonical(const thrum_model *model, const double *x, double *to) {
  double *work = random_alloc((int64_t)thrum_work_count(model), sizeof(double));
  double force[RANK], tangent[RANK * RANK];
  thrum_internal_force(model, x, force, work);
  thrum_tangent_stiffness(model, x, tangent, work);
  free(work);

  for (int i = 0; i < RANK; i++)
    to[i] = x[i] + step_h * step_h * betas[i] * force[i];

  // two equations by Cramer's rule
  const double share = step_h * step_h / 12.0;
  const double *p = x + RANK;
  const double a = 1 + share * tangent[0], b = share * tangent[1];
  const double c = share * tangent[RANK], d = 1 + share * tangent[RANK + 1];
  const double e = p[0] - share * tangent[2] * p[2], f = p[1] - share * tangent[RANK + 2] * p[2];
  to[RANK] = (e * d - b * f) / (a * d - b * c);
  to[RANK + 1] = (a * f - e * c) / (a * d - b * c);
  to[RANK + 2] = p[2];
}

/* How far the form dq dp changes from `before` to `after`, SIDE x SIDE derivatives each. */
static double change_of_form(double before[SIDE][SIDE], double after[SIDE][SIDE]) {
  double worst = 0;
  for (int a = 0; a < SIDE; a++)
    for (int b = 0; b < SIDE; b++) {
      double sum = 0;
      for (int i = 0; i < RANK; i++) {
        sum += after[a][i] * after[b][RANK + i] - after[a][RANK + i] * after[b][i];
        sum -= before[a][i] * before[b][RANK + i] - before[a][RANK + i] * before[b][i];
      }
      worst = fmax(worst, fabs(sum));
    }
  return worst;
}

static void a_step_is_symplectic_in_its_canonical_pair(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 7, RANK, 1.0, 9.0, 0.5);
  const thrum_state_def def = make_def(step_h);
  thrum_state *state = state_make(&m.model, &def);
  const double eps = 1e-4;

  // derivatives along each axis of (q, p), plain and in the canonical pair
  double plain[2][SIDE][SIDE], paired[2][SIDE][SIDE];
  for (int a = 0; a < SIDE; a++) {
    double there[2][SIDE], later[2][SIDE], pair[2][SIDE], pair_later[2][SIDE];
    for (int side = 0; side < 2; side++) {
      memcpy(there[side], start_q, sizeof start_q);
      memcpy(there[side] + RANK, start_p, sizeof start_p);
      there[side][a] += side ? eps : -eps;
      advance(&m.model, state, there[side], later[side]);
      canonical(&m.model, there[side], pair[side]);
      canonical(&m.model, later[side], pair_later[side]);
    }
    for (int i = 0; i < SIDE; i++) {
      plain[0][a][i] = (there[1][i] - there[0][i]) / (2 * eps);
      plain[1][a][i] = (later[1][i] - later[0][i]) / (2 * eps);
      paired[0][a][i] = (pair[1][i] - pair[0][i]) / (2 * eps);
      paired[1][a][i] = (pair_later[1][i] - pair_later[0][i]) / (2 * eps);
    }
  }

  assert_true(change_of_form(paired[0], paired[1]) < 1e-6);
  assert_true(change_of_form(plain[0], plain[1]) > 1e-4);
  state_free(state);
  random_model_free(&m);
}

/* --- stability -------------------------------------------------------------------------------- */

/* A mode with h omega = 0.9 at rest that a load has bent, until h^2 T = stiff there: by how much a
 * small disturbance of the equilibrium grows in 400 steps. */
static double growth(double stiff) {
  random_model m;
  const double h = 0.05, omega = 0.9 / h, q = 0.5, eps = 1e-7;
  random_model_make(&m, 1, 1, omega, omega, INFINITY);

  // V = omega^2 q^2/2 + c q^4, so T = omega^2 + 12 c q^2
  m.c4[0] = (stiff / (h * h) - omega * omega) / (12.0 * q * q);
  const double load = omega * omega * q + 4.0 * m.c4[0] * q * q * q, disturbed = q + eps;
  const thrum_state_def def = make_def(h);
  thrum_state *state = state_make(&m.model, &def);
  state_put(&m.model, state, &disturbed, NULL);
  state_push(&m.model, state, &load);

  double worst = 0;
  for (int k = 0; k < 400; k++) {
    double now;
    state_steps(&m.model, state, 1);
    state_read(&m.model, state, &now, NULL);
    worst = fmax(worst, fabs(now - q));
  }
  state_free(state);
  random_model_free(&m);
  return worst / eps;
}

static void low_modes_are_stable_until_their_present_angle_is_root_six(void **context) {
  (void)context;
  assert_true(growth(0.81) < 5.0);
  assert_true(growth(5.8) < 20.0);
  assert_true(growth(6.2) > 1e4);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_linear_mode_has_the_frequency_of_its_closed_form),
      cmocka_unit_test(a_linear_mode_has_its_frequency_to_order_four),
      cmocka_unit_test(free_motion_of_low_modes_is_of_order_four_and_else_of_order_two),
      cmocka_unit_test(without_low_modes_it_is_newmark_bit_for_bit),
      cmocka_unit_test(a_step_is_symplectic_in_its_canonical_pair),
      cmocka_unit_test(low_modes_are_stable_until_their_present_angle_is_root_six),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
