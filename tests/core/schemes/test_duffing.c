/* One mode is compared with the exact solution of the Duffing oscillator, and the linear oscillator
 * is tested for its stability bound, growth, decay and conserved quantities (design 4, 5).
 *
 * q'' + a q + b q^3 = 0 with q(0) = A at rest has q = A cn(W t | m), W^2 = a + b A^2,
 * m = b A^2 / (2 W^2); cn by the arithmetic-geometric mean (Abramowitz & Stegun 16.4, 17.6).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

static const thrum_integrator all[5] = {THRUM_INTEGRATOR_IMEXV, THRUM_INTEGRATOR_NEWMARK,
                                        THRUM_INTEGRATOR_VERLET, THRUM_INTEGRATOR_MIDPOINT,
                                        THRUM_INTEGRATOR_ENERGY};

/* --- exact solution --------------------------------------------------------------------------- */

/* Computes cn(u | m) and K(m), 0 <= m < 1. */
static double jacobi_cn(double u, double m, double *quarter_period) {
  enum { LEVELS = 8 };
  double a[LEVELS + 1], c[LEVELS + 1], b = sqrt(1 - m);
  a[0] = 1;
  c[0] = sqrt(m);

  // the means converge quadratically, so eight levels are plenty
  for (int n = 0; n < LEVELS; n++) {
    a[n + 1] = (a[n] + b) / 2;
    c[n + 1] = (a[n] - b) / 2;
    b = sqrt(a[n] * b);
  }

  if (quarter_period)
    *quarter_period = pi / (2 * a[LEVELS]);

  // descend to the amplitude, whose cosine is cn
  double phase = ldexp(a[LEVELS] * u, LEVELS);
  for (int n = LEVELS; n > 0; n--)
    phase = (phase + asin(c[n] / a[n] * sin(phase))) / 2;
  return cos(phase);
}

typedef struct duffing {
  random_model m;
  double linear, cubic, amplitude, rate, modulus;
} duffing;

/* omega^2 = 4, b A^2 = stiffening times omega^2. */
static void duffing_make(duffing *d, double stiffening) {
  random_model_make(&d->m, 1, 1, 2.0, 2.0, INFINITY);
  d->amplitude = 0.7;
  d->linear = 4.0;
  d->cubic = stiffening * d->linear / (d->amplitude * d->amplitude);
  d->m.c3[0] = 0;
  d->m.c4[0] = d->cubic / 4;
  const double square = d->cubic * d->amplitude * d->amplitude;
  d->rate = sqrt(d->linear + square);
  d->modulus = square / (2 * d->rate * d->rate);
}

static thrum_state_def duffing_def(thrum_integrator integrator, double dt) {
  thrum_state_def def = imexv_def();
  def.integrator = integrator;
  def.dt = dt;
  def.tolerance = 1e-13;
  return def;
}

/* Computes the largest error of q over three periods with `steps` a period. */
static double duffing_error(const duffing *d, thrum_integrator integrator, int64_t steps) {
  double quarter, worst = 0;
  jacobi_cn(0, d->modulus, &quarter);

  // the step divides the exact period
  const double dt = 4 * quarter / d->rate / (double)steps;
  const thrum_state_def def = duffing_def(integrator, dt);

  thrum_state *state = state_make(&d->m.model, &def);
  state_put(&d->m.model, state, &d->amplitude, NULL);

  for (int64_t k = 1; k <= 3 * steps; k++) {
    double q;
    state_steps(&d->m.model, state, 1);
    state_read(&d->m.model, state, &q, NULL);

    const double exact = d->amplitude * jacobi_cn(d->rate * dt * (double)k, d->modulus, NULL);
    worst = fmax(worst, fabs(q - exact));
  }

  state_free(state);
  return worst / d->amplitude;
}

static void elliptic_cosine_satisfies_its_identities(void **context) {
  (void)context;
  double quarter;

  // m = 0 is the cosine; cn' = -sn dn gives the differential equation of the oscillator
  assert_true(fabs(jacobi_cn(1.3, 0, &quarter) - cos(1.3)) < 1e-14);
  assert_true(fabs(quarter - pi / 2) < 1e-14);

  // K(1/2) = Gamma(1/4)^2 / (4 sqrt(pi))
  jacobi_cn(0, 0.5, &quarter);
  assert_true(fabs(quarter - pow(tgamma(0.25), 2) / (4 * sqrt(pi))) < 1e-13);
  assert_true(fabs(jacobi_cn(quarter, 0.5, NULL)) < 1e-13);
  assert_true(fabs(jacobi_cn(4 * quarter + 0.4, 0.5, NULL) - jacobi_cn(0.4, 0.5, NULL)) < 1e-12);

  // cn'' = cn (2 m - 1 - 2 m cn^2), by second differences
  const double s = 1e-3, u = 0.8, m = 0.37, c = jacobi_cn(u, m, NULL);
  const double second = (jacobi_cn(u + s, m, NULL) - 2 * c + jacobi_cn(u - s, m, NULL)) / (s * s);
  assert_true(fabs(second - c * (2 * m - 1 - 2 * m * c * c)) < 1e-6);
}

static void every_integrator_converges_to_the_duffing_solution(void **context) {
  (void)context;
  static const double stiffening[2] = {0.5, 20.0};
  for (int n = 0; n < 2; n++) {
    duffing d;
    duffing_make(&d, stiffening[n]);
    for (int i = 0; i < 5; i++) {
      const double coarse = duffing_error(&d, all[i], 500);
      const double fine = duffing_error(&d, all[i], 1000);
      assert_true(fine < 2e-4);
      assert_true(log2(coarse / fine) > 1.95 && log2(coarse / fine) < 2.05);
    }
    random_model_free(&d.m);
  }
}

/* Richardson's extrapolation from three step sizes removes h^2 and h^4: what is left would show a
 * limit that is not the exact solution. */
static void extrapolated_duffing_end_state_is_exact(void **context) {
  (void)context;
  duffing d;
  duffing_make(&d, 3.0);
  const double time = 1.7;
  const double exact = d.amplitude * jacobi_cn(d.rate * time, d.modulus, NULL);
  for (int i = 0; i < 5; i++) {
    // the end states of three runs, each with half the step of the one before
    double q[3];
    for (int level = 0; level < 3; level++) {
      const int64_t steps = INT64_C(200) << level;
      const thrum_state_def def = duffing_def(all[i], time / (double)steps);
      thrum_state *state = state_make(&d.m.model, &def);
      state_put(&d.m.model, state, &d.amplitude, NULL);
      state_steps(&d.m.model, state, steps);
      state_read(&d.m.model, state, &q[level], NULL);
      state_free(state);
    }

    // the finest run alone is off, the extrapolated one is not
    const double a = (4 * q[1] - q[0]) / 3, b = (4 * q[2] - q[1]) / 3;
    assert_true(fabs(q[2] - exact) > 1e-7);
    assert_true(fabs((16 * b - a) / 15 - exact) < 1e-9);
  }
  random_model_free(&d.m);
}

/* --- the linear oscillator -------------------------------------------------------------------- */

/* Computes the largest |q| over `steps` steps from q = 1 at rest, for omega = 1 and h omega =
 * angle. */
static double swing(thrum_integrator integrator, double angle, double alpha, int64_t steps,
                    double *last, double *before_last) {
  random_model m;
  random_model_make(&m, 1, 1, 1.0, 1.0, INFINITY);
  thrum_state_def def = duffing_def(integrator, angle);
  def.damping_alpha = alpha;

  thrum_state *state = state_make(&m.model, &def);

  // an unstable run ends before it overflows
  double q = 1, largest = 0;
  state_put(&m.model, state, &q, NULL);
  for (int64_t k = 0; k < steps && largest < 1e100; k++) {
    *before_last = q;
    state_steps(&m.model, state, 1);
    state_read(&m.model, state, &q, NULL);
    largest = fmax(largest, fabs(q));
  }

  *last = q;
  state_free(state);
  random_model_free(&m);
  return largest;
}

static void verlet_blows_up_just_above_its_bound_and_not_just_below(void **context) {
  (void)context;
  double a, b;
  assert_true(swing(THRUM_INTEGRATOR_VERLET, 1.9999, 0, 20000, &a, &b) < 1.0001);
  assert_true(swing(THRUM_INTEGRATOR_VERLET, 2.0001, 0, 20000, &a, &b) > 1e10);

  // centred damping leaves the bound where it is
  assert_true(swing(THRUM_INTEGRATOR_VERLET, 1.9999, 0.05, 20000, &a, &b) < 1.0001);
  assert_true(swing(THRUM_INTEGRATOR_VERLET, 2.01, 0.05, 20000, &a, &b) > 1e10);

  // the implicit midpoint rule has none
  assert_true(swing(THRUM_INTEGRATOR_MIDPOINT, 50, 0, 20000, &a, &b) < 1.0001);
  assert_true(swing(THRUM_INTEGRATOR_NEWMARK, 50, 0, 20000, &a, &b) < 1.0001);
}

static void verlet_grows_by_the_known_factors_above_its_bound(void **context) {
  (void)context;
  static const double f_times_h[3] = {0.35, 0.5, 1.0}, growth[3] = {2.4, 7.7, 37.5};
  for (int n = 0; n < 3; n++) {
    const double angle = 2 * pi * f_times_h[n], half_trace = 1 - angle * angle / 2;

    // after forty steps the larger root alone is left
    double last, before;
    swing(THRUM_INTEGRATOR_VERLET, angle, 0, 40, &last, &before);
    assert_true(fabs(fabs(last / before) - growth[n]) < 0.05);

    // the larger root of x^2 - (2 - h^2 omega^2) x + 1
    const double exact = half_trace - sqrt(half_trace * half_trace - 1);
    assert_true(fabs(last / before - exact) < 1e-9 * fabs(exact));
  }
}

static void imexv_chooses_its_split_at_the_bound(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 1, 10, 100.0, 1000.0, INFINITY);

  // frequencies are 100, 200, ... 1000: the bound is a count of them
  thrum_state_def def = imexv_def();
  const struct {
    thrum_split_rule rule;
    double dt, safety;
    int32_t count, expected;
  } cases[] = {
      {THRUM_SPLIT_CFL, 2.0 / 450, 1.0, 0, 4},   {THRUM_SPLIT_CFL, 2.0 / 450, 0.5, 0, 2},
      {THRUM_SPLIT_CFL, 1.0, 1.0, 0, 0},         {THRUM_SPLIT_CFL, 1e-5, 0.1, 0, 10},
      {THRUM_SPLIT_SAMPLING, 0.0139, 0.5, 0, 4}, {THRUM_SPLIT_SAMPLING, 1e-3, 0.5, 0, 10},
      {THRUM_SPLIT_COUNT, 1.0, 0.5, 7, 7},
  };

  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    def.split_rule = cases[n].rule;
    def.dt = cases[n].dt;
    def.split_safety = cases[n].safety;
    def.explicit_count = cases[n].count;

    thrum_state *state = state_make(&m.model, &def);

    const thrum_state_report report = thrum_state_report_get(state);
    assert_int_equal(report.explicit_modes, cases[n].expected);
    assert_int_equal(report.implicit_modes, 10 - cases[n].expected);
    state_free(state);
  }
  random_model_free(&m);
}

/* --- conserved and decaying quantities -------------------------------------------------------- */

enum { MODES = 6 };

/* Midpoint and average-acceleration Newmark keep the quadratic energy; Verlet keeps
 * p^2/2 + omega^2 q^2 (1 - h^2 omega^2 / 4) / 2 with synchronised p; imexv keeps each on its set.
 */
static void linear_invariants_are_kept_to_rounding(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 1, MODES, 1.0, 20.0, INFINITY);
  static const double start[MODES] = {0.9, -0.5, 0.3, 0.2, -0.1, 0.05};
  for (int i = 0; i < 5; i++) {
    thrum_state_def def = duffing_def(all[i], 0.09);
    def.split_rule = THRUM_SPLIT_COUNT;
    def.explicit_count = 3;

    thrum_state *state = state_make(&m.model, &def);

    // explicit modes keep the energy of Verlet, in the position form with the factor at p, the
    // others the quadratic one
    const int32_t split = thrum_state_report_get(state).explicit_modes;
    const bool position = def.integrator == THRUM_INTEGRATOR_IMEXV;

    double first[MODES] = {0}, q[MODES], p[MODES];
    state_put(&m.model, state, start, start);
    for (int k = 0; k < 2000; k++) {
      state_read(&m.model, state, q, p);
      for (int j = 0; j < MODES; j++) {
        const double factor = j < split ? 1 - def.dt * def.dt * m.omega2[j] / 4 : 1;
        const double kinetic = p[j] * p[j] * (position ? factor : 1);
        const double kept = 0.5 * (kinetic + m.omega2[j] * (position ? 1 : factor) * q[j] * q[j]);
        if (k == 0)
          first[j] = kept;
        assert_true(fabs(kept - first[j]) < 1e-10 * first[j]);
      }

      state_steps(&m.model, state, 1);
    }

    state_free(state);
  }
  random_model_free(&m);
}

/* D = alpha + beta omega^2 makes a mode's energy fall as exp(-D t), seen after whole periods of the
 * damped oscillation. */
static void damped_energy_decays_exponentially(void **context) {
  (void)context;
  random_model m;
  const double omega = 2 * pi;
  random_model_make(&m, 1, 1, omega, omega, INFINITY);
  static const double damping[3][2] = {{0.3, 0}, {0, 0.02}, {0.2, 0.01}};
  for (int i = 0; i < 5; i++)
    for (int n = 0; n < 3; n++)
      for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
        const double d = damping[n][0] + damping[n][1] * omega * omega;
        const double period = 2 * pi / sqrt(omega * omega - d * d / 4);

        thrum_state_def def = duffing_def(all[i], period / 1000);
        def.damping_alpha = damping[n][0];
        def.damping_beta = damping[n][1];
        def.damping_form = (thrum_damping_form)form;

        thrum_state *state = state_make(&m.model, &def);
        const double start = 0.5;
        state_put(&m.model, state, &start, NULL);

        // after each of five periods the rate is that of the damping
        const double first = state_energy(&m.model, state).total;
        for (int k = 1; k <= 5; k++) {
          state_steps(&m.model, state, 1000);
          const double rate = -log(state_energy(&m.model, state).total / first) / (k * period);
          assert_true(fabs(rate - d) < 1e-4 * d);
        }

        state_free(state);
      }
  random_model_free(&m);
}

/* Asserts that the means of the energy over windows of a nonlinear undamped run are bounded,
 * without a trend. */
static void expect_no_drift(const thrum_model *model, thrum_integrator integrator, double dt,
                            double bound) {
  enum { WINDOWS = 10, WINDOW = 10000 };
  thrum_state_def def = duffing_def(integrator, dt);
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = 2;

  thrum_state *state = state_make(model, &def);
  static const double start[4] = {0.25, 0.1, -0.05, 0.05};
  state_put(model, state, start, NULL);

  // the mean of each window, relative to the energy at the start
  const double first = state_energy(model, state).total;
  double mean[WINDOWS];
  for (int w = 0; w < WINDOWS; w++) {
    mean[w] = 0;
    for (int k = 0; k < WINDOW; k++) {
      state_steps(model, state, 1);
      mean[w] += state_energy(model, state).total / (first * WINDOW);
    }
    assert_true(fabs(mean[w] - mean[0]) < bound);
  }

  // the last mean is still near the first energy
  assert_true(fabs(mean[WINDOWS - 1] - 1) < 0.02);
  assert_int_equal(thrum_state_report_get(state).steps, WINDOWS * WINDOW);

  state_free(state);
}

static void long_runs_do_not_drift(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 4, 4, 1.0, 10.0, 0.5);

  // h omega = 0.3 for the fastest mode; bounds in the order of `all`, twice what was measured
  static const double bounds[5] = {3e-3, 8e-3, 6e-4, 1.5e-3, 1e-11};
  for (int i = 0; i < 5; i++)
    expect_no_drift(&m.model, all[i], 0.03, bounds[i]);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(elliptic_cosine_satisfies_its_identities),
      cmocka_unit_test(every_integrator_converges_to_the_duffing_solution),
      cmocka_unit_test(extrapolated_duffing_end_state_is_exact),
      cmocka_unit_test(verlet_blows_up_just_above_its_bound_and_not_just_below),
      cmocka_unit_test(verlet_grows_by_the_known_factors_above_its_bound),
      cmocka_unit_test(imexv_chooses_its_split_at_the_bound),
      cmocka_unit_test(linear_invariants_are_kept_to_rounding),
      cmocka_unit_test(damped_energy_decays_exponentially),
      cmocka_unit_test(long_runs_do_not_drift),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
