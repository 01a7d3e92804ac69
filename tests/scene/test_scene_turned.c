/* A scene that is turned and moved as a whole, with all that acts in it, is the same scene: its
 * bodies have the same coordinates, and places, forces and momenta turn with it.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "core/base/vec3.h"
#include "tests/support/scene_call.h"
#include "tests/support/two_bars.h"

enum { RANK = BAR_RANK, BODIES = 4 };

/* Two bars, and the free one in other axes. */
typedef struct fixture {
  two_bars bars;
  body turned;
  thrum_precomputed turned_bar;
} fixture;

static int setup(void **context) {
  fixture *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;
  two_bars_make(&f->bars, "beam:3x1x1@0.4x0.1x0.07,split=6", 3e5);

  // x, y and z of the third are y, z and x of the first, tilted about its first axis
  f->turned = body_make("beam:3x1x1@0.4x0.1x0.07,split=6", NULL);
  f->turned.mesh.materials[0] = f->bars.meshes[0].mesh.materials[0];
  for (int64_t v = 0; v < f->turned.mesh.vertex_count; v++) {
    double *x = f->turned.mesh.vertices + 3 * v, old[3] = {x[0], x[1], x[2]};
    x[0] = old[1];
    x[1] = 0.6 * old[2] - 0.8 * old[0];
    x[2] = 0.8 * old[2] + 0.6 * old[0];
  }
  f->turned_bar = body_precompute(&f->turned, BAR_MODES, BAR_RANK);
  *context = f;
  return 0;
}

static int teardown(void **context) {
  fixture *f = *context;
  two_bars_free(&f->bars);
  thrum_precomputed_free(&f->turned_bar);
  body_free(&f->turned);
  free(f);
  return 0;
}

/* How the world is turned, by a quaternion, and moved. */
typedef struct world {
  double quaternion[4], axes[9], way[3];
} world;

static world world_of(double w, double x, double y, double z, double way) {
  world made = {{w, x, y, z}, {0}, {way, -2 * way, 0.5 * way}};
  const double length = sqrt(w * w + x * x + y * y + z * z);
  for (int n = 0; n < 4; n++)
    made.quaternion[n] /= length;
  MUST(thrum_scene_axes(made.quaternion, made.axes, &failure));
  return made;
}

/* A direction and a place in the turned world. */
static void turn(const world *w, double x, double y, double z, double out[3]) {
  for (int axis = 0; axis < 3; axis++)
    out[axis] = w->axes[3 * axis] * x + w->axes[3 * axis + 1] * y + w->axes[3 * axis + 2] * z;
}

static void move(const world *w, double x, double y, double z, double out[3]) {
  turn(w, x, y, z, out);
  for (int axis = 0; axis < 3; axis++)
    out[axis] += w->way[axis];
}

/* The rotation `of`, then `a`. */
static void multiply(const double a[4], const double of[4], double out[4]) {
  out[0] = a[0] * of[0] - a[1] * of[1] - a[2] * of[2] - a[3] * of[3];
  out[1] = a[0] * of[1] + a[1] * of[0] + a[2] * of[3] - a[3] * of[2];
  out[2] = a[0] * of[2] - a[1] * of[3] + a[2] * of[0] + a[3] * of[1];
  out[3] = a[0] * of[3] + a[1] * of[2] - a[2] * of[1] + a[3] * of[0];
}

/* A rotation in the turned world. */
static void turn_rotation(const world *w, const double of[4], double out[4]) {
  multiply(w->quaternion, of, out);
}

/* --- a scene of everything -------------------------------------------------------------------- */

static void add_bodies(const fixture *f, const world *w, thrum_scene *scene) {
  static const double rotations[BODIES][4] = {
      {1, 0.2, 0, 0}, {0.8, 0, 0.4, 0.1}, {1, 0, 0, 0.3}, {1, 0.1, -0.2, 0}};
  for (int n = 0; n < BODIES; n++) {
    thrum_scene_body_def def = thrum_default_scene_body_def();
    def.model = n == 2 ? &f->bars.held_bar.model : &f->bars.free_bar.model;
    move(w, 0.1 * n, 0.3 * n, 0.1, def.position);
    turn_rotation(w, rotations[n], def.rotation);
    def.triangles = f->bars.triangles;
    def.triangle_count = f->bars.triangle_count;
    def.touch = f->bars.triangles;
    def.touch_count = 6;
    def.scale = n == 1 ? 1.5 : 1;
    def.free = n != 2;
    def.coupled = n == 1;
    if (def.free) {
      turn(w, 0.2, -0.1 * n, -0.3, def.velocity);
      turn(w, 3, 1 - n, -2, def.spin);
    }
    MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
  }
}

static void add_obstacles(const world *w, thrum_scene *scene) {
  thrum_obstacle floor = thrum_default_obstacle();
  move(w, 0.1, 0.2, -0.02, floor.centre);
  turn(w, 0.1, 0, 1, floor.normal);
  turn(w, 0, 0.1, 0.02, floor.velocity);
  floor.friction = 0.4;
  MUST(thrum_scene_add_obstacle(scene, &floor, NULL, &failure));

  // a box, whose axes are those of the world
  thrum_obstacle box = thrum_default_obstacle();
  box.shape = THRUM_OBSTACLE_BOX;
  move(w, 0.3, 0.35, -0.15, box.centre);
  memcpy(box.rotation, w->axes, sizeof box.rotation);
  box.half[0] = box.half[1] = 0.2;
  box.half[2] = 0.22;
  MUST(thrum_scene_add_obstacle(scene, &box, NULL, &failure));

  // a solid on a path
  const double times[2] = {0, 1}, none[4] = {1, 0, 0, 0}, tilted[4] = {1, 0.1, 0, 0};
  double places[14];
  move(w, 0.3, 1.0, -0.2, places);
  turn_rotation(w, none, places + 3);
  move(w, 0.3, 1.0, 0.1, places + 7);
  turn_rotation(w, tilted, places + 10);
  thrum_scene_solid_def solid = thrum_default_scene_solid_def();
  solid.half[0] = 0.3;
  solid.half[1] = solid.half[2] = 0.2;
  solid.path_times = times;
  solid.path_places = places;
  solid.path_count = 2;
  MUST(thrum_scene_add_solid(scene, &solid, NULL, &failure));
}

static void add_loads(const fixture *f, const world *w, thrum_scene *scene) {
  const int32_t corners[2] = {1, 5};
  const int64_t count = f->bars.free_bar.model.vertex_count;
  double *field = need(3 * (size_t)count, sizeof *field);
  for (int64_t v = 0; v < count; v++)
    turn(w, 0.01 * (double)v, -0.02, 0.005 * (double)(v % 3), field + 3 * v);
  for (int32_t n = 0; n < BODIES; n++) {
    thrum_scene_load_def force = {
        .cookie = sizeof force,
        .kind = THRUM_SCENE_FORCE,
        .vertices = corners,
        .count = 2,
        .course = {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = 2}};
    turn(w, 0.5, -0.7, 0.9 - n, force.vector);
    MUST(thrum_scene_add_load(scene, n, &force, &failure));
    thrum_scene_load_def pulled = {.cookie = sizeof pulled,
                                   .kind = THRUM_SCENE_ACCELERATION,
                                   .course = {.shape = THRUM_LOAD_CONSTANT, .until = 0.1}};
    turn(w, 1, 2, -1, pulled.vector);
    MUST(thrum_scene_add_load(scene, n, &pulled, &failure));
    const thrum_scene_load_def fields = {
        .cookie = sizeof fields,
        .kind = THRUM_SCENE_FIELD,
        .field = field,
        .field_count = count,
        .course = {.shape = THRUM_LOAD_CONSTANT, .until = INFINITY}};
    MUST(thrum_scene_add_load(scene, n, &fields, &failure));
  }
  free(field);

  // what acts on all
  double vector[3];
  turn(w, 0.3, 0, -0.8, vector);
  const thrum_load course = {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = 3};
  MUST(thrum_scene_add_base_motion(scene, vector, &course, &failure));
  turn(w, 0.5, 0.2, -9.81, vector);
  MUST(thrum_scene_set_gravity(scene, vector, &failure));
  thrum_scene_wind_def wind = thrum_default_scene_wind_def();
  turn(w, 3, -2, 1, wind.velocity);
  MUST(thrum_scene_set_wind(scene, &wind, &failure));
}

static void add_links(const world *w, thrum_scene *scene) {
  thrum_scene_link_def spring = thrum_default_scene_link_def();
  spring.kind = THRUM_LINK_SPRING;
  spring.stiffness = 40;
  spring.damping = 0.5;
  move(w, 0.2, 0.05, 0.12, spring.place);
  move(w, 0.3, -0.2, 0.5, spring.other_place);
  MUST(thrum_scene_add_link(scene, &spring, NULL, &failure));
  thrum_scene_link_def hinge = thrum_default_scene_link_def();
  hinge.kind = THRUM_LINK_HINGE;
  hinge.body = 3;
  hinge.other = 2;
  move(w, 0.35, 0.8, 0.12, hinge.place);
  turn(w, 1, 0.5, 0, hinge.axis);
  MUST(thrum_scene_add_link(scene, &hinge, NULL, &failure));
  double target[3];
  move(w, 0, 0, 0.6, target);
  MUST(thrum_scene_pull_start(scene, 1, 4, target, 60, 2, NULL, &failure));
}

static thrum_scene *make(const fixture *f, const world *w) {
  static const int32_t corners[3] = {0, 3, 7};
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.001, &scene, &failure));
  add_bodies(f, w, scene);
  add_obstacles(w, scene);
  add_loads(f, w, scene);
  add_links(w, scene);
  MUST(thrum_scene_add_probe(scene, "corners", 1, corners, 3, &failure));
  return scene;
}

/* --- comparison ------------------------------------------------------------------------------- */

/* How far two scenes may differ: by rounding and the tolerance of links, and of contact once they
 * touch. */
static double far;

static void assert_turned(const world *w, const double a[3], const double b[3], double size,
                          const char *what) {
  double turned[3];
  turn(w, a[0], a[1], a[2], turned);
  for (int axis = 0; axis < 3; axis++)
    if (!(fabs(turned[axis] - b[axis]) <= far * size))
      fail_msg("%s: %.12g along %d is %.12g in the turned world", what, turned[axis], axis,
               b[axis]);
}

/* The same of a place. */
static void assert_moved(const world *w, const double a[3], const double b[3], const char *what) {
  double back[3];
  thrum_subtract3(b, w->way, back);
  assert_turned(w, a, back, 1, what);
}

static void assert_same_bodies(const fixture *f, const world *w, thrum_scene *a, thrum_scene *b) {
  for (int32_t n = 0; n < BODIES; n++) {
    double q[2][RANK], p[2][RANK], x[2][3], v[2][3];
    MUST(thrum_scene_body_get(a, n, q[0], p[0], &failure));
    MUST(thrum_scene_body_get(b, n, q[1], p[1], &failure));
    assert_near(q[1], q[0], RANK, far);
    assert_near(p[1], p[0], RANK, far);
    for (int64_t vertex = 0; vertex < f->bars.free_bar.model.vertex_count; vertex += 3) {
      MUST(thrum_scene_body_vertex(a, n, vertex, x[0], v[0], &failure));
      MUST(thrum_scene_body_vertex(b, n, vertex, x[1], v[1], &failure));
      assert_moved(w, x[0], x[1], "a vertex");
      assert_turned(w, v[0], v[1], 10, "its velocity");
    }

    // energies, and the force of contact
    thrum_scene_energies of[2];
    double force[2][3];
    MUST(thrum_scene_body_energies(a, n, &of[0], &failure));
    MUST(thrum_scene_body_energies(b, n, &of[1], &failure));
    assert_close(of[1].kinetic, of[0].kinetic, far);
    assert_close(of[1].potential, of[0].potential, far);
    const thrum_scene_thing anything = {THRUM_SCENE_ANYTHING, 0};
    MUST(thrum_scene_contact_force(a, n, anything, force[0], &failure));
    MUST(thrum_scene_contact_force(b, n, anything, force[1], &failure));
    assert_turned(w, force[0], force[1], 1 + norm_of(force[0], 3), "contact");
  }
}

static void assert_same_rest(const world *w, thrum_scene *a, thrum_scene *b) {
  thrum_scene_account of[2];
  thrum_scene_link link[2];
  double x[2][3], v[2][3];
  MUST(thrum_scene_account_get(a, &of[0], &failure));
  MUST(thrum_scene_account_get(b, &of[1], &failure));
  assert_turned(w, of[0].momentum, of[1].momentum, 10, "the momentum");
  assert_close(of[1].links, of[0].links, far);
  for (int32_t n = 0; n < 2; n++) {
    MUST(thrum_scene_link_get(a, n, &link[0], &failure));
    MUST(thrum_scene_link_get(b, n, &link[1], &failure));
    assert_moved(w, link[0].places[0], link[1].places[0], "an end");
    assert_moved(w, link[0].places[1], link[1].places[1], "the other end");
    assert_turned(w, link[0].report.force, link[1].report.force,
                  1 + norm_of(link[0].report.force, 3), "the force of a link");
  }
  MUST(thrum_scene_probe_get(a, 0, x[0], v[0], &failure));
  MUST(thrum_scene_probe_get(b, 0, x[1], v[1], &failure));
  assert_moved(w, x[0], x[1], "a probe");
  MUST(thrum_scene_pull_get(a, THRUM_SCENE_PULLS, x[0], v[0], &failure));
  MUST(thrum_scene_pull_get(b, THRUM_SCENE_PULLS, x[1], v[1], &failure));
  assert_moved(w, x[0], x[1], "what is pulled");
  assert_turned(w, v[0], v[1], 1 + norm_of(v[0], 3), "the force of a pull");
  thrum_scene_ground(a, x[0]);
  thrum_scene_ground(b, x[1]);
  assert_turned(w, x[0], x[1], 1, "the ground");
}

static void a_turned_scene_is_the_same_scene(void **context) {
  const fixture *f = *context;
  const world still = world_of(1, 0, 0, 0, 0), turned = world_of(0.5, -0.3, 0.7, 0.2, 0.4);
  thrum_scene *a = make(f, &still), *b = make(f, &turned);
  far = 1e-8;
  for (int k = 0; k < 120; k++) {
    MUST(thrum_scene_step(a, &failure));
    MUST(thrum_scene_step(b, &failure));
    far = thrum_scene_collisions(a).touching > 0 ? 1e-3 : far;
    if (k % 20 == 19 || k == 0) {
      assert_same_bodies(f, &turned, a, b);
      assert_same_rest(&turned, a, b);
    }
  }
  assert_true(far > 1e-8);
  thrum_scene_destroy(a);
  thrum_scene_destroy(b);
}

/* Two bodies that fly at each other and a third that lies on a plane below them, with friction. */
static const double gravity[3] = {0, 0.3, -9.81};
static const double MASS = 0.4 * 0.1 * 0.07 * 1000; /* of a body [kg] */

static thrum_scene *throw(const fixture *f, const world *w, double stiffness, bool elastic,
                          bool other_axes) {
  static const double rotations[3][4] = {{1, 0.2, 0.3, 0.1}, {0.9, -0.1, 0.4, 0.2}, {1, 0, 0, 0.2}};
  static const double places[3][3] = {{0, 0, 0.05}, {0.15, 0.02, 0.3}, {0, 0.03, -0.2}};
  static const double speeds[3][3] = {{0.5, 0.2, -0.3}, {-0.4, 0.1, -2}, {0.1, 0, 0}};
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.001, &scene, &failure));
  double vector[3];
  turn(w, gravity[0], gravity[1], gravity[2], vector);
  MUST(thrum_scene_set_gravity(scene, vector, &failure));
  thrum_contact_pairs_def pairs = thrum_default_contact_pairs_def();
  pairs.thickness = 1.5e-3; // the default follows the box in the axes of the mesh
  pairs.friction = elastic ? 0 : 0.3;
  pairs.restitution = elastic ? 1 : 0.5;
  MUST(thrum_scene_set_collisions(scene, &pairs, &failure));
  for (int n = 0; n < 3; n++) {
    thrum_scene_body_def def = thrum_default_scene_body_def();
    def.model = &f->bars.free_bar.model;
    def.free = 1;
    def.stiffness = stiffness;
    def.triangles = f->bars.triangles;
    def.triangle_count = f->bars.triangle_count;
    move(w, places[n][0], places[n][1], places[n][2], def.position);
    turn_rotation(w, rotations[n], def.rotation);

    // the axes of the other mesh are turned back first
    if (other_axes) {
      static const double back[4] = {3, 1, 1, 3};
      double placed[4];
      memcpy(placed, def.rotation, sizeof placed);
      multiply(placed, back, def.rotation);
      def.model = &f->turned_bar.model;
    }
    turn(w, speeds[n][0], speeds[n][1], speeds[n][2], def.velocity);
    MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
  }
  return scene;
}

/* Soft bodies and near-rigid ones meet by springs and by impacts; neither changes the momentum,
 * that of gravity apart, nor adds energy. */
static void bodies_meet_alike_in_a_turned_world(void **context) {
  const fixture *f = *context;
  const world still = world_of(1, 0, 0, 0, 0), turned = world_of(0.5, -0.3, 0.7, 0.2, 0.4);
  for (int n = 0; n < 4; n++) {
    const double stiffness = n % 2 == 0 ? 1 : 300;
    const bool elastic = n >= 2;
    thrum_scene *a = throw(f, &still, stiffness, elastic, false);
    thrum_scene *b = throw(f, &turned, stiffness, elastic, false);
    thrum_scene_account first, now;
    MUST(thrum_scene_account_get(a, &first, &failure));
    int64_t touched = 0;
    double most = first.total;
    for (int k = 1; k <= 160; k++) {
      MUST(thrum_scene_step(a, &failure));
      MUST(thrum_scene_step(b, &failure));
      MUST(thrum_scene_account_get(a, &now, &failure));
      const thrum_contact_pairs_report report = thrum_scene_collisions(a);
      touched += report.touching + report.struck;
      most = fmax(most, now.total);
      if (elastic && fabs(now.total - first.total) > 1e-10 * first.total)
        fail_msg("step %d: %.3g of the energy is lost", k, 1 - now.total / first.total);
      for (int axis = 0; axis < 3; axis++)
        assert_true(fabs(now.momentum[axis] - first.momentum[axis] -
                         3 * MASS * 0.001 * k * gravity[axis]) <= 1e-11);
      if (k % 10 == 0)
        for (int32_t number = 0; number < 3; number++) {
          double x[2][3], v[2][3];
          far = 1e-8;
          for (int64_t vertex = 0; vertex < f->bars.free_bar.model.vertex_count; vertex++) {
            MUST(thrum_scene_body_vertex(a, number, vertex, x[0], v[0], &failure));
            MUST(thrum_scene_body_vertex(b, number, vertex, x[1], v[1], &failure));
            assert_moved(&turned, x[0], x[1], "a vertex");
            assert_turned(&turned, v[0], v[1], 10, "its velocity");
          }
        }
    }
    assert_true(touched > 10 && most <= first.total * (1 + 1e-9));
    thrum_scene_destroy(a);
    thrum_scene_destroy(b);
  }
}

/* The axes of a mesh are nobody's business either. */
static void bodies_meet_alike_in_meshes_of_other_axes(void **context) {
  const fixture *f = *context;
  const world still = world_of(1, 0, 0, 0, 0);
  for (int n = 0; n < 4; n++) {
    const double stiffness = n % 2 == 0 ? 1 : 300;
    const bool elastic = n >= 2;
    thrum_scene *a = throw(f, &still, stiffness, elastic, false),
                *b = throw(f, &still, stiffness, elastic, true);
    for (int k = 0; k < 160; k++) {
      MUST(thrum_scene_step(a, &failure));
      MUST(thrum_scene_step(b, &failure));
    }
    far = 1e-6; // of solves that end by a tolerance
    for (int32_t number = 0; number < 3; number++)
      for (int64_t vertex = 0; vertex < f->bars.free_bar.model.vertex_count; vertex++) {
        double x[2][3], v[2][3];
        MUST(thrum_scene_body_vertex(a, number, vertex, x[0], v[0], &failure));
        MUST(thrum_scene_body_vertex(b, number, vertex, x[1], v[1], &failure));
        assert_moved(&still, x[0], x[1], "a vertex");
        assert_turned(&still, v[0], v[1], 10, "its velocity");
      }
    thrum_scene_destroy(a);
    thrum_scene_destroy(b);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(a_turned_scene_is_the_same_scene),
                                     cmocka_unit_test(bodies_meet_alike_in_a_turned_world),
                                     cmocka_unit_test(bodies_meet_alike_in_meshes_of_other_axes)};
  return cmocka_run_group_tests(tests, setup, teardown);
}
