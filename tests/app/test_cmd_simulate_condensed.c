/* `thrum simulate --condense`: it is near the whole model and shows all coordinates, a scene does
 * the same, and what it leaves out is said. SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "io/npy_file.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

enum { RANK = 15 };

static int make_models(void **state) {
  (void)state;
  static const double kick[2 * RANK] = {[RANK] = 0.3}, far[2 * RANK] = {[RANK] = 1.6};
  return test_folder_make(folder) == NULL || !precompute_beam("12x2x2@1x0.1x0.1", "6", "15") ||
         !save_npy(in_folder("kick.npy"), kick, 2, RANK) ||
         !save_npy(in_folder("far.npy"), far, 2, RANK);
}

/* Simulates into `run_name`; the caller frees the JSON. */
static cJSON *simulate(const char *run_name, const char *start, const char *condense, int code) {
  program_result run = thrum_run(folder, "simulate", "beam.npz", "-o", run_name, "--json", "-q",
                                 "--time", "0.6", "--integrator", "energy", "--start", start,
                                 condense ? "--condense" : NULL, condense, NULL);
  if (run.exit_code != code)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

static double *read_q(const char *name, int64_t *rows) {
  double *values = NULL;
  int64_t columns = 0;
  assert_int_equal(thrum_npy_read_f8(in_folder(name), &values, rows, &columns, NULL), 0);
  assert_int_equal(columns, RANK);
  return values;
}

/* rms of the difference over the rms of the second, of coordinates from `from` on. */
static double difference(const char *name, const char *other, int from) {
  int64_t rows = 0, others = 0;
  double *q = read_q(name, &rows), *whole = read_q(other, &others), sum = 0, size = 0;
  assert_int_equal(rows, others);
  for (int64_t k = 0; k < RANK * rows; k++) {
    if (k % RANK < from)
      continue;
    sum += (q[k] - whole[k]) * (q[k] - whole[k]);
    size += whole[k] * whole[k];
  }
  free(q);
  free(whole);
  return sqrt(sum / size);
}

static void a_smooth_swing_is_that_of_the_whole_model_with_what_follows(void **state) {
  (void)state;
  cJSON_Delete(simulate("whole", "kick.npy", NULL, 0));
  cJSON *object = simulate("condensed", "kick.npy", "6", 0);
  assert_true(difference("condensed/q.npy", "whole/q.npy", 0) < 0.01);
  assert_true(difference("condensed/q.npy", "whole/q.npy", 6) < 0.1);

  // it says how many are stepped, and how far it can be believed
  const cJSON *condensed = cJSON_GetObjectItem(object, "condensed");
  assert_true(json_value(condensed, "masters") == 6);
  assert_true(json_value(condensed, "inertia_share") < 0.005);
  assert_true(json_value(condensed, "energy_defect") < 0.02);
  assert_true(json_value(object, "rank") == RANK);
  cJSON_Delete(object);
}

/* The tip swings by a fifth of the length. The sixth mode and the eighth coordinate stretch the
 * beam; with all terms of their products the run is lost. */
static void a_large_swing_with_stretching_masters_is_that_of_the_whole_model(void **state) {
  (void)state;
  cJSON_Delete(simulate("far", "far.npy", NULL, 0));
  cJSON_Delete(simulate("far8", "far.npy", "8", 0));
  assert_true(difference("far8/q.npy", "far/q.npy", 0) < 0.005);
}

/* Few masters lack the inertia of what follows, which the integrator manifold steps. */
static void a_flagged_run_of_few_masters_names_the_integrator_that_would_do(void **state) {
  (void)state;
  static const double bent[2 * RANK] = {[RANK] = 2.6};
  assert_true(save_npy(in_folder("bent.npy"), bent, 2, RANK));
  static const char *const integrators[] = {"energy", "manifold"};
  for (int n = 0; n < 2; n++) {
    program_result run = thrum_run(folder, "simulate", "beam.npz", "-o", integrators[n], "-q",
                                   "--time", "0.6", "--integrator", integrators[n], "--start",
                                   "bent.npy", "--condense", "4", "--accept-error", "100%", NULL);
    assert_int_equal(run.exit_code, n == 0 ? 3 : 0);
    assert_true((strstr(run.err, "take --integrator manifold") != NULL) == (n == 0));
    program_result_free(&run);
  }
  cJSON_Delete(simulate("bent", "bent.npy", NULL, 0));
  assert_true(4 * difference("manifold/q.npy", "bent/q.npy", 0) <
              difference("energy/q.npy", "bent/q.npy", 0));
}

static void a_scene_steps_it_alike(void **state) {
  (void)state;
  assert_true(text_file_write(
      in_folder("scene.json"),
      "{\"bodies\":[{\"name\":\"a\",\"model\":\"beam.npz\",\"start\":\"kick.npy\",\"condense\":6}],"
      "\"time\":0.6,\"integrator\":\"energy\"}"));
  program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "scene", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  program_result_free(&run);
  cJSON_Delete(simulate("alone", "kick.npy", "6", 0));
  assert_true(difference("scene/a/q.npy", "alone/q.npy", 0) == 0);
}

/* The run of one body of a scene of this text; the caller frees the JSON. */
static cJSON *simulate_scene(const char *run_name, const char *text, program_result *run) {
  assert_true(text_file_write(in_folder("error.json"), text));
  *run = thrum_run(folder, "simulate", "error.json", "-o", run_name, "-q", "--json", NULL);
  if (run->exit_code != 0 && run->exit_code != 3)
    return NULL;
  cJSON *object = json_line(run->out);
  assert_non_null(object);
  return object;
}

static void a_body_that_names_an_error_is_condensed_as_far_as_that_allows(void **state) {
  (void)state;
  program_result run;
  cJSON *object =
      simulate_scene("found",
                     "{\"bodies\":[{\"name\":\"a\",\"model\":\"beam.npz\",\"start\":"
                     "\"kick.npy\",\"error\":0.05},{\"name\":\"b\",\"model\":"
                     "\"beam.npz\",\"start\":\"kick.npy\"},{\"name\":\"still\",\"model\":"
                     "\"beam.npz\",\"error\":0.05}],\"time\":0.6}",
                     &run);
  assert_non_null(object);
  const cJSON *bodies = cJSON_GetObjectItem(object, "bodies");
  const cJSON *found = cJSON_GetArrayItem(bodies, 0);

  // fewer coordinates, with the error that is said
  const double masters = json_value(cJSON_GetObjectItem(found, "condensed"), "masters");
  assert_true(masters >= 2 && masters <= 7);
  assert_true(json_value(found, "error_asked") == 0.05);
  assert_true(json_value(found, "error_found") > 0 && json_value(found, "error_found") <= 0.05);
  assert_true(difference("found/a/q.npy", "found/b/q.npy", 0) < 0.06);

  // one that does not move says nothing of its error, and is stepped whole
  assert_true(cJSON_IsNull(cJSON_GetObjectItem(cJSON_GetArrayItem(bodies, 2), "condensed")));
  assert_non_null(strstr(run.err, "body 'still'"));
  cJSON_Delete(object);
  program_result_free(&run);

  // the table says how many of the model's coordinates are stepped
  run = thrum_run(folder, "simulate", "error.json", "-o", "found", "-q", NULL);
  char stepped[32];
  snprintf(stepped, sizeof stepped, " %d of ", (int)masters);
  assert_non_null(strstr(run.out, stepped));
  program_result_free(&run);

  // it finds what the other two keys say
  assert_null(simulate_scene("no",
                             "{\"bodies\":[{\"model\":\"beam.npz\",\"error\":0.05,"
                             "\"condense\":4}],\"time\":0.6}",
                             &run));
  assert_non_null(strstr(run.err, "leave out rank and condense"));
  program_result_free(&run);
}

/* Of a coarse mesh all that is stepped stretches it, and nothing follows: the file says so. */
static void a_mesh_in_which_nothing_follows_is_condensed_too(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "precompute", "beam:1x1x1@1x1x1", "--fix", "x<0.001", "--modes", "2",
                "--rank", "5", "--condense", "-o", "stiff.npz", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "stiff.npz", "-o", "stiff", "--time", "0.03", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  program_result_free(&run);
}

static void a_file_that_was_precomputed_condensed_is_stepped_alike(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "precompute", "beam:12x2x2@1x0.1x0.1,split=6", "--order", "1", "--fix",
                "x<0.001", "--young", "3e6", "--poisson", "0.4", "--density", "1000", "--modes",
                "6", "--rank", "15", "--condense", "-o", "small.npz", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  program_result_free(&run);

  // the whole model of the same mesh, condensed when it is read
  run = thrum_run(folder, "precompute", "beam:12x2x2@1x0.1x0.1,split=6", "--order", "1", "--fix",
                  "x<0.001", "--young", "3e6", "--poisson", "0.4", "--density", "1000", "--modes",
                  "6", "--rank", "15", "-o", "large.npz", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  static const char *const names[2][4] = {{"small.npz", "small", NULL, NULL},
                                          {"large.npz", "large", "--condense", "6"}};
  for (int n = 0; n < 2; n++) {
    run =
        thrum_run(folder, "simulate", names[n][0], "-o", names[n][1], "-q", "--time", "0.3",
                  "--integrator", "energy", "--start", "kick.npy", names[n][2], names[n][3], NULL);
    if (run.exit_code != 0)
      fail_msg("exit code %d: %s", run.exit_code, run.err);
    program_result_free(&run);
  }

  // only a part of the polynomial was made, by other sums
  assert_true(difference("small/q.npy", "large/q.npy", 0) < 1e-10);

  // what needs the polynomial of all coordinates says so, and info reads the file
  run = thrum_run(folder, "static", "small.npz", "--load", "gravity:0,0,-1", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "small.npz: the model was precomputed condensed to 6 of 15"));
  program_result_free(&run);
  run = thrum_run(folder, "tradeoff", "small.npz", "-o", "no", "--load", "gravity:0,0,-1", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "condensed to 6 of 15 coordinates, which tradeoff cannot take"));
  assert_null(strstr(run.err, "full order"));
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "small.npz", "-o", "no", "--rank", "3", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "give --condense 1 to 6"));
  program_result_free(&run);
  run = thrum_run(folder, "export", "small.npz", "--vega-cubic", "small.cub", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "condensed"));
  program_result_free(&run);
  run = thrum_run(folder, "info", "small.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.out, "condensed"));
  program_result_free(&run);
}

static void
with_the_inertia_of_what_follows_a_large_swing_is_that_of_the_whole_model(void **state) {
  (void)state;
  // four modes bend the beam by a fifth of its length, and its stretching follows
  static const double swing[2 * RANK] = {[RANK] = 3};
  assert_true(save_npy(in_folder("swing.npy"), swing, 2, RANK));

  // all coordinates, four that lead without inertia behind them, and with it
  cJSON_Delete(simulate("swung", "swing.npy", NULL, 0));
  cJSON_Delete(simulate("without", "swing.npy", "4", 3));
  program_result run =
      thrum_run(folder, "simulate", "beam.npz", "-o", "with", "-q", "--time", "0.6", "--integrator",
                "manifold", "--start", "swing.npy", "--condense", "4", NULL);
  if (run.exit_code != 0)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  program_result_free(&run);

  const double without = difference("without/q.npy", "swung/q.npy", 0);
  const double with = difference("with/q.npy", "swung/q.npy", 0);
  if (!(with < 0.02 && without > 4 * with))
    fail_msg("%g with and %g without", with, without);
}

/* Bending drags the beam's last master along; alone it vibrates, and its frequency is matched as it
 * is where all coordinates are stepped, though its slaves took most of the quartic energy. */
static void a_master_that_stretches_vibrates_at_its_own_frequency(void **state) {
  (void)state;
  static const struct {
    const char *run, *integrator, *dt, *every;
  } runs[] = {{"fine", "energy", "0.0001", "20"},
              {"coarse", "energy", "0.002", "1"},
              {"trapezoidal", "newmark", "0.002", "1"}};

  // rows at equal times, of each run
  for (size_t n = 0; n < 3; n++) {
    program_result run =
        thrum_run(folder, "simulate", "beam.npz", "-o", runs[n].run, "-q", "--time", "0.3",
                  "--integrator", runs[n].integrator, "--dt", runs[n].dt, "--record-every",
                  runs[n].every, "--condense", "6", "--start", "mode:6,0.001", NULL);
    if (run.exit_code != 0)
      fail_msg("exit code %d: %s", run.exit_code, run.err);
    program_result_free(&run);
  }

  assert_true(difference("coarse/q.npy", "fine/q.npy", 0) < 0.001);
  assert_true(difference("trapezoidal/q.npy", "fine/q.npy", 0) > 0.03);
}

static void a_body_at_rest_has_no_strain_energy_that_is_wrong(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "simulate", "beam.npz", "-o", "rest", "--time", "0.03",
                                 "--condense", "4", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.out, "4 of 15 coordinates stepped"));
  assert_null(strstr(run.out, "nan"));
  program_result_free(&run);
}

static void condensing_with_nothing_to_follow_is_refused_before_the_work(void **state) {
  (void)state;
  // the mesh is not even looked for
  program_result run = thrum_run(folder, "precompute", "none.vtk", "--modes", "6", "--rank", "6",
                                 "--condense", "-o", "no.npz", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "nothing is left to follow 6 linear modes"));
  program_result_free(&run);
}

static void a_large_swing_is_flagged(void **state) {
  (void)state;
  cJSON *object = simulate("large", "mode:1,0.5", "2", 3);
  assert_string_equal(cJSON_GetObjectItem(object, "status")->valuestring, "condensed_wrong");
  cJSON_Delete(object);
}

/* Runs beam.npz with three options into `run_name`; returns its object. */
static cJSON *simulate_with(const char *run_name, const char *const options[3], int code) {
  program_result run = thrum_run(folder, "simulate", "beam.npz", "-o", run_name, "--json", "-q",
                                 "--time", "0.6", options[0], options[1], options[2], NULL);
  if (run.exit_code != code)
    fail_msg("%s: exit code %d: %s", options[0], run.exit_code, run.err);
  cJSON *object = json_line(run.out);
  program_result_free(&run);
  return object;
}

/* The masters bend the beam, and what pulls along its axis acts on those that follow: they answer
 * it without vibrating. The share that is said is the error. */
static void vibration_of_what_follows_is_flagged(void **state) {
  (void)state;
  static const struct {
    const char *load;
    int code;
  } cases[] = {
      {"--load=gravity:1.5,0,0", 3},       {"--start=static:gravity:1.5,0,0", 3},
      {"--load=sine:0,1,0@tip,f=9", 3},    {"--load=gravity:1.5,0,-1.5", 0},
      {"--load=sine:0,0,-1@tip,f=0.5", 0}, {"--start=mode:1,0.05", 0},
  };
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    cJSON *object = simulate_with("few", (const char *const[]){cases[n].load, "--condense=2", NULL},
                                  cases[n].code);
    const double said = json_value(cJSON_GetObjectItem(object, "condensed"), "vibration_share");
    cJSON_Delete(object);
    assert_true(cases[n].code == 3 ? said > 0.03 : said <= 0.03);
    if (cases[n].code == 0)
      continue;

    // the whole model says what the error is
    cJSON_Delete(simulate_with("all", (const char *const[]){cases[n].load, NULL, NULL}, 0));
    const double found = difference("few/q.npy", "all/q.npy", 0);
    if (!(fabs(found - said) < 0.1 * found))
      fail_msg("%s: %g said, %g found", cases[n].load, said, found);
  }
}

/* With strong damping of the stiffness what follows creeps to its answer, which the masters show at
 * once. */
static void what_follows_slowly_is_flagged(void **state) {
  (void)state;
  static const char *const damping[] = {"--damping=0,0.01", "--damping=0,0.1", "--damping=0,1"};
  for (size_t n = 0; n < sizeof damping / sizeof damping[0]; n++) {
    cJSON *object = simulate_with(
        "few", (const char *const[]){"--load=gravity:1.5,0,0", "--condense=2", damping[n]}, 3);
    const double said = json_value(cJSON_GetObjectItem(object, "condensed"), "vibration_share");
    cJSON_Delete(object);
    cJSON_Delete(
        simulate_with("all", (const char *const[]){"--load=gravity:1.5,0,0", damping[n], NULL}, 0));
    const double found = difference("few/q.npy", "all/q.npy", 0);
    if (!(fabs(found - said) < 0.1 * found))
      fail_msg("%s: %g said, %g found", damping[n], said, found);
  }
}

/* A slave that follows at once is damped with its masters. Where it is damped so strongly that it
 * lags, the run is flagged, and the share that is said is about the error. */
static void a_lag_of_what_follows_is_flagged(void **state) {
  (void)state;
  static const char *const bent = "--start=static:gravity:0,0,-2", *const damping[] = {
                                                                       "--damping=0,0.003",
                                                                       "--damping=0,0.1"};
  for (int n = 0; n < 2; n++) {
    cJSON *object = simulate_with("few", (const char *const[]){bent, "--condense=4", damping[n]},
                                  n == 0 ? 0 : 3);
    const double said = json_value(cJSON_GetObjectItem(object, "condensed"), "vibration_share");
    cJSON_Delete(object);
    cJSON_Delete(simulate_with("all", (const char *const[]){bent, damping[n], NULL}, 0));
    const double found = difference("few/q.npy", "all/q.npy", 0);
    if (n == 0 ? !(found < 0.01) : !(said > 0.5 * found && said < 2 * found))
      fail_msg("%s: %g said, %g found", damping[n], said, found);
  }
}

/* The same in a scene, of bodies with other scales too, whose share is one of their own time. */
static void a_scene_flags_the_vibration_of_what_follows(void **state) {
  (void)state;
  program_result run;
  cJSON *object = simulate_scene(
      "vibration",
      "{\"time\":0.6,\"bodies\":["
      "{\"name\":\"a\",\"model\":\"beam.npz\",\"condense\":2,\"loads\":[\"gravity:1.5,0,0\"]},"
      "{\"name\":\"b\",\"model\":\"beam.npz\",\"condense\":2,\"loads\":[\"gravity:0,0,-1\"],"
      "\"position\":[0,1,0]},"
      "{\"name\":\"c\",\"model\":\"beam.npz\",\"condense\":2,\"scale\":2,\"stiffness\":4,"
      "\"start\":\"static:gravity:1.5,0,0\",\"position\":[0,3,0]}]}",
      &run);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.err, "lacks vibration of"));

  // the second is pulled in the directions of its masters
  static const bool flagged[] = {true, false, true};
  cJSON *bodies = cJSON_GetObjectItem(object, "bodies");
  for (int n = 0; n < 3; n++) {
    const cJSON *body = cJSON_GetArrayItem(bodies, n);
    const char *status = cJSON_GetObjectItem(body, "status")->valuestring;
    assert_int_equal(strcmp(status, "condensed_wrong") == 0, flagged[n]);
    const double said = json_value(cJSON_GetObjectItem(body, "condensed"), "vibration_share");
    assert_true(flagged[n] ? said > 0.5 : said < 0.03);
  }
  cJSON_Delete(object);
  program_result_free(&run);
}

/* A sphere that strikes the end of a beam along its axis acts on what follows alone, and the share
 * that is said is the error; a beam that swings down onto another is bent by its masters. */
static void an_impact_on_what_follows_is_flagged(void **state) {
  (void)state;
  program_result run;
  cJSON *object = simulate_scene(
      "struck",
      "{\"time\":0.4,\"dt\":0.001,\"bodies\":["
      "{\"name\":\"few\",\"model\":\"beam.npz\",\"condense\":2},"
      "{\"name\":\"all\",\"model\":\"beam.npz\",\"position\":[0,1,0]},"
      "{\"name\":\"bent\",\"model\":\"beam.npz\",\"condense\":6,\"position\":[0,2,0],"
      "\"loads\":[\"gravity:0,0,-2\"]},"
      "{\"name\":\"scaled\",\"model\":\"beam.npz\",\"condense\":2,\"scale\":2,"
      "\"stiffness\":4,\"position\":[0,4,0]}],"
      "\"obstacles\":["
      "{\"shape\":\"sphere\",\"radius\":0.1,\"centre\":[1.2,0,0],\"velocity\":[-1,0,0]},"
      "{\"shape\":\"sphere\",\"radius\":0.1,\"centre\":[1.2,1,0],\"velocity\":[-1,0,0]},"
      "{\"shape\":\"sphere\",\"radius\":1,\"centre\":[1,2.05,-1.05]},"
      "{\"shape\":\"sphere\",\"radius\":0.2,\"centre\":[2.4,4,0],\"velocity\":[-2,0,0]}]}",
      &run);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.err, "body 'few'"));
  assert_null(strstr(run.err, "body 'bent'"));

  // the error of the first is that against the second, struck in the same way
  const double found = difference("struck/few/q.npy", "struck/all/q.npy", 0);
  static const bool flagged[] = {true, false, false, true};
  cJSON *bodies = cJSON_GetObjectItem(object, "bodies");
  for (int n = 0; n < 4; n++) {
    const cJSON *body = cJSON_GetArrayItem(bodies, n);
    const char *status = cJSON_GetObjectItem(body, "status")->valuestring;
    assert_int_equal(strcmp(status, "condensed_wrong") == 0, flagged[n]);
    if (n == 1)
      continue;
    const double said = json_value(cJSON_GetObjectItem(body, "condensed"), "vibration_share");
    if (!(flagged[n] ? fabs(said - found) < 0.1 * found : said < 0.03))
      fail_msg("body %d: %g said, %g found", n, said, found);
  }

  // the third has come down on its sphere
  char *text = text_file_read(in_folder("struck/bent/run.json"));
  cJSON *bent = cJSON_Parse(text);
  free(text);
  assert_true(json_value(cJSON_GetObjectItem(bent, "contact"), "lost_j") > 0);
  cJSON_Delete(bent);
  cJSON_Delete(object);
  program_result_free(&run);
}

/* A beam of few coordinates beside one of all, that fall on a plane. Returns the impact share that
 * is said of the first; `found` is its error. */
static double impact_share_of(const char *gravity, const char *plane, const char *time, int code,
                              double *found) {
  char scene[600];
  program_result run;
  snprintf(
      scene, sizeof scene,
      "{\"time\":%s,\"dt\":0.0005,\"bodies\":["
      "{\"name\":\"few\",\"model\":\"beam.npz\",\"condense\":6,\"loads\":[\"gravity:0,0,%s\"]},"
      "{\"name\":\"all\",\"model\":\"beam.npz\",\"position\":[0,1,0],"
      "\"loads\":[\"gravity:0,0,%s\"]}],"
      "\"obstacles\":[{\"shape\":\"plane\",\"centre\":[0,0,%s],\"normal\":[0,0,1]}]}",
      time, gravity, gravity, plane);
  cJSON *object = simulate_scene("bounces", scene, &run);
  assert_int_equal(run.exit_code, code);
  assert_int_equal(strstr(run.err, "of which is off after impacts") != NULL, code == 3);

  // no other number of the check says so
  const cJSON *few = cJSON_GetArrayItem(cJSON_GetObjectItem(object, "bodies"), 0);
  const cJSON *said = cJSON_GetObjectItem(few, "condensed");
  *found = difference("bounces/few/q.npy", "bounces/all/q.npy", 0);
  const double share = json_value(said, "impact_share");
  assert_true(json_value(said, "vibration_share") < 0.03);
  assert_true(json_value(said, "inertia_share") < 0.005);
  cJSON_Delete(object);
  program_result_free(&run);
  return share;
}

/* A beam that bounces on a plane gives a part of its energy to what follows. The masters alone keep
 * it, and rebound too fast, while little vibration is missing. */
static void a_rebound_without_what_follows_is_flagged(void **state) {
  (void)state;
  double found;
  const double share = impact_share_of("-12", "-0.15", "0.6", 3, &found);
  assert_true(found > 0.04 && share > found && share < 1);
}

/* One that lands gently and late gives away a tenth of its energy, and is off by little: how far it
 * moves after that counts. */
static void a_gentle_landing_without_what_follows_is_not_flagged(void **state) {
  (void)state;
  double found;
  const double share = impact_share_of("-1", "-0.066", "0.3", 0, &found);
  assert_true(found < 0.04 && share > 0.5 * found && share < 2 * found);
}

/* Faces are touched by bodies that step all coordinates: the user hears of one that does not. */
static void a_body_that_passes_through_an_obstacle_is_warned_of(void **state) {
  (void)state;
  program_result run;
  cJSON *object = simulate_scene(
      "passes",
      "{\"time\":0.03,\"bodies\":[{\"name\":\"few\",\"model\":\"beam.npz\",\"condense\":4},"
      "{\"name\":\"all\",\"model\":\"beam.npz\",\"position\":[0,1,0]},"
      "{\"name\":\"less\",\"model\":\"beam.npz\",\"condense\":2,\"position\":[0,2,0]}],"
      "\"obstacles\":[{\"shape\":\"box\",\"size\":[0.1,0.1,0.1],\"centre\":[1,0,-2]}]}",
      &run);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "body 'few' and 1 more are condensed: they pass through"));
  cJSON_Delete(object);
  program_result_free(&run);
}

static void what_cannot_be_condensed_is_refused(void **state) {
  (void)state;
  static const char *const cases[][4] = {
      {"--condense", "15", NULL, "1 to 14"},
      {"--condense", "0", NULL, "--condense"},
      {"--condense", "4", "--full", "--condense is of a reduced model"},
      {"--condense", "4", "--start=mode:5,0.1", "coordinates 1 to 4"},
  };

  // each is refused with a word that says why
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    program_result run = thrum_run(folder, "simulate", "beam.npz", "-o", "no", "-q", cases[n][0],
                                   cases[n][1], cases[n][2], NULL);
    assert_true(run.exit_code == 1 || run.exit_code == 2);
    if (strstr(run.err, cases[n][3]) == NULL)
      fail_msg("case %zu: %s", n, run.err);
    program_result_free(&run);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_smooth_swing_is_that_of_the_whole_model_with_what_follows),
      cmocka_unit_test(a_large_swing_with_stretching_masters_is_that_of_the_whole_model),
      cmocka_unit_test(a_flagged_run_of_few_masters_names_the_integrator_that_would_do),
      cmocka_unit_test(a_scene_steps_it_alike),
      cmocka_unit_test(a_body_that_names_an_error_is_condensed_as_far_as_that_allows),
      cmocka_unit_test(a_mesh_in_which_nothing_follows_is_condensed_too),
      cmocka_unit_test(a_file_that_was_precomputed_condensed_is_stepped_alike),
      cmocka_unit_test(a_large_swing_is_flagged),
      cmocka_unit_test(with_the_inertia_of_what_follows_a_large_swing_is_that_of_the_whole_model),
      cmocka_unit_test(a_master_that_stretches_vibrates_at_its_own_frequency),

      // what is refused, flagged or warned of
      cmocka_unit_test(a_body_at_rest_has_no_strain_energy_that_is_wrong),
      cmocka_unit_test(condensing_with_nothing_to_follow_is_refused_before_the_work),
      cmocka_unit_test(vibration_of_what_follows_is_flagged),
      cmocka_unit_test(what_follows_slowly_is_flagged),
      cmocka_unit_test(a_lag_of_what_follows_is_flagged),
      cmocka_unit_test(a_scene_flags_the_vibration_of_what_follows),
      cmocka_unit_test(an_impact_on_what_follows_is_flagged),
      cmocka_unit_test(a_rebound_without_what_follows_is_flagged),
      cmocka_unit_test(a_gentle_landing_without_what_follows_is_not_flagged),
      cmocka_unit_test(a_body_that_passes_through_an_obstacle_is_warned_of),
      cmocka_unit_test(what_cannot_be_condensed_is_refused),
  };
  return cmocka_run_group_tests(tests, make_models, remove_folder);
}
