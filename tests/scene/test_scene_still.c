/* Tests of the events that wake a still body with a level of detail. Anything that is about to act
 * on the body finds all of its coordinates stepped, so that it moves as it would without a level of
 * detail. Calls that restart a scene or go back in time keep what updates have seen.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "tests/support/scene_call.h"

#define CLOSE 1e-4 /* iterations begin elsewhere after a change */

enum { EVERY = 8, QUIET = 200, ALL = 8, MASTERS = 2 };

static const thrum_scene_detail level = {.masters = MASTERS, .still = 0.02, .jump = 1e-3};

/* Two scenes of the same block, free or held at its left side; it has a level of detail in the
 * first. */
typedef struct fixture {
  body block;
  thrum_precomputed made;
  thrum_scene *scenes[2];
  int32_t *touch;
} fixture;

static int make(void **context, const char *fix) {
  fixture *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;
  f->block = body_make("beam:4x3x2@0.4x0.3x0.2,split=6", fix);
  f->made = body_precompute(&f->block, 4, ALL);
  const thrum_model *m = &f->made.model;
  f->touch = need((size_t)m->vertex_count, sizeof *f->touch);
  for (int64_t v = 0; v < m->vertex_count; v++)
    f->touch[v] = (int32_t)v;

  // two scenes with the same body, the first with a level of detail
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = m;
  def.touch = f->touch;
  def.touch_count = m->vertex_count;
  def.free = fix == NULL;
  def.position[2] = 1;
  for (int n = 0; n < 2; n++) {
    MUST(thrum_scene_create(0.002, &f->scenes[n], &failure));
    MUST(thrum_scene_add_body(f->scenes[n], &def, NULL, &failure));
  }
  MUST(thrum_scene_set_detail(f->scenes[0], 0, &level, &failure));
  *context = f;
  return 0;
}

static int make_free(void **context) {
  return make(context, NULL);
}

static int make_held(void **context) {
  return make(context, "x<0.001");
}

static int teardown(void **context) {
  fixture *f = *context;
  for (int n = 0; n < 2; n++)
    thrum_scene_destroy(f->scenes[n]);
  thrum_precomputed_free(&f->made);
  body_free(&f->block);
  free(f->touch);
  free(f);
  return 0;
}

static int64_t rank_of(thrum_scene *scene) {
  thrum_scene_body_info info;
  MUST(thrum_scene_body(scene, 0, &info, &failure));
  return info.rank;
}

/* Both scenes make these steps; an update comes before the first and then every few. */
static void run(fixture *f, int count) {
  for (int k = 0; k < count; k++)
    for (int n = 0; n < 2; n++) {
      if (k % EVERY == 0)
        MUST(thrum_scene_update_detail(f->scenes[n], &failure));
      MUST(thrum_scene_step(f->scenes[n], &failure));
    }
}

/* The bodies of both scenes move in the same way, and do move. */
static void expect_same(const fixture *f) {
  double q[2][ALL], p[2][ALL], most = 0;
  assert_int_equal(rank_of(f->scenes[0]), ALL);
  for (int n = 0; n < 2; n++)
    MUST(thrum_scene_body_get(f->scenes[n], 0, q[n], p[n], &failure));
  for (int i = 0; i < ALL; i++)
    most = fmax(most, fabs(p[1][i]));
  assert_true(most > 1e-6);
  for (int i = 0; i < ALL; i++)
    if (!(fabs(p[0][i] - p[1][i]) < CLOSE * most))
      fail_msg("velocity %d is %g, not %g", i, p[0][i], p[1][i]);
}

static void a_load_finds_a_still_body_awake(void **context) {
  fixture *f = *context;

  // one step of a force along the block, which two coordinates cannot show; between two updates
  const thrum_scene_load_def load = {
      .cookie = sizeof load,
      .kind = THRUM_SCENE_FORCE,
      .vector = {2e3, 0, 0},
      .vertices = f->touch + f->made.model.vertex_count - 3,
      .count = 3,
      .course = {.shape = THRUM_LOAD_CONSTANT, .from = 0.806, .until = 0.808}};
  for (int n = 0; n < 2; n++)
    MUST(thrum_scene_add_load(f->scenes[n], 0, &load, &failure));
  run(f, QUIET + QUIET / 2);
  assert_int_equal(rank_of(f->scenes[0]), MASTERS);
  run(f, QUIET);
  expect_same(f);
}

static void a_shaken_ground_finds_a_still_body_awake(void **context) {
  fixture *f = *context;
  const thrum_load course = {.shape = THRUM_LOAD_SINE, .from = 0.8, .until = 0.9, .frequency = 10};
  for (int n = 0; n < 2; n++)
    MUST(thrum_scene_add_base_motion(f->scenes[n], (double[]){5, 5, 0}, &course, &failure));
  run(f, QUIET);
  assert_int_equal(rank_of(f->scenes[0]), MASTERS);
  run(f, QUIET + QUIET / 4);
  expect_same(f);
}

static void a_call_that_changes_what_acts_wakes_it(void **context) {
  fixture *f = *context;
  run(f, QUIET);
  assert_int_equal(rank_of(f->scenes[0]), MASTERS);
  for (int n = 0; n < 2; n++)
    MUST(thrum_scene_set_gravity(f->scenes[n], (double[]){0, 0, -9.81}, &failure));
  run(f, EVERY);
  expect_same(f);
}

static void a_pull_wakes_it(void **context) {
  fixture *f = *context;
  const int64_t vertex = f->made.model.vertex_count - 1;
  run(f, QUIET);
  for (int n = 0; n < 2; n++)
    MUST(thrum_scene_pull_start(f->scenes[n], 0, vertex, (double[]){0.5, 0.3, 1.3}, 100, -1, NULL,
                                &failure));
  run(f, EVERY);
  expect_same(f);
}

static void an_obstacle_that_comes_near_finds_it_awake(void **context) {
  fixture *f = *context;
  thrum_obstacle ball = thrum_default_obstacle();
  ball.shape = THRUM_OBSTACLE_SPHERE;
  ball.radius = 0.1;
  ball.centre[0] = 0.35;
  ball.centre[1] = 0.15;
  ball.centre[2] = 3.3;
  ball.velocity[2] = -2;
  for (int n = 0; n < 2; n++)
    MUST(thrum_scene_add_obstacle(f->scenes[n], &ball, NULL, &failure));

  // it is far until it is near, and touches after a second
  run(f, QUIET);
  assert_int_equal(rank_of(f->scenes[0]), MASTERS);
  run(f, 2 * QUIET);
  expect_same(f);
}

static void a_body_that_falls_is_not_still(void **context) {
  fixture *f = *context;
  const thrum_obstacle floor = thrum_default_obstacle();
  for (int n = 0; n < 2; n++) {
    MUST(thrum_scene_set_gravity(f->scenes[n], (double[]){0, 0, -9.81}, &failure));
    MUST(thrum_scene_add_obstacle(f->scenes[n], &floor, NULL, &failure));
  }

  // it falls for 0.45 s, longer than a period, and bounces
  run(f, 2 * QUIET);
  expect_same(f);
}

static void a_reset_begins_with_all_coordinates(void **context) {
  fixture *f = *context;
  run(f, QUIET);
  assert_int_equal(rank_of(f->scenes[0]), MASTERS);
  MUST(thrum_scene_reset(f->scenes[0], &failure));
  assert_int_equal(rank_of(f->scenes[0]), ALL);
  thrum_scene_detail_report report;
  MUST(thrum_scene_body_detail(f->scenes[0], 0, &report, &failure));
  assert_false(report.reduced);
}

static void steps_after_a_restore_change_where_they_did_before(void **context) {
  fixture *f = *context;
  thrum_scene *scene = f->scenes[0];
  const size_t size = thrum_scene_snapshot_size(scene);
  unsigned char *kept = need(size, 1), *first = need(size, 1);
  run(f, 2 * EVERY);
  MUST(thrum_scene_snapshot(scene, kept, size, &failure));

  // what updates saw in between is forgotten again
  run(f, EVERY);
  MUST(thrum_scene_snapshot(scene, first, size, &failure));
  run(f, EVERY);
  MUST(thrum_scene_restore(scene, kept, size, &failure));
  run(f, EVERY);
  MUST(thrum_scene_snapshot(scene, kept, size, &failure));
  assert_memory_equal(kept, first, size);

  // another level of detail is another scene
  MUST(thrum_scene_set_detail(scene, 0, &level, &failure));
  assert_int_equal(thrum_scene_restore(scene, kept, size, &failure), THRUM_MODEL_MISMATCH);
  free(kept);
  free(first);
}

static void the_number_of_coordinates_is_its_own(void **context) {
  fixture *f = *context;
  thrum_scene *scene = f->scenes[0];
  assert_int_equal(thrum_scene_set_rank(scene, 0, 4, &failure), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_scene_set_condensed(scene, 0, 3, &failure), THRUM_INVALID_ARGUMENT);
  assert_non_null(strstr(failure.message, "level of detail"));
  MUST(thrum_scene_set_detail(scene, 0, NULL, &failure));
  MUST(thrum_scene_set_condensed(scene, 0, 3, &failure));
}

int main(void) {
#define HELD(name) cmocka_unit_test_setup_teardown(name, make_held, teardown)
  const struct CMUnitTest tests[] = {
      HELD(a_load_finds_a_still_body_awake),
      HELD(a_shaken_ground_finds_a_still_body_awake),
      HELD(a_call_that_changes_what_acts_wakes_it),
      HELD(a_pull_wakes_it),
      HELD(an_obstacle_that_comes_near_finds_it_awake),
      cmocka_unit_test_setup_teardown(a_body_that_falls_is_not_still, make_free, teardown),
      HELD(a_reset_begins_with_all_coordinates),
      HELD(steps_after_a_restore_change_where_they_did_before),
      HELD(the_number_of_coordinates_is_its_own),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
