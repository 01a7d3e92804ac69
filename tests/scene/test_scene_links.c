/* Tests of links: joints keep their places together, springs give back what they took, neither
 * changes the momentum of free bodies, and ends follow paths and let go.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_private.h" // before names of the tests that it uses otherwise

#include "tests/support/precompute_support.h"

#include "core/base/vec3.h"
#include "tests/support/scene_call.h"

static const double PI = 3.14159265358979323846;
static const double down[3] = {0, 0, -9.81};

/* A bar that nothing holds, and one held at its left end. */
typedef struct fixture {
  body meshes[2];
  thrum_precomputed free_bar, held_bar;
  thrum_scene *scene;
} fixture;

static int setup(void **context) {
  fixture *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;
  f->meshes[0] = body_make("beam:4x2x2@0.4x0.1x0.1,split=6", NULL);
  f->free_bar = body_precompute(&f->meshes[0], 4, 10);
  f->meshes[1] = body_make("beam:4x2x2@0.4x0.1x0.1,split=6", "x<0.001");
  f->held_bar = body_precompute(&f->meshes[1], 4, 10);
  *context = f;
  return thrum_scene_create(0.002, &f->scene, &failure) < 0;
}

static int teardown(void **context) {
  fixture *f = *context;
  thrum_scene_destroy(f->scene);
  thrum_precomputed_free(&f->free_bar);
  thrum_precomputed_free(&f->held_bar);
  body_free(&f->meshes[0]);
  body_free(&f->meshes[1]);
  free(f);
  return 0;
}

/* An empty scene in place of the one that is there. */
static void restart(fixture *f) {
  thrum_scene_destroy(f->scene);
  f->scene = NULL;
  MUST(thrum_scene_create(0.002, &f->scene, &failure));
}

/* A free bar whose left lower corner is at a place; its number. */
static int32_t add_bar(fixture *f, double x, double y, double z, double stiffness) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  int32_t number = -1;
  def.model = &f->free_bar.model;
  def.position[0] = x;
  def.position[1] = y;
  def.position[2] = z;
  def.stiffness = stiffness;
  def.free = 1;
  MUST(thrum_scene_add_body(f->scene, &def, &number, &failure));
  return number;
}

static void set_place(double place[3], double x, double y, double z) {
  place[0] = x;
  place[1] = y;
  place[2] = z;
}

/* A link of bar 0 at a place. */
static thrum_scene_link_def link_of(thrum_link_kind kind, double x, double y, double z) {
  thrum_scene_link_def def = thrum_default_scene_link_def();
  def.kind = kind;
  set_place(def.place, x, y, z);
  return def;
}

static void add_link(thrum_scene *scene, const thrum_scene_link_def *def) {
  MUST(thrum_scene_add_link(scene, def, NULL, &failure));
}

static void steps(thrum_scene *scene, int count) {
  for (int n = 0; n < count; n++)
    MUST(thrum_scene_step(scene, &failure));
}

static thrum_scene_account account_of(thrum_scene *scene) {
  thrum_scene_account account;
  MUST(thrum_scene_account_get(scene, &account, &failure));
  return account;
}

static thrum_scene_link link_at(thrum_scene *scene, int32_t number) {
  thrum_scene_link link;
  MUST(thrum_scene_link_get(scene, number, &link, &failure));
  return link;
}

/* The total energy, with what links have taken since. */
static double balance_of(thrum_scene *scene) {
  double sum = account_of(scene).total;
  for (int32_t n = 0; n < thrum_scene_link_count(scene); n++) {
    const thrum_link_report report = link_at(scene, n).report;
    sum += report.lost - report.driven;
  }
  return sum;
}

static void assert_near3(const double a[3], const double b[3], double tolerance) {
  for (int axis = 0; axis < 3; axis++)
    assert_true(fabs(a[axis] - b[axis]) <= tolerance);
}

/* --- joints ----------------------------------------------------------------------------------- */

/* Pushes bar 0 for a tenth of a second. */
static void push(fixture *f) {
  const thrum_scene_load_def load = {.cookie = sizeof load,
                                     .kind = THRUM_SCENE_FORCE,
                                     .vector = {3, -2, 6},
                                     .vertices = (const int32_t[]){0},
                                     .count = 1,
                                     .course = {.shape = THRUM_LOAD_CONSTANT, .until = 0.1}};
  MUST(thrum_scene_add_load(f->scene, 0, &load, &failure));
  steps(f->scene, 50);
}

/* Nothing acts from outside: momentum stays, and the energy less what links took. */
static void assert_kept(fixture *f, int count) {
  const thrum_scene_account first = account_of(f->scene);
  const double balance = balance_of(f->scene);
  const double speed = sqrt(thrum_dot3(first.momentum, first.momentum));
  const double spin = sqrt(thrum_dot3(first.angular_momentum, first.angular_momentum));
  steps(f->scene, count);
  const thrum_scene_account last = account_of(f->scene);
  assert_near3(last.momentum, first.momentum, 1e-12 * speed);
  assert_near3(last.angular_momentum, first.angular_momentum, 1e-9 * spin);
  assert_true(fabs(balance_of(f->scene) - balance) <= 1e-9 * balance);
}

static void joints_of_free_bodies_keep_places_momentum_and_energy(void **context) {
  fixture *f = *context;
  for (int kind = THRUM_LINK_BALL; kind <= THRUM_LINK_WELD; kind++) {
    restart(f);
    add_bar(f, 0, 0, 0, 1);
    add_bar(f, 0.4, 0, 0, 2);
    thrum_scene_link_def def = link_of((thrum_link_kind)kind, 0.4, 0, 0);
    def.other = 1;
    def.axis[0] = 0.2;
    add_link(f->scene, &def);

    // they fly, turn and bend
    push(f);
    const double lost = link_at(f->scene, 0).report.lost;
    assert_kept(f, 500);
    const thrum_scene_link link = link_at(f->scene, 0);
    assert_true(link.report.largest_drift <= 1e-12);
    assert_true(fabs(link.report.lost - lost) <= 1e-9 * account_of(f->scene).total);
    assert_near3(link.places[0], link.places[1], 1e-12);
  }
}

/* A pin or hinge of bar 0 at its left end, under a gravity that pulls along the bar and a little
 * across it. */
static void hang(fixture *f, thrum_link_kind kind, double across) {
  const double gravity[3] = {9.81, 0, -9.81 * across};
  restart(f);
  MUST(thrum_scene_set_gravity(f->scene, gravity, &failure));
  add_bar(f, 0, 0, 0, 1e3);
  thrum_scene_link_def def = link_of(kind, 0, 0, 0);
  set_place(def.axis, 0, 1, 0);
  add_link(f->scene, &def);
}

static void a_bar_on_a_joint_swings_as_a_pendulum(void **context) {
  fixture *f = *context;
  for (int kind = THRUM_LINK_BALL; kind <= THRUM_LINK_HINGE; kind++) {
    hang(f, (thrum_link_kind)kind, 0.01);

    // (L^2 + H^2)/12 + (L/2)^2 is the square of the radius of gyration about the pin
    const double radius = (0.16 + 0.01) / 12 + 0.04, period = 2 * PI * sqrt(radius / 1.962);
    const int half = (int)lround(0.5 * period / 0.002);
    double at[3];
    steps(f->scene, half);
    MUST(thrum_scene_body_vertex(f->scene, 0, 44, at, NULL, &failure));
    assert_true(fabs(at[2] - 0.05 + 0.4 * 0.02) < 1e-2 * 0.4 * 0.02);
    steps(f->scene, half);
    MUST(thrum_scene_body_vertex(f->scene, 0, 44, at, NULL, &failure));
    assert_true(fabs(at[2] - 0.05) < 1e-2 * 0.4 * 0.02);
  }
}

static void a_wide_swing_keeps_its_energy_and_its_pin(void **context) {
  fixture *f = *context;
  hang(f, THRUM_LINK_BALL, 10);
  const double first = balance_of(f->scene);
  steps(f->scene, 1000);
  const thrum_scene_link link = link_at(f->scene, 0);
  assert_true(link.report.largest_drift <= 1e-12);
  assert_true(account_of(f->scene).kinetic > 1);
  assert_true(fabs(balance_of(f->scene) - first) <= 1e-10);
  assert_true(fabs(link.report.lost) <= 1e-9);
}

static void a_hinge_bears_what_would_turn_it_otherwise(void **context) {
  fixture *f = *context;
  hang(f, THRUM_LINK_HINGE, 0);

  // across the hinge nothing turns, but for what the bar bends
  const thrum_scene_load_def aside = {.cookie = sizeof aside,
                                      .kind = THRUM_SCENE_ACCELERATION,
                                      .vector = {0, 2, 0},
                                      .course = {.shape = THRUM_LOAD_CONSTANT, .until = INFINITY}};
  MUST(thrum_scene_add_load(f->scene, 0, &aside, &failure));
  steps(f->scene, 500);
  double at[3];
  MUST(thrum_scene_body_vertex(f->scene, 0, 44, at, NULL, &failure));
  assert_true(fabs(at[1] - 0.05) < 1e-4);
  const thrum_link_report report = link_at(f->scene, 0).report;
  thrum_scene_body_info info;
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  assert_true(fabs(report.force[0] + 9.81 * info.mass) < 0.05 * 9.81 * info.mass);
  assert_true(fabs(report.torque[2] + 2 * info.mass * 0.2) < 0.1 * info.mass);
}

static void what_did_not_move_together_comes_to_rest_in_two_steps(void **context) {
  fixture *f = *context;
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &f->free_bar.model;
  def.free = 1;
  def.velocity[0] = 1;
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  thrum_scene_link_def caught = link_of(THRUM_LINK_WELD, 0.2, 0, 0);
  add_link(f->scene, &caught);
  const double first = balance_of(f->scene);
  steps(f->scene, 20);
  const thrum_link_report report = link_at(f->scene, 0).report;
  assert_true(report.largest_drift <= 1e-12);
  assert_true(report.lost > 0.9 * first);
  assert_true(fabs(balance_of(f->scene) - first) <= 1e-10 * first);
}

/* --- springs ---------------------------------------------------------------------------------- */

static void springs_give_back_what_they_took_at_any_stiffness(void **context) {
  fixture *f = *context;
  for (double stiffness = 1e2; stiffness < 1e12; stiffness *= 1e4)
    for (int n = 0; n < 2; n++) {
      restart(f);
      add_bar(f, 0, 0, 0, 1);
      add_bar(f, 0.6, 0.1, 0, 2);
      thrum_scene_link_def def = link_of(THRUM_LINK_SPRING, 0.4, 0.05, 0.05);
      def.other = 1;
      set_place(def.other_place, 0.6, 0.1, 0);
      def.stiffness = stiffness;
      def.damping = n == 0 ? 0 : 1e-4 * stiffness;
      add_link(f->scene, &def);
      push(f);

      // they pull at each other as they fly
      const double lost = link_at(f->scene, 0).report.lost;
      assert_kept(f, 300);
      const thrum_link_report report = link_at(f->scene, 0).report;
      assert_true(report.stored >= 0);
      if (n == 0)
        assert_true(fabs(report.lost - lost) <= 1e-9 * account_of(f->scene).total);
      else
        assert_true(report.lost > lost - 1e-12);
    }
}

static void a_body_on_a_spring_swings_as_its_mass_says(void **context) {
  fixture *f = *context;
  thrum_scene_body_info info;
  add_bar(f, 0, 0, 0, 1e3);
  MUST(thrum_scene_body(f->scene, 0, &info, &failure));
  thrum_scene_link_def def = link_of(THRUM_LINK_SPRING, 0.2, 0, 0);
  set_place(def.other_place, 0.2, 0, 0.1);
  def.stiffness = info.mass * 4 * PI * PI;
  def.length = 0;
  add_link(f->scene, &def);

  // a second is a period; 0.1 m to the place, and as far beyond it
  double at[3];
  const double first = balance_of(f->scene);
  steps(f->scene, 250);
  memcpy(at, link_at(f->scene, 0).places[0], sizeof at);
  assert_true(fabs(at[2] - 0.2) < 1e-4);
  steps(f->scene, 250);
  memcpy(at, link_at(f->scene, 0).places[0], sizeof at);
  assert_true(fabs(at[2]) < 1e-4 && fabs(at[0] - 0.2) < 1e-7);
  assert_true(fabs(balance_of(f->scene) - first) < 1e-9 * first);
}

/* --- ends in the world ------------------------------------------------------------------------ */

static void an_end_goes_along_its_path_and_does_the_work(void **context) {
  fixture *f = *context;
  static const double times[] = {0.1, 0.3, 0.5, 0.7};
  static const double places[] = {5, 5, 5, 5.1, 5, 5.2, 5.1, 5, 5.2, 5, 5, 5};
  add_bar(f, 0, 0, 0, 1);
  thrum_scene_link_def def = link_of(THRUM_LINK_WELD, 0.4, 0, 0);
  def.path_times = times;
  def.path_places = places;
  def.path_count = 4;
  add_link(f->scene, &def);

  // at its times the place is where the path says, counted from its first place
  const double first = account_of(f->scene).total;
  static const int counts[] = {50, 100, 100, 100, 50};
  for (int n = 0; n < 5; n++) {
    const int last = n < 4 ? n : 3;
    steps(f->scene, counts[n]);
    const thrum_scene_link link = link_at(f->scene, 0);
    const double there[3] = {0.4 + places[3 * last] - 5, places[3 * last + 1] - 5,
                             places[3 * last + 2] - 5};
    assert_near3(link.places[0], there, 1e-9);
    assert_near3(link.places[1], there, 1e-12);
    assert_true(fabs(account_of(f->scene).total - first - link.report.driven + link.report.lost) <
                1e-9);
  }
  assert_true(link_at(f->scene, 0).report.largest_drift <= 1e-12);
  assert_true(link_at(f->scene, 0).report.driven > 1e-3);
}

static void a_link_lets_go_at_its_time_or_when_it_is_told(void **context) {
  fixture *f = *context;
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  add_bar(f, 0, 0, 0, 1e4);
  add_bar(f, 1, 0, 0, 1e4);
  thrum_scene_link_def def = link_of(THRUM_LINK_WELD, 0.2, 0, 0);
  def.until = 0.1;
  add_link(f->scene, &def);
  def.body = 1;
  def.until = INFINITY;
  def.place[0] = 1.2;
  add_link(f->scene, &def);
  steps(f->scene, 49);
  assert_true(link_at(f->scene, 0).holds);
  steps(f->scene, 2);
  assert_false(link_at(f->scene, 0).holds);
  MUST(thrum_scene_link_release(f->scene, 1, &failure));

  // both fall freely, the first for one step longer
  double z[2];
  steps(f->scene, 100);
  for (int32_t n = 0; n < 2; n++)
    z[n] = link_at(f->scene, n).places[0][2];
  assert_true(fabs(z[0] + 0.5 * 9.81 * 0.202 * 0.202) < 1e-3);
  assert_true(fabs(z[1] + 0.5 * 9.81 * 0.2 * 0.2) < 1e-3);

  // a scene that starts again ties them again
  MUST(thrum_scene_reset(f->scene, &failure));
  steps(f->scene, 10);
  assert_true(link_at(f->scene, 0).holds && link_at(f->scene, 1).holds);
  assert_true(fabs(link_at(f->scene, 1).places[0][2]) < 1e-9);
}

/* --- with all else ---------------------------------------------------------------------------- */

/* A bar held at its end carries another by a hinge, which a spring holds up. */
static void add_crane(fixture *f) {
  thrum_scene_body_def held = thrum_default_scene_body_def();
  held.model = &f->held_bar.model;
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  MUST(thrum_scene_add_body(f->scene, &held, NULL, &failure));
  add_bar(f, 0.4, 0, 0, 1);
  thrum_scene_link_def hinge = link_of(THRUM_LINK_HINGE, 0.4, 0, 0);
  hinge.other = 1;
  set_place(hinge.axis, 0, 1, 0);
  add_link(f->scene, &hinge);

  // the spring hangs the end of the second bar on a place above
  thrum_scene_link_def spring = link_of(THRUM_LINK_SPRING, 0.8, 0, 0);
  spring.body = 1;
  set_place(spring.other_place, 0.6, 0, 0.6);
  spring.stiffness = 300;
  spring.damping = 2;
  add_link(f->scene, &spring);
}

static void bars_on_a_hinge_fall_on_a_floor(void **context) {
  fixture *f = *context;
  int32_t all[45];
  for (int n = 0; n < 45; n++)
    all[n] = n;
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  thrum_obstacle floor = thrum_default_obstacle();
  floor.restitution = 0.5;
  MUST(thrum_scene_add_obstacle(f->scene, &floor, NULL, &failure));
  for (int n = 0; n < 2; n++) {
    thrum_scene_body_def def = thrum_default_scene_body_def();
    def.model = &f->free_bar.model;
    def.free = 1;
    def.touch = all;
    def.touch_count = 45;
    set_place(def.position, 0.4 * n, 0, 0.2);
    MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
  }
  thrum_scene_link_def hinge = link_of(THRUM_LINK_HINGE, 0.4, 0, 0.2);
  hinge.other = 1;
  set_place(hinge.axis, 0, 1, 0);
  add_link(f->scene, &hinge);

  // obstacles take energy, and nothing gives any
  const double first = balance_of(f->scene);
  steps(f->scene, 500);
  double lost = 0;
  for (int32_t n = 0; n < 2; n++) {
    thrum_scene_body_info info;
    MUST(thrum_scene_body(f->scene, n, &info, &failure));
    lost += info.contact.lost;
  }
  assert_true(lost > 0);
  assert_true(fabs(balance_of(f->scene) + lost - first) < 1e-9);
  assert_true(link_at(f->scene, 0).report.largest_drift <= 1e-12);
}

static void a_snapshot_and_a_reset_step_to_the_same_bits(void **context) {
  fixture *f = *context;
  double q[3][10];
  add_crane(f);
  const double first = balance_of(f->scene);
  steps(f->scene, 50);
  const size_t size = thrum_scene_snapshot_size(f->scene);
  void *kept = malloc(size);
  assert_non_null(kept);
  MUST(thrum_scene_snapshot(f->scene, kept, size, &failure));

  // on, back and on, and from the start
  for (int n = 0; n < 3; n++) {
    if (n == 1)
      MUST(thrum_scene_restore(f->scene, kept, size, &failure));
    if (n == 2)
      MUST(thrum_scene_reset(f->scene, &failure));
    steps(f->scene, n == 2 ? 100 : 50);
    MUST(thrum_scene_body_get(f->scene, 1, q[n], NULL, &failure));
    assert_memory_equal(q[n], q[0], sizeof q[0]);
  }
  assert_true(fabs(balance_of(f->scene) - first) < 1e-9);
  assert_true(link_at(f->scene, 1).report.lost > 0);
  free(kept);
}

/* The crane, which a handle pushes as well, in a scene of models without a basis: its links are
 * those that the scene of f made. */
static thrum_scene *make_bare(const fixture *f, thrum_model bare[2]) {
  const thrum_model *models[2] = {&f->held_bar.model, &f->free_bar.model};
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.002, &scene, &failure));
  MUST(thrum_scene_set_gravity(scene, down, &failure));
  for (int n = 0; n < 2; n++) {
    bare[n] = *models[n];
    bare[n].basis = NULL;
    thrum_scene_body_def def = thrum_default_scene_body_def();
    def.model = bare + n;
    def.free = n;
    def.position[0] = 0.4 * n;
    MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
  }

  // each link as it was made
  for (int32_t n = 0; n < thrum_scene_link_count(f->scene); n++) {
    thrum_scene_link_def made;
    MUST(thrum_scene_link_made(f->scene, n, &made, &failure));
    add_link(scene, &made);
  }
  return scene;
}

static void links_of_ready_sides_step_to_the_same_bits_without_a_basis(void **context) {
  fixture *f = *context;
  static const double times[] = {0.02, 0.1}, way[] = {0, 0, 0, 0, 0.02, -0.03};
  thrum_model bare[2];
  double q[2][10], p[2][10];
  add_crane(f);
  thrum_scene_link_def handle = link_of(THRUM_LINK_SPRING, 0.8, 0.1, 0.1);
  handle.body = 1;
  handle.stiffness = 500;
  handle.path_times = times;
  handle.path_places = way;
  handle.path_count = 2;
  handle.until = 0.15;
  add_link(f->scene, &handle);
  thrum_scene *again = make_bare(f, bare);

  // from the energy in its springs on, over the time at which the handle lets go
  assert_true(account_of(again).links == account_of(f->scene).links);
  steps(f->scene, 100);
  steps(again, 100);
  for (int32_t n = 0; n < 2; n++) {
    MUST(thrum_scene_body_get(f->scene, n, q[0], p[0], &failure));
    MUST(thrum_scene_body_get(again, n, q[1], p[1], &failure));
    assert_memory_equal(q[1], q[0], sizeof q[0]);
    assert_memory_equal(p[1], p[0], sizeof p[0]);
  }
  for (int32_t n = 0; n < 3; n++) {
    const thrum_scene_link first = link_at(f->scene, n), second = link_at(again, n);
    assert_memory_equal(&second, &first, sizeof first);
  }
  assert_false(link_at(again, 2).holds);
  thrum_scene_destroy(again);
}

static void ready_sides_that_do_not_fit_are_refused(void **context) {
  fixture *f = *context;
  add_crane(f);
  thrum_scene_link_def made, wrong;
  thrum_scene_link_side sides[2];
  double rows[120];
  MUST(thrum_scene_link_made(f->scene, 0, &made, &failure));
  memcpy(sides, made.sides, sizeof sides);
  memcpy(rows, sides[0].rows, sizeof rows);
  assert_int_equal(thrum_scene_link_made(f->scene, 2, &wrong, &failure), THRUM_INVALID_ARGUMENT);

  // no rows, those of another rank, what is not finite, no place
  wrong = made;
  wrong.sides = sides;
  sides[1].rows = NULL;
  assert_int_equal(thrum_scene_add_link(f->scene, &wrong, NULL, &failure), THRUM_INVALID_ARGUMENT);
  sides[1].rows = made.sides[1].rows;
  sides[0].rank = 9;
  assert_int_equal(thrum_scene_add_link(f->scene, &wrong, NULL, &failure), THRUM_MODEL_MISMATCH);
  sides[0].rank = 10;
  sides[0].rows = rows;
  rows[7] = NAN;
  assert_int_equal(thrum_scene_add_link(f->scene, &wrong, NULL, &failure), THRUM_BAD_VALUE);
  rows[7] = 0;
  wrong.place[0] = wrong.place[1] = wrong.place[2] = NAN;
  assert_int_equal(thrum_scene_add_link(f->scene, &wrong, NULL, &failure), THRUM_BAD_VALUE);
  wrong = made;
  wrong.kind = THRUM_LINK_SPRING;
  wrong.other_place[0] = wrong.other_place[1] = wrong.other_place[2] = NAN;
  assert_int_equal(thrum_scene_add_link(f->scene, &wrong, NULL, &failure), THRUM_BAD_VALUE);
  assert_int_equal(thrum_scene_link_count(f->scene), 2);
}

static void a_body_that_cannot_step_lets_go_of_the_other(void **context) {
  fixture *f = *context;
  add_bar(f, 0, 0, 0, 1);
  add_bar(f, 0.4, 0, 0, 1);
  thrum_scene_link_def def = link_of(THRUM_LINK_WELD, 0.4, 0, 0);
  def.other = 1;
  add_link(f->scene, &def);

  // and a spring that holds energy
  def.kind = THRUM_LINK_SPRING;
  def.stiffness = 10;
  def.length = 0;
  set_place(def.other_place, 0.45, 0, 0);
  add_link(f->scene, &def);
  steps(f->scene, 3);
  assert_true(account_of(f->scene).links > 0.01);

  // forces that add up beyond the range of numbers, before its step begins
  const thrum_scene_load_def load = {.cookie = sizeof load,
                                     .kind = THRUM_SCENE_FORCE,
                                     .vector = {1.7e308, 0, 0},
                                     .course = {.shape = THRUM_LOAD_CONSTANT, .until = INFINITY}};
  for (int n = 0; n < 2; n++)
    MUST(thrum_scene_add_load(f->scene, 0, &load, &failure));
  assert_true(thrum_scene_step(f->scene, &failure) < 0);

  // the other one goes on alone
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  const double before = link_at(f->scene, 0).places[1][2];
  for (int n = 0; n < 100; n++)
    thrum_scene_step(f->scene, &failure);
  assert_true(fabs(link_at(f->scene, 0).places[1][2] - before + 0.5 * 9.81 * 0.04) < 1e-3);

  // both links say so, and what the spring held is lost
  assert_false(link_at(f->scene, 0).holds || link_at(f->scene, 1).holds);
  assert_true(account_of(f->scene).links == 0 && link_at(f->scene, 1).report.lost > 0.01);
}

static void a_faint_spring_leaves_the_joints_beside_it(void **context) {
  fixture *f = *context;
  static const double faint[] = {1e-310, 1e-320, 1e-200};
  for (int n = 0; n < 3; n++) {
    restart(f);
    add_bar(f, 0, 0, 0, 1);
    MUST(thrum_scene_set_gravity(f->scene, down, &failure));
    thrum_scene_link_def def = link_of(THRUM_LINK_BALL, 0, 0.05, 0.05);
    add_link(f->scene, &def);

    // the spring has a length of its own, or takes the one between its places
    def.kind = THRUM_LINK_SPRING;
    def.stiffness = def.damping = faint[n];
    set_place(def.other_place, 1, 0, 0);
    add_link(f->scene, &def);
    def.length = 0;
    add_link(f->scene, &def);
    steps(f->scene, 50);
    assert_true(link_at(f->scene, 0).report.drift < 1e-12);
  }
}

/* Both bodies of a joint that cannot be solved for stop, and say so; the third goes on. */
static void bodies_whose_links_cannot_be_solved_for_stop(void **context) {
  fixture *f = *context;
  restart(f);
  for (int n = 0; n < 3; n++)
    add_bar(f, 0.4 * n, 0, n, 1);
  MUST(thrum_scene_set_gravity(f->scene, down, &failure));
  thrum_scene_link_def def = link_of(THRUM_LINK_BALL, 0.4, 0.05, 0.5);
  def.other = 1;
  add_link(f->scene, &def);

  // no link that can be added does this: the rows of one become those of a body without mass
  f->scene->links[0].rows[0][0] = 1e200;
  assert_int_equal(thrum_scene_step(f->scene, &failure), THRUM_SINGULAR);
  assert_non_null(strstr(failure.message, "cannot be solved for together"));
  for (int n = 0; n < 3; n++) {
    thrum_scene_body_info info;
    MUST(thrum_scene_body(f->scene, n, &info, &failure));
    assert_int_equal(info.status, n < 2 ? THRUM_SINGULAR : THRUM_OK);
  }
  steps(f->scene, 5);
}

static void what_cannot_be_linked_is_refused(void **context) {
  fixture *f = *context;
  static const double twice[] = {1, 1}, places[6] = {0};
  static const double at_once[] = {0, 5e-324, 1e-323}, away[9] = {[3] = 1e-3, [6] = 2e-3};
  static const double ever[] = {-1e308, 1e308};
  add_bar(f, 0, 0, 0, 1);
  thrum_scene_link_def wrong[15];
  for (int n = 0; n < 15; n++)
    wrong[n] = link_of(THRUM_LINK_BALL, 0, 0, 0);
  wrong[0].cookie = 0;
  wrong[1].body = 1;
  wrong[2].other = 0;
  wrong[3].stiffness = -1;
  wrong[4].damping = NAN;
  set_place(wrong[5].axis, 0, 0, 0);
  wrong[6].path_times = twice;
  wrong[6].path_places = places;
  wrong[6].path_count = 2;
  wrong[7].vertices = (const int32_t[]){1000};
  wrong[7].count = 1;
  wrong[8].kind = (thrum_link_kind)7;
  wrong[9].place[1] = NAN;
  wrong[10].other_place[2] = 1e40;

  // paths whose slopes are not finite, the end of an arm that is too long, vertices of the world
  wrong[11].path_times = at_once;
  wrong[11].path_places = away;
  wrong[11].path_count = 3;
  wrong[12].path_times = ever;
  wrong[12].path_places = away;
  wrong[12].path_count = 2;
  wrong[13].place[0] = 1e7;
  wrong[14].kind = THRUM_LINK_SPRING;
  wrong[14].other_vertices = (const int32_t[]){0};
  wrong[14].other_count = 1;
  for (int n = 0; n < 15; n++)
    assert_true(thrum_scene_add_link(f->scene, wrong + n, NULL, &failure) < 0);
  assert_int_equal(thrum_scene_link_count(f->scene), 0);
  assert_true(thrum_scene_link_release(f->scene, 0, &failure) < 0);

  // a body that is linked keeps its coordinates, and one that follows cannot be linked
  const thrum_scene_link_def def = link_of(THRUM_LINK_BALL, 0, 0, 0);
  add_link(f->scene, &def);
  assert_true(thrum_scene_set_rank(f->scene, 0, 4, &failure) < 0);
  assert_true(thrum_scene_set_condensed(f->scene, 0, 4, &failure) < 0);
  thrum_scene_body_def follows = thrum_default_scene_body_def();
  follows.model = &f->free_bar.model;
  follows.condense = 4;
  MUST(thrum_scene_add_body(f->scene, &follows, NULL, &failure));
  thrum_scene_link_def second = def;
  second.body = 1;
  assert_true(thrum_scene_add_link(f->scene, &second, NULL, &failure) < 0);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(joints_of_free_bodies_keep_places_momentum_and_energy),
      TEST(a_bar_on_a_joint_swings_as_a_pendulum),
      TEST(a_wide_swing_keeps_its_energy_and_its_pin),
      TEST(a_hinge_bears_what_would_turn_it_otherwise),
      TEST(what_did_not_move_together_comes_to_rest_in_two_steps),

      // springs
      TEST(springs_give_back_what_they_took_at_any_stiffness),
      TEST(a_body_on_a_spring_swings_as_its_mass_says),
      TEST(a_faint_spring_leaves_the_joints_beside_it),

      // ends in the world
      TEST(an_end_goes_along_its_path_and_does_the_work),
      TEST(a_link_lets_go_at_its_time_or_when_it_is_told),

      // with all else
      TEST(bars_on_a_hinge_fall_on_a_floor),
      TEST(a_snapshot_and_a_reset_step_to_the_same_bits),
      TEST(links_of_ready_sides_step_to_the_same_bits_without_a_basis),
      TEST(ready_sides_that_do_not_fit_are_refused),
      TEST(a_body_that_cannot_step_lets_go_of_the_other),
      TEST(bodies_whose_links_cannot_be_solved_for_stop),
      TEST(what_cannot_be_linked_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
