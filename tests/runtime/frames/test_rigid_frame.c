/* Tests of bodies that rotate as a whole: free tops, pendulums, impacts off the centre, blocks that
 * topple.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/contact_support.h"

static thrum_rigid_frame make_rigid_frame(double jx, double jy, double jz) {
  const thrum_rigid_frame made = {.inverse = {1 / jx, 0, 0, 0, 1 / jy, 0, 0, 0, 1 / jz},
                                  .attitude = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  return made;
}

static void a_free_top_keeps_energy_momentum_and_shape(void **state) {
  (void)state;
  static const double steps[] = {1e-3, 0.1, 2};
  for (int n = 0; n < 3; n++) {
    thrum_rigid_frame top = make_rigid_frame(1, 2, 3.5);
    const double c = cos(0.4), s = sin(0.4), none[3] = {0};
    const thrum_placement placement = {{c, -s, 0, s, c, 0, 0, 0, 1}, {0, 0, 0}};

    // the momentum lies along no principal axis, so the axis of rotation moves in the body
    top.momentum[0] = 0.1;
    top.momentum[1] = 4;
    top.momentum[2] = 0.3;

    const double first = thrum_rigid_frame_energy(&top, &placement);
    for (int step = 0; step < 20000; step++)
      thrum_rigid_frame_step(&top, &placement, none, steps[n], NULL);

    // momentum exactly, energy to rounding
    assert_true(top.momentum[0] == 0.1 && top.momentum[1] == 4 && top.momentum[2] == 0.3);
    assert_true(fabs(thrum_rigid_frame_energy(&top, &placement) / first - 1) <= 1e-11);

    // the attitude stays a rotation: A A^T = 1
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) {
        double sum = i == j ? -1 : 0;
        for (int k = 0; k < 3; k++)
          sum += top.attitude[3 * i + k] * top.attitude[3 * j + k];
        assert_true(fabs(sum) <= 1e-14);
      }
  }
}

/* The axis of a symmetric top turns about its momentum L at L/J_1. */
static double precession_error(double dt) {
  thrum_rigid_frame top = make_rigid_frame(2, 2, 1);
  const double tilt = 0.5, none[3] = {0}, length = 6, end = 2;
  top.momentum[0] = length * sin(tilt);
  top.momentum[2] = length * cos(tilt);

  for (int step = 0; step < (int)(end / dt + 0.5); step++)
    thrum_rigid_frame_step(&top, NULL, none, dt, NULL);

  // the axis z turned about L by Rodrigues' formula
  const double angle = length / 2 * end, k[3] = {sin(tilt), 0, cos(tilt)}, z[3] = {0, 0, 1};
  const double cross[3] = {0, -k[0], 0}, along = k[2];

  double error = 0;
  for (int axis = 0; axis < 3; axis++) {
    const double expected =
        z[axis] * cos(angle) + cross[axis] * sin(angle) + k[axis] * along * (1 - cos(angle));
    error = fmax(error, fabs(top.attitude[3 * axis + 2] - expected));
  }
  return error;
}

static void a_symmetric_top_precesses_as_euler_says(void **state) {
  (void)state;
  const double coarse = precession_error(0.01), fine = precession_error(0.005);
  print_message("axis off by %.2g at h = 0.01 s, order %.2f\n", coarse, log2(coarse / fine));
  assert_true(fine <= 1e-3 && log2(coarse / fine) > 1.9);
}

static void energy_changes_by_torque_times_angle(void **state) {
  (void)state;
  random_state random = {8};
  for (int n = 0; n < 300; n++) {
    thrum_rigid_frame top = make_rigid_frame(1, 2, 2.5);
    double torque[3], angle[3], work = 0;

    // momentum or torque prevails, each in some of the cases
    random_vector(&random, 3, n % 3 == 0 ? 100 : 3, top.momentum);
    random_vector(&random, 3, n % 2 == 0 ? 100 : 3, torque);
    for (int step = 0; step < 20; step++) {
      const double before = thrum_rigid_frame_energy(&top, NULL);
      thrum_rigid_frame_step(&top, NULL, torque, 0.05, angle);

      work = torque[0] * angle[0] + torque[1] * angle[1] + torque[2] * angle[2];
      const double after = thrum_rigid_frame_energy(&top, NULL);
      assert_true(fabs(after - before - work) <= 1e-11 * (before + after));
    }
  }
}

/* Torques spin thin rods many times in a step, which no single step of the rule is found for. */
static void a_thin_rod_keeps_its_energy_balance_under_any_torque(void **state) {
  (void)state;
  random_state random = {31};
  for (int n = 0; n < 400; n++) {
    const double thin = pow(10, -1 - n % 5), h = 0.1;
    thrum_rigid_frame rod = make_rigid_frame(1, 1.1, thin);
    double torque[3], angle[3];
    random_vector(&random, 3, 1, rod.momentum);
    random_vector(&random, 3, (n % 4 == 0 ? 100 : 1) / (h * h), torque);

    // the change of energy is the work, and the axes stay a rotation
    const double before = thrum_rigid_frame_energy(&rod, NULL);
    thrum_rigid_frame_step(&rod, NULL, torque, h, angle);
    const double after = thrum_rigid_frame_energy(&rod, NULL);
    const double work = torque[0] * angle[0] + torque[1] * angle[1] + torque[2] * angle[2];
    if (!(fabs(after - before - work) <= 1e-9 * (before + after)))
      fail_msg("case %d: energy off by %.2g", n, (after - before - work) / (before + after));
    for (int i = 0; i < 3; i++) {
      const double *row = rod.attitude + 3 * i;
      assert_true(fabs(row[0] * row[0] + row[1] * row[1] + row[2] * row[2] - 1) <= 1e-12);
    }
  }
}

/* A rigid body on a stiff spring swings as 2 pi sqrt((J + m l^2) / (m g l)). */
static void a_body_hung_by_a_pull_is_a_pendulum(void **state) {
  (void)state;
  rig_def def = rig_default();
  def.points = 7;

  rig r;
  rig_make(&r, &def);
  thrum_rigid_frame rigid_frame = make_rigid_frame(0.5, 0.3, 0.4);
  const double *point = r.m.vertices + 3, arm = 0.8, angle = 0.05;

  // the centre hangs below the point, swung out about y
  rigid_frame.centre[0] = point[0];
  rigid_frame.centre[1] = point[1];
  rigid_frame.centre[2] = point[2] - arm;

  const double c = cos(angle), s = sin(angle);
  const double out[9] = {c, 0, s, 0, 1, 0, -s, 0, c};
  memcpy(rigid_frame.attitude, out, sizeof out);
  r.translation.position[0] = -arm * s;
  r.translation.position[2] = arm * (1 - c);

  // a stiff spring without damping holds one point, and no obstacle is near
  thrum_pull pull = {.vertices = {1, 1, 1}, .weights = {1, 0, 0}, .stiffness = 1e9, .damping = -1};
  memcpy(pull.target, point, sizeof pull.target);
  r.environment.rigid_frame = &rigid_frame;
  r.environment.obstacle_count = 0;
  r.environment.pulls = &pull;
  r.environment.pull_count = 1;

  // the time from the first to the ninth passage through the middle is four periods
  const double expected =
      2 * pi * sqrt((0.3 + RIG_MASS * arm * arm) / (RIG_MASS * RIG_GRAVITY * arm));
  double first = 0, last = 0;
  int crossings = 0;

  for (int n = 1; crossings < 9; n++) {
    const double before = r.translation.position[0];
    rig_steps(&r, 1);
    const double now = r.translation.position[0];
    assert_true(n < 20000);
    if ((before < 0) == (now < 0))
      continue;

    // interpolate the moment of the passage
    last = (n - 1 + before / (before - now)) * def.dt;
    if (crossings++ == 0)
      first = last;
  }

  const double period = (last - first) / 4;
  print_message("period off by %.2e\n", period / expected - 1);

  // the swing of 0.05 lengthens the period by a sixteenth of its square, which is far less
  assert_true(fabs(period / expected - 1) <= 1e-3);

  rig_free(&r);
}

/* One point off the centre meets a smooth floor: the impulse j follows from
 * 2 v = j (1/m + (r x n) J^-1 (r x n)). */
static void an_impact_off_the_centre_turns_the_body(void **state) {
  (void)state;

  // a spring that stiff feels the arc that its point goes along in a step
  static const double stiffness[] = {1e7, 1e9, 1e14}, allowed[] = {5e-4, 5e-4, 2e-2};
  for (int n = 0; n < 3; n++) {
    rig_def def = rig_default();
    def.stiffness = stiffness[n];
    def.dt = 1e-4;

    rig r;
    rig_make(&r, &def);
    r.floor.restitution = 1;
    r.floor.friction = 0;

    // the point lies off the centre along every axis
    thrum_rigid_frame rigid_frame = make_rigid_frame(0.5, 0.3, 0.4);
    const double *point = r.m.vertices + 3, arm[3] = {0.4, -0.3, -0.5};
    for (int axis = 0; axis < 3; axis++)
      rigid_frame.centre[axis] = point[axis] - arm[axis];
    r.environment.rigid_frame = &rigid_frame;

    // the body flies without weight towards the floor, at 1 m/s
    r.environment.force[2] = 0;
    r.translation.velocity[2] = -1;
    r.translation.position[2] = 2.4e-4;

    rig_steps(&r, 400);

    // r x n = (r_y, -r_x, 0)
    const double j = 2 / (1 / RIG_MASS + arm[1] * arm[1] / 0.5 + arm[0] * arm[0] / 0.3);

    // the error of the speed after the impact, and the energy that is missing
    const double off = r.translation.velocity[2] - (-1 + j / RIG_MASS);
    const double lost = 1 - rig_energy(&r) / (0.5 * RIG_MASS);
    print_message("k = %g: speed off by %.1e, %.1e of the energy lost\n", stiffness[n], off, lost);

    // energy, speed and angular momentum are those that the impulse leaves
    assert_true(lost >= -1e-9 && lost <= allowed[n]);
    assert_true(fabs(off) <= allowed[n]);
    assert_true(fabs(rigid_frame.momentum[0] - j * arm[1]) <= allowed[n]);
    assert_true(fabs(rigid_frame.momentum[1] + j * arm[0]) <= allowed[n]);
    assert_true(fabs(rigid_frame.momentum[2]) <= 1e-12);

    rig_free(&r);
  }
}

static void the_account_counts_the_turning(void **state) {
  (void)state;
  static const double steps[] = {1e-3, 1e-2, 1e-1}, restitution[] = {0, 0.5, 1};
  for (int n = 0; n < 18; n++) {
    rig_def def = rig_default();
    def.integrator = THRUM_INTEGRATOR_ENERGY;
    def.dt = steps[n % 3];
    def.shape = n < 9 ? 0 : 0.1;
    def.stiffness = n % 2 == 0 ? 1e5 : 1e10;
    def.points = 7;

    rig r;
    rig_make(&r, &def);

    // a body with some height
    for (int v = 0; v < RIG_POINTS; v++)
      r.m.vertices[3 * v + 2] = 0.3 * (v % 3);

    // the body falls while it turns
    r.floor.restitution = restitution[n / 3 % 3];
    thrum_rigid_frame rigid_frame = make_rigid_frame(0.5, 0.3, 0.4);
    rigid_frame.centre[2] = 0.3;
    rigid_frame.momentum[0] = 0.6;
    rigid_frame.momentum[1] = -0.4;
    r.environment.rigid_frame = &rigid_frame;
    r.translation.position[2] = 0.8;

    const double first = rig_energy(&r);
    for (int step = 0; step < 2000; step++) {
      rig_steps(&r, 1);

      // motion, stored and lost energy add up to that of the start at every step
      const thrum_contact_report report = thrum_contact_report_get(r.contact);
      assert_true(report.stored >= 0 && report.lost >= -1e-8 * first);
      const double sum = rig_energy(&r) + report.stored + report.lost;
      if (!(fabs(sum - first) <= 1e-9 * first))
        fail_msg("case %d, step %d: off by %.3g", n, step, sum / first - 1);
    }

    rig_free(&r);
  }
}

/* Returns whether a block topples. On a rough slope it does where tan(angle) > width / height. */
static bool topples(double angle) {
  const double width = 0.1, height = 0.3;
  rig_def def = rig_default();
  def.points = 7;
  def.stiffness = 1e6;

  rig r;
  rig_make(&r, &def);

  for (int v = 1; v < RIG_POINTS; v++) { // vertices 1..7: corners but for one on the top
    r.m.vertices[3 * v] = (v - 1) % 2 ? width : -width;
    r.m.vertices[3 * v + 1] = (v - 1) / 2 % 2 ? width : -width;
    r.m.vertices[3 * v + 2] = (v - 1) / 4 ? 2 * height : 0;
  }

  // the moments of inertia of a block
  const double j = RIG_MASS / 3 * (width * width + height * height);
  thrum_rigid_frame rigid_frame = make_rigid_frame(j, j, RIG_MASS / 1.5 * width * width);
  rigid_frame.centre[2] = height;
  r.environment.rigid_frame = &rigid_frame;

  // the weight is tilted instead of the floor
  r.floor.friction = 2;
  r.floor.restitution = 0;
  r.environment.force[0] = RIG_MASS * RIG_GRAVITY * sin(angle);
  r.environment.force[2] = -RIG_MASS * RIG_GRAVITY * cos(angle);

  // a block that has fallen has its axis far from the normal of the floor
  rig_steps(&r, 3000);
  const bool fallen = rigid_frame.attitude[8] < 0.5;
  if (!fallen) // and what stays does not creep
    assert_true(fabs(r.translation.position[0]) <= 1e-3);

  rig_free(&r);
  return fallen;
}

static void a_block_topples_where_its_weight_passes_its_edge(void **state) {
  (void)state;
  const double edge = atan(0.1 / 0.3);
  assert_false(topples(0));
  assert_false(topples(0.9 * edge));
  assert_true(topples(1.1 * edge));
}

/* Rigid modes 3 to 5 are a x (X - c) for three axes a: c is the centre, sum a a^T the inverse. */
static void a_frame_is_read_from_the_rigid_modes(void **state) {
  (void)state;
  random_model m;
  random_model_make(&m, 21, RIG_RANK, 5, 20, 1);
  random_model_add_mesh(&m, 22, RIG_POINTS);
  const double axes[3][3] = {{0.7, -0.2, 0.4}, {0.1, 0.9, -0.3}, {-0.5, 0.3, 1.1}};
  const double centre[3] = {0.3, -0.8, 0.5};
  double rigid[3 * RIG_POINTS * 6] = {0};
  for (int v = 0; v < RIG_POINTS; v++)
    for (int axis = 0; axis < 3; axis++) {
      const int next = (axis + 1) % 3, last = (axis + 2) % 3;
      const double *x = m.model.vertices + (ptrdiff_t)(3 * v);
      double *row = rigid + (ptrdiff_t)(18 * v + 6 * axis);
      row[axis] = 1;
      for (int n = 0; n < 3; n++)
        row[3 + n] =
            axes[n][next] * (x[last] - centre[last]) - axes[n][last] * (x[next] - centre[next]);
    }
  const int32_t tet[4] = {2, 5, 3, 7};
  thrum_model model = m.model;
  model.rigid = rigid;
  model.tets = tet;
  model.tet_count = 1;

  thrum_rigid_frame frame;
  thrum_error error = {0};
  assert_int_equal(thrum_rigid_frame_of(&model, &frame, &error), THRUM_OK);
  for (int i = 0; i < 3; i++) {
    assert_true(fabs(frame.centre[i] - centre[i]) < 1e-10);
    for (int j = 0; j < 3; j++) {
      double sum = 0;
      for (int n = 0; n < 3; n++)
        sum += axes[n][i] * axes[n][j];
      assert_true(fabs(frame.inverse[3 * i + j] - sum) < 1e-10);
      assert_true(frame.attitude[3 * i + j] == (i == j));
    }
    assert_true(frame.momentum[i] == 0);
  }

  // what gives no frame is refused, and the frame stays
  const thrum_rigid_frame kept = frame;
  assert_int_equal(thrum_rigid_frame_of(NULL, &frame, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_rigid_frame_of(&model, NULL, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_rigid_frame_of(&m.model, &frame, &error), THRUM_MISSING);
  const int32_t flat[4] = {2, 5, 3, 3};
  model.tets = flat;
  assert_int_equal(thrum_rigid_frame_of(&model, &frame, &error), THRUM_SINGULAR);
  model.tets = tet;
  memset(rigid, 0, sizeof rigid);
  assert_int_equal(thrum_rigid_frame_of(&model, &frame, &error), THRUM_SINGULAR);
  assert_memory_equal(&frame, &kept, sizeof frame);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_free_top_keeps_energy_momentum_and_shape),
      cmocka_unit_test(a_frame_is_read_from_the_rigid_modes),
      cmocka_unit_test(a_symmetric_top_precesses_as_euler_says),
      cmocka_unit_test(energy_changes_by_torque_times_angle),
      cmocka_unit_test(a_thin_rod_keeps_its_energy_balance_under_any_torque),
      cmocka_unit_test(a_body_hung_by_a_pull_is_a_pendulum),
      cmocka_unit_test(an_impact_off_the_centre_turns_the_body),
      cmocka_unit_test(the_account_counts_the_turning),
      cmocka_unit_test(a_block_topples_where_its_weight_passes_its_edge),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
