/* The stability monitor of imexv (design 4): its number is the spectral radius, modes leave and
 * return, the switch keeps the energy, and all of it comes along with a snapshot.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/sanitized.h"
#include "tests/support/state_support.h"

#include "core/state/state_layout.h"
#include "thrum/polynomial.h"

enum { RANK = 6 };

static const double start_q[RANK] = {0.3, -0.1, 0.15, 0.05, -0.04, 0.02};
static const double start_p[RANK] = {-0.2, 0.4, 0.1, -0.3, 0.2, 0.1};

static void make_model(random_model *m) {
  random_model_make(m, 21, RANK, 1.0, 12.0, 0.5);
}

static thrum_state_def make_def(int32_t explicit_count, double dt) {
  thrum_state_def def = imexv_def();
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = explicit_count;
  def.dt = dt;
  return def;
}

static void the_stability_number_at_rest_is_that_of_the_highest_explicit_mode(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  for (int split = 1; split <= RANK; split++) {
    const thrum_state_def def = make_def(split, 0.1);
    thrum_state *state = state_make(&m.model, &def);
    state_steps(&m.model, state, 2000);
    const thrum_state_report report = thrum_state_report_get(state);
    assert_true(fabs(report.stability_number_last - def.dt * sqrt(m.omega2[split - 1])) < 1e-6);
    assert_int_equal(report.split_changes + report.scheme_switches, 0);
    state_free(state);
  }
  random_model_free(&m);
}

/* In a body settled under a load the angle is that of T_EE there, found by many power iterations.
 */
static void the_stability_number_under_a_load_is_that_of_the_tangent(void **context) {
  (void)context;
  enum { SPLIT = 4 };
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(SPLIT, 0.05);
  def.damping_alpha = 3;
  def.damping_beta = 0.02;

  // strong damping brings the body to rest under its load
  thrum_state *state = state_make(&m.model, &def);
  const double load[RANK] = {3, -2, 4, 1, -5, 2};
  state_push(&m.model, state, load);
  state_steps(&m.model, state, 8000);

  // the largest eigenvalue of the explicit block of T, by power iteration
  double q[RANK], tangent[RANK * RANK], v[SPLIT] = {1, 1, 1, 1}, norm = 0;
  double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof(double));
  state_read(&m.model, state, q, NULL);
  thrum_tangent_stiffness(&m.model, q, tangent, work);

  for (int k = 0; k < 3000; k++) {
    double w[SPLIT] = {0};
    norm = 0;
    for (int i = 0; i < SPLIT; i++) {
      for (int j = 0; j < SPLIT; j++)
        w[i] += tangent[i * RANK + j] * v[j];
      norm += w[i] * w[i];
    }
    norm = sqrt(norm);
    for (int i = 0; i < SPLIT; i++)
      v[i] = w[i] / norm;
  }

  // h sqrt(lambda) is what the monitor reports
  const thrum_state_report report = thrum_state_report_get(state);
  assert_int_equal(report.explicit_modes, SPLIT);
  assert_true(fabs(report.stability_number_last / (def.dt * sqrt(norm)) - 1) < 1e-6);

  // the settled body is stiffer than at rest
  assert_true(report.stability_number_last > 1.02 * def.dt * sqrt(m.omega2[SPLIT - 1]));

  free(work);
  state_free(state);
  random_model_free(&m);
}

/* A load stiffens the body beyond the bound of a fixed split. With the monitor, modes leave E in
 * time, and come back when load and motion have gone. */
static void modes_leave_when_the_body_stiffens_and_return_after_a_quiet_time(void **context) {
  (void)context;
  enum { SPLIT = 5 };
  random_model m;
  make_model(&m);
  double energy[2] = {0, 0};
  for (int monitored = 0; monitored < 2; monitored++) {
    thrum_state_def def = make_def(SPLIT, 0.1);
    def.adaptive = monitored;
    def.fallback = 0;
    def.damping_alpha = 0.5;

    thrum_state *state = state_make(&m.model, &def);
    thrum_status status = THRUM_OK;

    // the load swings slowly, so that the body stiffens step by step
    for (int k = 0; k < 3000 && status >= 0; k++) {
      const double load[RANK] = {100 * sin(0.004 * k), 60 * sin(0.004 * k)};
      state_push(&m.model, state, load);
      status = thrum_step(&m.model, state, NULL);
      energy[monitored] = fmax(energy[monitored], state_energy(&m.model, state).total);
    }

    // the fixed split is lost
    if (!monitored) {
      assert_true(status < 0);
      state_free(state);
      continue;
    }
    assert_true(status >= 0);

    // the monitored one changes its split near the bound and goes on
    const thrum_state_report loaded = thrum_state_report_get(state);
    assert_true(loaded.split_changes > 0 && loaded.stability_number_peak > 1.6 &&
                loaded.stability_number_peak < 2.2);

    // without a load, damping takes the motion away
    state_push(&m.model, state, NULL);
    state_steps(&m.model, state, 150000);
    const thrum_state_report quiet = thrum_state_report_get(state);

    // the modes are back, even where the energies are too small to be normal numbers
    assert_int_equal(quiet.scheme_switches, 0);
    assert_int_equal(quiet.explicit_modes, SPLIT);
    assert_true(quiet.split_changes > loaded.split_changes);
    assert_int_equal(quiet.energy_steps + quiet.substep_steps, 0);
    state_free(state);
  }

  assert_true(energy[1] < 0.5 * energy[0]);
  random_model_free(&m);
}

/* Makes a state whose fixed split gains energy: large swings near the bound. */
static thrum_state *make_drifting(const thrum_model *model, thrum_split_form form) {
  thrum_state_def def = make_def(4, 0.08);
  def.split_form = form;
  thrum_state *state = state_make(model, &def);
  double q[RANK];
  for (int i = 0; i < RANK; i++)
    q[i] = 2 * start_q[i];
  state_put(model, state, q, NULL);
  return state;
}

static double mean_energy(const thrum_model *model, thrum_state *state, int64_t steps) {
  double sum = 0;
  for (int64_t k = 0; k < steps; k++) {
    state_steps(model, state, 1);
    sum += state_energy(model, state).total;
  }
  return sum / (double)steps;
}

/* The thesis split keeps the mean energy of its first steps, the position form the energy that the
 * run began with. */
static void a_drifting_run_switches_to_energy_at_its_first_energy(thrum_split_form form) {
  random_model m;
  make_model(&m);
  thrum_state *state = make_drifting(&m.model, form);
  const double begun = state_energy(&m.model, state).total;
  const double mean = mean_energy(&m.model, state, 2048);
  const double first = form == THRUM_FORM_POSITION ? begun : mean;
  state_steps(&m.model, state, 100000);

  // the run went over to the energy integrator, and stayed with it
  const thrum_state_report report = thrum_state_report_get(state);
  assert_int_equal(report.scheme_switches, 1);
  assert_int_equal(report.scheme, THRUM_SCHEME_ENERGY);
  assert_int_equal(report.explicit_modes, 0);
  assert_true(report.switched_steps > 50000 && report.switched_steps < report.steps);

  const double last = mean_energy(&m.model, state, 4096);
  if (!(fabs(last / first - 1) < 1e-4))
    fail_msg("%.3e of the mean energy", last / first - 1);

  state_free(state);
  random_model_free(&m);
}

static void a_drifting_run_of_either_form_switches_to_energy(void **context) {
  (void)context;
  a_drifting_run_switches_to_energy_at_its_first_energy(THRUM_FORM_THESIS);
  a_drifting_run_switches_to_energy_at_its_first_energy(THRUM_FORM_POSITION);
}

/* Energy that moves among modes changes the mean energy of the thesis split, which conserves
 * another energy. Once the monitor has seen that it does not come back, the mean returns to what it
 * was and stays, and the report says how much was corrected. */
static void slow_drift_goes_back_through_the_momentum(void **context) {
  (void)context;
  enum { PARTS = LENGTH_OF_RUN(20, 8), PART = 10000, SEEN = PARTS / 2 };
  random_model m;
  make_model(&m);
  double worst[2] = {0, 0};
  for (int monitored = 0; monitored < 2; monitored++) {
    thrum_state_def def = make_def(4, 0.05);
    def.adaptive = monitored;
    def.split_form = THRUM_FORM_THESIS;
    thrum_state *state = state_make(&m.model, &def);

    double q[RANK];
    for (int i = 0; i < RANK; i++)
      q[i] = 1.2 * start_q[i];
    state_put(&m.model, state, q, NULL);

    // the worst mean of a part in the second half, beside that of the steps of the reference
    const double first = mean_energy(&m.model, state, 2048);
    for (int part = 0; part < PARTS; part++) {
      const double mean = mean_energy(&m.model, state, PART);
      if (part >= SEEN)
        worst[monitored] = fmax(worst[monitored], fabs(mean / first - 1));
    }

    // corrections were made where the run was monitored, and they are small
    const thrum_state_report report = thrum_state_report_get(state);
    assert_int_equal(report.scheme_switches, 0);
    assert_true(monitored == (report.corrections > 0));
    assert_true(fabs(report.corrected) <= 0.041 * first);

    state_free(state);
  }

  // means of so many steps scatter
  if (!(worst[1] < 1.5e-4 && worst[0] > 10 * worst[1]))
    fail_msg("%.3e of the mean energy, unwatched %.3e", worst[1], worst[0]);
  random_model_free(&m);
}

/* After a switch the energy is what it was at the start of the run, to rounding: the conserving
 * step (design 7) returns to the target energy, not to what the split had drifted to. */
static void a_violent_run_goes_on_with_the_energy_it_began_with(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(5, 0.15);

  thrum_state *state = state_make(&m.model, &def);
  double q[RANK];
  for (int i = 0; i < RANK; i++)
    q[i] = 4 * start_q[i];
  state_put(&m.model, state, q, NULL);

  // the switch comes within the first hundred steps
  const double first = state_energy(&m.model, state).total;
  state_steps(&m.model, state, 1000);
  const thrum_state_report report = thrum_state_report_get(state);
  assert_int_equal(report.scheme_switches, 1);
  assert_true(report.switched_steps > 900);

  // the energy is compared with its target in one of eight steps
  double nearest = INFINITY;
  for (int k = 1; k <= 800; k++) {
    state_steps(&m.model, state, 1);
    const double off = fabs(state_energy(&m.model, state).total / first - 1);
    nearest = fmin(nearest, off);
    if (!(off < 1e-9 && (k % 8 != 0 || nearest < 1e-13)))
      fail_msg("step %d: %.3e of the energy, at least %.3e", k, off, nearest);
    nearest = k % 8 == 0 ? INFINITY : nearest;
  }

  state_free(state);
  random_model_free(&m);
}

/* So it is where the switch comes in the monitor's first window, after steps that have changed the
 * energy: the energy at the start is the reference already. */
static void a_switch_in_the_first_window_goes_back_to_the_energy_at_the_start(void **context) {
  (void)context;
  enum { WINDOW = 128 };
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(5, 0.1);

  thrum_state *state = state_make(&m.model, &def);
  double q[RANK];
  for (int i = 0; i < RANK; i++)
    q[i] = 2.5 * start_q[i];
  state_put(&m.model, state, q, NULL);

  // the energy before the step that switches is not the one of the start
  const double first = state_energy(&m.model, state).total;
  double before = first;
  while (thrum_state_report_get(state).scheme_switches == 0) {
    before = state_energy(&m.model, state).total;
    state_steps(&m.model, state, 1);
    assert_true(thrum_state_report_get(state).steps < WINDOW);
  }
  assert_true(fabs(before / first - 1) > 1e-4);

  // it comes back
  state_steps(&m.model, state, 1000);
  const double off = state_energy(&m.model, state).total / first - 1;
  if (!(fabs(off) < 1e-9))
    fail_msg("%.3e of the energy", off);

  state_free(state);
  random_model_free(&m);
}

/* An impulse of one step gives more energy than the sum of its work shows, so the energy after it
 * is the one to keep. */
static void an_impulse_is_no_drift(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  const thrum_state_def def = make_def(4, 0.05);
  thrum_state *state = state_make(&m.model, &def);

  const double impulse[RANK] = {4, -3, 2, 3, -2, 1};

  // a load of one step, and free motion after it
  state_steps(&m.model, state, 100);
  state_push(&m.model, state, impulse);
  state_steps(&m.model, state, 1);
  state_push(&m.model, state, NULL);
  state_steps(&m.model, state, 20000);

  // the monitor finds no drift of the energy
  const thrum_state_report report = thrum_state_report_get(state);
  assert_int_equal(report.scheme_switches + report.split_changes, 0);
  assert_true(fabs(report.balance_peak) < 0.03);

  state_free(state);
  random_model_free(&m);
}

/* When the energy of a run that drifted has been taken out, imexv comes back. */
static void returns_when_the_energy_has_fallen(thrum_split_form form, thrum_scheme scheme) {
  random_model m;
  make_model(&m);
  thrum_state *state = make_drifting(&m.model, form);
  while (thrum_state_report_get(state).scheme_switches == 0)
    state_steps(&m.model, state, 100);

  // a load against the momentum takes the energy out
  double p[RANK];
  for (int k = 0; k < 20000; k++) {
    state_read(&m.model, state, NULL, p);
    for (int i = 0; i < RANK; i++)
      p[i] *= -0.2;
    state_push(&m.model, state, p);
    state_steps(&m.model, state, 1);
  }

  // a free run follows, in which imexv comes back with its split
  state_push(&m.model, state, NULL);
  state_steps(&m.model, state, 20000);

  const thrum_state_report report = thrum_state_report_get(state);
  assert_int_equal(report.scheme_switches, 2);
  assert_int_equal(report.scheme, scheme);
  assert_int_equal(report.explicit_modes, 4);

  state_free(state);
  random_model_free(&m);
}

static void imexv_returns_when_the_energy_has_fallen(void **context) {
  (void)context;
  returns_when_the_energy_has_fallen(THRUM_FORM_THESIS, THRUM_SCHEME_THESIS);
  returns_when_the_energy_has_fallen(THRUM_FORM_POSITION, THRUM_SCHEME_POSITION);
}

/* From snapshots before and after every event of the monitor, the same steps follow, bit for bit.
 */
static void a_snapshot_brings_the_stability_monitor_along(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state *state = make_drifting(&m.model, THRUM_FORM_THESIS);
  const size_t bytes = thrum_state_kept_bytes(state);

  int64_t scheme_switches = 0;
  for (int part = 0; part < 300 && scheme_switches == 0; part++) {
    void *kept = state_snapshot(state);
    state_steps(&m.model, state, 200);
    void *after = state_snapshot(state);
    scheme_switches = thrum_state_report_get(state).scheme_switches;

    // the same steps from the snapshot give the same bytes
    memcpy(state, kept, bytes);
    state_steps(&m.model, state, 200);
    assert_memory_equal(state, after, bytes);

    free(kept);
    free(after);
  }

  // the last part held the switch
  assert_int_equal(scheme_switches, 1);
  state_free(state);
  random_model_free(&m);
}

/* As long as the monitor finds nothing, the motion is that of a fixed split. */
static void a_quiet_run_is_not_touched(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  double q[2][RANK], p[2][RANK];
  for (int monitored = 0; monitored < 2; monitored++) {
    thrum_state_def def = make_def(3, 0.02);
    def.adaptive = monitored;
    thrum_state *state = state_make(&m.model, &def);

    // a tenth of the usual start is a small motion
    for (int i = 0; i < RANK; i++) {
      q[monitored][i] = 0.1 * start_q[i];
      p[monitored][i] = 0.1 * start_p[i];
    }
    state_put(&m.model, state, q[monitored], p[monitored]);

    // the monitor finds nothing in it
    state_steps(&m.model, state, 20000);
    state_read(&m.model, state, q[monitored], p[monitored]);
    const thrum_state_report report = thrum_state_report_get(state);
    assert_int_equal(report.scheme_switches + report.split_changes + report.corrections, 0);
    state_free(state);
  }

  // and so the motion is the same, bit for bit
  assert_memory_equal(q[0], q[1], sizeof q[0]);
  assert_memory_equal(p[0], p[1], sizeof p[0]);
  random_model_free(&m);
}

/* An explicit mode that lies beyond the bound from the start becomes implicit before it grows. */
static void a_split_beyond_the_bound_is_mended_at_once(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 1, RANK, 1.0, 30.0, INFINITY);
  const thrum_state_def def = make_def(RANK, 0.1);
  thrum_state *state = state_make(&m.model, &def);
  state_put(&m.model, state, start_q, start_p);

  // the energy never doubles
  const double first = state_energy(&m.model, state).total;
  for (int k = 0; k < 5000; k++) {
    state_steps(&m.model, state, 1);
    assert_true(state_energy(&m.model, state).total < 2 * first);
  }

  // the lowest implicit mode is one near the bound
  const thrum_state_report report = thrum_state_report_get(state);
  assert_true(report.split_changes > 0);
  assert_true(def.dt * sqrt(m.omega2[report.explicit_modes]) > 1.4);

  state_free(state);
  random_model_free(&m);
}

/* After so many quiet steps, none from rest, a constant load f sets in: from then on the energy
 * grows by f (q - q_0). Returns the largest error of that in any step, relative to the most work
 * that was done. */
static double worst_balance(const thrum_model *model, double dt, int quiet, const double *force) {
  thrum_state_def def = imexv_def();
  double q[RANK], before[RANK], small_q[RANK], small_p[RANK], largest = 0, worst = 0;
  def.dt = dt;
  thrum_state *state = state_make(model, &def);

  // a swing that leaves the monitor nothing to do
  for (int i = 0; i < RANK; i++) {
    small_q[i] = 0.01 * start_q[i];
    small_p[i] = 0.01 * start_p[i];
  }
  if (quiet > 0)
    state_put(model, state, small_q, small_p);
  state_steps(model, state, quiet);
  const double first = state_energy(model, state).total;
  state_read(model, state, before, NULL);

  state_push(model, state, force);
  for (int step = 0; step < 300; step++) {
    // the work of a constant load
    double work = 0;
    state_steps(model, state, 1);
    state_read(model, state, q, NULL);
    for (int i = 0; i < RANK; i++)
      work += force[i] * (q[i] - before[i]);
    largest = fmax(largest, fabs(work));
    worst = fmax(worst, fabs(state_energy(model, state).total - first - work));
  }
  state_free(state);
  return worst / largest;
}

/* The loads go up to a thousand times what bends the body into its nonlinear range, the steps from
 * a twentieth of the slowest motion to hundreds of it. A jump of the energy is not left for the
 * next step to correct. */
static void a_sudden_load_however_large_leaves_no_wrong_energy(void **context) {
  (void)context;
  static const double steps[] = {0.05, 0.15, 1, 3, 30, 300};
  random_model m;
  make_model(&m);
  for (size_t n = 0; n < sizeof steps / sizeof steps[0]; n++) {
    for (double times = 0.1; times < 2000; times *= 10) {
      const double force[RANK] = {0.5 * times, 2 * times, -1 * times, 0, 0.3 * times, 0};
      const double worst = worst_balance(&m.model, steps[n], 0, force);
      if (!(worst < (steps[n] < 0.2 ? 0.2 : 0.25)))
        fail_msg("at a step of %g under a load of %g the balance errs by %g", steps[n], times,
                 worst);
    }
  }
  random_model_free(&m);
}

/* In long quiet motion the monitor evaluates the energy and the stability number seldom; a load
 * that then sets in is seen as soon as one at the start. */
static void a_sudden_load_after_quiet_motion_leaves_no_wrong_energy(void **context) {
  (void)context;
  static const double steps[] = {0.05, 0.15};
  random_model m;
  make_model(&m);
  for (size_t n = 0; n < sizeof steps / sizeof steps[0]; n++) {
    for (double times = 0.1; times < 2000; times *= 10) {
      const double force[RANK] = {0.5 * times, 2 * times, -1 * times, 0, 0.3 * times, 0};
      const double worst = worst_balance(&m.model, steps[n], 4007, force);
      if (!(worst < 0.2))
        fail_msg("at a step of %g under a load of %g the balance errs by %g", steps[n], times,
                 worst);
    }
  }
  random_model_free(&m);
}

/* Largest error of the energy in any of the first steps after a kick. */
static double worst_after_kick(const thrum_model *model, const thrum_state_def *def,
                               const double *p) {
  thrum_state *state = state_make(model, def);
  state_put(model, state, NULL, p);
  const double energy = state_energy(model, state).total;
  double worst = 0;
  for (int k = 0; k < 100; k++) {
    state_steps(model, state, 1);
    worst = fmax(worst, fabs(state_energy(model, state).total / energy - 1));
  }
  state_free(state);
  return worst;
}

/* No state that a caller sees has another energy, from the first step on, in any form. At large
 * steps the energy of a linear mode ripples by a quarter, and by less at small ones. */
static void a_wide_kick_keeps_its_energy_in_every_step(void **context) {
  (void)context;
  static const double steps[] = {0.05, 0.15, 0.3, 1, 3, 30};
  const uint64_t end = LENGTH_OF_RUN(31, 22);
  for (uint64_t seed = 21; seed < end; seed += 3) {
    random_model m;
    random_model_make(&m, seed, RANK, 1.0, 12.0, 0.5);

    for (size_t n = 0; n < sizeof steps / sizeof steps[0]; n++) {
      for (double times = 0.1; times < 2e4; times *= 10) {
        // momenta from small to far beyond the linear range
        const double p[RANK] = {0.5 * times, 2 * times, -1 * times, 0, 0.3 * times, 0};
        thrum_state_def def = imexv_def();
        def.dt = steps[n];

        // the bound of each form holds at small and at large steps
        for (int form = THRUM_FORM_THESIS; form <= THRUM_FORM_POSITION; form++) {
          def.split_form = (thrum_split_form)form;
          const double worst = worst_after_kick(&m.model, &def, p);
          const bool position = form == THRUM_FORM_POSITION;
          const double small = position ? 0.2 : 0.15, large = position ? 0.36 : 0.34;
          if (!(worst < (steps[n] < 0.2 ? small : large)))
            fail_msg("seed %d, a step of %g, a kick of %g, %s: the energy errs by %g", (int)seed,
                     steps[n], times, thrum_split_form_name(def.split_form), worst);
        }
      }
    }
    random_model_free(&m);
  }
}

/* A kick in the middle of a quiet run is one more first step. */
static void a_kick_in_a_quiet_run_keeps_its_energy(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def = imexv_def();
  def.dt = 0.15;
  for (double times = 1; times < 2e4; times *= 10) {
    thrum_state *state = state_make(&m.model, &def);
    double q[RANK], p[RANK];
    state_put(&m.model, state, start_q, NULL);
    state_steps(&m.model, state, 500);
    state_read(&m.model, state, q, p);
    p[0] += 2 * times;
    p[1] -= times;
    state_put(&m.model, state, q, p);

    // the energy after the kick is the one to keep
    const double energy = state_energy(&m.model, state).total;
    for (int k = 0; k < 50; k++) {
      state_steps(&m.model, state, 1);
      const double error = fabs(state_energy(&m.model, state).total / energy - 1);
      if (!(error < 0.15))
        fail_msg("a kick of %g, step %d: the energy errs by %g", times, k, error);
    }
    state_free(state);
  }
  random_model_free(&m);
}

/* From the switch on each step says that another scheme made it, also in a batch; before, and after
 * the return, none does. */
static void a_switch_shows_in_the_status_of_each_step(void **context) {
  (void)context;
  static const double force[RANK] = {50, 200, -100, 0, 30, 0};
  random_model m;
  make_model(&m);
  thrum_state_def def = imexv_def();
  def.split_form = THRUM_FORM_THESIS;
  def.dt = 0.15;
  def.damping_alpha = 1;
  thrum_state *state = state_make(&m.model, &def), *other = state_make(&m.model, &def);
  thrum_state *both[2] = {state, other};
  thrum_status statuses[2];
  size_t size = 0;
  assert_int_equal(thrum_batch_size(&m.model, &size, NULL), THRUM_OK);
  void *workspace = aligned_alloc(64, (size + 63) / 64 * 64);

  // ten quiet steps, then a load on one of the two
  const double quiet[RANK] = {0.01};
  state_put(&m.model, state, NULL, quiet);
  state_put(&m.model, other, NULL, quiet);
  for (int k = 0; k < 10; k++)
    assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_OK);
  assert_int_equal(thrum_state_report_get(state).first_switch, -1);
  state_push(&m.model, state, force);
  for (int k = 0; k < 20; k++) {
    assert_int_equal(thrum_batch_step(&m.model, both, 2, statuses, workspace, size, NULL),
                     THRUM_SWITCHED);
    assert_int_equal(statuses[0], THRUM_SWITCHED);
    assert_int_equal(statuses[1], THRUM_OK);
  }
  assert_int_equal(thrum_state_report_get(state).first_switch, 10);
  assert_int_equal(thrum_state_report_get(state).switched_steps, 20);

  // damping brings the def's scheme back, and the report remembers
  state_push(&m.model, state, NULL);
  state_steps(&m.model, state, 9000);
  assert_int_equal(thrum_step(&m.model, state, NULL), THRUM_OK);
  assert_int_equal(thrum_state_report_get(state).first_switch, 10);

  // the quadratic split that gave way to the thesis split says so too
  state_free(other);
  def.split_form = THRUM_FORM_QUADRATIC;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = RANK;
  def.damping_alpha = 0;
  other = state_make(&m.model, &def);
  state_put(&m.model, other, quiet, NULL);
  thrum_status status = THRUM_OK;
  for (int k = 0; k < 200; k++)
    status = thrum_step(&m.model, other, NULL);
  assert_int_equal(thrum_state_report_get(other).scheme, THRUM_SCHEME_THESIS);
  assert_int_equal(status, THRUM_SWITCHED);

  free(workspace);
  state_free(state);
  state_free(other);
  random_model_free(&m);
}

/* A state that switched to the energy integrator under a sudden load from rest returns when the
 * motion has been damped. */
static void a_switch_from_rest_ends_too(void **context) {
  (void)context;
  static const double force[RANK] = {500, 2000, -1000, 0, 300, 0};
  random_model m;
  make_model(&m);
  thrum_state_def def = imexv_def();
  def.dt = 0.15;
  def.damping_alpha = 1;

  // the first step under the load switches already
  thrum_state *state = state_make(&m.model, &def);
  state_push(&m.model, state, force);
  state_steps(&m.model, state, 1);
  assert_int_equal(thrum_state_report_get(state).scheme, THRUM_SCHEME_ENERGY);

  // without the load, damping brings the position form back
  state_push(&m.model, state, NULL);
  state_steps(&m.model, state, 9000);
  assert_int_equal(thrum_state_report_get(state).scheme, THRUM_SCHEME_POSITION);
  assert_int_equal(thrum_state_report_get(state).scheme_switches, 2);

  state_free(state);
  random_model_free(&m);
}

static void what_damping_took_long_ago_allows_no_error(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  for (int form = 0; form < 2; form++) {
    thrum_state_def def = make_def(3, 0.02);
    def.split_form = form == 0 ? THRUM_FORM_THESIS : THRUM_FORM_POSITION;
    def.damping_alpha = 1;
    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, start_q, start_p);

    // nearly all energy is gone before the last 512 steps, which is twice as long as it is
    // remembered
    state_steps(&m.model, state, 500);
    const double before = thrum_state_report_get(state).dissipated;
    state_steps(&m.model, state, 512);
    const double lately = thrum_state_report_get(state).dissipated - before;
    assert_true(before > 1e3 * lately && lately > 0);
    assert_true(state->monitor.recent < 0.2 * before);
    state_free(state);
  }
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_stability_number_at_rest_is_that_of_the_highest_explicit_mode),
      cmocka_unit_test(the_stability_number_under_a_load_is_that_of_the_tangent),
      cmocka_unit_test(modes_leave_when_the_body_stiffens_and_return_after_a_quiet_time),

      // drift, and motion that is no drift
      cmocka_unit_test(a_drifting_run_of_either_form_switches_to_energy),
      cmocka_unit_test(slow_drift_goes_back_through_the_momentum),
      cmocka_unit_test(a_violent_run_goes_on_with_the_energy_it_began_with),
      cmocka_unit_test(a_switch_in_the_first_window_goes_back_to_the_energy_at_the_start),
      cmocka_unit_test(an_impulse_is_no_drift),

      // what follows a switch, and runs without one
      cmocka_unit_test(imexv_returns_when_the_energy_has_fallen),
      cmocka_unit_test(a_snapshot_brings_the_stability_monitor_along),
      cmocka_unit_test(a_quiet_run_is_not_touched),
      cmocka_unit_test(a_split_beyond_the_bound_is_mended_at_once),

      // sudden loads and kicks
      cmocka_unit_test(a_sudden_load_however_large_leaves_no_wrong_energy),
      cmocka_unit_test(a_sudden_load_after_quiet_motion_leaves_no_wrong_energy),
      cmocka_unit_test(a_wide_kick_keeps_its_energy_in_every_step),
      cmocka_unit_test(a_kick_in_a_quiet_run_keeps_its_energy),
      cmocka_unit_test(a_switch_shows_in_the_status_of_each_step),
      cmocka_unit_test(a_switch_from_rest_ends_too),
      cmocka_unit_test(what_damping_took_long_ago_allows_no_error),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
