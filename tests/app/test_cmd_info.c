/* Tests of `thrum info` as a command, and of the mesh measures behind it.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "io/npz.h"
#include "mesh/model_quality.h"
#include "tests/support/test_folder.h"
#include "thrum/thrum.h"

static cJSON *made; /* what precompute said about beam.npz */

static int make_beam(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL)
    return -1;
  program_result run =
      thrum_run(folder, "precompute", "beam:8x2x2@0.8x0.2x0.2", "--order", "1", "--fix", "x<0.001",
                "--modes", "4", "--rank", "8", "-o", "beam.npz", "--json", NULL);
  made = json_line(run.out);
  if (made == NULL)
    print_error("%s", run.err);
  program_result_free(&run);
  return made == NULL;
}

static int remove_beam(void **state) {
  (void)state;
  cJSON_Delete(made);
  test_folder_remove(folder);
  return 0;
}

static cJSON *info(const char *model, const char *option, const char *value) {
  program_result run = thrum_run(folder, "info", model, "--json", option, value, NULL);
  if (run.exit_code != 0)
    print_error("%s", run.err);
  assert_int_equal(run.exit_code, 0);
  assert_string_equal(run.err, "");
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

static bool near(double a, double b, double tolerance) {
  return fabs(a - b) <= tolerance * fabs(b);
}

static const cJSON *item_of(const cJSON *object, const char *key, int k) {
  return cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(object, key), k);
}

static void beam_is_measured_exactly(void **state) {
  (void)state;
  cJSON *object = info("beam.npz", NULL, NULL);

  // volume and mass are those of the box, and its root is held
  assert_true(near(json_value(object, "volume_m3"), 0.8 * 0.2 * 0.2, 1e-13));
  assert_true(near(json_value(object, "mass_kg"), 1000 * 0.8 * 0.2 * 0.2, 1e-13));
  assert_true(json_value(object, "fixed") == 9);

  // the beam begins at x = 0 and lies symmetrically about the axis
  assert_true(item_of(object, "box_min_m", 0)->valuedouble == 0);
  assert_true(near(item_of(object, "box_max_m", 0)->valuedouble, 0.8, 1e-15));
  assert_true(near(item_of(object, "box_min_m", 2)->valuedouble, -0.1, 1e-15));

  // a Kuhn tet of a cube has volume 1/6 and squared edges 1, 1, 1, 2, 2, 3
  const double kuhn = 12 * cbrt(0.25) / 10;
  assert_true(near(json_value(object, "quality_min"), kuhn, 1e-12));
  assert_true(near(json_value(object, "quality_mean"), kuhn, 1e-12));

  cJSON_Delete(object);
}

/* A cube with a middle node pulled out by 0.3 across a face is larger by 0.3 times the integral of
 * its shape function there, a third. */
static void curved_hexahedra_have_their_own_mass(void **state) {
  (void)state;
  FILE *file = fopen(in_folder("bulge.inp"), "w");
  assert_non_null(file);
  fputs("*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n"
        "9,.5,0,0\n10,1,.5,0\n11,.5,1,0\n12,0,.5,0\n13,.5,0,1\n14,1,.5,1\n15,.5,1.3,1\n"
        "16,0,.5,1\n17,0,0,.5\n18,1,0,.5\n19,1,1,.5\n20,0,1,.5\n*ELEMENT, TYPE=C3D20\n"
        "1,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,\n16,17,18,19,20\n",
        file);
  fclose(file);
  program_result run = thrum_run(folder, "precompute", "bulge.inp", "--young", "1e6", "--poisson",
                                 "0.3", "--density", "10", "--fix", "x<0.001", "--modes", "1",
                                 "--rank", "2", "-o", "bulge.npz", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  program_result_free(&run);
  cJSON *object = info("bulge.npz", NULL, NULL);
  assert_true(near(json_value(object, "volume_m3"), 1.1, 1e-12));
  assert_true(near(json_value(object, "mass_kg"), 11, 1e-12));
  cJSON_Delete(object);
}

static void info_agrees_with_precompute(void **state) {
  (void)state;
  cJSON *object = info("beam.npz", NULL, NULL);
  static const char *const numbers[] = {"vertices", "tets", "fixed",          "rank",
                                        "modes",    "dt",   "explicit_modes", "implicit_modes"};
  for (size_t n = 0; n < sizeof numbers / sizeof numbers[0]; n++) {
    assert_true(json_value(object, numbers[n]) == json_value(made, numbers[n]));
  }

  // frequencies were stored with all their digits
  static const char *const lists[] = {"frequencies_hz", "basis_frequencies_hz"};
  for (int n = 0; n < 2; n++) {
    const cJSON *here = cJSON_GetObjectItem(object, lists[n]);
    const cJSON *there = cJSON_GetObjectItem(made, lists[n]);
    assert_true(cJSON_GetArraySize(here) >= 4);
    assert_int_equal(cJSON_GetArraySize(here), cJSON_GetArraySize(there));
    for (int k = 0; k < cJSON_GetArraySize(here); k++) {
      assert_true(cJSON_GetArrayItem(here, k)->valuedouble ==
                  cJSON_GetArrayItem(there, k)->valuedouble);
    }
  }

  // the residuals that were stored are small
  const cJSON *residuals = cJSON_GetObjectItem(object, "residuals");
  assert_true(json_value(residuals, "modes_max") < 1e-8);
  assert_true(json_value(residuals, "orthonormality") < 1e-9);

  // stages do not overlap
  const cJSON *seconds = cJSON_GetObjectItem(object, "seconds"), *stage = NULL;
  double sum = 0;
  cJSON_ArrayForEach(stage, seconds) sum += stage->valuedouble;
  assert_true(sum <= 2 * json_value(seconds, "total") + 1e-9);
  assert_true(json_value(object, "peak_mb") > 0.5);
  cJSON_Delete(object);
}

/* For the energy integrator slow modes have their own frequency and fast ones (2/h) atan(h
 * omega/2); a table of it where one is asked for. */
static void frequencies_as_stepped_stand_beside_those_of_the_model(void **state) {
  (void)state;
  cJSON *object = info("beam.npz", "--integrator", "energy");
  const double h = 0.003, two_pi = 2 * acos(-1.0);
  const int rank = cJSON_GetArraySize(cJSON_GetObjectItem(object, "stepped_frequencies_hz"));
  assert_int_equal(rank, 8);
  for (int k = 0; k < rank; k++) {
    const double f = item_of(object, "basis_frequencies_hz", k)->valuedouble;
    const double trapezoidal = 2 / h * atan(h * two_pi * f / 2) / two_pi;
    const double stepped = h * two_pi * f <= 1 ? f : trapezoidal;
    assert_true(near(item_of(object, "stepped_frequencies_hz", k)->valuedouble, stepped, 1e-12));
    assert_true(near(item_of(object, "stepped_amplitude_factors", k)->valuedouble, 1, 1e-12));
  }
  cJSON_Delete(object);

  // null where a mode is beyond the limit of stability
  object = info("beam.npz", "--integrator", "verlet");
  assert_true(cJSON_IsNull(item_of(object, "stepped_frequencies_hz", rank - 1)));
  cJSON_Delete(object);

  program_result run = thrum_run(folder, "info", "beam.npz", "--integrator", "verlet", NULL);
  assert_non_null(strstr(run.out, "by verlet at dt = 0.003 s"));
  assert_non_null(strstr(run.out, "beyond the limit of stability"));
  program_result_free(&run);
  run = thrum_run(folder, "info", "beam.npz", NULL);
  assert_null(strstr(run.out, "as stepped"));
  program_result_free(&run);
}

/* precompute --touch, or --touch-stepped, of the beam up to a rank; *code: the exit code. */
static cJSON *touch_up_to(const char *option, const char *rank, int *code) {
  program_result run = thrum_run(folder, "precompute", "beam:8x2x2@0.8x0.2x0.2", "--order", "1",
                                 "--fix", "x<0.001", "--modes", "4", "--rank", "8", "-o",
                                 "touch.npz", option, "--rank-max", rank, "--json", NULL);
  *code = run.exit_code;

  // a model that misses its aim names the place and what to do
  assert_true((strstr(run.err, "a pull at vertex") != NULL) == (*code == 3));
  cJSON *object = json_line(run.out);
  if (object == NULL)
    fail_msg("%s", run.err);
  program_result_free(&run);
  return object;
}

/* Touch modes that follow or are stepped: what precompute says of them, and what info measures. */
static void check_touch(const char *option, bool follow) {
  int code = -1;
  cJSON *object = touch_up_to(option, "60", &code);
  assert_int_equal(code, 0);

  // they come beside the rank that is stepped or are of it, and the worst place is followed as was
  // promised
  const cJSON *touch = cJSON_GetObjectItem(object, "touch");
  const cJSON *before = cJSON_GetObjectItem(touch, "before");
  const cJSON *after = cJSON_GetObjectItem(touch, "after");
  assert_true(cJSON_IsTrue(cJSON_GetObjectItem(touch, "follow")) == follow);
  assert_true(json_value(object, "rank") == 8 + (follow ? 0 : json_value(touch, "modes")));
  assert_true(json_value(before, "worst") < 0.8 && json_value(after, "worst") >= 0.8);

  // without --touch the beam is as it was before, and the file's figures are those of its basis
  cJSON *plain = info("beam.npz", "--touch", NULL), *stored = info("touch.npz", NULL, NULL);
  cJSON *measured = info("touch.npz", "--touch", NULL);
  assert_true(json_value(measured, "rank") == 8 + json_value(touch, "modes"));
  const char *const keys[] = {"worst",  "mean",   "worst_direction",
                              "vertex", "places", "stiff_places"};
  for (int k = 0; k < 6; k++) {
    const double value = json_value(after, keys[k]);
    assert_true(near(json_value(cJSON_GetObjectItem(stored, "touch"), keys[k]), value, 1e-14));
    assert_true(near(json_value(cJSON_GetObjectItem(measured, "touch"), keys[k]), value, 1e-9));
  }
  assert_true(near(json_value(cJSON_GetObjectItem(plain, "touch"), "worst"),
                   json_value(before, "worst"), 1e-6));
  cJSON_Delete(plain);
  cJSON_Delete(stored);
  cJSON_Delete(measured);
  cJSON_Delete(object);
}

static void touch_modes_are_counted_and_measured_again(void **state) {
  (void)state;
  check_touch("--touch-stepped", false);
  check_touch("--touch", true);
}

/* A run of a model with a pull warns of it and says what to do, or does not (NULL). */
static void assert_warned(const char *model, const char *load, const char *advice) {
  program_result run =
      thrum_run(folder, "simulate", model, "-o", "pulled", load, "--time", "0.006", "-q", NULL);
  // so short a run shows vibration that touch modes lack, which is flagged
  if (run.exit_code != 0 && run.exit_code != 3)
    fail_msg("%s", run.err);
  assert_true((strstr(run.err, "of what the mesh gives") != NULL) == (advice != NULL));
  if (advice != NULL)
    assert_non_null(strstr(run.err, advice));
  program_result_free(&run);
}

static void a_run_warns_of_a_pull_that_its_basis_cannot_follow(void **state) {
  (void)state;
  int code = -1;
  cJSON *object = touch_up_to("--touch", "60", &code);

  // the worst place of the plain beam; the whole tip it follows well
  cJSON *plain = info("beam.npz", "--touch", NULL);
  char load[64];
  snprintf(load, sizeof load, "--load=constant:0,0,-1@vertex=%.0f",
           json_value(cJSON_GetObjectItem(plain, "touch"), "vertex"));
  assert_warned("beam.npz", load, "make it with thrum precompute --touch, or");
  assert_warned("beam.npz", "--load=constant:0,0,-1@tip", NULL);
  cJSON_Delete(plain);
  cJSON_Delete(object);
}

static void a_rank_too_low_for_touch_modes_is_flagged(void **state) {
  (void)state;
  int code = -1;
  cJSON *object = touch_up_to("--touch", "10", &code);
  assert_int_equal(code, 3);
  assert_true(json_value(cJSON_GetObjectItem(object, "touch"), "modes") == 2);

  // a run that pulls there does not advise what the model has
  char load[64];
  const cJSON *touch = cJSON_GetObjectItem(object, "touch");
  snprintf(load, sizeof load, "--load=ramp:0,0,-1@vertex=%.0f,until=1",
           json_value(cJSON_GetObjectItem(touch, "after"), "vertex"));
  assert_warned("touch.npz", load, "add --handles for this place");
  cJSON_Delete(object);

  // no room at all is refused
  program_result run = thrum_run(folder, "precompute", "beam.npz", "-o", "full.npz", "--modes", "4",
                                 "--rank", "8", "--touch", "--rank-max", "8", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "raise --rank-max"));
  program_result_free(&run);
}

/* A mode is explicit where h omega <= 1, that is f <= 1 / (2 pi h). */
static void split_follows_the_time_step(void **state) {
  (void)state;
  const double steps[] = {1e-5, 0.001, 0.003, 0.01, 0.1};
  const char *texts[] = {"1e-5", "0.001", "0.003", "0.01", "0.1"};
  for (int n = 0; n < 5; n++) {
    cJSON *object = info("beam.npz", "--dt", texts[n]);

    // count the frequencies below the bound
    int expected = 0;
    const cJSON *item = NULL;
    cJSON_ArrayForEach(item, cJSON_GetObjectItem(object, "basis_frequencies_hz")) {
      expected += item->valuedouble <= 1 / (2 * 3.14159265358979323846 * steps[n]);
    }

    assert_true(json_value(object, "dt") == steps[n]);
    assert_true(json_value(object, "explicit_modes") == expected);
    assert_true(json_value(object, "implicit_modes") == 8 - expected);
    cJSON_Delete(object);
  }
}

static void groups_and_memory_are_listed(void **state) {
  (void)state;
  cJSON *object = info("beam.npz", NULL, NULL);

  // the left end has nine vertices
  bool found = false;
  const cJSON *group = NULL;
  cJSON_ArrayForEach(group, cJSON_GetObjectItem(object, "groups")) {
    if (strcmp(cJSON_GetObjectItem(group, "name")->valuestring, "left") != 0)
      continue;
    found = cJSON_GetObjectItem(group, "vertices")->valuedouble == 9;
  }
  assert_true(found);

  // the bytes of the model are those of its file
  char path[160];
  struct stat status;
  snprintf(path, sizeof path, "%s/beam.npz", folder);
  assert_int_equal(stat(path, &status), 0);
  assert_true(json_value(object, "model_bytes") == (double)status.st_size);

  // the state holds at least q, p and what the step keeps
  assert_true(json_value(object, "state_bytes") >= 2 * 8 * 8);
  cJSON_Delete(object);
}

static void table_names_what_people_ask_for(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "info", "beam.npz", NULL);
  assert_int_equal(run.exit_code, 0);

  static const char *const wanted[] = {"32 kg",      "0.032 m^3",    "81 vertices (9 held)",
                                       "192 tetra",  "left (9)",     "rank 8",
                                       "mean ratio", "tetrahedron ", "explicit",
                                       "residuals",  "state "};
  for (size_t n = 0; n < sizeof wanted / sizeof wanted[0]; n++) {
    if (strstr(run.out, wanted[n]) == NULL)
      print_error("no %s in\n%s", wanted[n], run.out);
    assert_non_null(strstr(run.out, wanted[n]));
  }
  program_result_free(&run);
}

static void a_polynomial_alone_is_a_model_too(void **state) {
  (void)state;
  const int32_t format[2] = {THRUM_MODEL_FORMAT_MAJOR, THRUM_MODEL_FORMAT_MINOR};
  const double omega2[2] = {1, 1e6}, c3[4] = {0}, c4[5] = {1, 0, 0, 0, 1};
  const thrum_model model = {.rank = 2,
                             .c3_count = 4,
                             .c4_count = 5,
                             .format = format,
                             .omega2 = omega2,
                             .c3 = c3,
                             .c4 = c4};

  char path[160];
  snprintf(path, sizeof path, "%s/hand.npz", folder);
  assert_int_equal(thrum_model_save(path, &model, NULL), THRUM_OK);

  // at the usual time step the first coordinate is explicit and the second is not
  cJSON *object = info("hand.npz", NULL, NULL);
  assert_true(json_value(object, "rank") == 2);
  assert_true(json_value(object, "explicit_modes") == 1);
  assert_true(json_value(object, "vertices") == 0);

  // quantities that need a mesh are null, not zero
  static const char *const nulls[] = {"mass_kg", "volume_m3", "quality_min", "worst_tet", "fixed"};
  for (int n = 0; n < 5; n++) {
    assert_true(cJSON_IsNull(cJSON_GetObjectItem(object, nulls[n])));
  }

  cJSON_Delete(object);
  program_result run = thrum_run(folder, "info", "hand.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.out, "a polynomial alone"));
  program_result_free(&run);
}

static void meta_of_any_kind_is_survived(void **state) {
  (void)state;
  const int32_t format[2] = {THRUM_MODEL_FORMAT_MAJOR, THRUM_MODEL_FORMAT_MINOR};
  const double omega2 = 1, zero = 0;
  char nested[2001], path[160];
  memset(nested, '[', 2000);
  nested[2000] = 0;

  // no JSON, JSON of other types, and 2000 brackets that are never closed
  const char *const texts[] = {
      "",
      "{",
      "[1,2]",
      "null",
      "no json",
      nested,
      "{\"residuals\":3,\"frequencies_hz\":\"x\"}",
      "{\"residuals\":{\"modes\":{\"a\":[]}},\"frequencies_hz\":{\"a\":null},\"mesh\":[]}",
      "{\"frequencies_hz\":[null,\"1\",[2],1e999]}"};

  snprintf(path, sizeof path, "%s/meta.npz", folder);
  for (size_t n = 0; n < sizeof texts / sizeof texts[0]; n++) {
    const thrum_model model = {.rank = 1,
                               .c3_count = 1,
                               .c4_count = 1,
                               .format = format,
                               .omega2 = &omega2,
                               .c3 = &zero,
                               .c4 = &zero,
                               .meta = (const uint8_t *)texts[n],
                               .meta_bytes = (int64_t)strlen(texts[n])};
    assert_int_equal(thrum_model_save(path, &model, NULL), THRUM_OK);

    // both forms of the output show the rest of the model
    cJSON *object = info("meta.npz", NULL, NULL);
    assert_true(json_value(object, "rank") == 1);
    cJSON_Delete(object);
    program_result run = thrum_run(folder, "info", "meta.npz", NULL);
    assert_int_equal(run.exit_code, 0);
    program_result_free(&run);
  }
}

static void assert_exit(int code, const char *wanted, const char *a, const char *b, const char *c) {
  program_result run = thrum_run(folder, "info", a, b, c, NULL);
  if (!is_refusal(&run, code, wanted))
    fail_msg("wanted %d '%s', got %d '%s'", code, wanted, run.exit_code, run.err);
  program_result_free(&run);
}

static void a_file_that_is_no_model_is_refused_in_one_line(void **state) {
  (void)state;
  char path[160], copy[160];

  // a text, a missing file and a folder
  snprintf(path, sizeof path, "%s/words.npz", folder);
  assert_true(text_file_write(path, "these are words, and long enough to hold an end record\n"));
  assert_exit(1, "words.npz", "words.npz", NULL, NULL);
  assert_exit(1, "missing.npz", "missing.npz", NULL, NULL);
  assert_exit(1, "a folder", ".", "--json", NULL);
  assert_exit(1, "missing", "missing", NULL, NULL);

  // half of a good file
  snprintf(path, sizeof path, "%s/beam.npz", folder);
  snprintf(copy, sizeof copy, "%s/half.npz", folder);

  FILE *from = fopen(path, "rb"), *to = fopen(copy, "wb");
  assert_true(from != NULL && to != NULL);
  for (int n = 0; n < 5000; n++)
    putc(getc(from), to);
  fclose(from);
  assert_int_equal(fclose(to), 0);

  assert_exit(1, "half.npz", "half.npz", NULL, NULL);
}

static void wrong_usage_exits_with_2(void **state) {
  (void)state;
  assert_exit(2, "no model", NULL, NULL, NULL);
  assert_exit(2, "one model", "beam.npz", "beam.npz", NULL);
  assert_exit(2, "--dt", "beam.npz", "--dt", "0");
  assert_exit(2, "--dt", "beam.npz", "--dt", "fast");
  assert_exit(2, "unknown option", "beam.npz", "--melt", NULL);

  // the help names all that it takes
  program_result help = thrum_run(folder, "info", "--help", NULL);
  assert_non_null(strstr(help.out, "usage: thrum info MODEL|RUN|SURFACE [OPTIONS]\n"));
  program_result_free(&help);
}

/* Runs `thrum` in the folder, which must end with this exit code and no message; its output. */
static char *output_of(const char *command, const char *path, const char *option) {
  program_result run = thrum_run(folder, command, path, option, NULL);
  if (run.exit_code != 0 || run.err[0] != 0)
    fail_msg("exit %d, %s", run.exit_code, run.err);
  char *out = strdup(run.out);
  program_result_free(&run);
  assert_non_null(out);
  return out;
}

static void expect_done(program_result run) {
  if (run.exit_code != 0)
    print_error("%s", run.err);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
}

static void the_folder_of_a_run_is_said(void **state) {
  (void)state;
  expect_done(thrum_run(folder, "simulate", "beam.npz", "-o", "kick", "-q", "--time", "0.03",
                        "--dt", "0.003", "--integrator", "newmark", "--load", "constant:0,0,-1@tip",
                        "--accept-error", "100%", NULL));
  char *out = output_of("info", "kick", NULL);
  assert_non_null(strstr(out, "kick, a run of a model that thrum simulate recorded\n"));
  assert_non_null(strstr(out, "beam.npz\n"));
  assert_non_null(strstr(out, "newmark, rank 8\n"));
  assert_non_null(strstr(out, "10 of 0.003 s, together 0.03 s\n"));
  assert_non_null(strstr(out, "constant:0,0,-1@tip\n"));
  assert_non_null(strstr(out, "thrum view kick, which plays it\n"));
  free(out);

  // the same for programs
  cJSON *object = info("kick", NULL, NULL);
  assert_string_equal(cJSON_GetObjectItem(object, "of")->valuestring, "model");
  assert_string_equal(cJSON_GetObjectItem(object, "run_status")->valuestring, "done");
  assert_string_equal(cJSON_GetObjectItem(object, "integrator")->valuestring, "newmark");
  assert_true(json_value(object, "dt") == 0.003 && json_value(object, "steps") == 10);
  assert_true(near(json_value(object, "simulated_s"), 0.03, 1e-12));
  cJSON_Delete(object);

  // options are for models
  assert_exit(2, "the folder of a run", "kick", "--dt", "0.001");
}

static void the_folder_of_a_scene_is_said(void **state) {
  (void)state;
  char path[160];
  snprintf(path, sizeof path, "%s/two.json", folder);
  assert_true(text_file_write(path, "{\"title\": \"Two beams\", \"dt\": 0.01, \"time\": 0.1,"
                                    " \"bodies\": [{\"name\": \"a\", \"model\": \"beam.npz\"},"
                                    " {\"name\": \"b\", \"model\": \"beam.npz\","
                                    " \"position\": [0, 2, 0]}]}\n"));
  expect_done(thrum_run(folder, "simulate", "two.json", "-o", "pair", "-q", NULL));
  char *out = output_of("info", "pair", NULL);
  assert_non_null(strstr(out, "pair, a run of a scene that thrum simulate recorded\n"));
  assert_non_null(strstr(out, "two.json\n"));
  assert_non_null(strstr(out, "Two beams\n"));
  assert_non_null(strstr(out, "b: beam.npz, rank 8, by energy: done\n"));
  assert_non_null(strstr(out, "10 of 0.01 s, together 0.1 s\n"));
  free(out);

  // the run of a body in it is one of a model
  cJSON *object = info("pair", NULL, NULL);
  assert_string_equal(cJSON_GetObjectItem(object, "of")->valuestring, "scene");
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(object, "bodies")), 2);
  cJSON_Delete(object);
  out = output_of("info", "pair/b", NULL);
  assert_non_null(strstr(out, "two.json\n"));
  free(out);

  // a folder without a run is none, and neither is one with the file of another program
  snprintf(path, sizeof path, "%s/other", folder);
  assert_int_equal(mkdir(path, 0700), 0);
  assert_exit(1, "a folder without a finished run", "other", NULL, NULL);
  snprintf(path, sizeof path, "%s/other/run.json", folder);
  assert_true(text_file_write(path, "{\"command\": \"sing\"}\n"));
  assert_exit(1, "not the report of a run", "other", NULL, NULL);
}

/* Is this the list of the warnings of a run that was pulled far beyond its basis? */
static void assert_pulled_too_far(const cJSON *object) {
  static const char *const raised[] = {"compressed", "inverted"};
  const cJSON *warnings = cJSON_GetObjectItem(object, "warnings");
  assert_int_equal(cJSON_GetArraySize(warnings), 2);
  for (int n = 0; n < 2; n++)
    assert_string_equal(cJSON_GetArrayItem(warnings, n)->valuestring, raised[n]);
  assert_true(json_value(object, "least_stretch") < 0);
}

/* A pull that far may need a fallback, which is exit code 3, on one machine and not on another. */
static void expect_finished(program_result run) {
  if (run.exit_code != 0 && run.exit_code != 3)
    fail_msg("exit %d, %s", run.exit_code, run.err);
  program_result_free(&run);
}

/* A run, or a body of a scene, that must not be believed says so. */
static void what_a_run_was_warned_of_is_said(void **state) {
  (void)state;
  expect_finished(thrum_run(folder, "simulate", "beam.npz", "-o", "far", "-q", "--time", "0.05",
                            "--dt", "0.003", "--load", "constant:0,0,-2e5@tip", NULL));
  char *out = output_of("info", "far", NULL);
  assert_non_null(strstr(out, "\nwarnings          compressed, inverted; least stretch -"));
  free(out);
  cJSON *object = info("far", NULL, NULL);
  assert_pulled_too_far(object);
  cJSON_Delete(object);

  // a scene of two bodies names the one that is pulled, and warns of no other
  char path[160];
  snprintf(path, sizeof path, "%s/strained.json", folder);
  assert_true(text_file_write(path, "{\"dt\": 0.003, \"time\": 0.05, \"bodies\": [{\"name\": \"a\","
                                    " \"model\": \"beam.npz\"}, {\"name\": \"b\", \"model\":"
                                    " \"beam.npz\", \"loads\": [\"constant:0,0,-2e5@tip\"]}]}\n"));
  expect_finished(thrum_run(folder, "simulate", "strained.json", "-o", "strained", "-q", NULL));
  out = output_of("info", "strained", NULL);
  assert_non_null(strstr(out, "\nwarnings          b: compressed, inverted; least stretch -"));
  free(out);
  object = info("strained", NULL, NULL);
  const cJSON *bodies = cJSON_GetObjectItem(object, "bodies");
  const cJSON *of_unloaded = cJSON_GetObjectItem(cJSON_GetArrayItem(bodies, 0), "warnings");
  assert_true(cJSON_IsArray(of_unloaded) && cJSON_GetArraySize(of_unloaded) == 0);
  assert_pulled_too_far(cJSON_GetArrayItem(bodies, 1));
  cJSON_Delete(object);
}

/* Makes the folder of a run, and the path of the report in it. */
static void make_report_path(const char *name, char path[160]) {
  snprintf(path, 160, "%s/%s", folder, name);
  assert_int_equal(mkdir(path, 0777), 0);
  snprintf(path, 160, "%s/%s/run.json", folder, name);
}

/* The statuses that a finished run is not to be believed by come with their figures. */
static void why_a_run_is_not_believed_is_said(void **state) {
  (void)state;
  char path[160];
  make_report_path("doubted", path);
  assert_true(text_file_write(path, "{\"command\": \"simulate\", \"status\": \"fell_back\","
                                    " \"fallback_steps\": 1, \"monitor\": null}\n"));
  char *out = output_of("info", "doubted", NULL);
  assert_non_null(strstr(out, "  1 step needed a fallback beyond quasi-Newton\n"));
  assert_null(strstr(out, "warnings"));
  free(out);

  // the error of its basis as the run said it
  assert_true(text_file_write(
      path, "{\"command\": \"simulate\", \"status\": \"done\", \"simulated_s\": 1.5,"
            " \"error_estimate\": {\"share\": 0.12, \"kind\": \"about\", \"shape_share\": 0.3,"
            " \"until_s\": 0.3, \"ended\": \"it takes long\"}}\n"));
  out = output_of("info", "doubted", NULL);
  assert_non_null(strstr(out,
                         " about 12 % of the motion and 30 % of the shape by the basis, in the "
                         "first 0.3 of 1.5 s\n"));
  free(out);
  assert_true(text_file_write(
      path, "{\"command\": \"simulate\", \"status\": \"fell_back\", \"simulated_s\": 1.5,"
            " \"fallback_steps\": 1, \"error_estimate\": {\"share\": 0.12, \"kind\": \"at least\","
            " \"until_s\": 1.5}}\n"));
  out = output_of("info", "doubted", NULL);
  assert_non_null(strstr(out, " at least 12 % of the motion by the basis\n"));
  free(out);

  // without a monitor nothing was looked at, which is not the same as no warning
  cJSON *object = info("doubted", NULL, NULL);
  assert_true(cJSON_IsNull(cJSON_GetObjectItem(object, "warnings")));
  cJSON_Delete(object);

  // shares of a condensed run that its report has
  assert_true(text_file_write(path, "{\"command\": \"simulate\", \"status\": \"condensed_wrong\","
                                    " \"condensed\": {\"inertia_share\": 0.02,"
                                    " \"energy_defect\": 0.31, \"vibration_share\": null,"
                                    " \"impact_share\": 0}}\n"));
  out = output_of("info", "doubted", NULL);
  assert_non_null(strstr(out, "  2 % of the kinetic energy in what follows, 31 % of the strain "
                              "energy wrong\n"));
  free(out);
}

/* Figures that a report lacks are not made up, and no "nan" is told for them. */
static void a_report_without_figures_is_said_without_them(void **state) {
  (void)state;
  char path[160];
  make_report_path("bare", path);
  assert_true(text_file_write(path, "{\"command\": \"simulate\", \"steps\": 1234567, "
                                    "\"energy_first_j\": null}\n"));
  char *out = output_of("info", "bare", NULL);
  assert_non_null(strstr(out, "1234567 of ? s, together ? s\n"));
  assert_non_null(strstr(out, "? rows, ? frames\n"));
  assert_null(strstr(out, "nan"));
  free(out);

  // nor is it the report of another program, or a whole one
  assert_true(text_file_write(path, "{\"steps\": 3}\n"));
  assert_exit(1, "not the report of a run", "bare", NULL, NULL);
  assert_true(text_file_write(path, "{\"command\": \"simul"));
  assert_exit(1, "run.json", "bare", NULL, NULL);
}

/* A report that was changed by hand is refused by what no run has, and told in no part. */
static void figures_that_no_run_has_are_refused(void **state) {
  (void)state;
  static const char *const wrong[][2] = {
      {"\"steps\": -5", "\"steps\" is -5, and a run has a whole number from 0 to 1e+12 there"},
      {"\"steps\": 2.5", "\"steps\" is 2.5"},
      {"\"rows\": \"many\"", "\"rows\" is \"many\""},
      {"\"dt\": 0", "\"dt\" is 0, and a run has a finite number above 0 there"},
      {"\"dt\": 1e999", "\"dt\" is infinite"},
      {"\"rank\": 1000000", "a whole number from 1 to 512"},
      {"\"energy_max_j\": 1e999", "\"energy_max_j\" is "},
      {"\"monitor\": {\"least_stretch\": true}", "\"least_stretch\" is true"},
      {"\"condensed\": {\"inertia_share\": -1}", "\"inertia_share\" is -1"},
      {"\"steps\": 10, \"dt\": 0.5, \"simulated_s\": 7", "its steps times their length"},
      {"\"steps\": 10, \"rows\": 12", "\"rows\" is 12"},
      {"\"options\": [1, 2]", "\"options\" is [1,2], and a run has an object of its options there"},
  };
  char path[160], text[300];
  make_report_path("changed", path);
  for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
    snprintf(text, sizeof text, "{\"command\": \"simulate\", %s}\n", wrong[n][0]);
    assert_true(text_file_write(path, text));
    assert_exit(1, wrong[n][1], "changed", NULL, NULL);
    assert_exit(1, "the file was changed, simulate again", "changed", "--json", NULL);
  }

  // a body of a scene names a folder in the run, and no other
  snprintf(path, sizeof path, "%s/changed/scene.json", folder);
  assert_true(text_file_write(path, "{\"command\": \"simulate\", \"bodies\": [{\"name\": "
                                    "\"../doubted\"}]}\n"));
  assert_exit(1, "none of a folder in the run", "changed", NULL, NULL);
}

/* Info tells the options of a run in the words of the command, and leaves out the defaults. */
static void options_of_a_run_are_said(void **state) {
  (void)state;
  expect_done(thrum_run(folder, "simulate", "beam.npz", "-o", "damped", "-q", "--time", "0.03",
                        "--damping", "0.3,0.001", "--start", "mode:1,0.01", "--base-motion",
                        "sine:1,0,0,f=2", "--record-every", "2", "--monitor", "off", NULL));
  char *out = output_of("info", "damped", NULL);
  assert_non_null(strstr(out, "\nstart             mode:1,0.01\n"));
  assert_non_null(strstr(out, "\nbase motion       sine:1,0,0,f=2\n"));
  assert_non_null(strstr(out, "\noptions           --damping 0.3,0.001 --record-every 2 --monitor "
                              "off\n"));
  free(out);

  // the JSON for programs has all options, and the energies
  cJSON *object = info("damped", NULL, NULL);
  const cJSON *options = cJSON_GetObjectItem(object, "options");
  assert_true(item_of(options, "damping", 1)->valuedouble == 0.001);
  assert_true(json_value(object, "energy_first_j") > 0);
  assert_true(json_value(object, "energy_max_j") >= json_value(object, "energy_min_j"));
  assert_true(cJSON_IsNull(cJSON_GetObjectItem(object, "missing")));
  cJSON_Delete(object);

  // which coordinates are stepped, and what a mesh is made a model by
  expect_done(thrum_run(folder, "simulate", "beam.npz", "-o", "fewer", "-q", "--time", "0.03",
                        "--rank", "3", "--accept-error", "100%", NULL));
  out = output_of("info", "fewer", NULL);
  assert_non_null(strstr(out, "\noptions           --rank 3 --accept-error 1\n"));
  free(out);
  expect_done(thrum_run(folder, "simulate", "beam:3x1x1@0.6x0.2x0.2", "--full", "-o", "whole", "-q",
                        "--time", "0.03", "--fix", "left", "--fix", "tip:z", "--young", "2e5",
                        NULL));
  out = output_of("info", "whole", NULL);
  assert_non_null(strstr(out, "\noptions           --fix left --fix tip:z --young 200000\n"));
  free(out);

  // only a body that nothing holds can spin
  expect_done(thrum_run(folder, "precompute", "beam:4x1x1@0.8x0.2x0.2", "--order", "1", "--modes",
                        "2", "--rank", "4", "-q", "-o", "loose.npz", NULL));
  expect_done(thrum_run(folder, "simulate", "loose.npz", "-o", "spun", "-q", "--time", "0.03",
                        "--spin", "0,90,0", "--judge", "off", NULL));
  out = output_of("info", "spun", NULL);
  assert_non_null(strstr(out, "\noptions           --spin 0,90,0 --judge off\n"));
  free(out);
}

/* Info tells which commands play a run only where its files and its model are there. */
static void what_a_run_lacks_is_said(void **state) {
  (void)state;
  expect_done(thrum_run(folder, "simulate", "beam.npz", "-o", "lacks", "-q", "--time", "0.03",
                        "--start", "mode:1,0.01", NULL));
  char path[160], away[160];
  snprintf(path, sizeof path, "%s/lacks/q.npy", folder);
  assert_int_equal(remove(path), 0);
  char *out = output_of("info", "lacks", NULL);
  assert_non_null(strstr(out, "\nmissing           lacks/q.npy is not there"));
  assert_null(strstr(out, "next "));
  free(out);

  // its model is missing, and then another model has its name
  snprintf(path, sizeof path, "%s/beam.npz", folder);
  snprintf(away, sizeof away, "%s/away.npz", folder);
  assert_int_equal(rename(path, away), 0);
  out = output_of("info", "damped", NULL);
  assert_non_null(strstr(out, "\nmissing           damped was made with the model beam.npz"));
  free(out);
  expect_done(thrum_run(folder, "precompute", "beam:4x1x1@0.8x0.2x0.2", "--order", "1", "--modes",
                        "4", "--rank", "8", "--fix", "x<0.001", "-q", "-o", "beam.npz", NULL));
  cJSON *object = info("damped", NULL, NULL);
  assert_non_null(strstr(cJSON_GetObjectItem(object, "missing")->valuestring,
                         "is not the model that damped was made with"));
  cJSON_Delete(object);
  assert_int_equal(rename(away, path), 0);
}

static void a_full_disk_is_not_success(void **state) {
  (void)state;

  // /dev/full takes what is written and fails when it is flushed
  if (!file_exists("/dev/full"))
    fail_msg("%s", "/dev/full is missing");

  char shell[] = "/bin/sh", option[] = "-c", script[300];
  snprintf(script, sizeof script, "%s info %s/beam.npz >/dev/full", THRUM_PROGRAM, folder);
  char *argv[] = {shell, option, script, NULL};
  program_result run = program_execute(NULL, argv);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "could not be written"));
  program_result_free(&run);
}

static void mean_ratio_is_one_for_regular_tets_at_any_size(void **state) {
  (void)state;
  for (double size = 1e-6; size < 1e7; size *= 100) {
    const double a[3] = {size, size, size}, b[3] = {size, -size, -size},
                 c[3] = {-size, size, -size}, d[3] = {-size, -size, size};
    const double *const one[4] = {a, b, c, d}, *const other[4] = {a, c, b, d};

    // either orientation has the ratio 1, and volumes of opposite sign
    double volume = 0, mirrored = 0;
    assert_true(near(thrum_tet_mean_ratio(one, &volume), 1, 1e-14));
    assert_true(near(thrum_tet_mean_ratio(other, &mirrored), 1, 1e-14));
    assert_true(near(fabs(volume), 8.0 / 3 * size * size * size, 1e-13));
    assert_true(volume == -mirrored);

    // pressed flat it goes to zero
    const double e[3] = {-size, -size, -size * (1 - 1e-9)};
    const double *const flat[4] = {b, c, e, (const double[3]){0, 0, -size}};
    assert_true(thrum_tet_mean_ratio(flat, &volume) < 1e-5);
  }
}

static void the_worst_tet_is_named(void **state) {
  (void)state;
  char path[160];
  snprintf(path, sizeof path, "%s/two.veg", folder);

  // the second tet, a needle, stands on the first one's slanted face
  assert_true(text_file_write(path, "*VERTICES\n5 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
                                    "5 0.4 0.4 0.4\n*ELEMENTS\nTET\n2 4 0\n1 1 2 3 4\n2 2 3 4 5\n"
                                    "*MATERIAL rubber\nENU, 1000, 1e6, 0.3\n"
                                    "*REGION\nallElements, rubber\n"));

  program_result run = thrum_run(folder, "precompute", "two.veg", "--fix", "z<0.1", "--modes", "2",
                                 "--rank", "2", "-o", "two.npz", NULL);
  if (run.exit_code != 0)
    print_error("%s", run.err);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // tetrahedra are counted from 1
  cJSON *object = info("two.npz", NULL, NULL);
  assert_true(json_value(object, "worst_tet") == 2);
  assert_true(json_value(object, "quality_min") < json_value(object, "quality_mean"));
  cJSON_Delete(object);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(beam_is_measured_exactly),
      cmocka_unit_test(curved_hexahedra_have_their_own_mass),
      cmocka_unit_test(info_agrees_with_precompute),
      cmocka_unit_test(touch_modes_are_counted_and_measured_again),
      cmocka_unit_test(a_run_warns_of_a_pull_that_its_basis_cannot_follow),
      cmocka_unit_test(a_rank_too_low_for_touch_modes_is_flagged),
      cmocka_unit_test(split_follows_the_time_step),
      cmocka_unit_test(frequencies_as_stepped_stand_beside_those_of_the_model),
      cmocka_unit_test(groups_and_memory_are_listed),
      cmocka_unit_test(table_names_what_people_ask_for),
      cmocka_unit_test(a_polynomial_alone_is_a_model_too),
      cmocka_unit_test(meta_of_any_kind_is_survived),

      // what is refused, and what cannot be printed
      cmocka_unit_test(a_file_that_is_no_model_is_refused_in_one_line),
      cmocka_unit_test(wrong_usage_exits_with_2),
      cmocka_unit_test(the_folder_of_a_run_is_said),
      cmocka_unit_test(the_folder_of_a_scene_is_said),
      cmocka_unit_test(what_a_run_was_warned_of_is_said),
      cmocka_unit_test(why_a_run_is_not_believed_is_said),
      cmocka_unit_test(a_report_without_figures_is_said_without_them),
      cmocka_unit_test(figures_that_no_run_has_are_refused),
      cmocka_unit_test(options_of_a_run_are_said),
      cmocka_unit_test(what_a_run_lacks_is_said),
      cmocka_unit_test(a_full_disk_is_not_success),

      // the element quality that it reports
      cmocka_unit_test(mean_ratio_is_one_for_regular_tets_at_any_size),
      cmocka_unit_test(the_worst_tet_is_named),
  };
  return cmocka_run_group_tests(tests, make_beam, remove_beam);
}
