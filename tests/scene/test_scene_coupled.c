/* Tests of free bodies in a scene whose rotation and shape act on each other
 * (thrum/floating_frame.h): bodies of one model side by side, scaled, in touch, put back by a
 * snapshot.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "tests/support/outer_triangles.h"
#include "tests/support/scene_call.h"

typedef struct fixture {
  body mesh;
  thrum_precomputed made;
  int32_t *triangles;
  int64_t triangle_count;
  thrum_scene *scene;
} fixture;

static int setup(void **context) {
  fixture *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;
  f->mesh = body_make("beam:3x2x2@0.3x0.2x0.1", NULL);
  f->mesh.mesh.materials[0] = (thrum_material){1e5, 0.3, 1000};
  f->made = body_precompute(&f->mesh, 4, 8);
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
  free(f);
  return 0;
}

/* A coupled body at x that spins about all axes. */
static thrum_scene_body_def def_of(const fixture *f, double x) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &f->made.model;
  def.triangles = f->triangles;
  def.triangle_count = f->triangle_count;
  def.position[0] = x;
  def.rotation[1] = 0.3;
  def.free = def.coupled = 1;
  def.spin[0] = 2;
  def.spin[1] = 20;
  def.spin[2] = -5;
  return def;
}

static void add(fixture *f, const thrum_scene_body_def *def) {
  MUST(thrum_scene_add_body(f->scene, def, NULL, &failure));
}

static void step(fixture *f, int count) {
  for (int k = 0; k < count; k++)
    MUST(thrum_scene_step(f->scene, &failure));
}

static double total_of(fixture *f, int32_t number) {
  thrum_scene_energies energies;
  MUST(thrum_scene_body_energies(f->scene, number, &energies, &failure));
  return energies.total;
}

static void bodies_side_by_side_keep_their_energy_and_stretch(void **context) {
  fixture *f = *context;
  thrum_scene_body_def first = def_of(f, 0), other = def_of(f, 1);
  other.scale = 2;
  other.density = 0.5;
  other.stiffness = 3;
  add(f, &first);
  add(f, &first);
  add(f, &other);
  const double energy = total_of(f, 0), larger = total_of(f, 2);
  thrum_scene_account before, after;
  MUST(thrum_scene_account_get(f->scene, &before, &failure));
  step(f, 1000);
  MUST(thrum_scene_account_get(f->scene, &after, &failure));

  // twins have the same bits, and the shape holds a part of the energy
  thrum_scene_energies now;
  MUST(thrum_scene_body_energies(f->scene, 0, &now, &failure));
  assert_true(total_of(f, 0) == total_of(f, 1));
  assert_true(now.potential > 1e-3 * energy);
  assert_true(fabs(total_of(f, 0) / energy - 1) <= 1e-12);
  assert_true(fabs(total_of(f, 2) / larger - 1) <= 1e-12);
  for (int axis = 0; axis < 3; axis++)
    assert_close(after.angular_momentum[axis], before.angular_momentum[axis], 1e-13);
}

/* A body s times as large, of e times the stiffness and d times the density, moves as the smaller
 * one does, s sqrt(d/e) times as slowly. */
static void a_scaled_body_moves_as_the_model_does(void **context) {
  fixture *f = *context;

  // the same start, in its own time
  const double s = 2, e = 4, d = 1, slower = s * sqrt(d / e);
  thrum_scene_body_def first = def_of(f, 0), other = def_of(f, 0);
  other.scale = s;
  other.stiffness = e;
  other.density = d;
  for (int axis = 0; axis < 3; axis++)
    other.spin[axis] /= slower;
  add(f, &first);
  add(f, &other);
  step(f, 200);
  for (int64_t v = 0; v < f->made.model.vertex_count; v++) {
    double x[3], larger[3];
    MUST(thrum_scene_body_vertex(f->scene, 0, v, x, NULL, &failure));
    MUST(thrum_scene_body_vertex(f->scene, 1, v, larger, NULL, &failure));
    for (int axis = 0; axis < 3; axis++)
      assert_true(fabs(larger[axis] - s * x[axis]) <= 1e-9);
  }
}

static void spinning_bodies_that_meet_keep_momentum_and_gain_no_energy(void **context) {
  fixture *f = *context;
  thrum_contact_pairs_def pairs = thrum_default_contact_pairs_def();
  MUST(thrum_scene_set_collisions(f->scene, &pairs, &failure));
  thrum_scene_body_def first = def_of(f, 0), other = def_of(f, 0.7);
  first.velocity[0] = 2;
  add(f, &first);
  add(f, &other);
  thrum_scene_account before, now;
  MUST(thrum_scene_account_get(f->scene, &before, &failure));

  // what both have together, in every step
  double most = before.total;
  int64_t touched = 0;
  for (int k = 0; k < 300; k++) {
    step(f, 1);
    MUST(thrum_scene_account_get(f->scene, &now, &failure));
    touched += thrum_scene_collisions(f->scene).touching;
    most = fmax(most, now.total);
    for (int axis = 0; axis < 3; axis++) {
      assert_true(fabs(now.momentum[axis] - before.momentum[axis]) <= 1e-9 * before.momentum[0]);
      assert_true(fabs(now.angular_momentum[axis] - before.angular_momentum[axis]) <= 1e-9);
    }
  }

  // what they lost is what contact took
  const double lost = thrum_scene_collisions(f->scene).lost;
  assert_true(touched > 0 && most <= before.total * (1 + 1e-9) && lost > 0.1 * before.total);
  assert_close(now.total + lost, before.total, 1e-9);
}

static void a_joint_between_coupled_bodies_keeps_its_place_momentum_and_energy(void **context) {
  fixture *f = *context;
  const int32_t corner = 0;
  const thrum_scene_load_def push = {.cookie = sizeof push,
                                     .kind = THRUM_SCENE_FORCE,
                                     .vector = {3, -20, 12},
                                     .vertices = &corner,
                                     .count = 1,
                                     .course = {.shape = THRUM_LOAD_CONSTANT, .until = 0.2}};
  thrum_scene_body_def first = def_of(f, 0), other = def_of(f, 0.3);
  memset(first.spin, 0, sizeof first.spin);
  memset(other.spin, 0, sizeof other.spin);
  add(f, &first);
  add(f, &other);

  // a ball joint where they meet, and a push that turns them about it
  thrum_scene_link_def joint = thrum_default_scene_link_def();
  joint.kind = THRUM_LINK_BALL;
  joint.other = 1;
  joint.place[0] = 0.3;
  joint.place[1] = joint.place[2] = 0;
  MUST(thrum_scene_add_link(f->scene, &joint, NULL, &failure));
  MUST(thrum_scene_add_load(f->scene, 0, &push, &failure));
  step(f, 100);
  thrum_scene_account before, after;
  thrum_scene_link start, end;
  MUST(thrum_scene_account_get(f->scene, &before, &failure));
  MUST(thrum_scene_link_get(f->scene, 0, &start, &failure));

  // nothing acts from outside any more
  step(f, 500);
  MUST(thrum_scene_account_get(f->scene, &after, &failure));
  MUST(thrum_scene_link_get(f->scene, 0, &end, &failure));
  const double spin = norm_of(before.angular_momentum, 3);
  assert_true(end.report.largest_drift <= 1e-8);
  assert_true(fabs(after.total + end.report.lost - before.total - start.report.lost) <=
              1e-9 * before.total);
  for (int axis = 0; axis < 3; axis++)
    assert_true(fabs(after.angular_momentum[axis] - before.angular_momentum[axis]) <= 1e-9 * spin);
}

/* The contact has taken all that is lost, of a soft body by its springs, and of a near-rigid one,
 * which vibrates as it lands, by impacts. */
static void land(fixture *f, double stiffness) {
  thrum_scene_body_def def = def_of(f, 0);
  double velocity[8] = {0.1, -0.2, 0.1};
  int32_t touch[200];
  def.position[2] = 0.5;
  def.stiffness = stiffness;
  def.p = velocity;
  def.touch = touch;
  def.touch_count = f->made.model.vertex_count;
  for (int32_t v = 0; v < def.touch_count; v++)
    touch[v] = v;
  add(f, &def);

  // a second and a half above the floor and on it
  const int32_t number = thrum_scene_body_count(f->scene) - 1;
  const double start = total_of(f, number);
  double most = start;
  for (int k = 0; k < 750; k++) {
    step(f, 1);
    most = fmax(most, total_of(f, number));
  }
  thrum_scene_body_info info;
  MUST(thrum_scene_body(f->scene, number, &info, &failure));
  assert_true(info.contact.lost > 0 && info.contact.declined == 0 && most <= start * (1 + 1e-9));
  assert_true(fabs(total_of(f, number) + info.contact.lost - start) <= 1e-9 * start);
}

static void a_spinning_body_that_lands_gains_no_energy(void **context) {
  fixture *f = *context;
  const double gravity[3] = {0, 0, -9.81};
  const thrum_obstacle floor = thrum_default_obstacle();
  MUST(thrum_scene_set_gravity(f->scene, gravity, &failure));
  MUST(thrum_scene_add_obstacle(f->scene, &floor, NULL, &failure));
  land(f, 1);
  land(f, 1e4);
}

/* A force at a vertex of the deformed body turns it by its arm there. */
static void a_snapshot_steps_to_the_same_bits(void **context) {
  fixture *f = *context;
  const thrum_scene_body_def def = def_of(f, 0);
  const int32_t corner = 0;
  const thrum_scene_load_def load = {.cookie = sizeof load,
                                     .kind = THRUM_SCENE_FORCE,
                                     .vector = {0, 1, 2},
                                     .vertices = &corner,
                                     .count = 1,
                                     .course = {.shape = THRUM_LOAD_CONSTANT, .until = INFINITY}};
  add(f, &def);
  MUST(thrum_scene_add_load(f->scene, 0, &load, &failure));
  step(f, 50);
  const size_t size = thrum_scene_snapshot_size(f->scene);
  void *kept = need(size, 1);
  MUST(thrum_scene_snapshot(f->scene, kept, size, &failure));
  step(f, 50);
  const double once = total_of(f, 0);
  MUST(thrum_scene_restore(f->scene, kept, size, &failure));
  step(f, 50);
  assert_true(total_of(f, 0) == once);

  // and so does a start that is gone back to
  MUST(thrum_scene_reset(f->scene, &failure));
  step(f, 100);
  assert_true(total_of(f, 0) == once);
  free(kept);
}

/* The same model without its basis, with the numbers of its inertia, which the caller frees. */
static thrum_model bare_of(const fixture *f, double **numbers) {
  thrum_model bare = f->made.model;
  thrum_inertia *inertia = NULL;
  MUST(thrum_inertia_create(&f->made.model, 0, NULL, &inertia, &failure));
  *numbers = malloc((size_t)thrum_inertia_number_count(bare.rank) * sizeof **numbers);
  assert_non_null(*numbers);
  thrum_inertia_numbers(inertia, *numbers);
  thrum_inertia_destroy(inertia);
  bare.basis = NULL;
  bare.inertia = *numbers;
  return bare;
}

static void a_body_without_a_basis_is_coupled_by_the_numbers_of_its_inertia(void **context) {
  fixture *f = *context;
  double *numbers = NULL, q[2][8], matrix[2][16];
  const thrum_model bare = bare_of(f, &numbers);
  thrum_scene_body_def def = def_of(f, 0);
  def.triangles = NULL;
  def.triangle_count = 0;

  // a body, then a scaled one: two with the basis, two without
  for (int n = 0; n < 4; n++) {
    def.model = n % 2 ? &bare : &f->made.model;
    def.scale = n < 2 ? 1 : 1.7;
    def.density = n < 2 ? 1 : 0.6;
    add(f, &def);
  }
  step(f, 200);
  for (int32_t n = 0; n < 4; n++) {
    MUST(thrum_scene_body_get(f->scene, n, q[n % 2], NULL, &failure));
    thrum_scene_body_matrix(f->scene, n, matrix[n % 2]);
    if (n % 2 == 0)
      continue;
    assert_memory_equal(q[1], q[0], sizeof q[0]);
    assert_memory_equal(matrix[1], matrix[0], sizeof matrix[0]);
  }

  // a model with fewer coordinates has no such numbers, and what is not finite is refused
  thrum_inertia *inertia = NULL;
  size_t size;
  const thrum_model *lower;
  MUST(thrum_model_lock_size(&bare, 4, &size, &failure));
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_non_null(memory);
  MUST(thrum_model_lock(memory, size, &bare, 4, &lower, &failure));
  assert_null(lower->inertia);
  numbers[20] = INFINITY;
  assert_int_equal(thrum_inertia_create(&bare, 0, NULL, &inertia, &failure), THRUM_NOT_FINITE);
  free(memory);
  free(numbers);
}

static void what_cannot_be_coupled_is_refused(void **context) {
  fixture *f = *context;
  thrum_scene_body_def def = def_of(f, 0);
  def.condense = 3;
  assert_int_equal(thrum_scene_add_body(f->scene, &def, NULL, &failure), THRUM_UNSUPPORTED);
  def.condense = 0;
  def.rank = 3;
  assert_int_equal(thrum_scene_add_body(f->scene, &def, NULL, &failure), THRUM_UNSUPPORTED);
  def = def_of(f, 0);
  def.state.integrator = THRUM_INTEGRATOR_IMEXV;
  assert_int_equal(thrum_scene_add_body(f->scene, &def, NULL, &failure), THRUM_UNSUPPORTED);
  def = def_of(f, 0);
  def.free = 0;
  assert_int_equal(thrum_scene_add_body(f->scene, &def, NULL, &failure), THRUM_INVALID_ARGUMENT);

  // changes that it cannot have leave it as it is
  def = def_of(f, 0);
  add(f, &def);
  const double energy = total_of(f, 0);
  assert_int_equal(thrum_scene_set_rank(f->scene, 0, 5, &failure), THRUM_UNSUPPORTED);
  assert_int_equal(thrum_scene_set_condensed(f->scene, 0, 3, &failure), THRUM_UNSUPPORTED);
  assert_int_equal(thrum_scene_set_integrator(f->scene, 0, THRUM_INTEGRATOR_NEWMARK, &failure),
                   THRUM_UNSUPPORTED);
  const thrum_scene_detail detail = {.masters = 3, .beyond = 1, .jump = 0.01};
  assert_int_equal(thrum_scene_set_detail(f->scene, 0, &detail, &failure), THRUM_UNSUPPORTED);
  assert_true(total_of(f, 0) == energy);

  // those that it can have go on
  MUST(thrum_scene_set_damping(f->scene, 0, 1, 0, &failure));
  step(f, 10);
  assert_true(total_of(f, 0) < energy);
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)
  const struct CMUnitTest tests[] = {
      TEST(bodies_side_by_side_keep_their_energy_and_stretch),
      TEST(a_scaled_body_moves_as_the_model_does),
      TEST(spinning_bodies_that_meet_keep_momentum_and_gain_no_energy),
      TEST(a_joint_between_coupled_bodies_keeps_its_place_momentum_and_energy),
      TEST(a_spinning_body_that_lands_gains_no_energy),
      TEST(a_snapshot_steps_to_the_same_bits),
      TEST(a_body_without_a_basis_is_coupled_by_the_numbers_of_its_inertia),
      TEST(what_cannot_be_coupled_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
