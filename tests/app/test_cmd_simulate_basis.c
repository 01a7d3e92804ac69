/* `thrum simulate` judges the basis of a run: the estimate is near what the whole mesh does
 * otherwise and below it, a sound run has a small one, and what cannot be judged is told.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

/* A slender beam whose five modes, all of bending, leave out how it shortens as it bends; and the
 * same with its modes' derivatives. */
static int make_models(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL)
    return 1;
  static const char *const ranks[2][3] = {{"poor.npz", "5", "5"}, {"good.npz", "5", "20"}};
  for (int n = 0; n < 2; n++) {
    program_result run =
        thrum_run(folder, "precompute", "beam:20x1x1@1x0.04x0.04", "--order", "2", "--fix",
                  "x<1e-9", "--young", "1e7", "--poisson", "0", "--density", "1000", "--modes",
                  ranks[n][1], "--rank", ranks[n][2], "-o", ranks[n][0], "-q", NULL);
    const int code = run.exit_code;
    program_result_free(&run);
    if (code != 0)
      return code;
  }
  return 0;
}

#define BEND "--time", "0.6", "--load", "constant:0,0,-0.4@right"

static const cJSON *member(const cJSON *object, const char *key) {
  const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
  assert_non_null(item);
  return item;
}

/* Simulates with one more option, or none; the exit code must be `code`. The caller deletes. */
static cJSON *bend(const char *model, const char *option, const char *value, int code) {
  program_result run =
      thrum_run(folder, "simulate", model, "-o", "run", "--json", "-q", BEND, option, value, NULL);
  if (run.exit_code != code)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  assert_true((code == 3) == (strstr(run.err, "the basis cannot show this motion") != NULL));
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

/* A blow gives the mesh more than the basis takes: both are said, and are what runs of both do. The
 * blow lasts three steps, so that the mesh's has more than one. */
static void what_a_basis_takes_of_a_blow_is_said(void **state) {
  (void)state;
  double said[2] = {0}, done[2];
  for (int full = 0; full < 2; full++) {
    program_result run =
        thrum_run(folder, "simulate", "good.npz", "-o", "blow", "--json", "-q", "--dt", "0.001",
                  "--time", "0.006", "--load", "impulse:0,0,-1@right", "--accept-error", "100%",
                  full ? "--full" : NULL, NULL);
    cJSON *object = json_line(run.out);
    const cJSON *work = member(object, "work");
    done[full] = json_value(work, "load_j");
    if (full == 0) {
      said[0] = json_value(work, "blow_basis_j");
      said[1] = json_value(work, "blow_mesh_j");
    }
    cJSON_Delete(object);
    program_result_free(&run);
  }
  assert_true(said[0] > 0 && said[0] < 0.9 * said[1]);
  assert_true(fabs(done[0] / said[0] - 1) < 0.05 && fabs(done[1] / said[1] - 1) < 0.05);
}

/* What thrum compare finds between the model and its mesh. */
static double true_share(const char *model) {
  program_result full =
      thrum_run(folder, "simulate", model, "--full", "-o", "full", "-q", BEND, NULL);
  program_result half = thrum_run(folder, "simulate", model, "-o", "half", "-q", BEND, NULL);
  assert_int_equal(full.exit_code, 0);
  program_result both = thrum_run(folder, "compare", "half", "full", "--json", NULL);
  cJSON *object = json_line(both.out);
  assert_non_null(object);
  const double share = json_value(cJSON_GetArrayItem(member(object, "bodies"), 0), "apart_share");
  cJSON_Delete(object);
  program_result_free(&full);
  program_result_free(&half);
  program_result_free(&both);
  return share;
}

static void a_basis_without_derivatives_is_flagged_by_what_the_mesh_does(void **state) {
  (void)state;
  cJSON *object = bend("poor.npz", NULL, NULL, 3);
  const cJSON *estimate = member(object, "error_estimate");
  assert_string_equal(member(object, "status")->valuestring, "basis_wrong");
  assert_string_equal(member(estimate, "kind")->valuestring, "at least");
  assert_true(json_value(estimate, "added") > 0);

  // the richer run is nearly what the mesh does
  const double said = json_value(estimate, "share"), found = true_share("poor.npz");
  print_message("said %.4f, found %.4f\n", said, found);
  assert_true(found > 0.1 && said > 0.8 * found && said < 1.1 * found);
  cJSON_Delete(object);

  // as it is accepted, or not looked at, the run is done
  cJSON_Delete(bend("poor.npz", "--accept-error", "100%", 0));
  object = bend("poor.npz", "--judge", "off", 0);
  assert_true(cJSON_IsNull(member(member(object, "error_estimate"), "share")));
  cJSON_Delete(object);
  object = bend("poor.npz", "--monitor", "off", 0);
  assert_true(cJSON_IsNull(member(object, "error_estimate")));
  cJSON_Delete(object);
}

static void a_sound_run_is_not_flagged(void **state) {
  (void)state;
  cJSON *object = bend("good.npz", NULL, NULL, 0);
  const double said = json_value(member(object, "error_estimate"), "share");
  const double found = true_share("good.npz");
  print_message("said %.4f, found %.4f\n", said, found);
  assert_true(found < 0.05 && said > 0.3 * found && said < 0.05);
  cJSON_Delete(object);
}

/* Explicit steps and other laws have the residual of the mesh alone. */
static void what_cannot_run_again_is_judged_by_its_residual(void **state) {
  (void)state;
  cJSON *object = bend("poor.npz", "--integrator", "verlet", 3);
  const cJSON *estimate = member(object, "error_estimate");
  assert_string_equal(member(estimate, "by")->valuestring, "residual");
  assert_true(json_value(estimate, "added") == 0 && json_value(estimate, "instants") > 3);
  cJSON_Delete(object);
}

static void the_mesh_beside_the_model_finds_the_error_itself(void **state) {
  (void)state;
  cJSON *object = bend("good.npz", "--against-mesh", "10min", 0);
  const cJSON *against = member(object, "against_mesh");
  const double found = json_value(against, "displacement_share"), other = true_share("good.npz");
  assert_true(cJSON_IsTrue(member(against, "whole")));
  assert_true(json_value(against, "simulated_s") == json_value(object, "simulated_s"));

  // thrum compare sees the mesh through the basis alone, and so less of it
  print_message("found %.5f, through the basis %.5f\n", found, other);
  assert_true(found > 0.9 * other && found < 0.02);
  assert_true(json_value(against, "velocity_share") > found);

  // as many rows as the run has, the last with what is said
  char *rows = text_file_read(in_folder("run/against_mesh.csv"));
  assert_non_null(rows);
  assert_true(line_count_is(rows, (int)json_value(object, "rows") + 1));
  double last[8];
  const char *at = rows + strlen(rows) - 1;
  while (at > rows && at[-1] != '\n')
    at--;
  for (int n = 0; n < 8; n++) {
    char *end = NULL;
    last[n] = strtod(at, &end);
    at = end + 1;
  }
  assert_true(fabs(last[6] / found - 1) < 1e-12 &&
              fabs(last[7] / json_value(against, "velocity_share") - 1) < 1e-12);
  free(rows);
  cJSON_Delete(object);

  // a basis that is wrong is flagged by what was found
  program_result run = thrum_run(folder, "simulate", "poor.npz", "-o", "run", "-q", BEND,
                                 "--against-mesh", "600", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.err, "of the displacement is wrong, beside the whole mesh"));
  program_result_free(&run);
}

/* How the run is stepped and damped has an error of its own, which neither the mesh beside the
 * model nor the run made again may take for one of the basis: both agree on that. */
static void a_method_is_no_error_of_the_basis(void **state) {
  (void)state;
  static const char *const methods[][6] = {
      {"--dt", "0.02"},
      {"--dt", "0.02", "--integrator", "imexv"},
      {"--dt", "0.02", "--integrator", "manifold", "--rank", "10"},
      {"--dt", "0.01", "--damping-form", "tangent", "--damping", "0,0.02"}};
  for (size_t n = 0; n < sizeof methods / sizeof methods[0]; n++) {
    const char *const *m = methods[n];
    program_result run =
        thrum_run(folder, "simulate", "good.npz", "-o", "run", "--json", "-q", BEND,
                  "--against-mesh", "600", m[0], m[1], m[2], m[3], m[4], m[5], NULL);
    if (run.exit_code != 0)
      fail_msg("%s %s: exit code %d: %s", m[2], m[3], run.exit_code, run.err);
    cJSON *object = json_line(run.out);
    assert_non_null(object);
    const double said = json_value(member(object, "error_estimate"), "share");
    const double found = json_value(member(object, "against_mesh"), "displacement_share");
    print_message("said %.5f, found %.5f\n", said, found);
    assert_true(found < 0.005 && said > 0.8 * found && said < 1.25 * found);
    cJSON_Delete(object);
    program_result_free(&run);
  }
}

/* What left all bounds by its time step says nothing of the basis, and neither does what falls or
 * rests. */
static void what_has_no_motion_to_judge_is_told(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "simulate", "good.npz", "-o", "run", "--json", "-q", BEND,
                                 "--integrator", "verlet", "--dt", "0.005", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_null(strstr(run.err, "the basis"));
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  assert_string_equal(member(object, "status")->valuestring, "not_finite");
  assert_string_equal(member(member(object, "error_estimate"), "kind")->valuestring, "not judged");
  cJSON_Delete(object);
  program_result_free(&run);

  // a free body falls without a strain, but for rounding
  run = thrum_run(folder, "precompute", "beam:12x2x2@1x0.02x0.02", "-o", "falls.npz", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "falls.npz", "-o", "run", "--json", "-q", "--time", "0.1",
                  "--load", "gravity:1,2,-9.81", NULL);
  assert_int_equal(run.exit_code, 0);
  object = json_line(run.out);
  assert_non_null(object);
  assert_true(json_value(member(object, "error_estimate"), "share") == 0);
  cJSON_Delete(object);
  program_result_free(&run);

  run = thrum_run(folder, "simulate", "good.npz", "-o", "run", "-q", "--time", "0.1", "--load",
                  "constant:0,0,0@right", "--against-mesh", "600", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.out, "mesh         nothing has moved"));
  assert_null(strstr(run.out, "nan"));
  program_result_free(&run);
}

/* A time that is over at once leaves the run and its estimate as they are. */
static void the_mesh_stops_when_its_time_is_over(void **state) {
  (void)state;
  cJSON *object = bend("good.npz", "--against-mesh", "1e-9", 0);
  const cJSON *against = member(object, "against_mesh");
  assert_true(cJSON_IsFalse(member(against, "whole")) && json_value(against, "steps") == 0);
  assert_string_equal(member(against, "ended")->valuestring, "the time is over");
  cJSON_Delete(object);
  program_result run = thrum_run(folder, "simulate", "good.npz", "--full", "-o", "run",
                                 "--against-mesh", "1s", NULL);
  assert_int_equal(run.exit_code, 2);
  program_result_free(&run);
}

/* Loads, base motions, starts at an equilibrium and spins are all judged; a rank of two modes is
 * wrong under each. */
static void each_kind_of_motion_is_judged(void **state) {
  (void)state;
  static const char *const motions[][2] = {{"--load", "gravity:0,0,-3"},
                                           {"--base-motion", "sine:0,0,3,f=1"},
                                           {"--start", "static:constant:0,0,-0.4@right"},
                                           {"--start", "mode:1,0.3"}};
  for (size_t n = 0; n < sizeof motions / sizeof motions[0]; n++) {
    program_result run = thrum_run(folder, "simulate", "poor.npz", "-o", "run", "--json", "-q",
                                   "--time", "0.6", motions[n][0], motions[n][1], NULL);
    if (run.exit_code != 3)
      fail_msg("%s: exit code %d: %s", motions[n][1], run.exit_code, run.out);
    program_result_free(&run);
  }

  // a free bar that stretches as it spins
  program_result made = thrum_run(folder, "precompute", "beam:8x1x1@1x0.1x0.1", "--modes", "2",
                                  "--rank", "2", "-o", "free.npz", "-q", NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);
  program_result run = thrum_run(folder, "simulate", "free.npz", "-o", "run", "-q", "--time", "0.2",
                                 "--spin", "0,0,3000", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.err, "the basis cannot show"));
  program_result_free(&run);
}

static void a_scene_judges_its_bodies(void **state) {
  (void)state;
  assert_true(text_file_write(in_folder("scene.json"),
                              "{\"time\": 0.6, \"bodies\": [{\"name\": \"poor\", \"model\": "
                              "\"poor.npz\", \"loads\": \"constant:0,0,-0.4@right\"}, {\"name\": "
                              "\"good\", \"model\": \"good.npz\", \"position\": [0, 1, 0], "
                              "\"loads\": \"constant:0,0,-0.4@right\"}]}"));
  program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "scene", "-q", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.err, "body 'poor': the basis cannot show this motion"));
  assert_null(strstr(run.err, "body 'good'"));
  program_result_free(&run);
}

/* The estimate of the first body of a scene, which the caller deletes with the rest of *object. */
static const cJSON *estimate_of(const char *scene, const char *name, int code, cJSON **object) {
  assert_true(text_file_write(in_folder("made.json"), scene));
  program_result run = thrum_run(folder, "simulate", "made.json", "-o", name, "--json", "-q", NULL);
  if (run.exit_code != code)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  *object = json_line(run.out);
  assert_non_null(*object);
  program_result_free(&run);
  return member(cJSON_GetArrayItem(member(*object, "bodies"), 0), "error_estimate");
}

/* Frames have the vertices of a body where it stands in the world, and its basis the axes of its
 * model: the basis is judged in the latter, whether there are frames or not. */
static void frames_do_not_change_how_a_turned_body_is_judged(void **state) {
  (void)state;
  double said[2];
  for (int n = 0; n < 2; n++) {
    char scene[400];
    cJSON *object;
    snprintf(scene, sizeof scene,
             "{\"time\": 0.6, \"bodies\": [{\"model\": \"poor.npz\", \"rotation\": {\"axis\": "
             "[1, 1, 0], \"angle\": 70}, \"loads\": \"constant:0,0.3,-0.4@right\"}], "
             "\"outputs\": {\"record_every\": 1%s}}",
             n > 0 ? ", \"frames\": 10" : "");
    said[n] = json_value(estimate_of(scene, "turned", 3, &object), "share");
    cJSON_Delete(object);
  }
  assert_true(said[0] == said[1]);
}

/* A floor that is never reached changes nothing: the scene made again says what the run of the body
 * alone says, and so does a body that is twice as large, of another material and turned. */
static void a_body_in_a_scene_made_again_has_the_error_that_it_has_alone(void **state) {
  (void)state;
  cJSON *object = bend("poor.npz", NULL, NULL, 3);
  const double alone = json_value(member(object, "error_estimate"), "share");
  cJSON_Delete(object);

  // forces go with stiffness and area, times with length and the root of density over stiffness
  static const char *const bodies[] = {
      "{\"time\": 0.6, \"bodies\": [{\"model\": \"poor.npz\", \"loads\": "
      "\"constant:0,0,-0.4@right\"}], \"obstacles\": [{\"shape\": \"plane\", \"centre\": "
      "[0, 0, -10]}]}",
      "{\"time\": 0.6, \"bodies\": [{\"model\": \"poor.npz\", \"scale\": 2, \"stiffness\": 8, "
      "\"density\": 2, \"rotation\": {\"axis\": [1, 0, 0], \"angle\": 90}, \"loads\": "
      "\"constant:0,12.8,0@right\"}]}"};
  for (size_t n = 0; n < sizeof bodies / sizeof bodies[0]; n++) {
    const cJSON *estimate = estimate_of(bodies[n], "again", 3, &object);
    const double said = json_value(estimate, "share");
    print_message("alone %.4f, with its scene %.4f\n", alone, said);
    assert_true(fabs(said - alone) < 0.1 * alone);
    assert_true(fabs(json_value(estimate, "until_s") - 0.6) < 1e-9);
    assert_string_equal(member(estimate, "kind")->valuestring, n == 0 ? "about" : "at least");
    cJSON_Delete(object);
  }
}

/* A beam that a moving end of a link bends, with few coordinates and with many. */
static void a_linked_body_is_judged_with_its_scene(void **state) {
  (void)state;
  static const char link[] =
      "{\"time\": 0.6, \"dt\": 0.0005, \"bodies\": [{\"name\": \"b\", \"model\": \"%s\"}], "
      "\"links\": "
      "[{\"kind\": \"ball\", \"body\": \"b\", \"at\": \"right\", \"path\": [{\"time\": 0, "
      "\"place\": [0, 0, 0]}, {\"time\": 0.5, \"place\": [0, 0, 0.4]}]}]%s}";
  char scene[600];
  cJSON *object;
  program_result made = thrum_run(folder, "precompute", "poor.npz", "--modes", "20", "--rank", "50",
                                  "-o", "rich.npz", "-q", NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);

  snprintf(scene, sizeof scene, link, "rich.npz", ", \"outputs\": {\"judge\": \"off\"}");
  const cJSON *estimate = estimate_of(scene, "rich", 0, &object);
  assert_string_equal(member(estimate, "kind")->valuestring, "not judged");
  cJSON_Delete(object);
  snprintf(scene, sizeof scene, link, "poor.npz", ", \"outputs\": {\"accept_error\": 1}");
  estimate = estimate_of(scene, "poor", 0, &object);
  const double said = json_value(estimate, "share");
  program_result both = thrum_run(folder, "compare", "poor", "rich", "--json", NULL);
  cJSON *apart = json_line(both.out);
  const double found = json_value(cJSON_GetArrayItem(member(apart, "bodies"), 0), "apart_share");
  print_message("said %.4f, found %.4f\n", said, found);
  assert_true(found > 0.1 && said > 0.7 * found && said < 1.4 * found);
  program_result_free(&both);
  cJSON_Delete(apart);
  cJSON_Delete(object);
}

/* A tilted block bounces, and what it does afterwards hangs on the last digits of how it began: the
 * comparison ends there, and says of the shape what it says of the motion as a whole apart. */
static void what_a_small_disturbance_parts_is_not_blamed_on_the_basis(void **state) {
  (void)state;
  cJSON *object;
  const cJSON *estimate = estimate_of(
      "{\"time\": 1.5, \"dt\": 0.002, \"gravity\": [0, 0, -9.81], \"bodies\": [{\"model\": "
      "\"beam:4x3x2@0.4x0.3x0.2\", \"material\": {\"young\": 4e6}, \"free\": "
      "true, \"position\": [0, 0, 0.5], \"rotation\": {\"axis\": [1, 1, 0], \"angle\": 20}}], "
      "\"obstacles\": [{\"shape\": \"plane\"}], \"outputs\": {\"judge\": \"on\", "
      "\"accept_error\": 1}}",
      "bounce", 0, &object);
  if (cJSON_IsNull(member(estimate, "share")))
    fail_msg("not judged: %s", member(estimate, "why")->valuestring);
  assert_true(json_value(estimate, "until_s") < 1.4);
  assert_true(json_value(estimate, "shape_share") > json_value(estimate, "share"));
  cJSON_Delete(object);

  // the table says where it ends, and why
  program_result run = thrum_run(folder, "simulate", "made.json", "-o", "bounce", "-q", NULL);
  assert_non_null(strstr(run.out, " % of the velocity\n             known up to "));
  assert_non_null(strstr(run.out, " s of 1.5 s: beyond it the motion hangs on the last digits\n"));
  program_result_free(&run);
}

/* A block that falls freely keeps its shape: what rounding leaves of it is not wrong by a share. */
/* How the mesh follows a blow at rest hinders the bending after it: with such directions the run
 * again was 22 % off where the mesh is 5 %. */
static void a_blow_is_judged_by_the_motion_after_it(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "simulate", "good.npz", "-o", "struck", "--time", "0.6", "--load",
                "impulse:0,0,-64@right", "--against-mesh", "60s", "--json", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  const cJSON *estimate = member(object, "error_estimate");
  const double said = json_value(estimate, "share");
  const double found = json_value(member(object, "against_mesh"), "displacement_share");
  print_message("said %.3g, found %.3g\n", said, found);
  assert_true(found > 0.03 && said > 0.5 * found && said < 2 * found);
  assert_string_equal(member(estimate, "kind")->valuestring, "about");
  cJSON_Delete(object);
  program_result_free(&run);
}

static void a_shape_of_rounding_is_not_judged(void **state) {
  (void)state;
  cJSON *object;
  const cJSON *estimate = estimate_of(
      "{\"time\": 0.1, \"dt\": 0.002, \"gravity\": [0, 0, -9.81], \"bodies\": [{\"model\": "
      "\"beam:4x3x2@0.4x0.3x0.2\", \"free\": true, \"position\": [0, 0, 5]}], \"obstacles\": "
      "[{\"shape\": \"plane\"}]}",
      "fall", 0, &object);
  assert_true(json_value(estimate, "share") < 1e-9);
  assert_true(cJSON_IsNull(member(estimate, "shape_share")));
  cJSON_Delete(object);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_a_basis_takes_of_a_blow_is_said),
      cmocka_unit_test(a_basis_without_derivatives_is_flagged_by_what_the_mesh_does),
      cmocka_unit_test(a_sound_run_is_not_flagged),
      cmocka_unit_test(what_cannot_run_again_is_judged_by_its_residual),
      cmocka_unit_test(the_mesh_beside_the_model_finds_the_error_itself),
      cmocka_unit_test(a_method_is_no_error_of_the_basis),
      cmocka_unit_test(what_has_no_motion_to_judge_is_told),
      cmocka_unit_test(the_mesh_stops_when_its_time_is_over),
      cmocka_unit_test(each_kind_of_motion_is_judged),
      cmocka_unit_test(a_scene_judges_its_bodies),
      cmocka_unit_test(a_body_in_a_scene_made_again_has_the_error_that_it_has_alone),
      cmocka_unit_test(frames_do_not_change_how_a_turned_body_is_judged),
      cmocka_unit_test(a_linked_body_is_judged_with_its_scene),
      cmocka_unit_test(what_a_small_disturbance_parts_is_not_blamed_on_the_basis),
      cmocka_unit_test(a_blow_is_judged_by_the_motion_after_it),
      cmocka_unit_test(a_shape_of_rounding_is_not_judged),
  };
  return cmocka_run_group_tests(tests, make_models, NULL);
}
