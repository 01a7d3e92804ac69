/* Tests of bodies that touch each other: momentum and energy are kept, nothing passes, stacks rest,
 * friction holds to its angle, and snapshots hold all of it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include <float.h>

#include "core/base/vec3.h"
#include "tests/support/outer_triangles.h"
#include "tests/support/sanitized.h"
#include "tests/support/scene_call.h"

static const double down[3] = {0, 0, -9.81};

/* A model that nothing holds, with its surface. */
typedef struct shape {
  body mesh;
  thrum_precomputed made;
  int32_t *triangles;
  int64_t triangle_count;
} shape;

typedef struct fixture {
  shape block, plate;
  thrum_scene *scene;
} fixture;

static shape shape_make(const char *name) {
  shape s = {.mesh = body_make(name, NULL)};
  s.made = body_precompute(&s.mesh, 4, 8);
  s.triangles = outer_triangles(&s.mesh.mesh, &s.triangle_count);
  return s;
}

static void shape_free(shape *s) {
  thrum_precomputed_free(&s->made);
  body_free(&s->mesh);
  free(s->triangles);
}

static int setup(void **context) {
  fixture *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;
  f->block = shape_make("beam:2x2x2@0.2x0.2x0.2");
  f->plate = shape_make("beam:6x6x1@0.6x0.6x0.02");
  *context = f;
  return thrum_scene_create(0.002, &f->scene, &failure) < 0;
}

static int teardown(void **context) {
  fixture *f = *context;
  thrum_scene_destroy(f->scene);
  shape_free(&f->block);
  shape_free(&f->plate);
  free(f);
  return 0;
}

/* A free body of a shape at a place, stiffened by a factor. */
static thrum_scene_body_def def_of(const shape *s, double x, double y, double z, double stiffness) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &s->made.model;
  def.triangles = s->triangles;
  def.triangle_count = s->triangle_count;
  def.position[0] = x;
  def.position[1] = y;
  def.position[2] = z;
  def.stiffness = stiffness;
  def.free = 1;
  return def;
}

/* All 27 vertices of a block may touch obstacles. */
static void touch_obstacles(thrum_scene_body_def *block) {
  static int32_t all[27];
  for (int n = 0; n < 27; n++)
    all[n] = n;
  block->touch = all;
  block->touch_count = 27;
}

static void add(thrum_scene *scene, const thrum_scene_body_def *def) {
  MUST(thrum_scene_add_body(scene, def, NULL, &failure));
}

static void collide(thrum_scene *scene, double friction, double restitution) {
  thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  def.friction = friction;
  def.restitution = restitution;
  MUST(thrum_scene_set_collisions(scene, &def, &failure));
}

static thrum_scene_account account_of(thrum_scene *scene) {
  thrum_scene_account account;
  MUST(thrum_scene_account_get(scene, &account, &failure));
  return account;
}

static void assert_near3(const double a[3], const double b[3], double tolerance) {
  for (int axis = 0; axis < 3; axis++)
    assert_true(fabs(a[axis] - b[axis]) <= tolerance);
}

/* Two bodies meet askew, with friction and spin. */
static void throw(fixture * f, double restitution) {
  thrum_scene_body_def a = def_of(&f->block, 0, 0, 0, 1), b = def_of(&f->block, 0.5, 0.06, 0.03, 3);
  a.velocity[0] = 3;
  a.spin[1] = 2;
  b.rotation[1] = 0.4;
  b.rotation[3] = 0.3;
  b.spin[0] = -1;
  collide(f->scene, 0.5, restitution);
  add(f->scene, &a);
  add(f->scene, &b);
}

static void bodies_that_meet_keep_momentum_and_gain_no_energy(void **context) {
  fixture *f = *context;
  throw(f, 0.5);
  const thrum_scene_account before = account_of(f->scene);
  double most = before.total;
  int64_t touched = 0;
  for (int k = 0; k < 400; k++) {
    MUST(thrum_scene_step(f->scene, &failure));
    const thrum_scene_account now = account_of(f->scene);
    touched += thrum_scene_collisions(f->scene).touching;
    most = fmax(most, now.total);
    assert_near3(now.momentum, before.momentum, 1e-12 * before.momentum[0]);
    assert_near3(now.angular_momentum, before.angular_momentum, 1e-11);
  }

  // they have met, and what they lost is what contact took
  const thrum_scene_account after = account_of(f->scene);
  const thrum_contact_pairs_report report = thrum_scene_collisions(f->scene);
  assert_true(touched > 0 && report.touching == 0);
  assert_true(most <= before.total * (1 + 1e-9));
  assert_true(report.lost > 0);
  assert_close(after.total + report.lost, before.total, 1e-6);
  assert_true(report.deepest_share < 1);

  // the second moves with what the first gave it
  double x[3], v[3];
  MUST(thrum_scene_body_vertex(f->scene, 1, 0, x, v, &failure));
  assert_true(x[0] > 0.5);
}

/* Whatever a row of blocks does in a step that is far too long for it, no energy comes from it, and
 * what is lost is counted. */
static void a_shot_along_a_row_gains_no_energy(void **context) {
  fixture *f = *context;
  collide(f->scene, 0, 0.5);
  for (int n = 0; n < 5; n++) {
    thrum_scene_body_def def = def_of(&f->block, n == 0 ? -0.21 : (n - 1) * 0.21, 0, 0, 100);
    def.velocity[0] = n == 0 ? 400 : 0;
    add(f->scene, &def);
  }

  // what is lost and what is left are what there was
  const thrum_scene_account before = account_of(f->scene);
  for (int k = 0; k < 20; k++) {
    MUST(thrum_scene_step(f->scene, &failure));
    const double lost = thrum_scene_collisions(f->scene).lost;
    const double total = account_of(f->scene).total;
    print_message("%d: %.6f, %.6f with the lost\n", k, total / before.total,
                  (total + lost) / before.total);
    assert_true(total <= before.total * (1 + 1e-9));
    assert_true(fabs(total + lost - before.total) <= 1e-9 * before.total);
  }
}

/* The sum of the impulses along z that the last step lists, on the first of two bodies. */
static double listed_impulse(const thrum_scene *scene) {
  const thrum_contact_pairs_report report = thrum_scene_collisions(scene);
  double sum = 0;
  for (int64_t n = 0; n < report.struck; n++) {
    thrum_pair_touch touch;
    MUST(thrum_scene_collision_get(scene, report.touching + n, &touch, &failure));
    assert_true(touch.force[2] == 0 && touch.distance > 0);
    sum += touch.impulse[2];
  }
  return sum;
}

/* The speed of a block after it has met a plane, a solid or another block flat at speed v. */
static double bounce(const fixture *f, double h, double stiffness, double e, double v,
                     int against) {
  thrum_scene *scene = NULL;
  double x[3], first[3], second[3] = {0};
  MUST(thrum_scene_create(h, &scene, &failure));
  thrum_scene_body_def block = def_of(&f->block, 0, 0, 0.104, stiffness);
  block.velocity[2] = -v;

  // a plane, a solid plate, or a block at rest, each 4 mm below it
  if (against == 0) {
    thrum_obstacle floor = thrum_default_obstacle();
    floor.restitution = e;
    touch_obstacles(&block);
    MUST(thrum_scene_add_obstacle(scene, &floor, NULL, &failure));
  } else if (against == 1) {
    thrum_scene_solid_def plate = thrum_default_scene_solid_def();
    plate.restitution = e;
    plate.position[2] = -0.503;
    MUST(thrum_scene_add_solid(scene, &plate, NULL, &failure));
  } else {
    collide(scene, 0.5, e);
    const thrum_scene_body_def low = def_of(&f->block, 0, 0, -0.103, stiffness);
    add(scene, &low);
  }
  add(scene, &block);

  // the energy is there or has been lost, and the impulses that are listed are those of the impact
  const thrum_scene_account before = account_of(scene);
  double impulse = 0;
  for (int k = 0; k < (int)(0.008 / (v * h)) + 10; k++) {
    MUST(thrum_scene_step(scene, &failure));
    impulse += listed_impulse(scene);
  }
  thrum_scene_body_info info;
  MUST(thrum_scene_body(scene, against == 2, &info, &failure));
  const double mass = -before.momentum[2] / v, met = against == 2 ? -0.5 * mass : mass;
  assert_true(against == 0 || fabs(impulse - met * (1 + e) * v) <= 1e-6 * mass * v);
  assert_true((info.contact.impacts > 0) == (against == 0));
  const double lost = thrum_scene_collisions(scene).lost + info.contact.lost;
  assert_true(fabs(account_of(scene).total + lost - before.total) <= 1e-9 * before.total);
  MUST(thrum_scene_body_vertex(scene, against == 2, 0, x, first, &failure));
  if (against == 2)
    MUST(thrum_scene_body_vertex(scene, 0, 0, x, second, &failure));
  thrum_scene_destroy(scene);
  return first[2] - second[2];
}

static void a_near_rigid_block_bounces_by_its_restitution(void **context) {
  const double steps[3] = {0.0002, 0.001, 0.004}, restitution[4] = {0, 0.3, 0.8, 1};
  double worst = 0;
  for (int against = 0; against < 3; against++)
    for (int n = 0; n < 3; n++)
      for (int soft = 0; soft < 2; soft++)
        for (int k = 0; k < 4; k++) {
          const double v = soft ? 0.02 : 1, e = restitution[k];
          const double got = bounce(*context, steps[n], soft ? 1 : 1e4, e, v, against) / v;
          worst = fmax(worst, fabs(got - e));
        }
  print_message("restitution off by %.1e\n", worst);
  assert_true(worst < 1e-6);
}

/* Stiff blocks that meet askew, with friction and spin, are struck as rigid ones. */
static void an_impact_of_rigid_bodies_keeps_momentum_and_gains_no_energy(void **context) {
  fixture *f = *context;
  for (int n = 0; n < 3; n++) {
    thrum_scene *scene = NULL;
    MUST(thrum_scene_create(0.002, &scene, &failure));

    // one flies at the other, both turn
    thrum_scene_body_def a = def_of(&f->block, 0, 0, 0, 1e5);
    thrum_scene_body_def b = def_of(&f->block, 0.5, 0.06, 0.03, 3e5);
    a.velocity[0] = 1;
    a.spin[1] = 2;
    b.rotation[1] = 0.4;
    b.rotation[3] = 0.3;
    b.spin[0] = -1;
    collide(scene, 0.5, 0.5 * n);
    add(scene, &a);
    add(scene, &b);
    const thrum_scene_account before = account_of(scene);

    // all is kept in every step, and what is lost is booked
    for (int k = 0; k < 400; k++) {
      MUST(thrum_scene_step(scene, &failure));
      const thrum_scene_account now = account_of(scene);
      const double lost = thrum_scene_collisions(scene).lost;
      assert_near3(now.momentum, before.momentum, 1e-12 * before.momentum[0]);
      assert_near3(now.angular_momentum, before.angular_momentum, 1e-12 * before.momentum[0]);
      assert_true(now.total <= before.total * (1 + 1e-12));
      assert_true(fabs(now.total + lost - before.total) <= 1e-9 * before.total);
    }
    assert_true(account_of(scene).momentum[0] > 0 && thrum_scene_collisions(scene).lost > 0);
    assert_true(thrum_scene_collisions(scene).deepest_share < 1);
    thrum_scene_destroy(scene);
  }
}

/* A block strikes two that touch each other, with e = 1, and these fly on in touch: rounding in the
 * forces between them, which are almost nothing, is no reason to decline their steps. */
static void bodies_that_fly_on_in_touch_keep_their_contact(void **context) {
  fixture *f = *context;
  const double thickness = 0.2 * sqrt(3) / 250;
  collide(f->scene, 0.5, 1);
  for (int n = 0; n < 3; n++) {
    thrum_scene_body_def block = def_of(&f->block, 0, 0, 0, 1e6);
    block.position[0] = n == 0 ? -0.5 : (n - 1) * (0.2 + 0.999 * thickness);
    block.velocity[0] = n == 0;
    add(f->scene, &block);
  }
  const double before = account_of(f->scene).total;
  for (int k = 0; k < 200; k++)
    MUST(thrum_scene_step(f->scene, &failure));

  // the two go at 2/3 each, as Moreau's law has it
  const thrum_contact_pairs_report report = thrum_scene_collisions(f->scene);
  for (int n = 1; n < 3; n++) {
    double x[3], v[3];
    MUST(thrum_scene_body_vertex(f->scene, n, 0, x, v, &failure));
    assert_close(v[0], 2.0 / 3.0, 1e-6);
  }
  assert_int_equal(report.declined, 0);
  assert_true(fabs(account_of(f->scene).total - before) <= 1e-10 * before);
}

/* The springs of a stiff block at rest return what they took, and a rest that is missing is theirs.
 */
static void what_is_lost_at_rest_is_never_below_zero(void **context) {
  fixture *f = *context;
  thrum_scene_solid_def floor = thrum_default_scene_solid_def();
  const thrum_scene_body_def block = def_of(&f->block, 0, 0, 0.1014, 2e3);
  floor.restitution = 0.5;
  floor.position[2] = -0.5;
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  MUST(thrum_scene_add_solid(f->scene, &floor, NULL, &failure));
  add(f->scene, &block);
  for (int k = 0; k < 200; k++) {
    MUST(thrum_scene_step(f->scene, &failure));
    assert_true(thrum_scene_collisions(f->scene).lost >= -1e-15);
  }
  assert_true(thrum_scene_collisions(f->scene).touching > 0);
}

/* A corner lands with e = 1, where friction with the whole coefficient would add energy: it acts
 * with a part of the coefficient, and nothing is gained. */
static void friction_of_an_impact_is_cut_where_it_would_gain(void **context) {
  fixture *f = *context;
  thrum_obstacle floor = thrum_default_obstacle();
  thrum_scene_body_def block = def_of(&f->block, 0, 0, 0.25, 1e6);
  floor.restitution = 1;
  floor.friction = 0.5;
  touch_obstacles(&block);
  block.rotation[1] = 0.2;
  block.rotation[2] = 0.26;
  block.rotation[3] = 0.07;
  block.velocity[0] = -0.5;
  block.velocity[2] = -2;
  block.spin[0] = 1;
  MUST(thrum_scene_add_obstacle(f->scene, &floor, NULL, &failure));
  add(f->scene, &block);

  // until it has met the floor
  const thrum_scene_account before = account_of(f->scene);
  thrum_scene_account after = before;
  for (int k = 0; k < 200 && after.momentum[2] == before.momentum[2]; k++) {
    MUST(thrum_scene_step(f->scene, &failure));
    after = account_of(f->scene);
  }
  const double along = after.momentum[2] - before.momentum[2];
  const double across =
      hypot(after.momentum[0] - before.momentum[0], after.momentum[1] - before.momentum[1]);
  print_message("friction %.4f of the normal impulse, energy %.6f of what it was\n", across / along,
                after.total / before.total);
  assert_true(along > 0 && across > 0.1 * along && across <= 0.5 * along);
  assert_true(after.total <= before.total * (1 + 1e-12));
}

/* Velocities of a block after its lowest edge has fallen on the highest edge of another, across it
 * and beside the middles of both, somewhere in space. */
static void cross_edges(const fixture *f, const double at[3], double velocity[3]) {
  const double half = sqrt(0.5), eighth = 0.5 * atan(1);
  double x[3];
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.002, &scene, &failure));
  collide(scene, 0.3, 0.5);

  // both stand on an edge, with their middles, 0.1 m along x in the mesh, one above the other but
  // for 0.02 and 0.03 m; 0.01 m are between the edges
  thrum_scene_body_def below = def_of(&f->block, at[0] - 0.1, at[1], at[2], 1e4);
  thrum_scene_body_def above =
      def_of(&f->block, at[0] + 0.02 - 0.1 * half, at[1] + 0.03, at[2] + 0.5 * half + 0.01, 1e4);
  below.rotation[0] = above.rotation[0] = cos(eighth);
  below.rotation[1] = above.rotation[2] = sin(eighth);
  above.velocity[2] = -1;
  add(scene, &below);
  add(scene, &above);
  for (int k = 0; k < 20; k++)
    MUST(thrum_scene_step(scene, &failure));

  // that of the vertex in its middle
  MUST(thrum_scene_body_vertex(scene, 1, 13, x, velocity, &failure));
  thrum_scene_destroy(scene);
}

static void edges_strike_alike_everywhere(void **context) {
  const double places[3][3] = {{0, 0, 0}, {64, -32, 16}, {-64, 32, -16}};
  double velocity[3][3];
  for (int n = 0; n < 3; n++)
    cross_edges(*context, places[n], velocity[n]);

  // it is thrown back, and the same way
  print_message("after %.6f %.6f %.6f m/s\n", velocity[0][0], velocity[0][1], velocity[0][2]);
  assert_true(velocity[0][2] > -0.9);
  assert_near3(velocity[0], velocity[1], 1e-6);
  assert_near3(velocity[0], velocity[2], 1e-6);
}

/* A wall that moves hits a block at rest: it goes on at (1 + e) times its speed, which the wall
 * paid.
 */
static void a_solid_that_moves_strikes_by_its_restitution(void **context) {
  fixture *f = *context;
  thrum_scene_solid_def wall = thrum_default_scene_solid_def();
  wall.restitution = 0.6;
  wall.position[2] = -0.61;
  wall.velocity[2] = 1;
  const thrum_scene_body_def block = def_of(&f->block, 0, 0, 0, 1e4);
  add(f->scene, &block);
  MUST(thrum_scene_add_solid(f->scene, &wall, NULL, &failure));
  for (int k = 0; k < 20; k++)
    MUST(thrum_scene_step(f->scene, &failure));

  // its energy is the work of the wall less what was lost
  double x[3], v[3];
  const thrum_contact_pairs_report report = thrum_scene_collisions(f->scene);
  MUST(thrum_scene_body_vertex(f->scene, 0, 0, x, v, &failure));
  assert_close(v[2], 1.6, 1e-9);
  assert_close(account_of(f->scene).kinetic, report.driven - report.lost, 1e-9);
}

/* A block between two walls meets one and the other several times in a step: what it has left does
 * not bear on it at the next impact, and with e = 1 it keeps its energy. */
static void a_block_between_two_walls_bounces_several_times_in_a_step(void **context) {
  fixture *f = *context;
  thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  thrum_scene_body_def block = def_of(&f->block, 0, 0, 0, 1e5);
  block.velocity[2] = -1;
  def.thickness = 0.001;
  MUST(thrum_scene_set_collisions(f->scene, &def, &failure));

  // it has a way of 0.38 mm between the walls, and makes 2 mm a step
  for (int side = -1; side <= 1; side += 2) {
    thrum_scene_solid_def wall = thrum_default_scene_solid_def();
    wall.restitution = 1;
    wall.friction = 0;
    wall.position[2] = side * (0.5 + 0.1 + 0.001 + 0.00019);
    MUST(thrum_scene_add_solid(f->scene, &wall, NULL, &failure));
  }
  add(f->scene, &block);
  const double before = account_of(f->scene).kinetic;

  // it is always between them, as fast as it was
  for (int k = 0; k < 100; k++) {
    double x[3], v[3];
    MUST(thrum_scene_step(f->scene, &failure));
    MUST(thrum_scene_body_vertex(f->scene, 0, 0, x, v, &failure));
    assert_close(fabs(v[2]), 1, 1e-7);
    assert_true(fabs(x[2] + 0.1) < 0.000191);
    assert_true(account_of(f->scene).kinetic <= before * (1 + 1e-12));
  }
}

/* A block that is dropped on a floor rises to e^2 of its height, again and again. */
static void a_dropped_block_rises_by_the_square_of_its_restitution(void **context) {
  fixture *f = *context;
  thrum_obstacle floor = thrum_default_obstacle();
  thrum_scene_body_def block = def_of(&f->block, 0, 0, 0.3, 1e5);
  floor.restitution = 0.8;
  touch_obstacles(&block);
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  MUST(thrum_scene_add_obstacle(f->scene, &floor, NULL, &failure));
  add(f->scene, &block);

  // the highest place after the first and the second impact
  double top[2] = {0, 0}, x[3], v[3];
  int impacts = 0;
  double last = 0;
  for (int k = 0; k < 400; k++) {
    MUST(thrum_scene_step(f->scene, &failure));
    MUST(thrum_scene_body_vertex(f->scene, 0, 0, x, v, &failure));
    impacts += v[2] > 0 && last < 0;
    if (impacts == 1 || impacts == 2)
      top[impacts - 1] = fmax(top[impacts - 1], x[2]);
    last = v[2];
  }
  assert_true(impacts > 1);
  assert_true(fabs(top[0] - 0.2 * 0.64) < 1e-3);
  assert_true(fabs(top[1] - 0.2 * 0.64 * 0.64) < 1e-3);
}

static void a_plate_holds_what_is_shot_at_it(void **context) {
  fixture *f = *context;
  for (int half = 0; half < 2; half++) {
    thrum_scene *scene = NULL;
    MUST(thrum_scene_create(0.002, &scene, &failure));

    // the block goes ten plates and more in a step, through the middle or near a rim
    thrum_scene_body_def block = def_of(&f->block, half ? 0.2 : 0.02, 0, 0.93, 1e3);
    const thrum_scene_body_def plate = def_of(&f->plate, 0, 0, 0, 1e4);
    block.scale = 0.5;
    block.velocity[2] = -100;
    collide(scene, 0.5, 0.5);
    add(scene, &block);
    add(scene, &plate);
    const thrum_scene_account before = account_of(scene);
    for (int k = 0; k < 12; k++)
      MUST(thrum_scene_step(scene, &failure));

    // it stays on its side, by more than the thickness at any time
    const thrum_scene_account after = account_of(scene);
    const thrum_contact_pairs_report report = thrum_scene_collisions(scene);
    assert_true(report.deepest_share < 1 && report.deepest > 0);
    assert_true(report.dropped == 0 && report.declined == 0);
    assert_true(after.total <= before.total);
    assert_near3(after.momentum, before.momentum, 1e-9 * 100);
    thrum_scene_destroy(scene);
  }
}

/* At 1 and 8 m a step, which is 50 and 400 times the plate, some of what is shot goes through. No
 * passage is silent: what went through counts as deeper than the thickness, momentum is kept and no
 * energy is gained. */
static void what_is_shot_through_a_plate_in_longer_steps_is_told(void **context) {
  fixture *f = *context;
  int passed = 0, shots = 0;
  for (int n = 0; n < 96; n += 4, shots++) {
    thrum_scene *scene = NULL;
    MUST(thrum_scene_create(0.002, &scene, &failure));

    // one cube of 5 cm, at 48 places
    thrum_scene_body_def block =
        def_of(&f->block, 0.22 + 0.0033 * (n % 8), 0.0033 * (n / 8 % 6), 0.3, 200);
    const thrum_scene_body_def plate = def_of(&f->plate, 0, 0, 0, 200);
    block.scale = 0.25;
    block.velocity[2] = n < 48 ? -500 : -4000;
    collide(scene, 0.5, 0.5);
    add(scene, &block);
    add(scene, &plate);
    const thrum_scene_account before = account_of(scene);
    for (int k = 0; k < 6; k++)
      MUST(thrum_scene_step(scene, &failure));

    // whether it came back, and what is said where it did not
    const thrum_scene_account after = account_of(scene);
    double x[3], v[3];
    MUST(thrum_scene_body_vertex(scene, 0, 0, x, v, &failure));
    const bool through = x[2] < -0.2;
    passed += through;
    assert_true(!through || thrum_scene_collisions(scene).deepest_share >= 1);
    assert_true(after.total <= before.total * (1 + 1e-9));
    assert_near3(after.momentum, before.momentum, 1e-9 * 1000);
    thrum_scene_destroy(scene);
  }
  print_message("%d of %d shots go through\n", passed, shots);
  assert_in_range(passed, 1, shots - 1);
}

/* A block that is struck meets the plate before it in the same step. */
static void what_is_struck_does_not_pass_what_it_meets(void **context) {
  fixture *f = *context;
  collide(f->scene, 0.5, 0.3);

  // the gaps are half a thickness, which the struck block goes many times over in a step
  const double heights[3] = {0, 0.0635, 0.1685};
  for (int n = 0; n < 3; n++) {
    thrum_scene_body_def def =
        def_of(n ? &f->block : &f->plate, n ? 0.1 : 0, 0, heights[n], n ? 10 : 1e3);
    def.scale = n ? 0.5 : 1;
    def.velocity[2] = n == 2 ? -20 : 0;
    add(f->scene, &def);
  }
  for (int k = 0; k < 25; k++)
    MUST(thrum_scene_step(f->scene, &failure));

  // all stay on their side, by more than the thickness at any time
  const thrum_contact_pairs_report report = thrum_scene_collisions(f->scene);
  print_message("deepest: %.2f\n", report.deepest_share);
  assert_true(report.deepest_share > 0 && report.deepest_share < 1);
}

/* What is struck meets a third body in the same step, whichever of them came first into the scene:
 * the one behind moves on at once, and none is in another. */
static void what_is_struck_meets_the_next_in_any_order(void **context) {
  fixture *f = *context;
  static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                   {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  const double places[3] = {0, 0.1025, -0.11};
  for (int n = 0; n < 6; n++) {
    thrum_scene *scene = NULL;
    MUST(thrum_scene_create(0.001, &scene, &failure));
    collide(scene, 0.5, 0.5);
    int behind = 0;
    for (int k = 0; k < 3; k++) {
      const int which = orders[n][k];
      thrum_scene_body_def def = def_of(&f->block, places[which], 0.015 * (which == 1), 0, 1e3);
      def.scale = 0.5;
      def.velocity[0] = which == 2 ? 25 : 0;
      add(scene, &def);
      behind = which == 1 ? k : behind;
    }
    MUST(thrum_scene_step(scene, &failure));
    double x[3], v[3];
    MUST(thrum_scene_body_vertex(scene, behind, 13, x, v, &failure));
    if (!(v[0] > 1))
      fail_msg("order %d: the body behind moves at %g m/s", n, v[0]);
    assert_true(thrum_scene_collisions(scene).deepest_share < 1);
    thrum_scene_destroy(scene);
  }
}

/* The same of a wall that moves. */
static void what_a_solid_strikes_meets_the_next(void **context) {
  fixture *f = *context;
  thrum_scene_solid_def wall = thrum_default_scene_solid_def();
  wall.position[0] = -0.51;
  wall.velocity[0] = 25;
  MUST(thrum_scene_add_solid(f->scene, &wall, NULL, &failure));
  collide(f->scene, 0.5, 0.5);
  for (int n = 0; n < 2; n++) {
    thrum_scene_body_def block = def_of(&f->block, 0.1025 * n, 0.015 * n, 0, 1e3);
    block.scale = 0.5;
    add(f->scene, &block);
  }
  MUST(thrum_scene_step(f->scene, &failure));
  double x[3], v[3];
  MUST(thrum_scene_body_vertex(f->scene, 1, 13, x, v, &failure));
  if (!(v[0] > 1))
    fail_msg("the second block moves at %g m/s", v[0]);
  assert_true(thrum_scene_collisions(f->scene).deepest_share < 1);
}

/* A column of cubes that lie on each other strikes the floor: without restitution all of them stop
 * in that impact, as its impulses are passed on from cube to cube. */
static void a_column_is_struck_as_one(void **context) {
  fixture *f = *context;
  const double thickness = 0.1 * sqrt(3) / 250, speed = 0.5, overlap = 1e-9;
  thrum_scene_solid_def floor = thrum_default_scene_solid_def();
  floor.position[2] = -0.5;
  floor.restitution = floor.friction = 0;
  MUST(thrum_scene_add_solid(f->scene, &floor, NULL, &failure));
  collide(f->scene, 0, 0);
  for (int n = 0; n < 12; n++) {
    thrum_scene_body_def cube =
        def_of(&f->block, 0.01 * (n % 3), 0,
               0.05 + thickness + n * (0.1 + thickness - overlap) + 5e-4, 1e4);
    cube.scale = 0.5;
    cube.velocity[2] = -speed;
    add(f->scene, &cube);
  }

  // half a millimetre above the floor, it meets it in the first step
  MUST(thrum_scene_step(f->scene, &failure));
  double fastest = 0;
  for (int n = 0; n < 12; n++) {
    double x[3], v[3];
    MUST(thrum_scene_body_vertex(f->scene, n, 13, x, v, &failure));
    fastest = fmax(fastest, sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
  }
  print_message("fastest after the impact: %.2g m/s\n", fastest);
  assert_true(thrum_scene_collisions(f->scene).impacts > 0);
  assert_true(fastest < 1e-6 * speed);
}

/* A candidate that is near needs room among the touches only until another one at the same vertex
 * is found to stand for it: a row of blocks with room for its touches, but not for all that is
 * near, leaves no touch out. */
static void what_others_speak_for_takes_no_room(void **context) {
  fixture *f = *context;
  const double thickness = 0.2 * sqrt(3) / 250;
  thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  def.touch_max = 150;
  MUST(thrum_scene_set_collisions(f->scene, &def, &failure));
  for (int n = 0; n < 8; n++) {
    thrum_scene_body_def block = def_of(&f->block, n * (0.2 + 0.99 * thickness), 0, 0, 1);
    block.velocity[0] = -1.0 * n; // too fast for lists
    add(f->scene, &block);
  }

  // the first step finds them all
  MUST(thrum_scene_step(f->scene, &failure));
  const thrum_contact_pairs_report report = thrum_scene_collisions(f->scene);
  print_message("%lld strike, %lld left out\n", (long long)report.impacts,
                (long long)report.dropped);
  assert_true(report.impacts > 0);
  assert_int_equal(report.dropped, 0);
}

/* Three blocks on a floor, a little apart and askew: each bears what is above it, and nothing
 * moves. Returns how many sweeps it took until then. shift: of the start [m]. */
static int64_t rest_as_stack(const fixture *f, double shift) {
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.002, &scene, &failure));
  const thrum_obstacle floor = thrum_default_obstacle();
  MUST(thrum_scene_set_gravity(scene, down, &failure));
  MUST(thrum_scene_add_obstacle(scene, &floor, NULL, &failure));
  collide(scene, 0.5, 0.3);
  const int64_t count = f->block.made.model.vertex_count;
  int32_t *touch = need((size_t)count, sizeof *touch);
  for (int64_t v = 0; v < count; v++)
    touch[v] = (int32_t)v;
  for (int n = 0; n < 3; n++) {
    thrum_scene_body_def def =
        def_of(&f->block, (0.01 + shift) * n, -0.01 * n, 0.105 + 0.21 * n, 20);
    def.state.damping_alpha = 2;
    def.touch = touch;
    def.touch_count = count;
    add(scene, &def);
  }
  thrum_scene_body_info info;
  MUST(thrum_scene_body(scene, 0, &info, &failure));
  const double weight = 9.81 * info.mass;

  // how long they rock on their corners depends on the last bits of the model; where they turn
  // round they stand still for a moment, and so rest is 200 quiet steps in a row
  int steps = 0;
  for (int quiet = 0; steps < 4000 && quiet < 200; steps++) {
    MUST(thrum_scene_step(scene, &failure));
    quiet = account_of(scene).kinetic < 1e-10 * weight ? quiet + 1 : 0;
  }
  const int64_t sweeps = thrum_scene_collisions(scene).sweeps;
  print_message("at rest for 200 steps after %d steps and %lld sweeps\n", steps, (long long)sweeps);

  // each bears what is above it
  MUST(thrum_scene_body(scene, 0, &info, &failure));
  assert_close(info.contact.normal, 3 * weight, 1e-3);
  double between[2] = {0, 0};
  const thrum_contact_pairs_report report = thrum_scene_collisions(scene);
  for (int64_t n = 0; n < report.touching; n++) {
    thrum_pair_touch touching;
    MUST(thrum_scene_collision_get(scene, n, &touching, &failure));
    assert_int_equal(touching.bodies[1], touching.bodies[0] + 1);
    between[touching.bodies[0]] -= touching.force[2];
    assert_true(touching.distance > 0);
  }
  assert_close(between[0], 2 * weight, 1e-3);
  assert_close(between[1], weight, 1e-3);
  assert_true(account_of(scene).kinetic < 1e-9 * weight);
  assert_true(report.deepest_share < 1);
  free(touch);
  thrum_scene_destroy(scene);
  return sweeps;
}

/* All blocks are solved at once, with the rows on the floor. Some starts rock for long and need
 * ten times as many sweeps as others, so the median is looked at: 1,100 to 8,000 by the kernels of
 * BLAS of ten processors, and by sweeps alone 33,000 to 82,000. */
static void a_stack_rests(void **context) {
  int64_t sweeps[7];
  const int count = LENGTH_OF_RUN(7, 1);
  for (int n = 0; n < count; n++)
    sweeps[n] = rest_as_stack(*context, 1e-4 * n);

  // in order
  for (int n = 1; n < count; n++)
    for (int k = n; k > 0 && sweeps[k - 1] > sweeps[k]; k--) {
      const int64_t other = sweeps[k];
      sweeps[k] = sweeps[k - 1];
      sweeps[k - 1] = other;
    }
  if (count == 7)
    assert_in_range(sweeps[3], 0, 16000);
}

/* A block on a plate that gravity tilts: below the angle of friction it stays, above it slides as
 * (sin a - mu cos a) g t^2 / 2. */
static void friction_holds_up_to_its_angle(void **context) {
  fixture *f = *context;
  const double mu = 0.4, slopes[2] = {0.9 * 0.4, 1.3 * 0.4}, time = 0.4;
  for (int n = 0; n < 2; n++) {
    thrum_scene *scene = NULL;
    const double a = atan(slopes[n]);
    const double gravity[3] = {9.81 * sin(a), 0, -9.81 * cos(a)};
    MUST(thrum_scene_create(0.002, &scene, &failure));
    MUST(thrum_scene_set_gravity(scene, gravity, &failure));
    collide(scene, mu, 0);

    // the plate deforms in place, as it is not free; the block lies on it
    thrum_scene_body_def plate = def_of(&f->plate, 0, 0, 0, 1e4);
    thrum_scene_body_def block = def_of(&f->block, 0.1, 0, 0.06, 1e3);
    plate.free = 0;
    plate.scale = 2;
    block.scale = 0.5;
    block.position[2] = 0.02 + 0.05 + 0.0006;
    block.state.damping_alpha = 0;
    add(scene, &plate);
    add(scene, &block);
    MUST(thrum_scene_add_probe(scene, NULL, 1, NULL, 0, &failure));
    double before[3], x[3];

    // what is to stay comes to rest first: it slides while it bounces on its corners
    for (int k = 0; k < (n == 0 ? 300 : 50); k++)
      MUST(thrum_scene_step(scene, &failure));
    double v[3];
    MUST(thrum_scene_probe_get(scene, 0, before, v, &failure));
    for (int k = 0; k < (int)(time / 0.002); k++)
      MUST(thrum_scene_step(scene, &failure));
    MUST(thrum_scene_probe_get(scene, 0, x, NULL, &failure));
    const double slid = 9.81 * (sin(a) - mu * cos(a)) * time * time / 2 + v[0] * time;
    printf("slope %.3f: %.5f m, expected %.5f m\n", slopes[n], x[0] - before[0], n ? slid : 0);
    if (n == 0)
      assert_true(fabs(x[0] - before[0]) < 1e-5);
    else
      assert_close(x[0] - before[0], slid, 0.03);
    thrum_scene_destroy(scene);
  }
}

/* A cube slides over the flat face of a plate that deforms: without friction as fast as it began,
 * with it for v^2 / (2 mu g). Vertices of the plate that come under the rim of the cube do not stop
 * it. */
static void a_flat_face_catches_nothing(void **context) {
  fixture *f = *context;
  const double frictions[2] = {0, 0.3}, ways[2] = {0.3, 1 / (2 * 0.3 * 9.81)};
  for (int n = 0; n < 2; n++) {
    thrum_scene *scene = NULL;
    MUST(thrum_scene_create(0.002, &scene, &failure));
    MUST(thrum_scene_set_gravity(scene, down, &failure));
    collide(scene, frictions[n], 0.5);
    thrum_scene_body_def plate = def_of(&f->plate, 0, 0, 0, 100);
    thrum_scene_body_def cube = def_of(&f->block, 0.5, 0.02, 0.04 + 0.05 + 0.0008, 10);
    plate.free = 0;
    plate.scale = 4;
    cube.scale = 0.5;
    cube.velocity[0] = 1;
    add(scene, &plate);
    add(scene, &cube);

    // its middle goes straight on, and does not rise
    double before[3], x[3], highest = 0;
    MUST(thrum_scene_body_vertex(scene, 1, 13, before, NULL, &failure));
    for (int k = 0; k < (n == 0 ? 150 : 200); k++) {
      MUST(thrum_scene_step(scene, &failure));
      MUST(thrum_scene_body_vertex(scene, 1, 13, x, NULL, &failure));
      highest = fmax(highest, x[2] - before[2]);
    }
    printf("friction %.1f: %.5f m of %.5f, rises by %.2e m\n", frictions[n], x[0] - before[0],
           ways[n], highest);
    assert_close(x[0] - before[0], ways[n], 1e-3);
    assert_true(highest < 1e-5 && fabs(x[1] - before[1]) < 1e-4);
    thrum_scene_destroy(scene);
  }
}

/* Five soft cubes of 1 MPa fly at each other at up to 4 m/s, and spin, for 0.25 s; returns the
 * report of how they met. */
static thrum_contact_pairs_report fly(const fixture *f, double h, double e) {
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(h, &scene, &failure));
  collide(scene, 0.5, e);
  for (int n = 0; n < 5; n++) {
    const double place[3] = {0.25 * (n % 3 - 1), 0.25 * (n / 3), 0};
    thrum_scene_body_def cube = def_of(&f->block, 0, 0, 0, 0.2);
    cube.scale = 0.5;
    cube.density = 4;
    for (int axis = 0; axis < 3; axis++) {
      const double random = 0.5 * random_number();
      cube.position[axis] = place[axis] + 0.02 * random;
      cube.velocity[axis] = -12 * place[axis] + 2 * random;
      cube.spin[axis] = 9 * random_number();
      cube.rotation[axis + 1] = random;
    }
    add(scene, &cube);
  }

  // energy is there or has been lost
  const double before = account_of(scene).total;
  for (int k = 0; k < (int)(0.25 / h); k++)
    MUST(thrum_scene_step(scene, &failure));
  const thrum_contact_pairs_report report = thrum_scene_collisions(scene);
  assert_true(fabs(account_of(scene).total + report.lost - before) <= 1e-9 * before);
  thrum_scene_destroy(scene);
  return report;
}

/* Springs stop what presses on them in a step, also where it is no impact, so surfaces never meet.
 */
static void soft_bodies_with_spin_stay_apart(void **context) {
  for (int n = 0; n < 6; n++) {
    const double deepest = fly(*context, 0.001, n % 2 ? 0.5 : 1).deepest_share;
    print_message("deepest %.3f of the thickness\n", deepest);
    assert_true(deepest > 0.1 && deepest < 1);
  }
}

/* Soft cubes, each beside the one below by a fifth of their width, stand without drift. */
static void a_stack_of_soft_cubes_stands(void **context) {
  fixture *f = *context;
  const double thickness = 0.1 * sqrt(3) / 250;
  const int count = LENGTH_OF_RUN(5, 3); // of cubes
  thrum_scene_solid_def floor = thrum_default_scene_solid_def();
  floor.position[2] = -0.5;
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  MUST(thrum_scene_add_solid(f->scene, &floor, NULL, &failure));
  collide(f->scene, 0.5, 0.5);
  for (int n = 0; n < count; n++) {
    thrum_scene_body_def cube =
        def_of(&f->block, n % 2 ? 0.01 : -0.01, 0, 0.05 + thickness + n * (0.1 + thickness), 0.2);
    cube.scale = 0.5;
    add(f->scene, &cube);
  }

  // it settles, and then stays
  double settled[5][3], x[3], v[3];
  const double before = account_of(f->scene).total;
  for (int k = 0; k < 400; k++)
    MUST(thrum_scene_step(f->scene, &failure));
  for (int n = 0; n < count; n++)
    MUST(thrum_scene_body_vertex(f->scene, n, 13, settled[n], v, &failure));
  for (int k = 0; k < 100; k++)
    MUST(thrum_scene_step(f->scene, &failure));
  for (int n = 0; n < count; n++) {
    MUST(thrum_scene_body_vertex(f->scene, n, 13, x, v, &failure));
    assert_near3(x, settled[n], 5e-6);
  }
  const thrum_contact_pairs_report report = thrum_scene_collisions(f->scene);
  assert_true(report.deepest_share < 0.1 && report.declined == 0);
  assert_true(fabs(account_of(f->scene).total + report.lost - before) <= 1e-12);
}

static void a_snapshot_of_bodies_that_touch_steps_to_the_same_bits(void **context) {
  fixture *f = *context;
  throw(f, 0.5);
  while (thrum_scene_collisions(f->scene).touching == 0)
    MUST(thrum_scene_step(f->scene, &failure));

  // twenty steps from a snapshot, twice
  const size_t size = thrum_scene_snapshot_size(f->scene);
  void *kept = need(size, 1), *first = need(size, 1), *second = need(size, 1);
  MUST(thrum_scene_snapshot(f->scene, kept, size, &failure));
  for (int k = 0; k < 20; k++)
    MUST(thrum_scene_step(f->scene, &failure));
  MUST(thrum_scene_snapshot(f->scene, first, size, &failure));
  MUST(thrum_scene_restore(f->scene, kept, size, &failure));
  for (int k = 0; k < 20; k++)
    MUST(thrum_scene_step(f->scene, &failure));
  MUST(thrum_scene_snapshot(f->scene, second, size, &failure));

  // the same place of a vertex, to the bit
  double a[3], b[3];
  MUST(thrum_scene_body_vertex(f->scene, 1, 3, a, NULL, &failure));
  MUST(thrum_scene_restore(f->scene, first, size, &failure));
  MUST(thrum_scene_body_vertex(f->scene, 1, 3, b, NULL, &failure));
  assert_memory_equal(a, b, sizeof a);
  free(kept);
  free(first);
  free(second);
}

/* A block that slides slowly over a plate, turns and rocks: a list of what is near holds for some
 * of its steps. `lift`: a solid that rises and turns on its path takes the place of the plate. */
static thrum_scene *slide(const fixture *f, bool lift) {
  static const double times[2] = {0.05, 0.25};
  static const double places[14] = {0, 0, -0.0125, 1, 0, 0, 0, 0.01, 0, -0.005, 1, 0.05, 0, 0.1};
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.002, &scene, &failure));
  MUST(thrum_scene_set_gravity(scene, down, &failure));
  collide(scene, 0.05, 0.5);

  // the solid on its path
  if (lift) {
    thrum_scene_solid_def floor = thrum_default_scene_solid_def();
    floor.shape = THRUM_SOLID_BOX;
    for (int axis = 0; axis < 3; axis++)
      floor.half[axis] = axis < 2 ? 0.3 : 0.0125;
    floor.path_times = times;
    floor.path_places = places;
    floor.path_count = 2;
    MUST(thrum_scene_add_solid(scene, &floor, NULL, &failure));
  }

  // the plate, out of the way where it is not needed, and the block
  thrum_scene_body_def plate = def_of(&f->plate, 0, 0, lift ? -0.5 : 0, 1);
  thrum_scene_body_def block = def_of(&f->block, 0.15, 0.2, 0.0225, 1);
  if (lift)
    block.position[0] = block.position[1] = -0.1;
  plate.free = 0;
  block.velocity[0] = 0.1;
  block.spin[2] = 0.3;
  block.spin[0] = 0.05;
  add(scene, &plate);
  add(scene, &block);
  return scene;
}

/* A block that slides over a plate, and one on a solid that rises. */
static thrum_scene *slide_over_plate(const fixture *f) {
  return slide(f, false);
}

static thrum_scene *slide_on_lift(const fixture *f) {
  return slide(f, true);
}

/* Two stiff blocks that rest on each other on a floor: they tremble, and what trembles strikes. */
static thrum_scene *stand(const fixture *f) {
  const thrum_obstacle floor = thrum_default_obstacle();
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.002, &scene, &failure));
  MUST(thrum_scene_set_gravity(scene, down, &failure));
  MUST(thrum_scene_add_obstacle(scene, &floor, NULL, &failure));
  collide(scene, 0.5, 0.5);
  for (int n = 0; n < 2; n++) {
    thrum_scene_body_def block = def_of(&f->block, 0, 0, 0.1025 + 0.205 * n, 20);
    touch_obstacles(&block);
    add(scene, &block);
  }
  return scene;
}

/* Lists of what is near are no part of a scene: one that has none, as it has just been restored,
 * finds the same touches as one that goes on with those of the steps before. */
static void check_lists_change_no_bit(const fixture *f, thrum_scene *(*make)(const fixture *),
                                      int64_t impacts) {
  thrum_scene *on = make(f), *restored = make(f);
  const size_t size = thrum_scene_snapshot_size(on);
  void *kept = need(size, 1);
  int64_t touched = 0;
  for (int k = 0; k < 150; k++) {
    MUST(thrum_scene_step(on, &failure));
    MUST(thrum_scene_step(restored, &failure));
    touched += thrum_scene_collisions(on).touching;

    // at different times of the lists that the other one keeps
    double a[3], b[3];
    MUST(thrum_scene_body_vertex(on, 1, 3, a, NULL, &failure));
    MUST(thrum_scene_body_vertex(restored, 1, 3, b, NULL, &failure));
    assert_memory_equal(a, b, sizeof a);
    if (k % 7 != 0)
      continue;
    MUST(thrum_scene_snapshot(restored, kept, size, &failure));
    thrum_scene_destroy(restored);
    restored = make(f);
    MUST(thrum_scene_restore(restored, kept, size, &failure));
  }

  // they have touched for most of the time
  const thrum_contact_pairs_report first = thrum_scene_collisions(on);
  const thrum_contact_pairs_report second = thrum_scene_collisions(restored);
  assert_true(touched > 150 && first.impacts >= impacts);
  assert_true(first.lost == second.lost && first.sweeps == second.sweeps);
  thrum_scene_destroy(on);
  thrum_scene_destroy(restored);
  free(kept);
}

static void lists_change_no_bit(void **context) {
  check_lists_change_no_bit(*context, slide_over_plate, 0);
  check_lists_change_no_bit(*context, slide_on_lift, 0);
  check_lists_change_no_bit(*context, stand, 100);
}

/* Runs tasks backwards over the workers, as threads might. */
static void run_backwards(void *context, int32_t count, void (*task)(void *, int32_t, int32_t),
                          void *of) {
  const int32_t *workers = context;
  for (int32_t n = count; n-- > 0;)
    task(of, n, n % *workers);
}

/* The state to which bodies come that are shared among workers. */
typedef struct shared {
  double x[12][3]; /* a vertex of each body */
  thrum_contact_pairs_report report;
  thrum_pair_touch touches[400];
} shared;

/* The touches of the last step where they are of several groups: bodies of one group are never
 * those of another, and groups come in the order of their first bodies. True where there are such.
 */
static bool look_at_touches(const thrum_scene *scene, shared *came) {
  const int64_t count = thrum_scene_collisions(scene).touching;
  thrum_pair_touch first, last;
  assert_in_range(count, 0, 400);
  if (count < 2)
    return false;
  MUST(thrum_scene_collision_get(scene, 0, &first, &failure));
  MUST(thrum_scene_collision_get(scene, count - 1, &last, &failure));
  if (last.bodies[0] / 3 <= first.bodies[1] / 3)
    return false;
  for (int64_t n = 0; n < count; n++)
    MUST(thrum_scene_collision_get(scene, n, came->touches + n, &failure));
  return true;
}

/* Blocks that fall on a floor and in four columns on each other, and plates that touch nothing. */
static void step_shared(fixture *f, int32_t workers, shared *came) {
  const thrum_obstacle floor = thrum_default_obstacle();
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.002, &scene, &failure));
  MUST(thrum_scene_set_workers(scene, workers, run_backwards, &workers, &failure));
  MUST(thrum_scene_set_gravity(scene, down, &failure));
  MUST(thrum_scene_add_obstacle(scene, &floor, NULL, &failure));
  collide(scene, 0.5, 0.5);

  // columns of blocks, and every fourth body a plate high above them
  for (int n = 0; n < 12; n++) {
    thrum_scene_body_def def =
        def_of(n % 4 == 3 ? &f->plate : &f->block, n / 3, 0.02 * n, 0.15 + 0.11 * (n % 3), 1 + n);
    if (n % 4 != 3)
      touch_obstacles(&def);
    def.velocity[1] = 0.1 * n;
    def.position[2] += n % 4 == 3 ? 5 : 0;
    add(scene, &def);
  }

  // they touch on the way, in several groups at once, or the test says nothing
  int64_t several = 0;
  for (int k = 0; k < 40; k++) {
    MUST(thrum_scene_step(scene, &failure));
    several += look_at_touches(scene, came);
  }
  assert_true(thrum_scene_collisions(scene).deepest > 0 && several > 0);
  for (int32_t n = 0; n < 12; n++)
    MUST(thrum_scene_body_vertex(scene, n, 5, came->x[n], NULL, &failure));

  came->report = thrum_scene_collisions(scene);
  thrum_scene_destroy(scene);
}

static void workers_make_the_same_bits(void **context) {
  static shared came[2];
  step_shared(*context, 1, came);
  step_shared(*context, 3, came + 1);
  assert_memory_equal(came, came + 1, sizeof *came);
}

/* A block's probe after `steps`, over a solid. */
static void let_fall(const shape *s, const thrum_scene_solid_def *solid, double height, int steps,
                     double x[3], double v[3]) {
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.002, &scene, &failure));
  MUST(thrum_scene_set_gravity(scene, down, &failure));

  // the mesh begins at x = 0
  double middle = 0;
  for (int64_t n = 0; n < s->made.model.vertex_count; n++)
    middle = fmax(middle, 0.5 * s->made.model.vertices[3 * n]);
  thrum_scene_body_def def = def_of(s, -middle, 0, height, 100);
  def.state.damping_alpha = 2;
  add(scene, &def);
  MUST(thrum_scene_add_solid(scene, solid, NULL, &failure));
  MUST(thrum_scene_add_probe(scene, NULL, 0, NULL, 0, &failure));
  for (int k = 0; k < steps; k++)
    MUST(thrum_scene_step(scene, &failure));
  MUST(thrum_scene_probe_get(scene, 0, x, v, &failure));
  const thrum_contact_pairs_report report = thrum_scene_collisions(scene);
  print_message("height %.4f m, deepest %.2f of the thickness\n", x[2], report.deepest_share);
  assert_true(report.deepest_share < 1);
  thrum_scene_destroy(scene);
}

static thrum_scene_solid_def solid_of(thrum_solid_shape kind) {
  thrum_scene_solid_def def = thrum_default_scene_solid_def();
  def.shape = kind;
  def.radius = 0.04;
  def.height = 0.3;
  def.restitution = 0;
  for (int axis = 0; axis < 3; axis++)
    def.half[axis] = axis < 2 ? 0.03 : 0.15;
  return def;
}

/* Distances to what is larger or further would not be finite, and nothing would touch it. */
static void a_solid_beyond_all_distances_is_refused(void **context) {
  (void)context;
  const double times[2] = {0, 1};
  const double places[14] = {0, 0, 0, 1, 0, 0, 0, 0, 0, 1e100, 1, 0, 0, 0};
  thrum_scene *scene = NULL;
  thrum_error error;
  assert_int_equal(thrum_scene_create(0.003, &scene, &error), THRUM_OK);

  // each in turn has a part that is too far away
  for (int n = 0; n < 4; n++) {
    thrum_scene_solid_def def = thrum_default_scene_solid_def();
    def.shape = n == 0 ? THRUM_SOLID_CAPSULE : THRUM_SOLID_BOX;
    def.radius = n == 0 ? 1e100 : 0.5;
    def.half[1] = n == 1 ? 1e100 : 0.5;
    def.position[2] = n == 2 ? -1e100 : 0;
    def.path_times = times;
    def.path_places = places;
    def.path_count = n == 3 ? 2 : 0;
    assert_int_equal(thrum_scene_add_solid(scene, &def, NULL, &error), THRUM_BAD_VALUE);
    assert_non_null(strstr(error.message, "within 1e30"));
  }
  thrum_scene_destroy(scene);
}

/* A plate stays on a pole that is thinner than any of its triangles, and a block on all shapes. */
static void what_falls_on_a_solid_stays_on_it(void **context) {
  fixture *f = *context;
  const thrum_solid_shape shapes[2] = {THRUM_SOLID_BOX, THRUM_SOLID_CYLINDER};
  double x[3], v[3];
  for (int n = 0; n < 2; n++) {
    const thrum_scene_solid_def pole = solid_of(shapes[n]);
    let_fall(&f->plate, &pole, 0.19, 400, x, v);
    print_message("plate on a pole: %.4f m, %.1e m/s\n", x[2], hypot(v[0], hypot(v[1], v[2])));
    assert_true(x[2] > 0.16 && x[2] < 0.17);
    assert_true(hypot(v[0], hypot(v[1], v[2])) < 1e-2);
  }

  // a board of one cell on a rail whose triangles are far longer than they are wide
  shape board = shape_make("beam:1x1x1@0.4x0.4x0.04");
  thrum_scene_solid_def rail = solid_of(THRUM_SOLID_BOX);
  rail.half[0] = 0.02;
  rail.half[2] = 0.02;
  rail.half[1] = 6;
  let_fall(&board, &rail, 0.06, 400, x, v);
  assert_true(x[2] > 0.03 && x[2] < 0.05);
  shape_free(&board);

  // a capsule that lies along y, twice as wide as the block
  thrum_scene_solid_def log = solid_of(THRUM_SOLID_CAPSULE);
  log.radius = 0.5;
  log.rotation[1] = 1;
  let_fall(&f->block, &log, 0.62, 300, x, v);
  assert_true(x[2] > 0.59 && x[2] < 0.61);

  // a hill of a height field
  double heights[25];
  for (int n = 0; n < 25; n++)
    heights[n] = 0.02 * (n % 5 == 2) + 0.02 * (n / 5 == 2);
  thrum_scene_solid_def hill = solid_of(THRUM_SOLID_HEIGHT_FIELD);
  hill.heights = heights;
  hill.rows = hill.columns = 5;
  let_fall(&f->block, &hill, 0.16, 300, x, v);
  assert_true(x[2] > 0.10 && x[2] < 0.145);
}

/* A lift carries a block up and turns it with it; a wall that moves pushes a block along. */
static void what_stands_on_a_path_goes_with_it(void **context) {
  fixture *f = *context;
  const double times[2] = {0.2, 1.2};
  const double places[14] = {0, 0, 0, 1, 0, 0, 0, 0.1, 0, 0.4, sqrt(0.5), 0, 0, sqrt(0.5)};
  thrum_scene_solid_def lift = solid_of(THRUM_SOLID_BOX);
  for (int axis = 0; axis < 3; axis++)
    lift.half[axis] = axis < 2 ? 0.3 : 0.05;
  lift.path_times = times;
  lift.path_places = places;
  lift.path_count = 2;

  // half a second along the path, which takes a second
  double x[3], v[3];
  let_fall(&f->block, &lift, 0.151, 350, x, v);
  const double share = (0.7 - 0.2) / 1.0;
  assert_true(fabs(x[2] - (0.15 + 0.4 * share)) < 3e-3);
  assert_true(fabs(x[0] - 0.1 * share) < 5e-3);
  assert_close(v[2], 0.4, 0.02);
}

static void what_begins_inside_is_found(void **context) {
  fixture *f = *context;
  const thrum_obstacle floor = thrum_default_obstacle();
  thrum_scene_overlap overlap;
  int32_t *touch = need((size_t)f->block.made.model.vertex_count, sizeof *touch);
  for (int64_t v = 0; v < f->block.made.model.vertex_count; v++)
    touch[v] = (int32_t)v;

  // two blocks above a floor, apart
  thrum_scene_body_def a = def_of(&f->block, 0, 0, 0.11, 1),
                       b = def_of(&f->block, 0.03, 0, 0.33, 1);
  a.touch = b.touch = touch;
  a.touch_count = b.touch_count = f->block.made.model.vertex_count;
  collide(f->scene, 0.5, 0.5);
  MUST(thrum_scene_add_obstacle(f->scene, &floor, NULL, &failure));
  add(f->scene, &a);
  add(f->scene, &b);
  MUST(thrum_scene_find_overlap(f->scene, &overlap, &failure));
  assert_int_equal(overlap.body, -1);

  // a third inside the upper one, and one in the floor
  thrum_scene_body_def c = def_of(&f->block, 0.03, 0.12, 0.35, 1),
                       d = def_of(&f->block, 1, 0, 0.05, 1);
  d.touch = touch;
  d.touch_count = a.touch_count;
  add(f->scene, &c);
  MUST(thrum_scene_find_overlap(f->scene, &overlap, &failure));
  assert_true((overlap.body == 2 && overlap.other == 1) ||
              (overlap.body == 1 && overlap.other == 2));
  assert_int_equal(overlap.obstacle, -1);
  assert_close(overlap.depth, 0.08, 1e-6);
  d.scale = 0.1;
  d.position[2] = -0.05;
  add(f->scene, &d);
  MUST(thrum_scene_find_overlap(f->scene, &overlap, &failure));
  assert_int_equal(overlap.body, 3);
  assert_int_equal(overlap.obstacle, 0);
  assert_close(overlap.depth, 0.06, 1e-6);
  free(touch);
}

/* Bodies that fill the same place have no vertex deeper than the surface of the other; blocks that
 * stand face to face have none either, and do not overlap. */
static void bodies_in_the_same_place_overlap(void **context) {
  fixture *f = *context;
  thrum_scene_overlap overlap;
  const thrum_scene_body_def a = def_of(&f->block, 0, 0, 0, 1);
  const double side = 0.2;

  // a block, and three of which each stands at one of its faces
  collide(f->scene, 0.5, 0.5);
  add(f->scene, &a);
  for (int axis = 0; axis < 3; axis++) {
    thrum_scene_body_def b = a;
    b.position[axis] += side;
    add(f->scene, &b);
  }
  MUST(thrum_scene_find_overlap(f->scene, &overlap, &failure));
  assert_true(overlap.body < 0 || overlap.depth < 1e-9);

  // one more where the first is
  add(f->scene, &a);
  MUST(thrum_scene_find_overlap(f->scene, &overlap, &failure));
  assert_true((overlap.body == 0 && overlap.other == 4) ||
              (overlap.body == 4 && overlap.other == 0));
  assert_close(overlap.depth, 0.5 * side, 1e-6);
}

/* Plates that cross have no vertex in each other. */
static void what_begins_inside_without_a_vertex_there_is_found(void **context) {
  fixture *f = *context;
  thrum_scene_overlap overlap;
  collide(f->scene, 0.5, 0.5);

  // a plate of 2 cm that stands above one that lies, and through it
  const thrum_scene_body_def lies = def_of(&f->plate, 0, 0, 0, 1);
  thrum_scene_body_def stands = def_of(&f->plate, 0, 0.05, 0.45, 1);
  stands.rotation[0] = stands.rotation[1] = sqrt(0.5);
  add(f->scene, &lies);
  add(f->scene, &stands);
  MUST(thrum_scene_find_overlap(f->scene, &overlap, &failure));
  assert_int_equal(overlap.body, -1);
  stands.position[0] = lies.position[0] + 0.03;
  stands.position[2] = 0.05;
  add(f->scene, &stands);
  MUST(thrum_scene_find_overlap(f->scene, &overlap, &failure));
  assert_true(overlap.body >= 0 && overlap.other >= 0);
  assert_close(overlap.depth, 0.01, 1e-6);
}

/* A sphere, and a box, wholly inside a body touch none of its vertices. */
static void what_is_inside_a_body_is_found(void **context) {
  fixture *f = *context;
  thrum_scene_overlap overlap;
  thrum_obstacle sphere = thrum_default_obstacle();
  sphere.shape = THRUM_OBSTACLE_SPHERE;
  sphere.radius = 0.02;
  thrum_scene_body_def block = def_of(&f->block, 0, 0, 0, 1);
  touch_obstacles(&block);
  add(f->scene, &block);

  // a sphere beside the block, then one 5 cm deep in it, with the radius
  sphere.centre[2] = 0.13;
  MUST(thrum_scene_add_obstacle(f->scene, &sphere, NULL, &failure));
  MUST(thrum_scene_find_overlap(f->scene, &overlap, &failure));
  assert_int_equal(overlap.body, -1);
  sphere.centre[0] = sphere.centre[1] = sphere.centre[2] = 0.05;
  MUST(thrum_scene_add_obstacle(f->scene, &sphere, NULL, &failure));
  MUST(thrum_scene_find_overlap(f->scene, &overlap, &failure));
  assert_int_equal(overlap.obstacle, 1);
  assert_close(overlap.depth, 0.07, 1e-6);

  // a box, whose corner is the deepest of all
  thrum_scene_solid_def box = solid_of(THRUM_SOLID_BOX);
  for (int axis = 0; axis < 3; axis++) {
    box.position[axis] = axis == 0 ? 0.06 : 0.04;
    box.half[axis] = 0.02;
  }
  MUST(thrum_scene_add_solid(f->scene, &box, NULL, &failure));
  MUST(thrum_scene_find_overlap(f->scene, &overlap, &failure));
  assert_int_equal(overlap.solid, 0);
  assert_close(overlap.depth, 0.08, 1e-6);
}

/* A solid is looked for where it is at the scene's time, also after a restore. */
static void an_overlap_after_a_restore_is_that_of_the_time(void **context) {
  fixture *f = *context;
  const thrum_scene_body_def block = def_of(&f->block, 0, 0, 0, 1);
  thrum_scene_solid_def box = solid_of(THRUM_SOLID_BOX);
  box.velocity[2] = 10;
  thrum_scene_overlap overlap;
  add(f->scene, &block);
  MUST(thrum_scene_add_solid(f->scene, &box, NULL, &failure));

  // the box starts in the block and flies away
  const size_t size = thrum_scene_snapshot_size(f->scene);
  void *kept = need(size, 1);
  MUST(thrum_scene_snapshot(f->scene, kept, size, &failure));
  for (int k = 0; k < 100; k++)
    MUST(thrum_scene_step(f->scene, &failure));
  MUST(thrum_scene_restore(f->scene, kept, size, &failure));
  MUST(thrum_scene_find_overlap(f->scene, &overlap, &failure));
  assert_int_equal(overlap.body, 0);
  assert_int_equal(overlap.solid, 0);
  free(kept);
}

/* A body that comes to a scene takes nothing from what the others have done. */
static void a_body_that_is_added_leaves_the_report_as_it_is(void **context) {
  fixture *f = *context;
  throw(f, 0.5);
  while (thrum_scene_collisions(f->scene).touching == 0)
    MUST(thrum_scene_step(f->scene, &failure));
  const thrum_contact_pairs_report before = thrum_scene_collisions(f->scene);
  const double total = account_of(f->scene).total;

  // a third body needs more room
  const thrum_scene_body_def far = def_of(&f->block, 0, 0, 9, 1);
  add(f->scene, &far);
  const thrum_contact_pairs_report after = thrum_scene_collisions(f->scene);
  assert_memory_equal(&before, &after, sizeof before);
  assert_close(account_of(f->scene).total, total, 1e-12);

  // and the account goes on
  for (int k = 0; k < 100; k++)
    MUST(thrum_scene_step(f->scene, &failure));
  assert_close(account_of(f->scene).total + thrum_scene_collisions(f->scene).lost,
               total + before.lost, 1e-6);
}

/* Blocks in each other that turn beyond all measure, and a thickness near zero: what is deeper than
 * the largest number times it is that number. */
static void a_share_of_a_thickness_near_zero_is_a_number(void **context) {
  fixture *f = *context;
  for (int n = 0; n < 2; n++) {
    thrum_scene_body_def block = def_of(&f->block, 0, 0, 0, 1);
    block.spin[0] = n == 0 ? 1 : 1e29;
    block.spin[1] = n == 0 ? 1e29 : -1e30;
    add(f->scene, &block);
  }
  MUST(thrum_scene_set_dt(f->scene, 1e30, &failure));
  thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  def.thickness = 1e-300;
  MUST(thrum_scene_set_collisions(f->scene, &def, &failure));
  MUST(thrum_scene_step(f->scene, &failure));
  const thrum_contact_pairs_report report = thrum_scene_collisions(f->scene);
  assert_true(report.deepest > 1e9 && report.deepest_share == DBL_MAX);
}

/* How deep the block at the origin is in a solid, or the solid in it; 0: apart. */
static double depth_in_solid(const fixture *f, const thrum_scene_solid_def *solid) {
  thrum_scene *scene = NULL;
  thrum_scene_overlap overlap;
  MUST(thrum_scene_create(0.001, &scene, &failure));
  const thrum_scene_body_def block = def_of(&f->block, 0, 0, 0, 1);
  add(scene, &block);
  MUST(thrum_scene_add_solid(scene, solid, NULL, &failure));
  MUST(thrum_scene_find_overlap(scene, &overlap, &failure));
  thrum_scene_destroy(scene);
  assert_true(overlap.body < 0 || (overlap.body == 0 && overlap.other == -1 &&
                                   overlap.obstacle == -1 && overlap.solid == 0));
  return overlap.body < 0 ? 0 : overlap.depth;
}

/* The middle of the block. */
static void middle_of(const shape *block, double middle[3]) {
  double least[3], most[3];
  thrum_box3(block->made.model.vertices, block->made.model.vertex_count, least, most);
  for (int k = 0; k < 3; k++)
    middle[k] = 0.5 * (least[k] + most[k]);
}

/* A slab between two layers of vertices of the block, across each axis: edges go through it, and
 * are deepest in its middle. Its own edges, the diagonals of its faces too, are outside. */
static void a_slab_between_vertices_is_as_deep_as_half_of_it(void **context) {
  const fixture *f = *context;
  double middle[3];
  middle_of(&f->block, middle);
  for (int axis = 0; axis < 3; axis++) {
    thrum_scene_solid_def slab = solid_of(THRUM_SOLID_BOX);
    for (int k = 0; k < 3; k++) {
      slab.half[k] = k == axis ? 0.02 : 0.7;
      slab.position[k] = middle[k] + (k == axis ? 0.043 : k == (axis + 1) % 3 ? 0.36 : 0.013);
    }
    assert_close(depth_in_solid(f, &slab), 0.02, 1e-9);

    // beside the block
    slab.position[axis] = middle[axis] + 0.121;
    assert_true(depth_in_solid(f, &slab) == 0);
  }
}

/* Two slabs in one mesh, the farther and thicker one first: each edge of the block meets four
 * faces, and is in the mesh twice. */
static void an_edge_is_followed_through_two_slabs(void **context) {
  static const int32_t box[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                     {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                     {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  static const double ends[2][2] = {{0.04, 0.07}, {0.012, 0.022}};
  const fixture *f = *context;
  double middle[3];
  middle_of(&f->block, middle);
  for (int axis = 0; axis < 3; axis++) {
    double vertices[2 * 8][3];
    int32_t triangles[2 * 12][3];
    for (int n = 0; n < 2 * 8; n++)
      for (int k = 0; k < 3; k++) {
        const int side = n >> ((k + 3 - axis) % 3) & 1;
        vertices[n][k] = middle[k] +
                         (k == axis ? ends[n / 8][side]
                          : side    ? 0.7
                                    : -0.7) +
                         (k == (axis + 1) % 3 ? 0.36 : 0);
      }
    for (int n = 0; n < 2 * 12 * 3; n++)
      triangles[n / 3][n % 3] = 8 * (n / 36) + box[n / 3 % 12][n % 3];
    thrum_scene_solid_def both = solid_of(THRUM_SOLID_MESH);
    both.vertices = vertices[0];
    both.vertex_count = 16;
    both.triangles = triangles[0];
    both.triangle_count = 24;
    assert_close(depth_in_solid(f, &both), 0.015, 1e-9);
  }
}

/* A height field that is a plane, turned every way: as deep behind it as the farthest end of an
 * edge that goes through it. */
static void what_is_behind_a_height_field_is_as_deep_as_its_edges_reach(void **context) {
  const fixture *f = *context;
  static const double flat[4] = {0};
  for (int n = 0; n < 12; n++) {
    thrum_scene_solid_def field = solid_of(THRUM_SOLID_HEIGHT_FIELD);
    field.heights = flat;
    field.rows = field.columns = 2;
    field.spacing[0] = field.spacing[1] = 20;
    const double half = 0.26 * n, axis[3] = {0.6, n % 2 ? -0.8 : 0, n % 2 ? 0 : 0.8};
    field.rotation[0] = cos(half);
    for (int k = 0; k < 3; k++)
      field.rotation[k + 1] = sin(half) * axis[k];
    field.position[n % 3] = 0.031;
    field.position[(n + 1) % 3] = -0.044;
    field.position[(n + 2) % 3] = 0.017;

    // along its turned x axis it is moved, so that no edge of its own meets the block
    const double *q = field.rotation;
    field.position[0] += 5 * (1 - 2 * (q[2] * q[2] + q[3] * q[3]));
    field.position[1] += 5 * 2 * (q[1] * q[2] + q[0] * q[3]);
    field.position[2] += 5 * 2 * (q[1] * q[3] - q[0] * q[2]);

    // its normal, the turned z axis
    const double normal[3] = {2 * (q[1] * q[3] + q[0] * q[2]), 2 * (q[2] * q[3] - q[0] * q[1]),
                              1 - 2 * (q[1] * q[1] + q[2] * q[2])};
    double deepest = 0;
    for (int64_t e = 0; e < 3 * f->block.triangle_count; e++) {
      const int32_t ends[2] = {f->block.triangles[e],
                               f->block.triangles[e % 3 < 2 ? e + 1 : e - 2]};
      double at[2] = {0};
      for (int k = 0; k < 6; k++)
        at[k / 3] += normal[k % 3] * (f->block.made.model.vertices[3 * ends[k / 3] + k % 3] -
                                      field.position[k % 3]);
      if (at[0] * at[1] < 0)
        deepest = fmax(deepest, -fmin(at[0], at[1]));
    }
    assert_true(deepest > 0);
    assert_close(depth_in_solid(f, &field), deepest, 1e-9);
  }
}

/* A block that stopped as it was thrown beyond all numbers: what is read is a number, or the status
 * says why it is not, and nothing is written. */
static void the_speed_of_a_corner_is_a_number_or_refused(void **context) {
  fixture *f = *context;
  thrum_scene_body_def block = def_of(&f->block, 0, 0, 0, 1e-300);
  block.spin[1] = 1e29;
  block.spin[2] = 1e300;
  add(f->scene, &block);
  MUST(thrum_scene_set_dt(f->scene, 1e10, &failure));
  const double pull[3] = {-1e30, 0, 1e-30};
  MUST(thrum_scene_set_gravity(f->scene, pull, &failure));
  assert_true(thrum_scene_step(f->scene, NULL) < 0);
  int refused = 0;
  for (int64_t v = 0; v < 27; v++) {
    double x[3] = {7, 7, 7}, speed[3] = {7, 7, 7};
    const thrum_status status = thrum_scene_body_vertex(f->scene, 0, v, x, speed, NULL);
    assert_true(status == THRUM_OK || status == THRUM_NOT_FINITE);
    for (int axis = 0; axis < 3; axis++)
      assert_true(isfinite(speed[axis]) && (status == THRUM_OK || x[axis] == 7));
    refused += status != THRUM_OK;
  }
  assert_true(refused > 0);
}

static void bodies_that_do_not_collide_pass(void **context) {
  fixture *f = *context;
  thrum_scene_body_def a = def_of(&f->block, 0, 0, 0, 1), b = def_of(&f->block, 0.5, 0, 0, 1);
  a.velocity[0] = 3;
  b.collide = 0;
  collide(f->scene, 0.5, 0.5);
  add(f->scene, &a);
  add(f->scene, &b);
  for (int k = 0; k < 200; k++)
    MUST(thrum_scene_step(f->scene, &failure));
  double x[3], v[3];
  MUST(thrum_scene_body_vertex(f->scene, 0, 0, x, v, &failure));
  assert_close(v[0], 3, 1e-9);
  assert_int_equal(thrum_scene_collisions(f->scene).deepest, 0);
}

/* A pull of the default strength has the same effect whether bodies touch each other or not. */
static void a_pull_is_as_strong_where_bodies_touch(void **context) {
  fixture *f = *context;
  double x[2][3];
  for (int n = 0; n < 2; n++) {
    thrum_scene *scene = NULL;
    MUST(thrum_scene_create(0.002, &scene, &failure));
    if (n == 1)
      collide(scene, 0.5, 0.5);
    const thrum_scene_body_def def = def_of(&f->block, 0, 0, 0, 1);
    add(scene, &def);

    // its corner at the origin is pulled away
    const double target[3] = {1, 0, 0};
    MUST(thrum_scene_pull_start(scene, 0, 0, target, 1e5, 0, NULL, &failure));
    MUST(thrum_scene_add_probe(scene, NULL, 0, NULL, 0, &failure));
    for (int k = 0; k < 5; k++)
      MUST(thrum_scene_step(scene, &failure));
    MUST(thrum_scene_probe_get(scene, 0, x[n], NULL, &failure));
    thrum_scene_destroy(scene);
  }
  print_message("pulled to %.4f and %.4f m\n", x[0][0], x[1][0]);
  assert_true(x[0][0] > 0.15);
  assert_near3(x[0], x[1], 1e-12);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(bodies_that_meet_keep_momentum_and_gain_no_energy),
      TEST(a_pull_is_as_strong_where_bodies_touch),
      TEST(a_shot_along_a_row_gains_no_energy),
      TEST(a_near_rigid_block_bounces_by_its_restitution),
      TEST(an_impact_of_rigid_bodies_keeps_momentum_and_gains_no_energy),
      TEST(bodies_that_fly_on_in_touch_keep_their_contact),
      TEST(what_is_lost_at_rest_is_never_below_zero),
      TEST(friction_of_an_impact_is_cut_where_it_would_gain),
      TEST(edges_strike_alike_everywhere),
      TEST(a_solid_that_moves_strikes_by_its_restitution),
      TEST(a_block_between_two_walls_bounces_several_times_in_a_step),
      TEST(a_dropped_block_rises_by_the_square_of_its_restitution),
      TEST(a_plate_holds_what_is_shot_at_it),
      TEST(what_is_shot_through_a_plate_in_longer_steps_is_told),
      TEST(what_is_struck_does_not_pass_what_it_meets),

      // what rests
      TEST(what_is_struck_meets_the_next_in_any_order),
      TEST(what_a_solid_strikes_meets_the_next),
      TEST(a_column_is_struck_as_one),
      TEST(what_others_speak_for_takes_no_room),
      TEST(a_stack_rests),
      TEST(friction_holds_up_to_its_angle),
      TEST(a_flat_face_catches_nothing),
      TEST(a_stack_of_soft_cubes_stands),
      TEST(soft_bodies_with_spin_stay_apart),

      // the same bits again
      TEST(a_snapshot_of_bodies_that_touch_steps_to_the_same_bits),
      TEST(lists_change_no_bit),
      TEST(workers_make_the_same_bits),

      // solids, and what begins inside them
      cmocka_unit_test(a_solid_beyond_all_distances_is_refused),
      TEST(what_falls_on_a_solid_stays_on_it),
      TEST(what_stands_on_a_path_goes_with_it),
      TEST(what_begins_inside_is_found),
      TEST(bodies_in_the_same_place_overlap),
      TEST(what_begins_inside_without_a_vertex_there_is_found),
      TEST(what_is_inside_a_body_is_found),
      TEST(an_overlap_after_a_restore_is_that_of_the_time),
      TEST(a_body_that_is_added_leaves_the_report_as_it_is),
      TEST(a_slab_between_vertices_is_as_deep_as_half_of_it),
      TEST(an_edge_is_followed_through_two_slabs),
      TEST(what_is_behind_a_height_field_is_as_deep_as_its_edges_reach),
      TEST(a_share_of_a_thickness_near_zero_is_a_number),
      TEST(the_speed_of_a_corner_is_a_number_or_refused),
      TEST(bodies_that_do_not_collide_pass),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
