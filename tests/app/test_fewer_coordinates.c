/* A body that swings by a tenth of its length, stepped with half and a third of its coordinates:
 * by every door of the library and the program its tip goes as far as with all of them, where the
 * same coordinates alone lock it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"
#include "thrum/scene.h"
#include "thrum/thrum.h"

enum { RANK = 24, HALF = 12, THIRD = 8, STEPS = 250 };
static const double step_length = 0.004, push = -4.0, near = 0.03;
static const thrum_model *model;
static double whole; /* m, the furthest of the tip with all coordinates */
static thrum_error failure;

#define MUST(call)                                                                                 \
  do {                                                                                             \
    if ((call) < 0)                                                                                \
      fail_msg("%s", failure.message);                                                             \
  } while (0)

/* --- the library ------------------------------------------------------------------------------ */

/* The furthest that the tip goes in a scene whose body is changed by `change` before it steps. */
static double furthest(const thrum_model *of, int64_t rank,
                       void (*change)(thrum_scene *scene, int64_t rank)) {
  thrum_scene *scene = NULL;
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = of;
  def.rank = change ? 0 : rank;
  MUST(thrum_scene_create(step_length, &scene, &failure));
  MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
  if (change)
    change(scene, rank);

  // pushed at the tip from rest
  const int32_t *tip = NULL;
  int64_t count = 0;
  MUST(thrum_model_group(of, "tip", &tip, &count, &failure));
  const thrum_scene_load_def load = {.cookie = sizeof load,
                                     .kind = THRUM_SCENE_FORCE,
                                     .vector = {0, 0, push},
                                     .vertices = tip,
                                     .count = count,
                                     .course = {.shape = THRUM_LOAD_CONSTANT, .until = INFINITY}};
  MUST(thrum_scene_add_load(scene, 0, &load, &failure));

  double far = 0;
  for (int n = 0; n < STEPS; n++) {
    double place[3];
    MUST(thrum_scene_step(scene, &failure));
    MUST(thrum_scene_body_vertex(scene, 0, tip[0], place, NULL, &failure));
    far = fmax(far, fabs(place[2] - of->vertices[3 * tip[0] + 2]));
  }
  thrum_scene_destroy(scene);
  return far;
}

static void set_rank(thrum_scene *scene, int64_t rank) {
  MUST(thrum_scene_set_rank(scene, 0, rank, &failure));
}

static int make_model(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL)
    return 1;
  program_result run =
      thrum_run(folder, "precompute", "beam:12x2x2@1x0.1x0.1", "--fix", "x<0.001", "--young", "1e6",
                "--poisson", "0.4", "--density", "1000", "--modes", "10", "--rank", "24", "--order",
                "1", "-q", "-o", "beam.npz", NULL);
  const bool made = run.exit_code == 0;
  program_result_free(&run);
  if (!made || thrum_model_load(in_folder("beam.npz"), &model, &failure) < 0)
    return 1;
  whole = furthest(model, 0, NULL);
  return 0;
}

static int free_model(void **state) {
  thrum_model_destroy(model);
  return remove_folder(state);
}

static void a_rank_of_a_body_lets_the_others_follow(void **state) {
  (void)state;
  assert_true(whole > 0.1);
  assert_true(fabs(furthest(model, RANK, NULL) - whole) == 0);
  assert_true(fabs(furthest(model, HALF, NULL) - whole) < near * whole);
  assert_true(fabs(furthest(model, THIRD, NULL) - whole) < near * whole);
}

static void a_rank_that_is_set_later_does_too(void **state) {
  (void)state;
  assert_true(fabs(furthest(model, HALF, set_rank) - whole) < near * whole);
  assert_true(fabs(furthest(model, THIRD, set_rank) - whole) < near * whole);
}

static void the_same_coordinates_alone_lock_the_body(void **state) {
  (void)state;
  size_t size = 0;
  const thrum_model *locked = NULL;
  MUST(thrum_model_lock_size(model, HALF, &size, &failure));
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_non_null(memory);
  MUST(thrum_model_lock(memory, size, model, HALF, &locked, &failure));
  assert_true(furthest(locked, 0, NULL) < 0.7 * whole);
  free(memory);
}

/* --- the program ------------------------------------------------------------------------------ */

static void expect_refused(program_result run, int code, const char *words) {
  if (!is_refusal(&run, code, words))
    fail_msg("exit %d: %s", run.exit_code, run.err);
  program_result_free(&run);
}

/* The run's furthest vertex is as far away as with all coordinates, which *all gets of the first.
 */
static void expect_near(program_result run, double *all) {
  if (run.exit_code != 0)
    fail_msg("exit %d: %s", run.exit_code, run.err);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  const cJSON *bodies = cJSON_GetObjectItem(object, "bodies");
  const double peak =
      json_value(bodies ? cJSON_GetArrayItem(bodies, 0) : object, "peak_displacement_m");
  *all = *all > 0 ? *all : peak;
  assert_true(peak > whole && fabs(peak - *all) < near * *all);
  cJSON_Delete(object);
  program_result_free(&run);
}

static void simulate_with_a_rank_lets_the_others_follow(void **state) {
  (void)state;
  static const char *const ranks[] = {"24", "12", "8"};
  double all = 0;
  for (int n = 0; n < 3; n++)
    expect_near(thrum_run(folder, "simulate", "beam.npz", "-o", "run", "--json", "-q", "--dt",
                          "0.004", "--time", "1", "--load", "constant:0,0,-4@tip", "--accept-error",
                          "100%", "--rank", ranks[n], NULL),
                &all);

  // the number is said once
  expect_refused(
      thrum_run(folder, "simulate", "beam.npz", "-o", "no", "--rank", "8", "--condense", "4", NULL),
      1, "both say how many coordinates are stepped");
}

static void a_scene_with_a_rank_lets_the_others_follow(void **state) {
  (void)state;
  static const int ranks[] = {RANK, HALF, THIRD};
  double all = 0;
  for (int n = 0; n < 3; n++) {
    char scene[256];
    snprintf(scene, sizeof scene,
             "{\"dt\": 0.004, \"time\": 1, \"outputs\": {\"accept_error\": \"100%%\"}, "
             "\"gravity\": [0, 0, 0], "
             "\"bodies\": [{\"model\": "
             "\"beam.npz\", "
             "\"rank\": %d, \"loads\": [\"constant:0,0,-4@tip\"]}]}",
             ranks[n]);
    assert_true(text_file_write(in_folder("scene.json"), scene));
    expect_near(thrum_run(folder, "simulate", "scene.json", "-o", "scene", "--json", "-q", NULL),
                &all);
  }
}

/* An equilibrium costs little with all coordinates, and is not sought in fewer. */
static void static_with_fewer_coordinates_is_refused(void **state) {
  (void)state;
  expect_refused(thrum_run(folder, "static", "beam.npz", "--rank", "12", "--load",
                           "constant:0,0,-4@tip", NULL),
                 1, "leave --rank out");
  program_result run = thrum_run(folder, "static", "beam.npz", "--rank", "24", "--load",
                                 "constant:0,0,-4@tip", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
}

/* Cubature points have no polynomial by which coordinates could follow. */
static void a_model_of_points_steps_all_of_its_coordinates(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "precompute", "beam:6x2x2@1x0.1x0.1", "--fix", "x<0.001", "--young", "1e6",
                "--poisson", "0.4", "--density", "1000", "--modes", "4", "--rank", "8",
                "--cubature", "-q", "-o", "points.npz", NULL);
  assert_true(run.exit_code == 0 || run.exit_code == 3);
  program_result_free(&run);
  expect_refused(thrum_run(folder, "simulate", "points.npz", "-o", "no", "--rank", "4", NULL), 1,
                 "the model has cubature points");

  // the library says the same
  const thrum_model *points = NULL;
  thrum_scene *scene = NULL;
  thrum_scene_body_def def = thrum_default_scene_body_def();
  MUST(thrum_model_load(in_folder("points.npz"), &points, &failure));
  MUST(thrum_scene_create(step_length, &scene, &failure));
  def.model = points;
  MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
  assert_int_equal(thrum_scene_set_rank(scene, 0, 4, &failure), THRUM_UNSUPPORTED);
  def.rank = 4;
  assert_int_equal(thrum_scene_add_body(scene, &def, NULL, &failure), THRUM_UNSUPPORTED);
  thrum_scene_destroy(scene);
  thrum_model_destroy(points);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_rank_of_a_body_lets_the_others_follow),
      cmocka_unit_test(a_rank_that_is_set_later_does_too),
      cmocka_unit_test(the_same_coordinates_alone_lock_the_body),
      cmocka_unit_test(simulate_with_a_rank_lets_the_others_follow),
      cmocka_unit_test(a_scene_with_a_rank_lets_the_others_follow),
      cmocka_unit_test(static_with_fewer_coordinates_is_refused),
      cmocka_unit_test(a_model_of_points_steps_all_of_its_coordinates),
  };
  return cmocka_run_group_tests(tests, make_model, free_model);
}
