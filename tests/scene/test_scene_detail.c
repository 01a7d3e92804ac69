/* Tests of levels of detail: a far or still body steps fewer coordinates and comes back, no vertex
 * jumps further than was stated, and what would jump waits.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "tests/support/scene_call.h"
#include "thrum/external_load.h"

enum { RANK = 8, MASTERS = 3, VERTICES = 9, EVERY = 8 };

typedef struct world {
  random_model m;
  thrum_scene *scene;
} world;

/* A body that swings by `size`, or rests, under alpha damping. */
static void open_world(world *w, double size, double damping) {
  const double q[RANK] = {0.2 * size, -0.1 * size, 0.1 * size};
  random_model_make(&w->m, 11, RANK, 3, 100, 1);
  random_model_add_mesh(&w->m, 12, VERTICES);
  random_model_pack(&w->m);
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &w->m.model;
  def.state.integrator = THRUM_INTEGRATOR_ENERGY;
  def.state.damping_alpha = damping;
  def.q = q;
  MUST(thrum_scene_create(0.003, &w->scene, &failure));
  MUST(thrum_scene_add_body(w->scene, &def, NULL, &failure));
}

static void close_world(world *w) {
  thrum_scene_destroy(w->scene);
  random_model_free(&w->m);
}

static void positions_of(const world *w, double *positions) {
  for (int64_t v = 0; v < VERTICES; v++)
    MUST(thrum_scene_body_vertex(w->scene, 0, v, positions + 3 * v, NULL, &failure));
}

/* Updates, and how far the vertex goes that goes furthest. */
static double jump_of_update(const world *w) {
  double before[3 * VERTICES], after[3 * VERTICES], largest = 0;
  positions_of(w, before);
  MUST(thrum_scene_update_detail(w->scene, &failure));
  positions_of(w, after);
  for (int v = 0; v < VERTICES; v++) {
    double square = 0;
    for (int axis = 0; axis < 3; axis++)
      square += pow(after[3 * v + axis] - before[3 * v + axis], 2);
    largest = fmax(largest, sqrt(square));
  }
  return largest;
}

/* Steps with updates; the largest jump of one. */
static double run(const world *w, int count) {
  double largest = 0;
  for (int k = 0; k < count; k++) {
    if (k % EVERY == 0)
      largest = fmax(largest, jump_of_update(w));
    MUST(thrum_scene_step(w->scene, &failure));
  }
  return largest;
}

static int64_t rank_of(const world *w) {
  thrum_scene_body_info info;
  MUST(thrum_scene_body(w->scene, 0, &info, &failure));
  return info.rank;
}

static thrum_scene_detail_report report_of(const world *w) {
  thrum_scene_detail_report report;
  MUST(thrum_scene_body_detail(w->scene, 0, &report, &failure));
  return report;
}

static void set_eye(const world *w, double x) {
  MUST(thrum_scene_set_eye(w->scene, (double[]){x, 0, 0}, &failure));
}

static void a_far_body_steps_fewer_coordinates_and_comes_back_without_a_jump(void **state) {
  (void)state;
  world w;
  open_world(&w, 1, 0);
  const thrum_scene_detail detail = {.masters = MASTERS, .beyond = 50, .jump = 0.05};
  MUST(thrum_scene_set_detail(w.scene, 0, &detail, &failure));

  // near it is stepped whole
  run(&w, 200);
  assert_int_equal(rank_of(&w), RANK);
  assert_int_equal(report_of(&w).changes, 0);

  // far it is not, and what it jumps by is measured and no more than was stated
  set_eye(&w, 1000);
  const double jump = run(&w, 800);
  assert_int_equal(rank_of(&w), MASTERS);
  assert_int_equal(report_of(&w).changes, 1);
  assert_true(jump > 0 && jump <= detail.jump);
  assert_true(fabs(report_of(&w).largest_jump - jump) <= 1e-9 * jump);
  assert_true(report_of(&w).reduced_steps > 400 && report_of(&w).reduced_steps <= 800);
  assert_true(report_of(&w).distance > 900);

  // near again it goes on from where it followed
  set_eye(&w, 0);
  assert_true(jump_of_update(&w) < 1e-12);
  assert_int_equal(rank_of(&w), RANK);
  assert_int_equal(report_of(&w).changes, 2);
  assert_false(report_of(&w).reduced);
  run(&w, 100);
  close_world(&w);
}

static void a_border_is_not_crossed_to_and_fro(void **state) {
  (void)state;
  world w;
  open_world(&w, 0, 0);
  const thrum_scene_detail detail = {.masters = MASTERS, .beyond = 50, .jump = 0.05};
  MUST(thrum_scene_set_detail(w.scene, 0, &detail, &failure));
  set_eye(&w, 60);
  run(&w, EVERY);
  assert_int_equal(rank_of(&w), MASTERS);

  // within a tenth of the border it stays far, and beyond that comes back
  set_eye(&w, 47.5);
  run(&w, EVERY);
  assert_int_equal(rank_of(&w), MASTERS);
  set_eye(&w, 40);
  run(&w, EVERY);
  assert_int_equal(rank_of(&w), RANK);
  close_world(&w);
}

static void a_change_that_would_jump_further_is_put_off(void **state) {
  (void)state;
  world w;
  open_world(&w, 1, 0);
  const thrum_scene_detail detail = {.masters = MASTERS, .beyond = 50, .jump = 1e-9};
  MUST(thrum_scene_set_detail(w.scene, 0, &detail, &failure));
  set_eye(&w, 1000);
  assert_true(run(&w, 400) == 0);
  assert_int_equal(rank_of(&w), RANK);
  assert_int_equal(report_of(&w).changes, 0);
  assert_int_equal(report_of(&w).put_off, 400 / EVERY);
  close_world(&w);
}

/* Also where the first vertex alone moves. */
static void the_jump_of_every_vertex_counts(void **state) {
  (void)state;
  for (int64_t only = 0; only < VERTICES; only += VERTICES - 1) {
    world w;
    open_world(&w, 1, 0);
    double rows[3 * RANK];
    memcpy(rows, w.m.basis + 3 * RANK * (VERTICES - 1), sizeof rows);
    memset(w.m.basis, 0, VERTICES * sizeof rows);
    memcpy(w.m.basis + 3 * RANK * only, rows, sizeof rows);
    const thrum_scene_detail detail = {.masters = MASTERS, .beyond = 50, .jump = 1e-9};
    MUST(thrum_scene_set_detail(w.scene, 0, &detail, &failure));
    set_eye(&w, 1000);
    run(&w, 80);
    assert_int_equal(report_of(&w).changes, 0);
    assert_int_equal(report_of(&w).put_off, 80 / EVERY);
    close_world(&w);
  }
}

static double energy_of(const world *w) {
  thrum_scene_energies energies;
  MUST(thrum_scene_body_energies(w->scene, 0, &energies, &failure));
  return energies.kinetic + energies.potential;
}

static void what_changes_take_is_counted(void **state) {
  (void)state;
  world w;
  open_world(&w, 1, 0);
  const thrum_scene_detail detail = {.masters = MASTERS, .beyond = 50, .jump = 1};
  MUST(thrum_scene_set_detail(w.scene, 0, &detail, &failure));
  double taken = 0, least = INFINITY;
  for (int k = 0; k < 6; k++) {
    run(&w, 30);
    set_eye(&w, k % 2 == 0 ? 1000 : 0);
    const double before = energy_of(&w);
    MUST(thrum_scene_update_detail(w.scene, &failure));
    taken += energy_of(&w) - before;
    least = fmin(least, energy_of(&w) - before);
  }
  assert_int_equal(report_of(&w).changes, 6);
  assert_true(least < -1e-6 && fabs(report_of(&w).energy - taken) <= 1e-12 * energy_of(&w));
  close_world(&w);
}

/* Updates at both ends of a swing, where it has no velocity, see the way between them. */
static void a_swing_is_not_still_where_it_turns(void **state) {
  (void)state;
  enum { HALF = 35 };
  const double dt = 0.003, omega = 3.14159265358979 / (HALF * dt), q[RANK] = {0.1};
  world w;
  random_model_make(&w.m, 11, RANK, omega, 100, INFINITY);
  random_model_add_mesh(&w.m, 12, VERTICES);
  random_model_pack(&w.m);
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &w.m.model;
  def.state.integrator = THRUM_INTEGRATOR_ENERGY;
  def.q = q;
  MUST(thrum_scene_create(dt, &w.scene, &failure));
  MUST(thrum_scene_add_body(w.scene, &def, NULL, &failure));
  const thrum_scene_detail detail = {.masters = MASTERS, .still = 1e-9, .jump = 1e-9};
  MUST(thrum_scene_set_detail(w.scene, 0, &detail, &failure));
  MUST(thrum_scene_update_detail(w.scene, &failure));
  for (int k = 0; k < 4; k++) {
    double before[3 * VERTICES], after[3 * VERTICES];
    positions_of(&w, before);
    for (int n = 0; n < HALF; n++)
      MUST(thrum_scene_step(w.scene, &failure));
    positions_of(&w, after);
    MUST(thrum_scene_update_detail(w.scene, &failure));
    for (int v = 0; v < 3 * VERTICES; v++)
      assert_true(report_of(&w).speed * HALF * dt >= fabs(after[v] - before[v]) * (1 - 1e-12));
  }
  close_world(&w);
}

static void a_still_body_steps_fewer_until_it_moves_again(void **state) {
  (void)state;
  world w;
  open_world(&w, 1, 8);
  const thrum_scene_detail detail = {.masters = MASTERS, .still = 0.01, .jump = 1e-3};
  MUST(thrum_scene_set_detail(w.scene, 0, &detail, &failure));
  run(&w, 40);
  assert_int_equal(rank_of(&w), RANK);

  // the swing of the body dies away
  assert_true(run(&w, 3000) <= detail.jump);
  assert_int_equal(rank_of(&w), MASTERS);
  assert_true(report_of(&w).speed < detail.still);

  // a push wakes it in the next update
  const thrum_scene_load_def push = {.cookie = sizeof push,
                                     .kind = THRUM_SCENE_ACCELERATION,
                                     .vector = {0, 0, 500},
                                     .course = {.shape = THRUM_LOAD_CONSTANT, .until = INFINITY}};
  MUST(thrum_scene_add_load(w.scene, 0, &push, &failure));
  for (int k = 0; k < EVERY; k++)
    MUST(thrum_scene_step(w.scene, &failure));
  assert_true(jump_of_update(&w) <= detail.jump);
  assert_int_equal(rank_of(&w), RANK);
  close_world(&w);
}

static void a_condensed_body_comes_back_to_its_own_number(void **state) {
  (void)state;
  world w;
  open_world(&w, 0.3, 0);
  MUST(thrum_scene_set_condensed(w.scene, 0, 5, &failure));
  const thrum_scene_detail detail = {.masters = 2, .beyond = 50, .jump = 0.05};
  MUST(thrum_scene_set_detail(w.scene, 0, &detail, &failure));
  set_eye(&w, 1000);
  assert_true(run(&w, 400) <= detail.jump);
  assert_int_equal(rank_of(&w), 2);
  set_eye(&w, 0);
  assert_true(run(&w, 400) <= detail.jump);
  assert_int_equal(rank_of(&w), 5);

  // without a level of detail it stays as it is, and a reset keeps the number
  MUST(thrum_scene_set_detail(w.scene, 0, NULL, &failure));
  set_eye(&w, 1000);
  run(&w, 100);
  assert_int_equal(rank_of(&w), 5);
  assert_false(report_of(&w).set);
  MUST(thrum_scene_reset(w.scene, &failure));
  assert_int_equal(rank_of(&w), 5);
  close_world(&w);
}

static void a_body_that_may_touch_others_is_left_whole(void **state) {
  (void)state;
  static const int32_t triangles[] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2};
  world w;
  open_world(&w, 0, 0);
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &w.m.model;
  def.triangles = triangles;
  def.triangle_count = 4;
  def.position[0] = 100;
  MUST(thrum_scene_add_body(w.scene, &def, NULL, &failure));
  const thrum_contact_pairs_def pairs = thrum_default_contact_pairs_def();
  MUST(thrum_scene_set_collisions(w.scene, &pairs, &failure));

  // both are far; the first has no triangles, and may follow
  const thrum_scene_detail detail = {.masters = MASTERS, .beyond = 50, .jump = 0.05};
  for (int32_t n = 0; n < 2; n++)
    MUST(thrum_scene_set_detail(w.scene, n, &detail, &failure));
  set_eye(&w, 1000);
  MUST(thrum_scene_update_detail(w.scene, &failure));
  thrum_scene_body_info info;
  MUST(thrum_scene_body(w.scene, 1, &info, &failure));
  assert_int_equal(info.rank, RANK);
  assert_int_equal(rank_of(&w), MASTERS);

  // where bodies pass through each other, so may the second
  MUST(thrum_scene_set_collisions(w.scene, NULL, &failure));
  MUST(thrum_scene_update_detail(w.scene, &failure));
  MUST(thrum_scene_body(w.scene, 1, &info, &failure));
  assert_int_equal(info.rank, MASTERS);
  close_world(&w);
}

static void what_cannot_be_is_refused(void **state) {
  (void)state;
  world w;
  open_world(&w, 1, 0);
  const thrum_scene_detail wrong[] = {
      {.masters = 0, .beyond = 1, .jump = 1},
      {.masters = RANK, .beyond = 1, .jump = 1},
      {.masters = 2, .beyond = 1},
      {.masters = 2, .beyond = -1, .jump = 1},
      {.masters = 2, .still = INFINITY, .jump = 1},
      {.masters = 2, .still = -1, .jump = 1},
      {.masters = 2, .beyond = 1, .jump = INFINITY},
  };
  for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++)
    assert_true(thrum_scene_set_detail(w.scene, 0, &wrong[n], &failure) < 0);
  assert_true(thrum_scene_set_detail(w.scene, 1, &wrong[0], &failure) < 0);
  assert_true(thrum_scene_set_eye(w.scene, (double[]){0, NAN, 0}, &failure) == THRUM_BAD_VALUE);
  assert_false(report_of(&w).set);

  // a body that steps few coordinates already has no fewer
  const thrum_scene_detail right = {.masters = 2, .beyond = 1, .jump = 1};
  MUST(thrum_scene_set_rank(w.scene, 0, 2, &failure));
  assert_true(thrum_scene_set_detail(w.scene, 0, &right, &failure) == THRUM_INVALID_ARGUMENT);
  MUST(thrum_scene_set_rank(w.scene, 0, RANK, &failure));
  MUST(thrum_scene_set_detail(w.scene, 0, &right, &failure));
  close_world(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_far_body_steps_fewer_coordinates_and_comes_back_without_a_jump),
      cmocka_unit_test(a_border_is_not_crossed_to_and_fro),
      cmocka_unit_test(a_change_that_would_jump_further_is_put_off),
      cmocka_unit_test(the_jump_of_every_vertex_counts),
      cmocka_unit_test(what_changes_take_is_counted),
      cmocka_unit_test(a_swing_is_not_still_where_it_turns),
      cmocka_unit_test(a_still_body_steps_fewer_until_it_moves_again),
      cmocka_unit_test(a_condensed_body_comes_back_to_its_own_number),
      cmocka_unit_test(a_body_that_may_touch_others_is_left_whole),
      cmocka_unit_test(what_cannot_be_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
