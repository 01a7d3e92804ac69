/* Tests of contact and pulls against closed forms: bounces, slopes, stopping distances, depths and
 * springs.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/contact_support.h"
#include "tests/support/sanitized.h"

#include "contact/contact_private.h"
#include "contact/contact_rows.h"
#include "contact/contact_step.h"

static double height_reached(int points, double dt, double stiffness, double restitution) {
  // a rigid body that falls from a height of 1 m
  rig_def def = rig_default();
  def.points = points;
  def.dt = dt;
  def.stiffness = stiffness;
  rig r;
  rig_make(&r, &def);
  r.floor.restitution = restitution;
  r.translation.position[2] = 1;

  // the apex after the first bounce
  double top = 0;
  bool bounced = false;
  for (int64_t n = 0; n < (int64_t)(1.2 / dt); n++) {
    rig_steps(&r, 1);
    bounced = bounced || r.translation.velocity[2] > 0;
    if (bounced)
      top = fmax(top, r.translation.position[2]);
  }

  rig_free(&r);
  return top;
}

static void a_body_bounces_as_high_as_its_restitution_says(void **state) {
  (void)state;
  const double stiffness[] = {1e4, 1e6, 1e9, 1e15};
  for (int n = 0; n < 4; n++) {
    // the apex lies between two steps, at most g h^2 / 8 higher
    assert_true(fabs(height_reached(1, 0.001, stiffness[n], 1) - 1) <= 2e-6);
    const double coarse = fabs(height_reached(1, 0.002, stiffness[n], 0.5) - 0.25);
    const double fine = fabs(height_reached(1, 0.0001, stiffness[n], 0.5) - 0.25);
    print_message("k = %g: rebound off by %.2g m at 2 ms, %.2g m at 0.1 ms\n", stiffness[n], coarse,
                  fine);
    assert_true(coarse <= 0.02 && fine <= 0.001);
    assert_true(height_reached(1, 0.001, stiffness[n], 0) <= 1e-3);
  }
}

/* Points that move as one can share the force of an impact in many ways; with any of them, the
 * whole momentum comes back. */
static void a_body_that_lands_flat_bounces_as_one_point_does(void **state) {
  (void)state;
  for (double stiffness = 1e4; stiffness < 1e16; stiffness *= 100)
    for (int n = 0; n < 3; n++) {
      const double dt[] = {0.01, 0.002, 0.0005};
      const double flat = height_reached(7, dt[n], stiffness, 1);
      const double half = height_reached(7, dt[n], stiffness, 0.5);
      print_message("k = %g, dt = %g: rebound %.9f and %.6f m\n", stiffness, dt[n], flat, half);
      assert_true(fabs(flat - 1) <= 1e-3);
      assert_true(fabs(half - 0.25) <= 15 * dt[n]);
    }
}

typedef struct impact {
  double depth, duration, speed; /* greatest [m]; of contact [s]; afterwards [m/s] */
} impact;

/* Lets a rigid body without weight meet a floor at 1 m/s. */
static impact meet(double dt, double stiffness, double damping) {
  // a floor that returns everything but what its damper takes
  rig_def def = rig_default();
  def.dt = dt;
  def.stiffness = stiffness;
  rig r;
  rig_make(&r, &def);
  r.floor.restitution = 1;
  r.floor.damping = damping;
  r.environment.force[2] = 0;
  r.translation.velocity[2] = -1;
  r.translation.position[2] = 2.3 * dt;

  // the body is followed until it has left the floor
  impact found = {0};
  double touched = -1, left = -1, before = r.translation.position[2];
  for (int n = 0; left < 0; n++) {
    assert_true(n < 1000000);
    rig_steps(&r, 1);
    const double now = r.translation.position[2];
    found.depth = fmax(found.depth, -now);
    // the times at which the path crosses the floor are interpolated
    if (touched < 0 && now < 0)
      touched = (n + before / (before - now)) * dt;
    if (touched >= 0 && now >= 0)
      left = (n + before / (before - now)) * dt;
    before = now;
  }

  // two more steps complete the impact
  rig_steps(&r, 2);
  found.duration = left - touched;
  found.speed = r.translation.velocity[2];
  rig_free(&r);
  return found;
}

static void an_impact_is_half_a_swing_on_the_spring(void **state) {
  (void)state;

  // the depth and the duration of half a period of the spring
  const double k = 2e4, omega = sqrt(k / RIG_MASS);
  double depth[2], duration[2];
  for (int n = 0; n < 2; n++) {
    const impact found = meet(n == 0 ? 0.002 : 0.0005, k, 0);
    assert_true(fabs(found.speed - 1) <= 1e-12);
    depth[n] = fabs(found.depth * omega - 1);
    duration[n] = fabs(found.duration * omega / pi - 1);
    print_message("h w = %.2f: depth off by %.2g, duration by %.2g\n",
                  omega * (n == 0 ? 0.002 : 0.0005), depth[n], duration[n]);
  }

  // both are close, and the error of the duration falls with the time step
  assert_true(depth[1] <= 2e-3 && duration[1] <= 5e-3);
  assert_true(duration[1] <= 0.3 * duration[0]);

  // no energy is lost at any stiffness
  double worst = 0;
  for (double stiff = 1; stiff < 1e16; stiff *= 37)
    worst = fmax(worst, fabs(meet(0.001, stiff, 0).speed - 1));
  print_message("largest loss of speed over stiffnesses: %.1g\n", worst);
  assert_true(worst <= 1e-8);
}

/* A spring and a damper that never pull: Schwager & Poeschel 2007, arXiv:cond-mat/0701278. */
static void a_damped_impact_has_the_restitution_of_its_damping(void **state) {
  (void)state;
  const double k = 2e4, ratio[] = {0.1, 0.3, 0.6};
  for (int n = 0; n < 3; n++) {
    const double beta = ratio[n] * sqrt(k / RIG_MASS), omega = sqrt(k / RIG_MASS - beta * beta);
    const double angle = atan2(2 * beta * omega, omega * omega - beta * beta);
    const double expected = exp(-beta / omega * (pi - angle));
    double off[2];
    for (int m = 0; m < 2; m++)
      off[m] = fabs(meet(m == 0 ? 1e-3 : 1e-4, k, 2 * beta * RIG_MASS).speed - expected);
    print_message("damping ratio %.1f: restitution %.4f, off by %.2g at 1 ms, %.2g at 0.1 ms\n",
                  ratio[n], expected, off[0], off[1]);
    assert_true(off[0] <= 0.03 && off[1] <= 3e-3);
  }
}

static void a_body_slides_down_a_slope_as_coulomb_says(void **state) {
  (void)state;
  const double angle = 0.5, friction[] = {0, 0.2, 0.5};
  for (int n = 0; n < 3; n++) {
    // gravity is inclined instead of the floor
    rig_def def = rig_default();
    def.points = 3;
    rig r;
    rig_make(&r, &def);
    r.floor.friction = friction[n];
    r.environment.force[0] = RIG_MASS * RIG_GRAVITY * sin(angle);
    r.environment.force[2] = -RIG_MASS * RIG_GRAVITY * cos(angle);

    // the body starts at its equilibrium depth, so that the motion is along the slope only
    r.translation.position[2] = r.environment.force[2] / (3 * def.stiffness);
    rig_steps(&r, 1000);

    // uniform acceleration for one second
    const double a = RIG_GRAVITY * (sin(angle) - friction[n] * cos(angle));
    print_message("mu = %g: slid %.9f m in 1 s, off by %.1g\n", friction[n],
                  r.translation.position[0], r.translation.position[0] - 0.5 * a);
    assert_true(fabs(r.translation.position[0] - 0.5 * a) <= 1e-9);
    assert_true(fabs(r.translation.velocity[0] - a) <= 1e-9);
    rig_free(&r);
  }
}

static void a_body_below_the_angle_of_friction_stays(void **state) {
  (void)state;

  for (int n = 0; n < 9; n++) {
    // a deformable body on a slope below the angle of friction, with each integrator
    rig_def def = rig_default();
    def.integrator = all_integrators[n];
    def.points = 3;
    def.shape = 0.1;
    rig r;
    rig_make(&r, &def);
    r.floor.friction = 0.6;
    r.floor.restitution = 0;
    r.environment.force[0] = RIG_MASS * RIG_GRAVITY * sin(0.5);
    r.environment.force[2] = -RIG_MASS * RIG_GRAVITY * cos(0.5);

    // the body settles for 20 s and must not creep in the next 20 s
    const int steps = LENGTH_OF_RUN(20000, 8000);
    rig_steps(&r, steps);
    const double x = r.translation.position[0];
    rig_steps(&r, steps);
    const double creep = r.translation.position[0] - x;
    print_message("%d: creep in %d steps: %.3g m\n", n, steps, creep);
    assert_true(fabs(creep) <= 1e-12);
    rig_free(&r);
  }
}

static void friction_stops_a_body_after_its_distance(void **state) {
  (void)state;
  const double speed = 2, friction = 0.4, expected = speed * speed / (2 * friction * RIG_GRAVITY);

  // the body starts at its equilibrium depth, with a velocity along the floor
  rig_def def = rig_default();
  def.points = 3;
  rig r;
  rig_make(&r, &def);
  r.floor.friction = friction;
  r.translation.velocity[1] = speed;
  r.translation.position[2] = r.environment.force[2] / (3 * def.stiffness);

  // it stops after the distance of uniform deceleration and stays there
  rig_steps(&r, 3000);
  print_message("stopped after %.9f m, off by %.1g\n", r.translation.position[1],
                r.translation.position[1] - expected);
  assert_true(fabs(r.translation.position[1] - expected) <= 1e-6);
  assert_true(fabs(r.translation.velocity[1]) <= 1e-12);
  rig_free(&r);
}

static void a_body_rests_at_the_depth_of_its_weight(void **state) {
  (void)state;
  const double restitution[] = {0, 0.5, 0.9};

  for (int n = 0; n < 3; n++) {
    // a small drop on four points
    rig_def def = rig_default();
    def.points = 4;
    rig r;
    rig_make(&r, &def);
    r.floor.restitution = restitution[n];
    r.translation.position[2] = 0.05;
    rig_steps(&r, 5000);

    // the springs of the four points carry the weight
    const double depth = RIG_MASS * RIG_GRAVITY / (4 * def.stiffness);
    assert_true(fabs(r.translation.position[2] + depth) <= 1e-9 * depth);
    print_message("e = %g: depth off by %.2g\n", restitution[n],
                  r.translation.position[2] / depth + 1);

    // the report counts these points and holds their force
    const thrum_contact_report report = thrum_contact_report_get(r.contact);
    assert_int_equal(report.touching, 4);
    assert_true(fabs(report.normal - RIG_MASS * RIG_GRAVITY) <= 1e-9);

    // the touches, one by one, carry the weight upwards at that depth
    double carried = 0;
    for (int64_t k = 0; k < report.touching; k++) {
      thrum_touch touch;
      assert_int_equal(thrum_contact_touch_get(r.contact, k, &touch, NULL), THRUM_OK);
      assert_true(touch.normal[2] == 1 && fabs(touch.gap + depth) <= 1e-9);
      carried += touch.force[2];
    }
    assert_true(fabs(carried - report.normal) <= 1e-9);
    thrum_touch none;
    assert_int_equal(thrum_contact_touch_get(r.contact, 4, &none, NULL), THRUM_INVALID_ARGUMENT);
    assert_true(thrum_contact_stiffness(r.contact) > 0);

    // the next step is searched where the body stays, and not where it would fall to
    thrum_contact_run run;
    thrum_contact_open(&r.m.model, r.state, r.contact, &r.environment, &run, NULL);
    assert_int_equal(thrum_contact_prepare(&run, NULL), THRUM_OK);
    assert_true(run.moved[2] < 0 && fabs(run.sought[2]) <= 1e-6 * fabs(run.moved[2]));
    rig_free(&r);
  }
}

/* A point that only the step without contact would bring down has no row, until the body comes. */
static void a_point_that_the_last_forces_hold_up_waits(void **state) {
  (void)state;
  rig_def def = rig_default();
  def.points = 5;
  rig r;
  rig_make(&r, &def);
  const double depth = RIG_MASS * RIG_GRAVITY / (4 * def.stiffness);
  r.m.vertices[3 * 5 + 2] = 1.4 * depth;
  r.floor.restitution = 0;
  rig_steps(&r, 3000);
  assert_int_equal(thrum_contact_report_get(r.contact).touching, 4);

  // four bear, and one waits above them
  thrum_contact_run run;
  thrum_contact_open(&r.m.model, r.state, r.contact, &r.environment, &run, NULL);
  assert_int_equal(thrum_contact_prepare(&run, NULL), THRUM_OK);
  assert_true(r.contact->row_count == 4 && run.waiting == 1);
  run.moved[2] = -0.39 * depth;
  assert_false(thrum_contact_wake(&run, false));
  run.moved[2] = -0.41 * depth;
  assert_true(thrum_contact_wake(&run, false));
  assert_true(r.contact->row_count == 5 && run.waiting == 0);

  // a load that doubles brings it down within the step
  r.environment.force[2] *= 2;
  rig_steps(&r, 3000);
  const thrum_contact_report report = thrum_contact_report_get(r.contact);
  assert_int_equal(report.touching, 5);
  assert_true(fabs(report.normal - 2 * RIG_MASS * RIG_GRAVITY) <= 1e-9);
  rig_free(&r);
}

/* A near-rigid body is struck as a whole: the places of the impact are listed with their impulses,
 * and no longer after the next step. */
static void the_impulses_of_an_impact_are_listed(void **state) {
  (void)state;
  rig_def def = rig_default();
  rig r;
  def.points = 4;
  rig_make(&r, &def);
  r.contact->springy = 0; // as if no spring had been asked for
  r.floor.restitution = 0.5;
  r.environment.force[2] = 0;
  r.translation.position[2] = 0.0105;
  r.translation.velocity[2] = -0.1;

  // it comes to the floor after 105 steps, in the middle of one
  rig_steps(&r, 105);
  assert_int_equal(thrum_contact_report_get(r.contact).impacts, 0);
  rig_steps(&r, 1);
  const thrum_contact_report report = thrum_contact_report_get(r.contact);
  assert_in_range(report.struck, 1, 4);
  assert_int_equal(report.impacts, report.struck);
  assert_int_equal(report.touching, 0);

  // the points share the impulse in some way, and together they turn the velocity round
  double sum = 0;
  thrum_touch touch;
  for (int64_t n = 0; n < report.struck; n++) {
    assert_int_equal(thrum_contact_touch_get(r.contact, n, &touch, NULL), THRUM_OK);
    assert_true(touch.force[2] == 0 && touch.normal[2] == 1 && touch.impulse[2] > 0);
    sum += touch.impulse[2];
  }
  assert_true(fabs(sum - 1.5 * 0.1 * RIG_MASS) <= 1e-9 * sum);
  assert_int_equal(thrum_contact_touch_get(r.contact, report.struck, &touch, NULL),
                   THRUM_INVALID_ARGUMENT);
  rig_steps(&r, 1);
  assert_int_equal(thrum_contact_report_get(r.contact).struck, 0);
  assert_int_equal(thrum_contact_report_get(r.contact).impacts, report.impacts);
  thrum_contact_reset(r.contact);
  assert_int_equal(thrum_contact_report_get(r.contact).impacts, 0);
  rig_free(&r);
}

static void a_pulled_body_hangs_and_swings_on_its_spring(void **state) {
  (void)state;

  // a body without a floor, pulled at one vertex
  rig_def def = rig_default();
  rig r;
  rig_make(&r, &def);
  r.environment.obstacle_count = 0;
  const double *x = r.m.vertices + 3;
  const double k = 800;
  thrum_pull pull = {.vertices = {1, 1, 1}, .weights = {0.5, 0.25, 0.25}, .stiffness = k};
  memcpy(pull.target, x, sizeof pull.target);
  r.environment.pulls = &pull;
  r.environment.pull_count = 1;

  // undamped from rest: z = -m g/k (1 - cos w t)
  const double omega = sqrt(k / RIG_MASS), depth = RIG_MASS * RIG_GRAVITY / k;
  for (int n = 1; n <= 1000; n++) {
    rig_steps(&r, 1);
    const double expected = -depth * (1 - cos(omega * n * def.dt));
    assert_true(fabs(r.translation.position[2] - expected) <= 1e-3 * depth);
  }

  // critically damped: at rest where the spring carries the weight
  pull.damping = -1;
  rig_steps(&r, 3000);
  assert_true(fabs(r.translation.position[2] + depth) <= 1e-9 * depth);
  double force[3];
  assert_int_equal(thrum_contact_pull_force(r.contact, 0, force, NULL), THRUM_OK);
  assert_true(fabs(force[2] - RIG_MASS * RIG_GRAVITY) <= 1e-9);
  rig_free(&r);
}

static void a_step_of_one_coordinate_alone_meets_the_floor(void **state) {
  (void)state;
  for (int i = 0; i < RIG_RANK; i++) {
    rig_def def = rig_default();
    def.shape = 1;
    def.dt = 0.01;
    def.points = 4;
    rig r;
    rig_make(&r, &def);

    // the body is at rest above the floor but for one coordinate, which takes a point through it
    double p[RIG_RANK] = {0}, most = 0;
    for (int v = 1; v <= def.points; v++)
      most = fmax(most, -r.m.basis[(3 * v + 2) * RIG_RANK + i]);
    assert_true(most > 0);
    p[i] = 0.1 / (def.dt * most);
    r.translation.position[2] = 0.05;
    state_put(&r.m.model, r.state, NULL, p);
    rig_steps(&r, 1);
    assert_true(thrum_contact_report_get(r.contact).normal > 0);
    rig_free(&r);
  }
}

/* A body that would leave all numbers behind in the step: it stays where it was, on its way, and so
 * do its state and its contact. */
static void a_step_that_fails_leaves_the_translation_where_it_was(void **state) {
  (void)state;
  rig_def def = rig_default();
  def.dt = 1;
  rig r;
  rig_make(&r, &def);
  r.environment.force[2] = 0;
  r.translation.position[2] = 1;
  r.translation.position[0] = 1.7e308;
  r.translation.velocity[0] = 1e308;
  r.translation.velocity[1] = 1;
  const thrum_translation before = r.translation;
  thrum_error error = {0};
  assert_int_equal(thrum_contact_step(&r.m.model, r.state, r.contact, &r.environment, &error),
                   THRUM_NOT_FINITE);
  assert_memory_equal(&r.translation, &before, sizeof before);
  assert_true(thrum_state_report_get(r.state).steps == 0);

  // from nearer it goes on
  r.translation.position[0] = 0;
  assert_int_equal(thrum_contact_step(&r.m.model, r.state, r.contact, &r.environment, &error),
                   THRUM_OK);
  assert_true(r.translation.position[0] == 1e308 && r.translation.position[1] == 1);
  rig_free(&r);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_body_bounces_as_high_as_its_restitution_says),
      cmocka_unit_test(a_body_that_lands_flat_bounces_as_one_point_does),
      cmocka_unit_test(an_impact_is_half_a_swing_on_the_spring),
      cmocka_unit_test(a_damped_impact_has_the_restitution_of_its_damping),
      cmocka_unit_test(a_body_slides_down_a_slope_as_coulomb_says),
      cmocka_unit_test(a_body_below_the_angle_of_friction_stays),
      cmocka_unit_test(friction_stops_a_body_after_its_distance),
      cmocka_unit_test(a_body_rests_at_the_depth_of_its_weight),
      cmocka_unit_test(a_point_that_the_last_forces_hold_up_waits),
      cmocka_unit_test(the_impulses_of_an_impact_are_listed),
      cmocka_unit_test(a_pulled_body_hangs_and_swings_on_its_spring),
      cmocka_unit_test(a_step_of_one_coordinate_alone_meets_the_floor),
      cmocka_unit_test(a_step_that_fails_leaves_the_translation_where_it_was),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
