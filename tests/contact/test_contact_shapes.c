/* Tests of obstacles as signed distances, of bodies on them, and of the arguments that are refused.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/contact_support.h"

#include "contact/contact_private.h"

static thrum_obstacle some_obstacle(random_state *random, int kind) {
  thrum_obstacle o = thrum_default_obstacle();
  const double c = cos(0.7), s = sin(0.7);
  const double turn[9] = {c, -s, 0, s * c, c * c, -s, s * s, c * s, c};
  o.shape = (thrum_obstacle_shape)(kind % 3);
  o.inside = kind >= 3 && o.shape != THRUM_OBSTACLE_PLANE;
  memcpy(o.rotation, turn, sizeof turn);
  random_vector(random, 3, 1, o.centre);
  random_vector(random, 3, 1, o.normal);
  o.radius = 0.7;
  o.half[0] = 0.3;
  o.half[1] = 0.8;
  o.half[2] = 0.5;
  return o;
}

static void gaps_are_signed_distances(void **state) {
  (void)state;
  random_state random = {5};

  for (int n = 0; n < 6000; n++) {
    // two random points around a random obstacle
    const thrum_obstacle o = some_obstacle(&random, n % 6);
    double x[3], y[3], normal[3], other[3], length = 0, apart = 0;
    random_vector(&random, 3, 2, x);
    random_vector(&random, 3, 2, y);

    // the normal is a unit vector, and the gap is Lipschitz continuous with constant 1
    const double gap = thrum_obstacle_gap(&o, x, normal);
    for (int axis = 0; axis < 3; axis++) {
      length += normal[axis] * normal[axis];
      apart += (x[axis] - y[axis]) * (x[axis] - y[axis]);
    }
    assert_true(fabs(length - 1) <= 1e-14);
    assert_true(fabs(gap - thrum_obstacle_gap(&o, y, other)) <= sqrt(apart) * (1 + 1e-14));

    // outside, the gap grows along the normal by the distance
    for (int axis = 0; axis < 3; axis++)
      y[axis] = x[axis] + 0.1 * normal[axis];
    const double moved = thrum_obstacle_gap(&o, y, other);
    assert_true(gap <= 0 || o.inside || fabs(moved - gap - 0.1) <= 1e-13);

    // one gap back along the normal lies the surface
    for (int axis = 0; axis < 3; axis++)
      y[axis] = x[axis] - gap * normal[axis];
    assert_true(fabs(thrum_obstacle_gap(&o, y, other)) <= 1e-13 || o.inside);
  }
}

static void gaps_are_those_of_closed_forms(void **state) {
  (void)state;

  // a box, outside and inside of it
  thrum_obstacle o = thrum_default_obstacle();
  double normal[3];

  o.shape = THRUM_OBSTACLE_BOX;
  o.half[0] = 1;
  o.half[1] = 2;
  o.half[2] = 3;
  assert_true(thrum_obstacle_gap(&o, (double[3]){4, 6, 0}, normal) == 5);
  assert_true(fabs(normal[0] - 0.6) <= 1e-15 && fabs(normal[1] - 0.8) <= 1e-15);
  assert_true(thrum_obstacle_gap(&o, (double[3]){-0.75, 0, 0}, normal) == -0.25);
  assert_true(normal[0] == -1 && normal[1] == 0);

  // the inside of the same box as the obstacle
  o.inside = 1;
  assert_true(thrum_obstacle_gap(&o, (double[3]){-0.75, 0, 0}, normal) == 0.25);
  assert_true(normal[0] == 1);

  // a sphere
  o.shape = THRUM_OBSTACLE_SPHERE;
  o.radius = 6;
  assert_true(thrum_obstacle_gap(&o, (double[3]){0, 3, -4}, normal) == 1);
  assert_true(fabs(normal[1] + 0.6) <= 1e-15 && fabs(normal[2] - 0.8) <= 1e-15);
}

/* Drops a point on an obstacle and returns its gap at the end. */
static double drop_into(const thrum_obstacle *obstacle, double x, double *speed) {
  // a point 0.1 m above the place where it lands
  rig_def def = rig_default();
  rig r;
  rig_make(&r, &def);
  r.floor = *obstacle;
  const double *point = r.m.vertices + 3;
  for (int axis = 0; axis < 3; axis++)
    r.translation.position[axis] = (axis == 0 ? x : 0) - point[axis];
  r.translation.position[2] += 0.1;

  // the end of a long run
  rig_steps(&r, 20000);
  double at[3], normal[3];
  for (int axis = 0; axis < 3; axis++)
    at[axis] = point[axis] + r.translation.position[axis];
  *speed = sqrt(2 * rig_kinetic(&r) / RIG_MASS);
  const double gap = thrum_obstacle_gap(obstacle, at, normal);
  rig_free(&r);
  return gap;
}

static void a_body_comes_to_rest_in_bowls_and_rooms(void **state) {
  (void)state;
  thrum_obstacle o = thrum_default_obstacle();
  const double depth = RIG_MASS * RIG_GRAVITY / 1e6;
  double speed;
  o.inside = 1;
  o.centre[2] = 1;
  o.shape = THRUM_OBSTACLE_SPHERE;
  // off the middle of a bowl friction holds the body, and the spring carries less than the weight
  double gap = drop_into(&o, 0.2, &speed);
  assert_true(speed <= 1e-9 && gap < 0 && gap > -depth);
  o.shape = THRUM_OBSTACLE_BOX;
  o.half[0] = 0.2001;
  gap = drop_into(&o, 0.2, &speed);
  assert_true(speed <= 1e-9 && fabs(gap + depth) <= 1e-9);
}

/* A heavy point in a bowl without friction swings like a pendulum of the length of the radius. */
static void a_body_swings_in_a_smooth_bowl(void **state) {
  (void)state;

  // a smooth bowl, without restitution
  rig_def def = rig_default();
  rig r;
  rig_make(&r, &def);
  r.floor.shape = THRUM_OBSTACLE_SPHERE;
  r.floor.inside = 1;
  r.floor.friction = 0;
  r.floor.restitution = 0;

  // the point starts on the bowl at a small angle, at the depth of its weight
  const double *point = r.m.vertices + 3, angle = 0.02;
  r.translation.position[0] = sin(angle) - point[0];
  r.translation.position[1] = -point[1];
  r.translation.position[2] = -cos(angle) - RIG_MASS * RIG_GRAVITY / def.stiffness - point[2];

  // times of crossing the middle, interpolated between steps
  const double period = 2 * pi / sqrt(RIG_GRAVITY);
  int crossings = 0;
  double last = 0, time = 0;
  for (int n = 1; crossings < 8; n++) {
    const double before = r.translation.position[0] + point[0];
    rig_steps(&r, 1);
    const double now = r.translation.position[0] + point[0];
    assert_true(n < 20000);
    if ((before < 0) == (now < 0))
      continue;
    time = (n - 1 + before / (before - now)) * def.dt;
    if (crossings++ == 0)
      last = time;
  }

  print_message("period off by %.2e\n", (time - last) / 3.5 / period - 1);
  assert_true(fabs((time - last) / 3.5 / period - 1) <= 1e-3);
  rig_free(&r);
}

/* A body with a placement in a rotated frame moves as without it, rotated. */
static void a_placement_turns_everything(void **state) {
  (void)state;

  // a rotation about y, and a shift
  const double c = cos(0.9), s = sin(0.9);
  thrum_placement placement = {{c, 0, s, 0, 1, 0, -s, 0, c}, {3, -2, 5}};
  double q[2][RIG_RANK], height[2];

  for (int turned = 0; turned < 2; turned++) {
    // a flexible body that moves along the floor
    rig_def def = rig_default();
    def.shape = 0.2;
    def.points = 4;
    rig r;
    rig_make(&r, &def);
    r.translation.position[2] = 0.05;
    r.translation.velocity[0] = 0.5;

    // the same with gravity, floor, position and velocity in the rotated frame
    if (turned) {
      const double weight = r.environment.force[2];
      r.environment.placement = &placement;
      r.environment.force[0] = s * weight;
      r.environment.force[2] = c * weight;
      memcpy(r.floor.centre, placement.origin, sizeof placement.origin);
      for (int axis = 0; axis < 3; axis++) {
        r.floor.normal[axis] = placement.axes[3 * axis + 2];
        r.translation.position[axis] = 0.05 * placement.axes[3 * axis + 2];
        r.translation.velocity[axis] = 0.5 * placement.axes[3 * axis];
      }
    }

    // modal coordinates and height over the floor
    rig_steps(&r, 300);
    state_read(&r.m.model, r.state, q[turned], NULL);
    height[turned] = 0;
    for (int axis = 0; axis < 3; axis++)
      height[turned] += r.translation.position[axis] *
                        (turned ? placement.axes[3 * axis + 2] : (axis == 2 ? 1.0 : 0.0));
    rig_free(&r);
  }

  // the differences are those of rounding
  for (int i = 0; i < RIG_RANK; i++)
    assert_true(fabs(q[0][i] - q[1][i]) <= 1e-7);
  assert_true(fabs(height[0] - height[1]) <= 1e-7);
}

static void expect_refused(rig *r, thrum_status expected, const char *part) {
  thrum_error error = {0};
  const size_t size = thrum_contact_bytes(r->contact);
  void *contact = malloc(size), *body = state_snapshot(r->state);
  assert_non_null(contact);
  memcpy(contact, r->contact, size);
  assert_int_equal(thrum_contact_step(&r->m.model, r->state, r->contact, &r->environment, &error),
                   expected);
  if (!strstr(error.message, part))
    fail_msg("'%s' does not say '%s'", error.message, part);
  assert_memory_equal(contact, r->contact, size);
  assert_memory_equal(body, r->state, thrum_state_kept_bytes(r->state));
  free(contact);
  free(body);
}

static void impossible_obstacles_and_contacts_are_refused(void **state) {
  (void)state;

  // a good rig, of which one thing is changed at a time
  rig_def def = rig_default();
  rig r;
  rig_make(&r, &def);
  const thrum_obstacle good = r.floor;

  // an obstacle that was not initialised, and a plane without a normal
  r.floor.cookie = 0;
  expect_refused(&r, THRUM_UNINITIALISED_DEF, "obstacle 0");
  r.floor = good;
  r.floor.normal[2] = 0;
  expect_refused(&r, THRUM_BAD_VALUE, "normal");

  // numbers of the material outside their ranges
  r.floor = good;
  r.floor.restitution = 1.1;
  expect_refused(&r, THRUM_BAD_VALUE, "restitution");
  r.floor = good;
  r.floor.friction = NAN;
  expect_refused(&r, THRUM_BAD_VALUE, "friction");
  r.floor = good;
  r.floor.stiffness = 1e31;
  expect_refused(&r, THRUM_BAD_VALUE, "stiffness");

  // the rotation of a box must be an orthogonal matrix
  r.floor = good;
  r.floor.shape = THRUM_OBSTACLE_BOX;
  r.floor.rotation[0] = 2;
  expect_refused(&r, THRUM_BAD_VALUE, "rotation");
  r.floor = good;

  // the rigid translation
  r.translation.mass = 0;
  expect_refused(&r, THRUM_BAD_VALUE, "mass");
  r.translation.mass = RIG_MASS;

  // pulls of vertices that do not exist, and more pulls than the contact has room for
  thrum_pull pull = {.vertices = {1, 1, RIG_POINTS}, .weights = {1, 0, 0}, .stiffness = 1};
  r.environment.pulls = &pull;
  r.environment.pull_count = 1;
  expect_refused(&r, THRUM_INVALID_ARGUMENT, "vertex 8");
  r.environment.pull_count = 2;
  expect_refused(&r, THRUM_INVALID_ARGUMENT, "made for 1");
  r.environment.pull_count = 0;

  // a load that is not finite
  double load[RIG_RANK] = {0, INFINITY};
  r.environment.load = load;
  expect_refused(&r, THRUM_BAD_VALUE, "load");
  r.environment.load = NULL;

  // the end of a step that was not begun
  rig_steps(&r, 1);
  assert_int_equal(thrum_contact_end(&r.m.model, r.state, r.contact, &r.environment, NULL),
                   THRUM_INVALID_ARGUMENT);
  rig_free(&r);
}

/* A step with one number changed is refused with that word. */
static void refuse_number(rig *r, double *number, double value, const char *part) {
  const double kept = *number;
  *number = value;
  expect_refused(r, THRUM_BAD_VALUE, part);
  *number = kept;
}

/* Each of `count` numbers, not finite in turn, is refused with that word. */
static void refuse_numbers(rig *r, double *numbers, int count, const char *part) {
  for (int n = 0; n < count; n++) {
    refuse_number(r, numbers + n, NAN, part);
    refuse_number(r, numbers + n, n % 2 ? INFINITY : -INFINITY, part);
  }
}

static void every_number_around_a_body_is_checked(void **state) {
  (void)state;
  rig_def def = rig_default();
  rig r;
  rig_make(&r, &def);

  // where the body is, and what moves it as a whole
  thrum_placement placement = {.axes = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  thrum_rigid_frame frame = {.inverse = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                             .attitude = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  r.environment.placement = &placement;
  r.environment.rigid_frame = &frame;
  refuse_numbers(&r, placement.axes, 9, "placement");
  refuse_numbers(&r, placement.origin, 3, "placement");
  refuse_numbers(&r, frame.centre, 3, "rigid frame");
  refuse_numbers(&r, frame.inverse, 9, "rigid frame");
  refuse_numbers(&r, frame.attitude, 9, "rigid frame");
  refuse_numbers(&r, frame.momentum, 3, "rigid frame");
  refuse_numbers(&r, r.translation.position, 3, "translation");
  refuse_numbers(&r, r.translation.velocity, 3, "translation");
  refuse_number(&r, &r.translation.mass, INFINITY, "translation");
  refuse_number(&r, &r.translation.mass, -1, "translation");
  refuse_numbers(&r, r.environment.force, 3, "force");
  refuse_numbers(&r, r.environment.torque, 3, "torque");

  // pulls
  thrum_pull pull = {.vertices = {1, 1, 1}, .weights = {1, 0, 0}, .stiffness = 1};
  r.environment.pulls = &pull;
  r.environment.pull_count = 1;
  refuse_numbers(&r, pull.weights, 3, "pull 0");
  refuse_numbers(&r, pull.target, 3, "pull 0");
  refuse_numbers(&r, pull.velocity, 3, "pull 0");
  refuse_number(&r, &pull.stiffness, -1, "pull 0");
  refuse_number(&r, &pull.stiffness, 1.1e30, "pull 0");
  refuse_number(&r, &pull.damping, 1.1e30, "pull 0");
  refuse_number(&r, &pull.damping, NAN, "pull 0");
  refuse_number(&r, &pull.force_max, -1, "pull 0");
  refuse_number(&r, &pull.force_max, 1.1e30, "pull 0");

  // what gives way at a pull is symmetric, and answers no force against itself
  refuse_numbers(&r, pull.give, 9, "pull 0: give");
  refuse_number(&r, pull.give + 4, -1, "pull 0: give");
  refuse_number(&r, pull.give, 1.1e30, "pull 0: give");
  refuse_number(&r, pull.give + 1, 1e-3, "pull 0: give");
  pull.give[1] = pull.give[3] = 1;
  expect_refused(&r, THRUM_BAD_VALUE, "pull 0: give");
  pull.give[0] = pull.give[4] = pull.give[8] = 1;
  pull.give[2] = pull.give[6] = 1;
  pull.give[5] = pull.give[7] = -1;
  expect_refused(&r, THRUM_BAD_VALUE, "pull 0: give");
  memset(pull.give, 0, sizeof pull.give);
  for (int corner = 0; corner < 3; corner++) {
    pull.vertices[corner] = -1;
    expect_refused(&r, THRUM_INVALID_ARGUMENT, "pull 0: vertex -1");
    pull.vertices[corner] = 1;
  }

  // lists that do not fit their counts
  r.environment.pulls = NULL;
  expect_refused(&r, THRUM_INVALID_ARGUMENT, "counts");
  r.environment.pull_count = -1;
  expect_refused(&r, THRUM_INVALID_ARGUMENT, "counts");
  r.environment.pull_count = 0;
  r.environment.obstacle_count = -1;
  expect_refused(&r, THRUM_INVALID_ARGUMENT, "counts");
  r.environment.obstacle_count = 1;
  r.environment.obstacles = NULL;
  expect_refused(&r, THRUM_INVALID_ARGUMENT, "counts");
  r.environment.obstacles = &r.floor;

  // as it was, it is taken
  assert_true(thrum_contact_step(&r.m.model, r.state, r.contact, &r.environment, NULL) >= 0);
  rig_free(&r);
}

static void every_number_of_an_obstacle_is_checked(void **state) {
  (void)state;
  rig_def def = rig_default();
  rig r;
  rig_make(&r, &def);
  refuse_numbers(&r, r.floor.centre, 3, "centre");
  refuse_numbers(&r, r.floor.velocity, 3, "velocity");
  refuse_numbers(&r, r.floor.normal, 3, "normal");
  refuse_number(&r, &r.floor.stiffness, -1, "stiffness");
  refuse_number(&r, &r.floor.damping, -1, "damping");
  refuse_number(&r, &r.floor.damping, 1.1e30, "damping");
  refuse_number(&r, &r.floor.restitution, -0.1, "restitution");
  refuse_number(&r, &r.floor.friction, -1, "friction");
  refuse_number(&r, &r.floor.friction, 1.1e30, "friction");

  // the numbers of its own shape
  r.floor.shape = THRUM_OBSTACLE_SPHERE;
  refuse_numbers(&r, &r.floor.radius, 1, "radius");
  refuse_number(&r, &r.floor.radius, INFINITY, "radius");
  refuse_number(&r, &r.floor.radius, 0, "radius");
  r.floor.shape = THRUM_OBSTACLE_BOX;
  refuse_numbers(&r, r.floor.half, 3, "half sides");
  refuse_numbers(&r, r.floor.rotation, 9, "rotation");
  for (int axis = 0; axis < 3; axis++)
    refuse_number(&r, &r.floor.half[axis], 0, "half sides");
  for (int n = 0; n < 9; n++)
    refuse_number(&r, &r.floor.rotation[n], r.floor.rotation[n] + 1e-3, "rotation");
  memset(&r.floor.shape, 0x11, sizeof r.floor.shape);
  expect_refused(&r, THRUM_BAD_VALUE, "none of plane, sphere and box");
  rig_free(&r);
}

/* No contact has touches, pulls or counters, and what a contact does not have is refused. */
static void missing_arguments_of_a_contact_are_refused(void **state) {
  (void)state;
  const rig_def made = rig_default();
  rig r;
  rig_make(&r, &made);
  r.translation.position[2] = -0.001;
  rig_steps(&r, 1);

  // a touch that there is, and others
  thrum_touch touch;
  assert_int_equal(thrum_contact_touch_get(r.contact, 0, &touch, NULL), THRUM_OK);
  assert_int_equal(thrum_contact_touch_get(r.contact, 0, NULL, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_contact_touch_get(r.contact, 1, &touch, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_contact_touch_get(r.contact, -1, &touch, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_contact_touch_get(NULL, 0, &touch, NULL), THRUM_INVALID_ARGUMENT);

  // the same of pulls, of which the step had none
  double force[3];
  assert_int_equal(thrum_contact_pull_force(r.contact, 0, force, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_contact_pull_force(r.contact, -1, force, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_contact_pull_force(r.contact, 0, NULL, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_contact_pull_force(NULL, 0, force, NULL), THRUM_INVALID_ARGUMENT);

  // no contact
  thrum_contact_reset(NULL);
  assert_int_equal(thrum_contact_bytes(NULL), 0);
  assert_true(thrum_contact_stiffness(NULL) == 0);
  assert_int_equal(thrum_contact_report_get(NULL).steps, 0);
  assert_int_equal(thrum_contact_step(&r.m.model, r.state, NULL, &r.environment, NULL),
                   THRUM_INVALID_ARGUMENT);

  // a def, a size and a mesh that are missing
  size_t size = 77;
  const thrum_contact_def def = thrum_default_contact_def();
  thrum_model bare = r.m.model;
  bare.basis = NULL;
  assert_int_equal(thrum_contact_size(&r.m.model, r.state, NULL, &size, NULL),
                   THRUM_UNINITIALISED_DEF);
  assert_int_equal(thrum_contact_size(&bare, r.state, &def, &size, NULL), THRUM_MISSING);
  assert_int_equal(size, 77);
  rig_free(&r);
}

static void defs_that_cannot_be_are_refused(void **state) {
  (void)state;

  // a model and a state for the definitions
  rig_def made = rig_default();
  rig r;
  rig_make(&r, &made);

  // an output with a known value, and arguments out of range
  size_t size = 77;
  thrum_error error = {0};
  const int32_t beyond = RIG_POINTS;
  const double area = -1;

  // definitions with one thing wrong
  thrum_contact_def def = {0};
  assert_int_equal(thrum_contact_size(&r.m.model, r.state, &def, &size, &error),
                   THRUM_UNINITIALISED_DEF);
  def = thrum_default_contact_def();
  def.vertices = &beyond;
  def.vertex_count = 1;
  assert_int_equal(thrum_contact_size(&r.m.model, r.state, &def, &size, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "outside 0..7"));
  def.vertices = (const int32_t[1]){0};
  def.areas = &area;
  assert_int_equal(thrum_contact_size(&r.m.model, r.state, &def, &size, &error), THRUM_BAD_VALUE);
  def.areas = NULL;

  // counts up to 2^31, as the messages say, and not one more
  const int64_t most = INT64_C(1) << 31;
  def.vertex_count = most + 1;
  assert_int_equal(thrum_contact_size(&r.m.model, r.state, &def, &size, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "2147483649 vertices; it needs 1 to 2^31"));
  def.vertex_count = 1;
  for (int n = 0; n < 2; n++) {
    thrum_contact_def large = def;
    int64_t *count = n == 0 ? &large.touch_max : &large.pull_max;
    *count = most + 1;
    assert_int_equal(thrum_contact_size(&r.m.model, r.state, &large, &size, &error),
                     THRUM_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "0 to 2^31"));
    assert_int_equal(size, 77);
    *count = most;
    assert_int_equal(thrum_contact_size(&r.m.model, r.state, &large, &size, &error), THRUM_OK);
    size = 77;
  }

  // each other number outside its range
  static const double bad[][2] = {{NAN, NAN}, {-1, 0}, {1.1e30, 1.1e-2}};
  for (int n = 0; n < 3; n++) {
    thrum_contact_def wrong = def;
    wrong.stiffness = bad[n][0];
    assert_int_equal(thrum_contact_size(&r.m.model, r.state, &wrong, &size, &error),
                     THRUM_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "stiffness"));
    wrong = def;
    wrong.tolerance = bad[n][1];
    assert_int_equal(thrum_contact_size(&r.m.model, r.state, &wrong, &size, &error),
                     THRUM_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "tolerance"));
    wrong = def;
    wrong.diagonal = n < 2 ? bad[n][0] : INFINITY;
    assert_int_equal(thrum_contact_size(&r.m.model, r.state, &wrong, &size, &error),
                     THRUM_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "diagonal"));
  }
  for (int n = 0; n < 4; n++) {
    thrum_contact_def wrong = def;
    wrong.touch_max = n == 0 ? -1 : 0;
    wrong.pull_max = n == 1 ? -1 : 0;
    wrong.sweeps_max = n == 2 ? 0 : 1;
    wrong.vertex_count = n == 3 ? 0 : 1;
    assert_int_equal(thrum_contact_size(&r.m.model, r.state, &wrong, &size, &error),
                     THRUM_INVALID_ARGUMENT);
  }
  assert_int_equal(size, 77);

  // a model without a basis has no vertices to touch with
  thrum_model bare = r.m.model;
  bare.basis = NULL;
  assert_int_equal(thrum_contact_size(&bare, r.state, &def, &size, &error), THRUM_MISSING);
  assert_int_equal(size, 77);

  // memory that is too small or misaligned
  assert_int_equal(thrum_contact_size(&r.m.model, r.state, &def, &size, &error), THRUM_OK);
  void *memory = aligned_alloc(64, size);
  thrum_contact *contact = NULL;
  assert_int_equal(
      thrum_contact_init(memory, size - 1, &r.m.model, r.state, &def, &contact, &error),
      THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(
      thrum_contact_init((char *)memory + 8, size, &r.m.model, r.state, &def, &contact, &error),
      THRUM_MISALIGNED);

  assert_null(contact);
  free(memory);
  rig_free(&r);
}

static void forces_of_touches_are_what_the_body_gets(void **state) {
  (void)state;
  rig_def def = rig_default();
  def.points = 3;
  rig r;
  rig_make(&r, &def);

  // a floor that leans in all directions, on which it slides
  const double normal[3] = {0.48, 0.36, 0.8};
  memcpy(r.floor.normal, normal, sizeof normal);
  r.floor.friction = 0.2;
  r.translation.velocity[0] = 0.4;
  int touching = 0;
  for (int n = 0; n < 40; n++) {
    double before[3], sum[3];
    memcpy(before, r.translation.velocity, sizeof before);
    memcpy(sum, r.environment.force, sizeof sum);
    rig_steps(&r, 1);
    const thrum_contact_report report = thrum_contact_report_get(r.contact);
    for (int32_t t = 0; t < report.touching; t++) {
      thrum_touch touch;
      assert_int_equal(thrum_contact_touch_get(r.contact, t, &touch, NULL), THRUM_OK);
      for (int axis = 0; axis < 3; axis++) {
        sum[axis] += touch.force[axis];
        assert_true(fabs(touch.normal[axis] - normal[axis]) <= 1e-15);
      }
    }
    touching += report.touching;
    for (int axis = 0; axis < 3; axis++)
      assert_true(fabs(RIG_MASS * (r.translation.velocity[axis] - before[axis]) -
                       def.dt * sum[axis]) <= 1e-9);
  }
  assert_true(touching > 20);
  rig_free(&r);
}

static void an_unnamed_stiffness_is_that_of_the_hardest_region(void **state) {
  (void)state;
  double found[3];
  for (int n = 0; n < 3; n++) {
    rig_def def = rig_default();
    rig r;
    rig_make(&r, &def);
    double material[6] = {n == 1 ? 3e6 : 1e6, 0.3, 1, n == 2 ? 3e6 : 1e6, 0.3, 1};
    r.m.model.material = material;
    r.m.model.region_count = 2;
    thrum_contact_def plain = thrum_default_contact_def();
    thrum_contact *contact = contact_make(&r.m.model, r.state, &plain);
    found[n] = contact->stiffness;
    free(contact);
    r.m.model.material = r.m.material;
    r.m.model.region_count = 1;
    rig_free(&r);
  }
  assert_true(found[0] > 0 && fabs(found[1] / found[0] - 3) <= 1e-14 && found[2] == found[1]);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(gaps_are_signed_distances),
      cmocka_unit_test(gaps_are_those_of_closed_forms),
      cmocka_unit_test(a_body_comes_to_rest_in_bowls_and_rooms),
      cmocka_unit_test(a_body_swings_in_a_smooth_bowl),
      cmocka_unit_test(a_placement_turns_everything),
      cmocka_unit_test(impossible_obstacles_and_contacts_are_refused),
      cmocka_unit_test(every_number_around_a_body_is_checked),
      cmocka_unit_test(every_number_of_an_obstacle_is_checked),
      cmocka_unit_test(missing_arguments_of_a_contact_are_refused),
      cmocka_unit_test(defs_that_cannot_be_are_refused),
      cmocka_unit_test(forces_of_touches_are_what_the_body_gets),
      cmocka_unit_test(an_unnamed_stiffness_is_that_of_the_hardest_region),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
