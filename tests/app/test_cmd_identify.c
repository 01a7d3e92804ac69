/* Tests of `thrum identify`: what a noisy ring-down of a body says of its moduli and damping, by a
 * model of others, and what is refused.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "tests/support/program_object.h"
#include "tests/support/random_model.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

static void done(program_result run) {
  if (run.exit_code != 0)
    fail_msg("%s%s", run.out, run.err);
  program_result_free(&run);
}

static void precompute(const char *young, const char *name) {
  done(thrum_run(folder, "precompute", "beam:6x1x1@1x0.1x0.08", "--order", "2", "--fix", "x<0.001",
                 "--young", young, "--poisson", "0.3", "--density", "1000", "--modes", "3",
                 "--rank", "6", "-o", name, "-q", NULL));
}

/* Every tenth row of the probes, with noise of this size. */
static void add_noise(double size) {
  char *text = text_file_read(in_folder("ring/probes.csv")), line[512];
  FILE *to = fopen(in_folder("ring.csv"), "w");
  assert_true(text != NULL && to != NULL);
  random_state random = {4};
  int64_t row = -1;
  for (char *at = strtok(text, "\n"); at != NULL; at = strtok(NULL, "\n"), row++) {
    snprintf(line, sizeof line, "%s", at);
    if (row < 0)
      fprintf(to, "%s\n", line);
    if (row < 0 || row % 10 != 0)
      continue;

    // step and time, then numbers
    char *next = strchr(strchr(line, ',') + 1, ',');
    fprintf(to, "%.*s", (int)(next - line), line);
    while (*next == ',') {
      const double value = strtod(next + 1, &next);
      fprintf(to, ",%.12g", value + size * (random_uniform(&random) + random_uniform(&random)));
    }
    fprintf(to, "\n");
  }
  assert_int_equal(fclose(to), 0);
  free(text);
}

static int make_models(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL)
    return 1;
  precompute("1.2e6", "true.npz");
  precompute("1e6", "beam.npz");
  done(thrum_run(folder, "simulate", "true.npz", "--start", "mode:1,0.1", "--dt", "0.0005",
                 "--time", "4", "--damping", "0.4,0.0004", "--probe", "near:1,0.05,0", "-o", "ring",
                 "-q", NULL));
  add_noise(5e-4);
  return 0;
}

static const cJSON *parameter(const cJSON *object, int place, const char *name) {
  const cJSON *list = cJSON_GetObjectItemCaseSensitive(object, "parameters");
  const cJSON *item = cJSON_GetArrayItem(list, place);
  assert_non_null(item);
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(item, "name")->valuestring, name);
  return item;
}

/* Is the truth within four deviations, and the value within this share of it? */
static void assert_found(const cJSON *object, int place, const char *name, double truth,
                         double share) {
  const cJSON *item = parameter(object, place, name);
  const double value = json_value(item, "value"), deviation = json_value(item, "deviation");
  if (!(fabs(value - truth) < 4 * deviation && fabs(value / truth - 1) < share))
    fail_msg("%s: %g +- %g", name, value, deviation);
}

static void a_noisy_ringdown_gives_modulus_and_damping(void **state) {
  (void)state;
  cJSON *object =
      program_object(thrum_run(folder, "identify", "beam.npz", "ring.csv", "--start", "mode:1,0.1",
                               "--parameters", "E,alpha,beta,start", "-o", "fit", "--json", NULL),
                     0);
  assert_found(object, 0, "E", 1.2e6, 0.005);
  assert_found(object, 1, "alpha", 0.4, 0.05);
  assert_found(object, 2, "beta", 4e-4, 0.5);

  assert_true(json_value(object, "repeated_share") < 0.1);

  // what is left is the noise, of two uniform numbers in [-1, 1)
  assert_true(fabs(json_value(object, "rms_m") / (5e-4 * sqrt(2. / 3)) - 1) < 0.1);
  assert_true(file_exists(in_folder("fit/fit.csv")));
  assert_true(file_exists(in_folder("fit/identify.json")));
  cJSON_Delete(object);
}

/* Half of the damping is missing: what is left swings, and no interval of noise holds the truth. */
static void what_a_model_misses_is_flagged_and_said(void **state) {
  (void)state;
  cJSON *object = program_object(thrum_run(folder, "identify", "beam.npz", "ring.csv", "--start",
                                           "mode:1,0.1", "--damping", "0.2,0.0004", "--parameters",
                                           "E,start", "--start-modes", "2", "--json", "-q", NULL),
                                 3);
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "status")->valuestring, "misfit");
  assert_true(json_value(object, "repeated_share") > 0.5);
  const cJSON *item = parameter(object, 0, "E");
  assert_true(json_value(item, "off_by_model") > 10 * json_value(item, "deviation"));
  assert_true(fabs(json_value(item, "value") - 1.2e6) < json_value(item, "off_by_model"));
  cJSON_Delete(object);
}

static void times_in_milliseconds_are_refused(void **state) {
  (void)state;
  FILE *to = fopen(in_folder("ms.csv"), "w");
  assert_non_null(to);
  fprintf(to, "time_s,near:1 0.05 0.z_m\n");
  for (int n = 0; n < 50; n++)
    fprintf(to, "%d,%g\n", 10 * n, 0.1 * cos(0.05 * n));
  assert_int_equal(fclose(to), 0);
  program_result run =
      thrum_run(folder, "identify", "beam.npz", "ms.csv", "--start", "mode:1,0.1", NULL);
  assert_true(is_refusal(&run, 1, "are the times in seconds"));
  program_result_free(&run);
}

static void what_does_not_show_is_flagged(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "identify", "true.npz", "ring.csv", "--start", "mode:1,0.1", "--damping",
                "0.4,0.0004", "--parameters", "damping-ratio", "--ratios", "3", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.out, "does not show it"));
  program_result_free(&run);
}

/* Every tenth row of the time and one other column of the probes. */
static void keep_column(int kept, const char *name) {
  char *text = text_file_read(in_folder("even/probes.csv"));
  FILE *to = fopen(in_folder(name), "w");
  assert_true(text != NULL && to != NULL);
  int64_t row = -1;
  for (char *at = text; *at != 0; row++) {
    char *end = strchr(at, '\n'), *next = at;
    *end = 0;
    for (int column = 0; next != NULL && (row < 0 || row % 10 == 0); column++) {
      const size_t length = strcspn(next, ",");
      if (column == 1 || column == kept)
        fprintf(to, "%.*s%s", (int)length, next, column == 1 ? "," : "\n");
      next = next[length] == ',' ? next + length + 1 : NULL;
    }
    at = end + 1;
  }
  assert_int_equal(fclose(to), 0);
  free(text);
}

/* The body swings along z, and mode 2 along y: of it the recording says nothing, but all of E and
 * of the damping of mode 1. */
static void what_does_not_show_takes_nothing_from_the_rest(void **state) {
  (void)state;
  done(thrum_run(folder, "precompute", "beam:4x2x2@1x0.1x0.08", "--order", "2", "--fix", "x<0.001",
                 "--young", "1e6", "--poisson", "0.3", "--density", "1000", "--modes", "3",
                 "--rank", "8", "-o", "even.npz", "-q", NULL));
  done(thrum_run(folder, "simulate", "even.npz", "--start", "mode:1,0.08", "--dt", "0.002",
                 "--time", "4", "--damping-ratio", "0.03", "--probe", "tip", "-o", "even", "-q",
                 NULL));
  keep_column(4, "z.csv");
  cJSON *object =
      program_object(thrum_run(folder, "identify", "even.npz", "z.csv", "--start", "mode:1,0.08",
                               "--parameters", "E,damping-ratio,start", "--ratios", "3",
                               "--start-modes", "2", "--dt", "0.002", "--json", NULL),
                     3);
  const struct {
    int place;
    const char *name;
    double truth;
  } seen[] = {{0, "E", 1e6}, {1, "damping ratio of mode 1", 0.03}};
  for (int n = 0; n < 2; n++) {
    const cJSON *item = parameter(object, seen[n].place, seen[n].name);
    assert_true(fabs(json_value(item, "value") / seen[n].truth - 1) < 5e-3);
    assert_true(json_value(item, "deviation") < 5e-3 * seen[n].truth);
  }
  const cJSON *ratio = parameter(object, 2, "damping ratio of mode 2");
  const cJSON *start = parameter(object, 5, "start q2");
  assert_true(cJSON_IsFalse(cJSON_GetObjectItemCaseSensitive(ratio, "seen")));
  assert_true(cJSON_IsFalse(cJSON_GetObjectItemCaseSensitive(start, "seen")));
  cJSON_Delete(object);
}

static void a_fit_that_explains_nothing_is_flagged(void **state) {
  (void)state;
  FILE *to = fopen(in_folder("noise.csv"), "w");
  assert_non_null(to);
  random_state random = {7};
  fprintf(to, "time_s,tip.z_m\n");
  for (int row = 0; row < 60; row++)
    fprintf(to, "%g,%g\n", 0.01 * row, 0.01 * random_uniform(&random));
  assert_int_equal(fclose(to), 0);
  cJSON *object = program_object(thrum_run(folder, "identify", "beam.npz", "noise.csv", "--start",
                                           "mode:1,0.1", "--json", NULL),
                                 3);
  assert_true(
      cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(parameter(object, 0, "E"), "deviation")));
  cJSON_Delete(object);
}

static void bad_recordings_are_refused(void **state) {
  (void)state;
  static const struct {
    const char *text, *says;
  } cases[] = {
      {"", "the names of the columns"},
      {"time_s\n0\n1\n2\n", "TARGET.x_m"},
      {"tip.x_m\n0\n1\n2\n", "time_s"},
      {"time_s,near:1 0 0.x_m\n0,1\n", "3 or more"},
      {"time_s,near:1 0 0.x_m\n0,1\n0,2\n1,2\n", "bad.csv:3"},
      {"time_s,near:1 0 0.x_m\n0,1\n1,nan\n2,1\n", "bad.csv:3"},
      {"time_s,near:1 0 0.x_m\n0,1\n1\n2,1\n", "bad.csv:3"},
      {"time_s,near:1 0 0.x_m\n0,0\n1,0\n2,0\n3,0\n", "nothing moves"},
      {"time_s,near:1 0 0.x_m\n0,1\n1,5 0.5\n2,1\n", "bad.csv:3"},
      {"time_s,near:1 0 0.x_m\n0,1\n1,5,7\n2,1\n", "more columns"},
      {"note,time_s,near:1 0 0.x_m\n,0,0\na b,1,0\nc,2,0\n", "nothing moves"},
      {"time_s,nogroup.x_m\n0,1\n1,1\n2,1\n", "nogroup"},
  };
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    assert_true(text_file_write(in_folder("bad.csv"), cases[n].text));
    program_result run =
        thrum_run(folder, "identify", "beam.npz", "bad.csv", "--start", "mode:1,0.1", NULL);
    if (!is_refusal(&run, 1, cases[n].says))
      fail_msg("case %zu: %d %s", n, run.exit_code, run.err);
    program_result_free(&run);
  }
  static const struct {
    const char *option, *value, *says;
    int code;
  } uses[] = {
      {"--parameters", "E,colour", "E, nu, density, damping-ratio, alpha, beta and start", 2},
      {"--parameters", "E", "starts at rest", 1}};
  for (size_t n = 0; n < sizeof uses / sizeof uses[0]; n++) {
    program_result run =
        thrum_run(folder, "identify", "beam.npz", "ring.csv", uses[n].option, uses[n].value, NULL);
    assert_true(is_refusal(&run, uses[n].code, uses[n].says));
    program_result_free(&run);
  }

  // the file is looked at before anything else is asked for
  program_result run = thrum_run(folder, "identify", "beam.npz", "none.csv", NULL);
  assert_true(is_refusal(&run, 1, "none.csv"));
  program_result_free(&run);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_noisy_ringdown_gives_modulus_and_damping),
      cmocka_unit_test(what_a_model_misses_is_flagged_and_said),
      cmocka_unit_test(times_in_milliseconds_are_refused),
      cmocka_unit_test(what_does_not_show_is_flagged),
      cmocka_unit_test(what_does_not_show_takes_nothing_from_the_rest),
      cmocka_unit_test(a_fit_that_explains_nothing_is_flagged),
      cmocka_unit_test(bad_recordings_are_refused),
  };
  return cmocka_run_group_tests(tests, make_models, remove_folder);
}
