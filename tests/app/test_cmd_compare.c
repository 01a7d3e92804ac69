/* `thrum compare`: a run is no way from itself, a shift and a turn are found as they are, and the
 * runs of a spinning body with shorter and shorter steps come together as their integrator's order
 * says. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/support/test_folder.h"

/* A free bar that spins and is thrown; %s: its place, turn and coupling, and what else there is. */
static const char scene_text[] =
    "{\"dt\": 0.004, \"time\": 0.4, \"gravity\": [0, 0, -9.81], \"outputs\": {\"plots\": false},"
    " \"bodies\": [{\"name\": \"bar\", \"model\": \"free.npz\", \"free\": true,"
    " \"stiffness\": 0.2, %s}%s]}";

/* Runs the scene into `out` with this step. */
static void run_scene(const char *body, const char *others, const char *dt, const char *out) {
  char text[1000];
  snprintf(text, sizeof text, scene_text, body, others);
  assert_true(text_file_write(in_folder("scene.json"), text));
  program_result run =
      thrum_run(folder, "simulate", "scene.json", "-o", out, "--dt", dt, "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  program_result_free(&run);
}

#define SPIN "\"velocity\": [1, 0, 2], \"spin\": [40, 500, 200]"

static int make_runs(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL || !precompute_beam("6x2x2@1x0.2x0.3", "4", "7"))
    return -1;
  program_result run = thrum_run(folder, "precompute", "beam:6x2x2@0.6x0.1x0.1,split=6", "--order",
                                 "1", "-o", "free.npz", "--modes", "6", "--rank", "16", "-q", NULL);
  const int code = run.exit_code;
  program_result_free(&run);

  // the scene of a coupled bar with three steps, and without the coupling
  run_scene(SPIN ", \"coupled\": true", "", "0.002", "whole");
  run_scene(SPIN ", \"coupled\": true", "", "0.001", "half");
  run_scene(SPIN ", \"coupled\": true", "", "0.0005", "quarter");
  run_scene(SPIN ", \"coupled\": false", "", "0.0005", "without");
  return code;
}

/* Returns the JSON that compare prints of two runs; the caller deletes it. */
static cJSON *compare(const char *left, const char *right) {
  program_result run = thrum_run(folder, "compare", left, right, "--json", NULL);
  if (run.exit_code != 0)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  assert_string_equal(run.err, "");
  cJSON *object = json_line(run.out);
  program_result_free(&run);
  return object;
}

/* The same of the first body. */
static const cJSON *first_body(const cJSON *object) {
  return cJSON_GetArrayItem(cJSON_GetObjectItem(object, "bodies"), 0);
}

static void a_run_is_no_way_from_itself(void **state) {
  (void)state;
  static const char *const zero[] = {"apart_m", "apart_share", "end_m",   "largest_m",
                                     "shape_m", "turn_deg",    "energy_j"};
  cJSON *object = compare("half", "half");
  const cJSON *body = first_body(object);
  for (size_t n = 0; n < sizeof zero / sizeof zero[0]; n++)
    assert_true(json_value(body, zero[n]) == 0);
  assert_true(json_value(body, "moments") == 401);
  assert_true(json_value(body, "moved_m") > 0.1);
  assert_true(cJSON_IsNull(cJSON_GetObjectItem(body, "largest_vertex")));
  cJSON_Delete(object);
}

/* The error of energy is C h^2: runs with h and h/2 are four times as far apart as with h/2, h/4.
 */
static void runs_of_a_coupled_body_come_together_by_order_two(void **state) {
  (void)state;
  cJSON *far = compare("whole", "half"), *near = compare("half", "quarter");
  assert_true(json_value(first_body(far), "moments") == 201);
  assert_true(json_value(first_body(near), "moments") == 401);
  const char *const keys[] = {"apart_m", "end_m"};
  for (int n = 0; n < 2; n++) {
    const double ratio =
        json_value(first_body(far), keys[n]) / json_value(first_body(near), keys[n]);
    if (!(ratio > 3.6 && ratio < 4.4))
      fail_msg("%s: %g times", keys[n], ratio);
  }
  cJSON_Delete(far);
  cJSON_Delete(near);
}

/* Without coupling the spin strains nothing; with it, it does, by far more than steps err. */
static void coupling_is_seen_in_the_shape(void **state) {
  (void)state;
  cJSON *object = compare("quarter", "without"), *steps = compare("quarter", "half");
  const cJSON *body = first_body(object);
  const double shape = json_value(body, "shape_m");
  assert_true(shape > 20 * json_value(first_body(steps), "shape_m"));
  assert_true(shape > 1e-5);
  assert_true(json_value(body, "turn_deg") > 0);
  cJSON_Delete(object);
  cJSON_Delete(steps);
}

static void shifts_and_turns_are_found(void **state) {
  (void)state;
  run_scene(SPIN ", \"position\": [0, 0.3, 0.4]", "", "0.004", "shifted");
  run_scene(SPIN, "", "0.004", "placed");
  cJSON *object = compare("shifted", "placed");
  const cJSON *body = first_body(object);
  assert_true(fabs(json_value(body, "apart_m") - 0.5) < 1e-12);
  assert_true(fabs(json_value(body, "largest_m") - 0.5) < 1e-12);
  assert_true(json_value(body, "shape_m") < 1e-12);
  assert_true(json_value(body, "turn_deg") < 1e-6);
  cJSON_Delete(object);

  // a body that falls without spin keeps its turn
  run_scene("\"rotation\": {\"axis\": [1, 2, 3], \"angle\": 10}", "", "0.004", "turned");
  run_scene("\"position\": [0, 0, 0]", "", "0.004", "straight");
  object = compare("turned", "straight");
  assert_true(fabs(json_value(first_body(object), "turn_deg") - 10) < 1e-9);
  cJSON_Delete(object);
}

/* Bodies go together by their names; those of one run alone are counted. */
static void bodies_go_together_by_their_names(void **state) {
  (void)state;
  run_scene(
      SPIN,
      ", {\"name\": \"other\", \"model\": \"free.npz\", \"free\": true, \"position\": [3, 0, 0]}",
      "0.004", "two");
  cJSON *object = compare("two", "placed");
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(object, "bodies")), 1);
  assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(first_body(object), "name")), "bar");
  assert_true(json_value(object, "bodies_alone") == 1);
  cJSON_Delete(object);

  // the folder of a body is a run of its own
  object = compare("two/bar", "placed/bar");
  assert_true(json_value(first_body(object), "apart_m") < 1e-9);
  cJSON_Delete(object);
}

/* Runs of one model with two integrators, and as a table. */
static void runs_of_a_model_are_compared(void **state) {
  (void)state;
  static const char *const integrators[] = {"energy", "newmark"};
  for (int n = 0; n < 2; n++) {
    program_result run =
        thrum_run(folder, "simulate", "beam.npz", "-o", integrators[n], "--time", "0.3", "--start",
                  "mode:1,0.1", "--integrator", integrators[n], "-q", NULL);
    assert_int_equal(run.exit_code, 0);
    program_result_free(&run);
  }
  program_result run = thrum_run(folder, "compare", "energy", "newmark", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.out, "energy with newmark, at 101 times from 0 to 0.3 s"));
  assert_non_null(strstr(run.out, "stepped by   energy, and newmark"));
  program_result_free(&run);
}

/* The rows of a run of the whole mesh lack what the basis lacks, which the table says. */
static void a_run_of_the_whole_mesh_is_told(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "simulate", "beam.npz", "-o", "mesh", "--full", "--time",
                                 "0.03", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "compare", "energy", "mesh", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.out, "what the basis of its model has of the motion"));
  program_result_free(&run);

  // it stays at rest, so nothing is measured by its way
  cJSON *object = compare("energy", "mesh");
  const cJSON *body = first_body(object);
  assert_true(cJSON_IsFalse(cJSON_GetObjectItem(body, "full")));
  assert_true(cJSON_IsTrue(cJSON_GetObjectItem(body, "other_full")));
  assert_true(cJSON_IsNull(cJSON_GetObjectItem(body, "apart_share")));
  cJSON_Delete(object);

  // a blow gives the mesh what the basis cannot take
  const char *const names[] = {"struck", "struck_mesh"};
  for (int n = 0; n < 2; n++) {
    run =
        thrum_run(folder, "simulate", "beam.npz", "-o", names[n], "--load", "impulse:0,0,-1@tip",
                  "--time", "0.03", "--accept-error", "100%", "-q", n == 1 ? "--full" : NULL, NULL);
    program_result_free(&run);
  }
  object = compare("struck", "struck_mesh");
  const double taken = json_value(first_body(object), "load_work_j");
  assert_true(taken > 0 && taken < 0.9 * json_value(first_body(object), "other_load_work_j"));
  cJSON_Delete(object);
}

static void runs_that_do_not_go_together_are_refused(void **state) {
  (void)state;

  // a run that has the start alone in common with the others
  program_result run =
      thrum_run(folder, "simulate", "beam.npz", "-o", "end", "--time", "0.31", "--dt", "0.031",
                "--record-every", "10", "-q", "--start", "mode:1,0.01", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // each pair is refused in one line, and nothing is printed
  const struct {
    const char *left, *right, *words;
    int code;
  } cases[] = {
      {"half", NULL, "two runs", 2},
      {"half", "free.npz", "no folder of a finished run", 1},
      {"nothing", "half", "no folder of a finished run", 1},
      {"half", "energy", "is the run of a scene and energy that of a model", 1},
      {"half/bar", "energy", "other vertices", 1},
      {"energy", "end", "1 common time:", 1},
  };
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    run = thrum_run(folder, "compare", cases[n].left, cases[n].right, NULL);
    if (run.exit_code != cases[n].code || !strstr(run.err, cases[n].words) ||
        !line_count_is(run.err, 1) || run.out[0] != 0)
      fail_msg("case %d: exit %d, %s", (int)n, run.exit_code, run.err);
    program_result_free(&run);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_run_is_no_way_from_itself),
      cmocka_unit_test(runs_of_a_coupled_body_come_together_by_order_two),
      cmocka_unit_test(coupling_is_seen_in_the_shape),
      cmocka_unit_test(shifts_and_turns_are_found),
      cmocka_unit_test(bodies_go_together_by_their_names),
      cmocka_unit_test(runs_of_a_model_are_compared),
      cmocka_unit_test(a_run_of_the_whole_mesh_is_told),
      cmocka_unit_test(runs_that_do_not_go_together_are_refused),
  };
  return cmocka_run_group_tests(tests, make_runs, remove_folder);
}
