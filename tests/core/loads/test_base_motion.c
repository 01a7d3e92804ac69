/* Tests of base motions: means, integrals and splines against closed forms, the response of an
 * oscillator against its closed form, and the balance of energy.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"
#include "thrum/external_load.h"

/* Samples of a(t), piecewise linear and unevenly spaced. */
static const double times[5] = {0.5, 0.6, 1.0, 1.7, 2.0};
static const double values[15] = {1, 0, -2, 3, 1, 0, -1, 2, 4, 0, -3, 1, 2, 2, 2};
static const thrum_base_motion motion = {5, times, values, NULL, NULL};

static double acceleration(double t, int axis) {
  for (int k = 0; k < 4; k++) {
    if (t >= times[k] && t < times[k + 1])
      return values[3 * k + axis] + (t - times[k]) / (times[k + 1] - times[k]) *
                                        (values[3 * k + 3 + axis] - values[3 * k + axis]);
  }
  return 0;
}

static void a_step_takes_the_mean_of_the_acceleration(void **state) {
  (void)state;
  static const double steps[] = {0.013, 0.1, 0.77, 5};
  for (int n = 0; n < 4; n++) {
    const double dt = steps[n];
    double sum[3] = {0, 0, 0};
    for (int64_t step = 0; (double)step * dt < 2.5; step++) {
      double mean[3], by_parts[3] = {0, 0, 0};
      thrum_base_motion_mean(&motion, step, dt, mean);
      // the midpoint rule over many parts is exact where no sample lies inside a part
      for (int part = 0; part < 20000; part++)
        for (int axis = 0; axis < 3; axis++)
          by_parts[axis] +=
              acceleration(((double)step + ((double)part + 0.5) / 20000) * dt, axis) / 20000;

      // the means agree, and their sum is kept for the whole
      for (int axis = 0; axis < 3; axis++) {
        assert_true(fabs(mean[axis] - by_parts[axis]) <= 3e-4);
        sum[axis] += mean[axis] * dt;
      }
    }

    // the means add up to the integral of the acceleration, for any time step
    for (int axis = 0; axis < 3; axis++) {
      double whole = 0;
      for (int k = 0; k < 4; k++)
        whole +=
            0.5 * (times[k + 1] - times[k]) * (values[3 * k + axis] + values[3 * k + 3 + axis]);
      assert_true(fabs(sum[axis] - whole) <= 1e-14);
    }
  }

  // after the last sample the base is at rest or in uniform motion
  double mean[3] = {1, 1, 1};
  thrum_base_motion_mean(&motion, 1000, 0.1, mean);
  assert_true(mean[0] == 0 && mean[1] == 0 && mean[2] == 0);
}

static void a_constant_acceleration_is_a_parabola(void **state) {
  (void)state;

  // velocity and position follow from the samples
  static const double t[3] = {1, 1.5, 4}, a[9] = {2, 0, -4, 2, 0, -4, 2, 0, -4};
  double v[9], x[9], position[3], velocity[3];
  thrum_base_motion_integrate(3, t, a, v, x);
  const thrum_base_motion falling = {3, t, a, v, x};

  // between samples the motion is the parabola of the constant acceleration
  for (double time = 1; time <= 4; time += 0.25) {
    thrum_base_motion_at(&falling, time, position, velocity);
    assert_true(fabs(position[0] - (time - 1) * (time - 1)) <= 1e-13);
    assert_true(fabs(velocity[2] + 4 * (time - 1)) <= 1e-13);
    assert_true(position[1] == 0);
  }

  // the base is at rest before the first sample and in uniform motion after the last
  thrum_base_motion_at(&falling, 0.3, position, velocity);
  assert_true(position[0] == 0 && velocity[0] == 0);
  thrum_base_motion_at(&falling, 5, position, velocity);
  assert_true(fabs(position[0] - (9 + 6)) <= 1e-13 && fabs(velocity[0] - 6) <= 1e-13);
}

/* An acceleration that changes evenly over each interval: velocity and position are polynomials of
 * degree two and three, here 3 t - t^2 and 3/2 t^2 - t^3 / 3 up to t = 3, and uniform motion after.
 */
static void a_changing_acceleration_is_a_cubic(void **state) {
  (void)state;
  static const double t[4] = {0, 0.5, 2, 3};
  double a[12], v[12], x[12], position[3], velocity[3];
  for (int k = 0; k < 4; k++)
    for (int axis = 0; axis < 3; axis++)
      a[3 * k + axis] = (axis + 1) * (3 - 2 * t[k]);
  thrum_base_motion_integrate(4, t, a, v, x);
  const thrum_base_motion swerving = {4, t, a, v, x};

  // at samples, between them, and behind the last
  for (double time = 0; time <= 4; time += 0.125) {
    thrum_base_motion_at(&swerving, time, position, velocity);
    const double moved = time < 3 ? time * time * (1.5 - time / 3) : 4.5;
    const double speed = time < 3 ? time * (3 - time) : 0;
    for (int axis = 0; axis < 3; axis++) {
      assert_true(fabs(position[axis] - (axis + 1) * moved) <= 1e-13);
      assert_true(fabs(velocity[axis] - (axis + 1) * speed) <= 1e-13);
    }
  }
}

/* x = 1 - cos t starts at rest; the acceleration of its spline is cos t to second order. */
static double spline_error(int count) {
  // one block holds the samples, the derivatives and the work space
  double *t = random_alloc(11 * count, sizeof(double));
  double *x = t + count, *a = x + 3 * count, *v = a + 3 * count, *work = v + 3 * count;
  double worst = 0, position[3];
  for (int k = 0; k < count; k++) {
    t[k] = 3 * pi / 2 * k / (count - 1); // cos is zero at the end
    for (int axis = 0; axis < 3; axis++)
      x[3 * k + axis] = (axis + 1) * (1 - cos(t[k]));
  }

  // the spline through the sampled positions
  thrum_base_motion_spline(count, t, x, a, v, work);
  const thrum_base_motion sampled = {count, t, a, v, x};

  for (int k = 0; k < count; k++) {
    worst = fmax(worst, fabs(a[3 * k + 2] - 3 * cos(t[k])));
    // the motion between two samples joins them
    thrum_base_motion_at(&sampled, k > 0 ? t[k] * (1 - 1e-15) : 0, position, NULL);
    assert_true(fabs(position[1] - x[3 * k + 1]) <= 1e-12);
  }
  free(t);
  return worst;
}

static void a_spline_of_positions_gives_their_acceleration(void **state) {
  (void)state;
  const double coarse = spline_error(31), fine = spline_error(61);
  assert_true(fine < 5e-3);
  assert_true(log2(coarse / fine) > 1.7);
}

/* An oscillator of one mode with angular frequency omega and axis_mass along z. */
typedef struct oscillator {
  double omega2, zero[2], axis_mass[3];
  thrum_model model;
} oscillator;

static void oscillator_make(oscillator *o, double omega, double mass, double quartic) {
  *o = (oscillator){.omega2 = omega * omega, .zero = {0, quartic}, .axis_mass = {0, 0, mass}};
  o->model = (thrum_model){.rank = 1,
                           .c3_count = 1,
                           .c4_count = 1,
                           .omega2 = &o->omega2,
                           .c3 = &o->zero[0],
                           .c4 = &o->zero[1],
                           .axis_mass = o->axis_mass};
}

/* Returns the error against q'' + w^2 q = -m A sin(W t) from rest, whose solution is
 * q = -m A / (w^2 - W^2) (sin W t - W/w sin w t). */
static double base_motion_error(thrum_integrator integrator, double dt) {
  // an oscillator driven below its own frequency
  const double omega = 7, driven = 5, mass = 1.3, amplitude = 2, end = 2;
  oscillator o;
  oscillator_make(&o, omega, mass, 0);
  thrum_state_def def = thrum_default_state_def();
  def.integrator = integrator;
  def.dt = dt;
  thrum_state *state = state_make(&o.model, &def);

  // the inertial load of each step is that of the mean acceleration
  const thrum_load course = {
      .shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = driven / (2 * pi)};
  const int64_t steps = (int64_t)(end / dt + 0.5);
  for (int64_t step = 0; step < steps; step++) {
    const double a[3] = {0, 0, amplitude * thrum_load_mean(&course, step, dt)};
    double force = 0;
    assert_int_equal(thrum_base_motion_load(&o.model, a, &force, NULL), THRUM_OK);
    state_push(&o.model, state, &force);
    state_steps(&o.model, state, 1);
  }

  // the error at the end
  double q = 0;
  state_read(&o.model, state, &q, NULL);
  state_free(state);
  const double exact = -mass * amplitude / (omega * omega - driven * driven) *
                       (sin(driven * end) - driven / omega * sin(omega * end));
  return fabs(q - exact);
}

static void an_oscillator_on_a_moving_base_follows_its_closed_form(void **state) {
  (void)state;
  static const thrum_integrator all[] = {THRUM_INTEGRATOR_IMEXV, THRUM_INTEGRATOR_NEWMARK,
                                         THRUM_INTEGRATOR_VERLET, THRUM_INTEGRATOR_MIDPOINT,
                                         THRUM_INTEGRATOR_ENERGY};
  for (int n = 0; n < 5; n++) {
    const double coarse = base_motion_error(all[n], 0.01), fine = base_motion_error(all[n], 0.005);
    assert_true(fine < 1e-3);
    assert_true(log2(coarse / fine) > 1.8);
  }
}

static void a_falling_base_is_gravity(void **state) {
  (void)state;
  static const double t[2] = {0, 100}, a[6] = {0, 0, 9.81, 0, 0, 9.81}, g[3] = {0, 0, -9.81};
  const thrum_base_motion lift = {2, t, a, NULL, NULL};
  oscillator o;
  oscillator_make(&o, 7, 1.3, 40);
  double weight = 0;
  assert_int_equal(thrum_load_add_gravity(&o.model, g, &weight, NULL), THRUM_OK);
  for (int64_t step = 0; step < 30000; step += 997) {
    double mean[3], force = 0;
    thrum_base_motion_mean(&lift, step, 0.003, mean);
    assert_int_equal(thrum_base_motion_load(&o.model, mean, &force, NULL), THRUM_OK);
    assert_true(fabs(force - weight) <= 1e-12 * fabs(weight));
  }
}

static void the_base_puts_in_what_the_body_gains(void **state) {
  (void)state;

  // a nonlinear oscillator, without and with damping
  oscillator o;
  oscillator_make(&o, 7, 1.3, 400);
  for (int damped = 0; damped < 2; damped++) {
    thrum_state_def def = thrum_default_state_def();
    def.integrator = THRUM_INTEGRATOR_ENERGY;
    def.dt = 0.01;
    def.damping_alpha = damped ? 0.5 : 0;
    def.damping_beta = damped ? 0.002 : 0;
    thrum_state *body = state_make(&o.model, &def);
    matched_step by;
    state_matched_steps(&o.model, body, def.dt, &by);

    // the sums over the run: work of the base, loss of the damping
    double work = 0, loss = 0, before = 0, after = 0, largest = 0;
    for (int64_t step = 0; step < 400; step++) {
      // a strong base motion
      double mean[3], force = 0;
      thrum_base_motion_mean(&motion, step, def.dt, mean);
      for (int axis = 0; axis < 3; axis++)
        mean[axis] *= 30;

      // one step under the inertial load
      assert_int_equal(thrum_base_motion_load(&o.model, mean, &force, NULL), THRUM_OK);
      state_push(&o.model, body, &force);
      state_steps(&o.model, body, 1);
      state_read(&o.model, body, &after, NULL);

      // the energy is the work less the loss, to rounding, at every step
      work += thrum_load_work(&force, &before, &after, 1);
      loss += by.speed * by.speed *
              thrum_damping_loss(&o.model, def.damping_alpha, def.damping_beta, &before, &after,
                                 def.dt);
      before = after;
      const double energy = state_energy(&o.model, body).total;
      largest = fmax(largest, energy);
      assert_true(fabs(energy - work + loss) <= 1e-11 * largest);
    }

    // the run gained energy, and lost some of it only where there is damping
    assert_true(largest > 1 && (damped ? loss > 0.1 * largest : loss == 0));
    state_free(body);
  }
}

static void bad_motions_are_refused(void **state) {
  (void)state;

  // times that do not ascend, a sample that is not finite, and a single sample
  static const double same[2] = {1, 1}, back[2] = {1, 0.5}, a[6] = {0};
  const double bad[6] = {0, 0, 0, 0, NAN, 0};
  thrum_error error;
  assert_int_equal(thrum_base_motion_check(&motion, NULL), THRUM_OK);
  assert_int_equal(thrum_base_motion_check(&(thrum_base_motion){2, same, a, NULL, NULL}, &error),
                   THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "sample 2"));
  assert_int_equal(thrum_base_motion_check(&(thrum_base_motion){2, back, a, NULL, NULL}, NULL),
                   THRUM_BAD_VALUE);
  assert_int_equal(thrum_base_motion_check(&(thrum_base_motion){2, times, bad, NULL, NULL}, NULL),
                   THRUM_BAD_VALUE);
  assert_int_equal(thrum_base_motion_check(&(thrum_base_motion){1, times, a, NULL, NULL}, NULL),
                   THRUM_BAD_VALUE);

  // each place of a sample, and what is missing altogether
  for (int n = 0; n < 8; n++) {
    double when[2] = {0, 1}, samples[6] = {0};
    *(n < 2 ? &when[n] : &samples[n - 2]) = INFINITY;
    assert_int_equal(
        thrum_base_motion_check(&(thrum_base_motion){2, when, samples, NULL, NULL}, NULL),
        THRUM_BAD_VALUE);
  }
  assert_int_equal(thrum_base_motion_check(NULL, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_base_motion_check(&(thrum_base_motion){2, NULL, a, NULL, NULL}, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_base_motion_check(&(thrum_base_motion){2, times, NULL, NULL, NULL}, NULL),
                   THRUM_INVALID_ARGUMENT);

  // a model without axis masses has no inertial load
  oscillator o;
  oscillator_make(&o, 7, 1.3, 0);
  o.model.axis_mass = NULL;
  double force = 0;
  assert_int_equal(thrum_base_motion_load(&o.model, a, &force, NULL), THRUM_MISSING);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_step_takes_the_mean_of_the_acceleration),
      cmocka_unit_test(a_constant_acceleration_is_a_parabola),
      cmocka_unit_test(a_changing_acceleration_is_a_cubic),
      cmocka_unit_test(a_spline_of_positions_gives_their_acceleration),
      cmocka_unit_test(an_oscillator_on_a_moving_base_follows_its_closed_form),
      cmocka_unit_test(a_falling_base_is_gravity),
      cmocka_unit_test(the_base_puts_in_what_the_body_gains),
      cmocka_unit_test(bad_motions_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
