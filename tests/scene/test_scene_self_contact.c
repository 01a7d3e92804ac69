/* Tests of a body that touches itself: the arms of a horseshoe are thrown at each other. They meet
 * and stay apart, momentum and energy are kept, and without self contact they pass through each
 * other.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "tests/support/outer_triangles.h"
#include "tests/support/scene_call.h"

#include "core/base/vec3.h"

/* The horseshoe [m]: a straight bar of this width, bent about a half circle. */
#define ARM 0.16
#define RADIUS 0.04
#define WIDTH 0.03
#define IMPULSE 0.25 /* on either end [N s] */
#define PI 3.14159265358979324
#define BAR "beam:18x2x2@0.445663706143592x0.03x0.03,split=6"

typedef struct fixture {
  body mesh;
  thrum_precomputed made;
  int32_t *triangles;
  int64_t triangle_count;
  int32_t *ends[2]; /* vertices of the ends of both arms */
  int64_t end_count;
  thrum_scene *scene;
} fixture;

/* Where a vertex of the bar is on the horseshoe, whose arms point up and whose bend is below. */
static void bend(double x[3]) {
  const double along = x[0], across = x[1], bow = PI * RADIUS;
  const double angle = PI + (along - ARM) / RADIUS;
  const double end = along < ARM ? -1.0 : 1.0;
  if (along > ARM && along < ARM + bow) {
    x[0] = (RADIUS - across) * cos(angle);
    x[1] = (RADIUS - across) * sin(angle);
    return;
  }
  x[0] = end * (RADIUS - across);
  x[1] = end < 0.0 ? ARM - along : along - ARM - bow;
}

static int setup(void **context) {
  fixture *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;
  f->mesh = body_make(BAR, NULL);
  f->mesh.mesh.materials[0] = (thrum_material){1e6, 0.3, 1000};
  const int64_t count = f->mesh.mesh.vertex_count;
  f->ends[0] = need((size_t)count, sizeof **f->ends);
  f->ends[1] = need((size_t)count, sizeof **f->ends);

  // the ends of the bar, in the same order on both sides
  for (int side = 0; side < 2; side++) {
    const double end = side == 0 ? 0.0 : 2 * ARM + PI * RADIUS;
    f->end_count = 0;
    for (int64_t v = 0; v < count; v++)
      if (fabs(f->mesh.mesh.vertices[3 * v] - end) < 1e-6)
        f->ends[side][f->end_count++] = (int32_t)v;
  }
  for (int64_t v = 0; v < count; v++)
    bend(f->mesh.mesh.vertices + 3 * v);
  f->made = body_precompute(&f->mesh, 5, 14);
  f->triangles = outer_triangles(&f->mesh.mesh, &f->triangle_count);
  *context = f;
  return thrum_scene_create(0.002, &f->scene, &failure) < 0;
}

static int teardown(void **context) {
  fixture *f = *context;
  thrum_scene_destroy(f->scene);
  thrum_precomputed_free(&f->made);
  body_free(&f->mesh);
  free(f->triangles);
  free(f->ends[0]);
  free(f->ends[1]);
  free(f);
  return 0;
}

/* The momenta of an impulse [N s] on the end of each arm towards the other. */
static void press(const fixture *f, double impulse, double *p) {
  const thrum_model *model = &f->made.model;
  for (int side = 0; side < 2; side++)
    for (int64_t n = 0; n < f->end_count; n++)
      for (int64_t i = 0; i < model->rank; i++)
        p[i] += (side == 0 ? impulse : -impulse) / (double)f->end_count *
                model->basis[3 * f->ends[side][n] * model->rank + i];
}

/* A horseshoe that flies and spins with its arms thrown at each other. */
static void throw(fixture * f, bool touches, double impulse, double p[THRUM_RANK_MAX]) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &f->made.model;
  def.triangles = f->triangles;
  def.triangle_count = f->triangle_count;
  press(f, impulse, p);
  def.p = p;
  def.free = 1;
  def.velocity[0] = 1;
  def.velocity[1] = 0.3;
  def.spin[2] = 2;
  def.spin[0] = 0.5;
  def.self_contact = touches;
  MUST(thrum_scene_add_body(f->scene, &def, NULL, &failure));
}

/* Is x inside a tetrahedron of these corners, whose volume is positive? */
static bool is_inside(double (*const places)[3], const int32_t *tet, const double x[3]) {
  static const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  bool inside = true;
  for (int n = 0; n < 4 && inside; n++) {
    double edges[3][3];
    for (int axis = 0; axis < 3; axis++) {
      const double from = places[tet[faces[n][0]]][axis];
      edges[0][axis] = places[tet[faces[n][1]]][axis] - from;
      edges[1][axis] = places[tet[faces[n][2]]][axis] - from;
      edges[2][axis] = x[axis] - from;
    }
    inside = thrum_triple3(edges[0], edges[1], edges[2]) < 0.0;
  }
  return inside;
}

/* Vertices of the left arm that are inside of the right one, by the tetrahedra as they are now. */
static int64_t crossed(fixture *f) {
  const thrum_mesh *mesh = &f->mesh.mesh;
  double(*places)[3] = need((size_t)mesh->vertex_count, sizeof *places);
  int64_t count = 0;
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    MUST(thrum_scene_body_vertex(f->scene, 0, v, places[v], NULL, &failure));

  // an arm is what is above the bend on one side
  for (int64_t v = 0; v < mesh->vertex_count; v++) {
    const double *rest = mesh->vertices + 3 * v;
    bool inside = false;
    for (int64_t t = 0; t < mesh->tet_count && rest[0] < 0 && rest[1] > 0 && !inside; t++) {
      const int32_t *tet = mesh->tets + 4 * t;
      inside = mesh->vertices[3 * tet[0]] > 0 && mesh->vertices[3 * tet[0] + 1] > 0 &&
               is_inside(places, tet, places[v]);
    }
    count += inside;
  }
  free(places);
  return count;
}

static thrum_scene_account account_of(thrum_scene *scene) {
  thrum_scene_account account;
  MUST(thrum_scene_account_get(scene, &account, &failure));
  return account;
}

/* Makes so many steps; returns how many vertices went through at most. */
static int64_t step_through(fixture *f, int steps) {
  int64_t most = 0;
  for (int k = 0; k < steps; k++) {
    MUST(thrum_scene_step(f->scene, &failure));
    const int64_t now = crossed(f);
    most = now > most ? now : most;
  }
  return most;
}

static void arms_that_meet_stay_apart(void **context) {
  fixture *f = *context;
  double p[THRUM_RANK_MAX] = {0};
  throw(f, true, IMPULSE, p);
  const thrum_scene_account before = account_of(f->scene);
  int64_t touched = 0;
  double most = before.total;
  for (int k = 0; k < 200; k++) {
    assert_int_equal(step_through(f, 1), 0);
    const thrum_scene_account now = account_of(f->scene);
    touched += thrum_scene_collisions(f->scene).touching;
    most = fmax(most, now.total);

    // the forces are within the body
    assert_near(now.momentum, before.momentum, 3, 1e-9);
    assert_near(now.angular_momentum, before.angular_momentum, 3, 1e-9);
  }

  // they have met, no deeper than the thickness, and what they lost is what contact took
  const thrum_contact_pairs_report report = thrum_scene_collisions(f->scene);
  assert_true(touched > 0 && report.lost > 0 && report.declined == 0);
  assert_true(report.deepest_share < 1);
  assert_true(most <= before.total * (1 + 1e-9));
  assert_close(account_of(f->scene).total + report.stored + report.lost, before.total, 1e-9);
}

static void arms_pass_through_each_other_without_self_contact(void **context) {
  fixture *f = *context;
  double p[THRUM_RANK_MAX] = {0};
  throw(f, false, IMPULSE, p);
  assert_true(step_through(f, 40) > 0);
}

/* The same horseshoe coupled to its rotation, with another body in its way. */
static void a_body_that_touches_itself_and_another_keeps_momentum(void **context) {
  fixture *f = *context;
  double p[THRUM_RANK_MAX] = {0};
  const thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  MUST(thrum_scene_set_collisions(f->scene, &def, &failure));
  throw(f, true, IMPULSE, p);

  // the other body, at rest
  thrum_scene_body_def other = thrum_default_scene_body_def();
  other.model = &f->made.model;
  other.triangles = f->triangles;
  other.triangle_count = f->triangle_count;
  other.free = 1;
  other.position[0] = 0.13;
  MUST(thrum_scene_add_body(f->scene, &other, NULL, &failure));

  // the run must have touches of the body with itself, and with another one
  const thrum_scene_account before = account_of(f->scene);
  bool own = false, both = false;
  for (int k = 0; k < 100; k++) {
    MUST(thrum_scene_step(f->scene, &failure));
    thrum_pair_touch touch;
    for (int64_t n = 0; n < thrum_scene_collisions(f->scene).touching; n++) {
      MUST(thrum_scene_collision_get(f->scene, n, &touch, &failure));
      own = own || touch.bodies[0] == touch.bodies[1];
      both = both || touch.bodies[0] != touch.bodies[1];
    }
  }

  const thrum_scene_account after = account_of(f->scene);
  const thrum_contact_pairs_report report = thrum_scene_collisions(f->scene);
  assert_true(own && both && report.deepest_share < 1);
  assert_near(after.momentum, before.momentum, 3, 1e-9);
  assert_near(after.angular_momentum, before.angular_momentum, 3, 1e-9);
  assert_close(after.total + report.lost, before.total, 1e-9);
}

/* Two horseshoes, of which one passes through other bodies, fly through each other on a faint
 * spring, which has them step together. */
static void what_passes_through_others_does_so_beside_its_own_touches(void **context) {
  fixture *f = *context;
  const thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  MUST(thrum_scene_set_collisions(f->scene, &def, &failure));
  for (int n = 0; n < 2; n++) {
    double p[THRUM_RANK_MAX] = {0};
    thrum_scene_body_def made = thrum_default_scene_body_def();
    press(f, IMPULSE, p);
    made.model = &f->made.model;
    made.triangles = f->triangles;
    made.triangle_count = f->triangle_count;
    made.free = 1;
    made.p = p;
    made.position[2] = n == 0 ? 0 : 0.1;
    made.velocity[2] = n == 0 ? 1 : -1;
    made.collide = n;
    made.self_contact = 1;
    MUST(thrum_scene_add_body(f->scene, &made, NULL, &failure));
  }
  thrum_scene_link_def spring = thrum_default_scene_link_def();
  spring.kind = THRUM_LINK_SPRING;
  spring.other = 1;
  spring.stiffness = 1e-6;
  MUST(thrum_scene_add_link(f->scene, &spring, NULL, &failure));

  // each touches itself alone
  bool own = false;
  for (int k = 0; k < 100; k++) {
    MUST(thrum_scene_step(f->scene, &failure));
    thrum_pair_touch touch;
    for (int64_t n = 0; n < thrum_scene_collisions(f->scene).touching; n++) {
      MUST(thrum_scene_collision_get(f->scene, n, &touch, &failure));
      assert_int_equal(touch.bodies[0], touch.bodies[1]);
      own = true;
    }
  }
  assert_true(own);
}

/* Arms of 1.5 thicknesses that open and vibrate: what is so near at rest is no touch. */
static void thin_arms_do_not_touch_themselves(void **context) {
  fixture *f = *context;
  thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  def.thickness = WIDTH / 1.5;
  MUST(thrum_scene_set_collisions(f->scene, &def, &failure));
  double p[THRUM_RANK_MAX] = {0};
  throw(f, true, -0.2 * IMPULSE, p);
  for (int k = 0; k < 20; k++) {
    MUST(thrum_scene_step(f->scene, &failure));
    assert_int_equal(thrum_scene_collisions(f->scene).touching, 0);
  }
}

static void a_snapshot_amid_a_touch_steps_to_the_same_bits(void **context) {
  fixture *f = *context;
  double p[THRUM_RANK_MAX] = {0}, x[2][3];
  throw(f, true, IMPULSE, p);
  while (thrum_scene_collisions(f->scene).touching == 0)
    MUST(thrum_scene_step(f->scene, &failure));

  // twice from there
  const size_t size = thrum_scene_snapshot_size(f->scene);
  void *kept = need(size, 1);
  MUST(thrum_scene_snapshot(f->scene, kept, size, &failure));
  for (int n = 0; n < 2; n++) {
    MUST(thrum_scene_restore(f->scene, kept, size, &failure));
    for (int k = 0; k < 5; k++)
      MUST(thrum_scene_step(f->scene, &failure));
    MUST(thrum_scene_body_vertex(f->scene, 0, f->ends[0][0], x[n], NULL, &failure));
  }
  assert_memory_equal(x[0], x[1], sizeof x[0]);
  free(kept);
}

static void what_cannot_touch_itself_is_refused(void **context) {
  fixture *f = *context;
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &f->made.model;
  def.self_contact = 1;
  assert_int_equal(thrum_scene_add_body(f->scene, &def, NULL, &failure), THRUM_MISSING);
  def.triangles = f->triangles;
  def.triangle_count = f->triangle_count;
  def.condense = 4;
  assert_int_equal(thrum_scene_add_body(f->scene, &def, NULL, &failure), THRUM_UNSUPPORTED);
  assert_int_equal(thrum_scene_body_count(f->scene), 0);

  // nor is it condensed later on, where one that does not touch itself is
  for (int touches = 0; touches < 2; touches++) {
    def.condense = 0;
    def.self_contact = touches;
    assert_int_equal(thrum_scene_add_body(f->scene, &def, NULL, &failure), THRUM_OK);
    assert_int_equal(thrum_scene_set_condensed(f->scene, touches, 4, &failure),
                     touches ? THRUM_UNSUPPORTED : THRUM_OK);
  }
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(arms_that_meet_stay_apart),
      TEST(arms_pass_through_each_other_without_self_contact),
      TEST(a_body_that_touches_itself_and_another_keeps_momentum),
      TEST(what_passes_through_others_does_so_beside_its_own_touches),
      TEST(thin_arms_do_not_touch_themselves),
      TEST(a_snapshot_amid_a_touch_steps_to_the_same_bits),
      TEST(what_cannot_touch_itself_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
