/* Tests of actuators as commands: precompute, info, simulate and static, reduced and of the mesh.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/support/program_object.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

#define WIRE "wire=tendon:near:0,0,0.05,near:0.5,0,0.05,near:1,0,0.05"

static int make_model(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL)
    return 1;
  program_result run =
      thrum_run(folder, "precompute", "beam:8x1x1@1x0.1x0.1", "--fix", "x<0.001", "--young", "1e6",
                "--order", "2", "--modes", "4", "--rank", "8", "--actuator", WIRE, "--actuator",
                "heat=swell:all", "--actuator", "lean=muscle:1,1,0,1", "-o", "arm.npz", "-q", NULL);
  const int code = run.exit_code;
  if (code != 0)
    print_error("%s", run.err);
  program_result_free(&run);
  return code;
}

static void info_lists_what_acts(void **state) {
  (void)state;
  cJSON *object = program_object(thrum_run(folder, "info", "arm.npz", "--json", NULL), 0);
  const cJSON *list = cJSON_GetObjectItemCaseSensitive(object, "actuators");
  assert_int_equal(cJSON_GetArraySize(list), 3);
  for (int n = 0; n < 3; n++)
    assert_true(fabs(json_value(cJSON_GetArrayItem(list, n), "static_share") - 1) < 1e-9);
  assert_true(fabs(json_value(cJSON_GetArrayItem(list, 0), "at_rest") - 1) < 1e-9);
  assert_int_equal(json_value(object, "rank"), 8 + 2 * 3);
  cJSON_Delete(object);
  program_result run = thrum_run(folder, "info", "arm.npz", NULL);
  assert_non_null(strstr(run.out, "heat=swell:all"));
  assert_non_null(strstr(run.out, "lean=muscle:1,1,0,1"));
  program_result_free(&run);
}

static void a_run_has_the_work_of_its_actuators(void **state) {
  (void)state;
  cJSON *object = program_object(thrum_run(folder, "simulate", "arm.npz", "-o", "run", "--time",
                                           "0.6", "--actuate", "wire=ramp:20,until=0.3",
                                           "--actuate", "lean=sine:0.02,f=3", "--json", "-q", NULL),
                                 0);
  const cJSON *work = cJSON_GetObjectItemCaseSensitive(object, "work");
  const double done = json_value(work, "actuators_j");
  assert_true(done > 0);
  assert_true(fabs(done - json_value(object, "energy_last_j")) < 1e-11 * done);
  assert_true(fabs(json_value(work, "balance_j")) < 1e-11 * done);
  cJSON_Delete(object);
}

/* The run of a body of a scene. */
static cJSON *run_of(const char *path) {
  char *text = text_file_read(in_folder(path));
  assert_non_null(text);
  cJSON *object = cJSON_Parse(text);
  assert_non_null(object);
  free(text);
  return object;
}

/* A body of a scene works as one that is run alone, and where it touches, what it lost is said. */
static void bodies_of_scenes_act(void **state) {
  (void)state;
  assert_true(text_file_write(
      in_folder("scene.json"),
      "{\"dt\": 0.003, \"time\": 0.6, \"bodies\": [{\"name\": \"free\", \"model\": \"arm.npz\", "
      "\"position\": [0, 0, 5], \"actuate\": [\"wire=ramp:20,until=0.3\", "
      "\"lean=sine:0.02,f=3\"]}, "
      "{\"name\": \"low\", \"model\": \"arm.npz\", \"actuate\": [\"wire=ramp:20,until=0.3\", "
      "\"lean=sine:0.02,f=3\"]}], \"obstacles\": [{\"shape\": \"plane\", \"centre\": [0, 0, "
      "-0.051]}]}"));
  cJSON *scene = program_object(
      thrum_run(folder, "simulate", "scene.json", "-o", "scene", "--json", "-q", NULL), 0);
  cJSON *alone =
      program_object(thrum_run(folder, "simulate", "arm.npz", "-o", "alone", "--dt", "0.003",
                               "--time", "0.6", "--actuate", "wire=ramp:20,until=0.3", "--actuate",
                               "lean=sine:0.02,f=3", "--json", "-q", NULL),
                     0);
  cJSON *free_run = run_of("scene/free/run.json"), *low = run_of("scene/low/run.json");
  const cJSON *work = cJSON_GetObjectItemCaseSensitive(low, "work");
  const double expected =
      json_value(cJSON_GetObjectItemCaseSensitive(alone, "work"), "actuators_j");
  assert_true(json_value(cJSON_GetObjectItemCaseSensitive(free_run, "work"), "actuators_j") ==
              expected);
  const cJSON *contact = cJSON_GetObjectItemCaseSensitive(low, "contact");
  const double lost = json_value(contact, "lost_j"), done = json_value(work, "actuators_j");
  assert_true(lost > 1e-6 && done > lost);
  assert_true(fabs(json_value(low, "energy_last_j") + json_value(contact, "stored_j") + lost -
                   done) < 1e-10 * done);
  cJSON_Delete(scene);
  cJSON_Delete(alone);
  cJSON_Delete(free_run);
  cJSON_Delete(low);
}

/* The tip of an answer, and its height. */
static double height_of(const cJSON *object) {
  const cJSON *shown =
      cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(object, "displacements"), 0);
  return cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(shown, "mean_m"), 2)->valuedouble;
}

static void the_mesh_comes_to_rest_where_the_model_does(void **state) {
  (void)state;
  double height[2];
  for (int full = 0; full < 2; full++) {
    cJSON *object =
        program_object(thrum_run(folder, "static", "arm.npz", "--actuate", "lean=constant:-0.01",
                                 "--at", "tip", "--json", full ? "--full" : NULL, NULL),
                       0);
    height[full] = height_of(object);
    cJSON_Delete(object);
  }
  assert_true(height[1] > 0.005);
  assert_true(fabs(height[0] / height[1] - 1) < 0.01);
}

static void what_is_no_actuation_is_refused(void **state) {
  (void)state;
  static const struct {
    const char *text, *why;
    int code;
  } bad[] = {{"wir=constant:1", "no actuator 'wir'; the first of 3 is 'wire'", 1},
             {"wire=often:1", "wanted is constant:LEVEL", 2},
             {"wire=sine:1", "frequency", 2},
             {"wire=constant:much", "is not a number", 2},
             {"wire", "NAME=KIND:LEVEL", 2}};
  for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
    program_result run =
        thrum_run(folder, "simulate", "arm.npz", "-o", "none", "--actuate", bad[n].text, NULL);
    assert_int_equal(run.exit_code, bad[n].code);
    if (!strstr(run.err, bad[n].why))
      fail_msg("%s: %s", bad[n].text, run.err);
    program_result_free(&run);
  }
  program_result run = thrum_run(folder, "precompute", "beam:2x1x1@1x0.1x0.1", "-o", "none.npz",
                                 "--actuator", "a=chamber:tip", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "--actuator: 'a=chamber:tip': the surface is open"));
  program_result_free(&run);
  run = thrum_run(folder, "precompute", "beam:2x1x1@1x0.1x0.1", "--fix", "x<0.001", "--order", "1",
                  "--modes", "2", "-o", "none.npz", "-q", "--actuator", "a=gas:right,cap", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "'a=gas:right,cap': its surface encloses nothing"));
  program_result_free(&run);
}

/* Levels that no step sees are named, and coordinates that only follow are no place to act on. */
static void what_has_no_effect_is_said(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "simulate", "arm.npz", "-o", "late", "--time", "0.01",
                                 "--actuate", "wire=constant:1,from=3", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "the level 'wire=constant:1,from=3' begins at 3 s"));
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "arm.npz", "-o", "few", "--rank", "4", "--actuate",
                  "wire=constant:1", "-q", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "leave --rank and --condense out"));
  assert_false(file_exists(in_folder("few")));
  program_result_free(&run);

  // a rope from outside pulls at a free body as a whole
  run = thrum_run(folder, "precompute", "beam:2x1x1@1x0.1x0.1", "--order", "1", "--modes", "2",
                  "--actuator", "rope=tendon:at:0,0,5,near:1,0,0.05", "-o", "free.npz", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "free.npz", "-o", "pulled", "--time", "0.01", "--actuate",
                  "rope=constant:1", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "what a rope would move it by as a whole has no effect"));
  program_result_free(&run);
}

static void three_of(const cJSON *object, const char *key, double values[3]) {
  const cJSON *list = cJSON_GetObjectItemCaseSensitive(object, key);
  for (int axis = 0; axis < 3; axis++)
    values[axis] = cJSON_GetArrayItem(list, axis)->valuedouble;
}

/* Theorem: a pressure p on a surface whose edge is held pushes by p times the area within the edge,
 * whatever its shape; what holds the edge bears all of it. A rope to a place that stays pulls at
 * the body as a whole. */
static void what_holds_a_body_bears_what_acts(void **state) {
  (void)state;
  static const char *const acts[2][2] = {
      {"push=pressure:back", "push=constant:50"},
      {"rope=tendon:at:0.05,0.3,0,near:0.05,0.005,0", "rope=constant:0.5"}};
  for (int n = 0; n < 2; n++) {
    program_result run = thrum_run(folder, "precompute", "beam:4x1x4@0.1x0.01x0.1", "--order", "1",
                                   "--fix", "x<1e-6", "--fix", "x>0.09999", "--fix", "z<-0.04999",
                                   "--fix", "z>0.04999", "--young", "1e5", "--modes", "2",
                                   "--actuator", acts[n][0], "-o", "plate.npz", "-q", NULL);
    assert_int_equal(run.exit_code, 0);
    program_result_free(&run);
    for (int full = 0; full < 2; full++) {
      double force[3], load[3];
      cJSON *object =
          program_object(thrum_run(folder, "static", "plate.npz", "--actuate", acts[n][1], "--json",
                                   "--accept-error", "100%", "-q", full ? "--full" : NULL, NULL),
                         0);
      const cJSON *found = cJSON_GetObjectItemCaseSensitive(object, "reactions");
      three_of(found, "force_n", force);
      three_of(found, "load_force_n", load);
      assert_true(fabs(load[1] / (n ? 0.5 : -0.5) - 1) < (n ? 1e-3 : 1e-12));
      assert_true(fabs(force[1] / load[1] + 1) < (full ? 1e-9 : 0.1));
      assert_true(!full || json_value(found, "imbalance_share") < 1e-9);
      cJSON_Delete(object);
    }
  }
}

/* A gas acts at level 0 as well: static has it without --actuate, and what would leave it out is
 * refused. */
static void a_gas_is_never_left_out(void **state) {
  (void)state;
  static const char box[] =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
      "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  FILE *file = fopen(in_folder("box.obj"), "w");
  assert_non_null(file);
  fputs(box, file);
  assert_int_equal(fclose(file), 0);
  program_result run =
      thrum_run(folder, "mesh", "box.obj", "--thickness", "0.1", "-o", "box.inp", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "precompute", "box.inp", "--element", "tet", "--order", "1", "--fix",
                  "x<0.1", "--young", "1e5", "--poisson", "0.3", "--density", "1000", "--modes",
                  "4", "--rank", "8", "--actuator", "lid=gas:bottom,outside=1e6", "-o", "gas.npz",
                  "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // told or not, it is the same body
  double heights[2];
  for (int n = 0; n < 2; n++) {
    cJSON *object =
        program_object(thrum_run(folder, "static", "gas.npz", "--load",
                                 "constant:0,0,-200@near:1,1,1", "--accept-error", "100%", "--json",
                                 "-q", n ? "--actuate" : NULL, "lid=constant:0", NULL),
                       0);
    heights[n] = height_of(object);
    cJSON_Delete(object);
  }
  assert_true(heights[0] < 0 && fabs(heights[0] / heights[1] - 1) < 1e-9);

  // the mesh, whose tangent has not all of the gas, loses no branch
  run = thrum_run(folder, "precompute", "box.inp", "--element", "tet", "--order", "1", "--fix",
                  "x<0.1", "--young", "1e5", "--poisson", "0.3", "--density", "1000", "--modes",
                  "2", "--actuator", "lid=gas:bottom,outside=3e4", "-o", "soft.npz", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  cJSON *whole =
      program_object(thrum_run(folder, "static", "soft.npz", "--load",
                               "constant:0,0,-200@near:1,1,1", "--full", "--json", "-q", NULL),
                     0);
  assert_true(cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(whole, "lost_factor")));
  cJSON_Delete(whole);

  const char *const others[3][4] = {{"response", "gas.npz", "--mode", "1"},
                                    {"export", "gas.npz", "--numpy", "gas.py"},
                                    {"simulate", "gas.npz", "--condense=4", "--output=left"}};
  for (int n = 0; n < 3; n++) {
    run = thrum_run(folder, others[n][0], others[n][1], others[n][2], others[n][3], NULL);
    assert_int_equal(run.exit_code, 1);
    assert_non_null(strstr(run.err, "the model has a gas"));
    program_result_free(&run);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(info_lists_what_acts),
      cmocka_unit_test(a_run_has_the_work_of_its_actuators),
      cmocka_unit_test(bodies_of_scenes_act),
      cmocka_unit_test(the_mesh_comes_to_rest_where_the_model_does),
      cmocka_unit_test(what_has_no_effect_is_said),
      cmocka_unit_test(what_holds_a_body_bears_what_acts),
      cmocka_unit_test(a_gas_is_never_left_out),
      cmocka_unit_test(what_is_no_actuation_is_refused),
  };
  return cmocka_run_group_tests(tests, make_model, remove_folder);
}
