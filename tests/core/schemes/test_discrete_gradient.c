/* Tests of the energy-conserving step (design 7): its equations with both mean forces, and its
 * energy at any step, with load and damping. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"
#include "thrum/polynomial.h"

enum { RANK = 6 };

static const double start_q[RANK] = {0.3, -0.1, 0.15, 0.05, -0.04, 0.02};
static const double start_p[RANK] = {-0.2, 0.4, 0.1, -0.3, 0.2, 0.1};
static const double push[RANK] = {0.5, -0.4, 0.3, -0.2, 0.1, 0.6};

static void make_model(random_model *m) {
  random_model_make(m, 21, RANK, 1.0, 12.0, 0.5);
}

static thrum_state_def make_def(double dt) {
  thrum_state_def def = imexv_def();
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  def.dt = dt;
  return def;
}

/* The energy stays within `share` of itself over so many steps from q and p. */
static void expect_energy_kept(const thrum_model *model, const thrum_state_def *def,
                               const double *q, const double *p, int steps, double share) {
  thrum_state *state = state_make(model, def);
  state_put(model, state, q, p);
  const double first = state_energy(model, state).total;
  for (int k = 0; k < steps; k++) {
    state_steps(model, state, 1);
    const double now = state_energy(model, state).total;
    if (!(fabs(now - first) < share * first))
      fail_msg("dt %g, step %d: %.3e of the energy", def->dt, k, (now - first) / first);
  }
  state_free(state);
}

static void energy_is_conserved_at_any_step(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  static const double steps[5] = {0.003, 0.01, 0.05, 0.3, 2.0};
  for (int n = 0; n < 5; n++) {
    const thrum_state_def def = make_def(steps[n]);
    expect_energy_kept(&m.model, &def, start_q, start_p, 3000, 1e-11);
  }
  random_model_free(&m);
}

/* Scaling p' corrects the error of the energy that a loose solve leaves. */
static void energy_is_conserved_whatever_the_tolerance(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(0.05);
  def.tolerance = 1e-4;
  thrum_state *state = state_make(&m.model, &def);
  state_put(&m.model, state, start_q, start_p);

  const double first = state_energy(&m.model, state).total;
  double loosest = 0;
  for (int k = 0; k < 3000; k++) {
    state_steps(&m.model, state, 1);
    loosest = fmax(loosest, thrum_state_report_get(state).residual_last);
    assert_true(fabs(state_energy(&m.model, state).total - first) < 1e-12 * first);
  }

  // solves did end early
  assert_true(loosest > 1e-6);
  state_free(state);
  random_model_free(&m);
}

/* Where that error is more than p' can take up, the step is made again, in parts if need be. */
static void a_large_step_keeps_its_energy_with_a_loose_solve(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(100.0);
  def.tolerance = 1e-3;
  expect_energy_kept(&m.model, &def, start_q, start_p, 1000, 1e-2);
  random_model_free(&m);
}

/* The tolerance of a solve and rounding do not add up: after many steps the energy is off by no
 * more than after few, also where every solve ends early. */
static void errors_of_the_energy_do_not_add_up(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  for (int loose = 0; loose < 2; loose++) {
    thrum_state_def def = make_def(0.3);
    def.tolerance = loose ? 1e-6 : 1e-10;
    def.iterations_max = loose ? 3 : 50;

    thrum_state *state = state_make(&m.model, &def);
    double q[RANK];
    for (int i = 0; i < RANK; i++)
      q[i] = 3 * start_q[i];
    state_put(&m.model, state, q, start_p);

    // the energy after the first step is the one to compare with
    state_steps(&m.model, state, 1);
    const double first = state_energy(&m.model, state).total;

    // in each sixteen steps one must come back to it within rounding
    for (int k = 0; k < 2000; k++) {
      double nearest = INFINITY;
      for (int n = 0; n < 16; n++) {
        state_steps(&m.model, state, 1);
        const double off = fabs(state_energy(&m.model, state).total / first - 1);
        nearest = fmin(nearest, off);
        if (!(off < (loose ? 1e-4 : 1e-11)))
          fail_msg("%s solves, step %d: %.3e of the energy", loose ? "loose" : "exact", 16 * k,
                   off);
      }
      if (!(nearest < 1e-13))
        fail_msg("%s solves, step %d: %.3e of the energy", loose ? "loose" : "exact", 16 * k,
                 nearest);
    }

    state_free(state);
  }
  random_model_free(&m);
}

/* Modes far stiffer than the step swing from one end to the other in each, and their forces are
 * thousands of times their momenta: those do not take over the rounding of these. */
static void stiff_modes_keep_their_energy(void **context) {
  (void)context;
  for (int nonlinear = 0; nonlinear < 2; nonlinear++) {
    random_model m;
    random_model_make(&m, 3, RANK, 1.0, 30.0, nonlinear ? 1.0 : INFINITY);

    double q[RANK], p[RANK];
    for (int i = 0; i < RANK; i++) {
      q[i] = 0.1 * start_q[i];
      p[i] = 0.1 * start_p[i];
    }

    // h omega goes up to 30,000
    for (double dt = 100.0; dt <= 1000.0; dt *= 10.0) {
      const thrum_state_def def = make_def(dt);
      expect_energy_kept(&m.model, &def, q, p, 2000, 1e-13);
    }

    random_model_free(&m);
  }
}

/* With a load that changes its sign and with damping, the energy is that of the start plus the sum
 * of work less dissipation. */
static void the_account_follows_work_and_dissipation(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  thrum_state_def def = make_def(0.1);
  def.damping_alpha = 1e-3;
  thrum_state *state = state_make(&m.model, &def);
  state_put(&m.model, state, start_q, start_p);

  matched_step by[RANK];
  state_matched_steps(&m.model, state, def.dt, by);

  // the energy that it should have, and how much was put in and taken out in all
  double expected = state_energy(&m.model, state).total, moved = 0;
  for (int k = 0; k < 20000; k++) {
    double f[RANK], before[RANK], after[RANK];
    for (int i = 0; i < RANK; i++)
      f[i] = 0.05 * push[i] * sin(0.07 * k);

    state_push(&m.model, state, f);
    state_read(&m.model, state, before, NULL);
    state_steps(&m.model, state, 1);
    state_read(&m.model, state, after, NULL);

    // work of the load less that of the damping over the step
    for (int i = 0; i < RANK; i++) {
      const double d = after[i] - before[i], v = by[i].speed * d / def.dt;
      const double gain = d * f[i] - def.dt * def.damping_alpha * v * v;
      expected += gain;
      moved += fabs(gain);
    }
  }

  const double now = state_energy(&m.model, state).total;
  if (!(fabs(now - expected) < 1e-13 * (now + moved)))
    fail_msg("%.3e of %.3e J, %.3e J moved", now - expected, now, moved);

  state_free(state);
  random_model_free(&m);
}

/* With d = q' - q and v = nu d/h, E' - E = f d - h v D v holds in every single step, to rounding.
 */
static void energy_changes_by_work_less_dissipation(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof(double));
  for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
    thrum_state_def def = make_def(0.07);
    def.damping_alpha = 0.3;
    def.damping_beta = 0.004;
    def.damping_form = (thrum_damping_form)form;

    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, start_q, start_p);
    matched_step by[RANK];
    state_matched_steps(&m.model, state, def.dt, by);

    random_state random = {5};
    for (int k = 0; k < 300; k++) {
      double f[RANK], before[RANK], after[RANK], v[RANK], middle[RANK], product[RANK];
      random_vector(&random, RANK, 3.0, f);
      state_push(&m.model, state, f);
      state_read(&m.model, state, before, NULL);

      // the change of the energy in one step
      double change = -state_energy(&m.model, state).total;
      state_steps(&m.model, state, 1);
      change += state_energy(&m.model, state).total;
      state_read(&m.model, state, after, NULL);

      // the work less the dissipation, with T of the middle in the tangent form
      double expected = 0, size = 0;
      for (int i = 0; i < RANK; i++) {
        v[i] = by[i].speed * (after[i] - before[i]) / def.dt;
        middle[i] = 0.5 * (after[i] + before[i]);
      }
      thrum_tangent_product(&m.model, middle, v, product, work);
      for (int i = 0; i < RANK; i++) {
        const double stiff = form == THRUM_DAMPING_TANGENT ? product[i] : m.omega2[i] * v[i];
        const double drag = def.damping_alpha * v[i] + def.damping_beta * stiff;
        const double gain = f[i] * (after[i] - before[i]), loss = def.dt * v[i] * drag;
        expected += gain - loss;
        size += fabs(gain) + fabs(loss);
      }

      assert_true(fabs(change - expected) < 1e-10 * (size + fabs(change)));
    }

    state_free(state);
  }
  free(work);
  random_model_free(&m);
}

/* Impulses throw a body of few modes far beyond where it is linear, and end it there at a
 * standstill: there is no p' to take up what the mean force leaves of the balance. */
static void a_kick_of_any_size_keeps_the_balance(void **context) {
  (void)context;
  for (int64_t rank = 1; rank <= 3; rank++) {
    random_model m;
    random_model_make(&m, 21, rank, 1.0, 12.0, 0.5);
    for (double impulse = 1e4; impulse < 1e12; impulse *= 10) {
      const thrum_state_def def = make_def(impulse < 1e8 ? 2.0 : 0.3);
      thrum_state *state = state_make(&m.model, &def);

      // five gentle steps and five under impulses, in turns
      random_state random = {4};
      for (int k = 0; k < 60; k++) {
        double f[RANK], before[RANK], after[RANK];
        random_vector(&random, rank, k % 10 < 5 ? 1.0 : impulse, f);
        state_push(&m.model, state, f);
        state_read(&m.model, state, before, NULL);

        const double first = state_energy(&m.model, state).total;
        state_steps(&m.model, state, 1);
        const double last = state_energy(&m.model, state).total;
        state_read(&m.model, state, after, NULL);

        // the change of the energy is the work of the load
        double work = 0, size = first + last;
        for (int64_t i = 0; i < rank; i++) {
          work += f[i] * (after[i] - before[i]);
          size += fabs(f[i] * (after[i] - before[i]));
        }
        if (!(fabs(last - first - work) < 1e-9 * size))
          fail_msg("rank %d, impulse %g, step %d: %.3e of the energy", (int)rank, impulse, k,
                   (last - first - work) / size);
      }

      state_free(state);
    }
    random_model_free(&m);
  }
}

/* Computes how far p' is off from p - lambda dt (mean - f), with the mean force of the ends, and
 * with that of the path: R is cubic along the step, so Simpson's rule is exact; and q' from q +
 * lambda dt/2 (p + p'). */
static void errors_of_step(const thrum_model *model, const thrum_state *state, double dt,
                           const double *f, double q[2][RANK], double p[2][RANK], double *work,
                           double *ends, double *path, double *half) {
  double middle[RANK], d[RANK], force[3][RANK], square = 0, along = 0;
  for (int i = 0; i < RANK; i++) {
    middle[i] = 0.5 * (q[0][i] + q[1][i]);
    d[i] = q[1][i] - q[0][i];
  }

  // forces at both ends and in the middle, energies at the ends
  const double start = thrum_internal_force(model, q[0], force[0], work);
  thrum_internal_force(model, middle, force[1], work);
  const double end = thrum_internal_force(model, q[1], force[2], work);

  for (int i = 0; i < RANK; i++) {
    square += d[i] * d[i];
    along += 0.5 * (force[0][i] + force[2][i]) * d[i];
  }

  // compare the change of the momentum with both mean forces
  matched_step by[RANK];
  state_matched_steps(model, state, dt, by);
  *ends = *path = *half = 0;
  for (int i = 0; i < RANK; i++) {
    const double own = by[i].stretch * dt, push_back = (p[1][i] - p[0][i]) / own - f[i];
    const double of_path = (force[0][i] + 4 * force[1][i] + force[2][i]) / 6;
    const double of_ends =
        0.5 * (force[0][i] + force[2][i]) + (end - start - along) / square * d[i];
    *ends = fmax(*ends, dt * fabs(push_back + of_ends));
    *path = fmax(*path, dt * fabs(push_back + of_path));
    *half = fmax(*half, fabs(d[i] - 0.5 * own * (p[0][i] + p[1][i])));
  }
}

/* Steps that quasi-Newton solves at once are those of the ends; damping in tangent form, here as
 * good as none, goes with the path. */
static void a_step_satisfies_its_equations(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof(double));
  for (int form = THRUM_DAMPING_REST; form <= THRUM_DAMPING_TANGENT; form++) {
    thrum_state_def def = make_def(0.2);
    def.tolerance = 1e-14;
    def.damping_form = (thrum_damping_form)form;
    def.damping_beta = 1e-200;

    thrum_state *state = state_make(&m.model, &def);
    state_put(&m.model, state, start_q, start_p);
    state_push(&m.model, state, push);
    for (int k = 0; k < 50; k++) {
      double q[2][RANK], p[2][RANK], ends, path, half;

      state_read(&m.model, state, q[0], p[0]);
      state_steps(&m.model, state, 1);
      state_read(&m.model, state, q[1], p[1]);

      // q' follows from the momenta, p' from the mean force of the form in use
      errors_of_step(&m.model, state, def.dt, push, q, p, work, &ends, &path, &half);
      assert_true(half < 1e-11);
      if (!((form == THRUM_DAMPING_TANGENT ? path : ends) < 1e-11))
        fail_msg("step %d: off by %.3e for the ends, %.3e for the path", k, ends, path);
    }

    state_free(state);
  }
  free(work);
  random_model_free(&m);
}

/* Where h omega is 24 and the ends do not always lead to a solution, every step is still one of the
 * two. */
static void a_hard_step_takes_the_mean_force_of_the_path(void **context) {
  (void)context;
  random_model m;
  make_model(&m);
  double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof(double));
  thrum_state_def def = make_def(2.0);
  def.tolerance = 1e-13;

  thrum_state *state = state_make(&m.model, &def);
  state_put(&m.model, state, start_q, start_p);

  // count which of the two mean forces each step has
  int of_ends = 0, of_path = 0;
  double worst = 0;
  for (int k = 0; k < 2000; k++) {
    static const double none[RANK] = {0};
    double q[2][RANK], p[2][RANK], ends, path, half;

    state_read(&m.model, state, q[0], p[0]);
    state_steps(&m.model, state, 1);
    state_read(&m.model, state, q[1], p[1]);

    errors_of_step(&m.model, state, def.dt, none, q, p, work, &ends, &path, &half);
    if (!(fmin(ends, path) < 1e-9))
      fail_msg("step %d: off by %.3e for the ends, %.3e for the path", k, ends, path);
    worst = fmax(worst, half);
    of_ends += ends < path;
    of_path += path < ends;
  }

  // both were used
  assert_true(worst < 1e-8);
  assert_true(of_ends > 0 && of_path > 0);

  state_free(state);
  free(work);
  random_model_free(&m);
}

static void unmatched_on_a_linear_model_it_is_the_midpoint_rule(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 1, RANK, 1.0, 20.0, INFINITY);
  thrum_state_def def = make_def(0.1);
  def.damping_alpha = 0.2;
  def.damping_beta = 0.01;
  def.tolerance = 1e-13;
  def.frequency_matched = 0;

  thrum_state *energy = state_make(&m.model, &def);
  def.integrator = THRUM_INTEGRATOR_MIDPOINT;
  thrum_state *midpoint = state_make(&m.model, &def);

  // the same start and load for both
  double q[2][RANK], p[2][RANK];
  state_put(&m.model, energy, start_q, start_p);
  state_put(&m.model, midpoint, start_q, start_p);
  state_push(&m.model, energy, push);
  state_push(&m.model, midpoint, push);

  for (int k = 0; k < 200; k++) {
    state_steps(&m.model, energy, 1);
    state_steps(&m.model, midpoint, 1);
    state_read(&m.model, energy, q[0], p[0]);
    state_read(&m.model, midpoint, q[1], p[1]);
    assert_true(largest_difference(q[0], q[1], RANK) < 1e-12);
    assert_true(largest_difference(p[0], p[1], RANK) < 1e-11);
  }

  state_free(energy);
  state_free(midpoint);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(energy_is_conserved_at_any_step),
      cmocka_unit_test(errors_of_the_energy_do_not_add_up),
      cmocka_unit_test(the_account_follows_work_and_dissipation),
      cmocka_unit_test(energy_changes_by_work_less_dissipation),
      cmocka_unit_test(a_kick_of_any_size_keeps_the_balance),
      cmocka_unit_test(energy_is_conserved_whatever_the_tolerance),
      cmocka_unit_test(a_large_step_keeps_its_energy_with_a_loose_solve),
      cmocka_unit_test(stiff_modes_keep_their_energy),
      cmocka_unit_test(a_step_satisfies_its_equations),
      cmocka_unit_test(a_hard_step_takes_the_mean_force_of_the_path),
      cmocka_unit_test(unmatched_on_a_linear_model_it_is_the_midpoint_rule),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
