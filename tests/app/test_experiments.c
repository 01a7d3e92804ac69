/* Tests of `thrum experiments` as a command: a reduced matrix, the long run, the sweep over time
 * steps, and what is refused. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/support/model_folder.h"
#include "tests/support/sanitized.h"
#include "tests/support/test_folder.h"

/* The relative change of the mean energy of imexv at a swing of 5 %: between the first and the last
 * window, and between any two. Its position form ripples, and nothing corrects it; see
 * docs/experiments.md. */
#define IMEXV_CHANGE 2e-3
#define IMEXV_WORST 6e-3

static int make_models(void **state) {
  char path[192];
  (void)state;
  if (test_folder_make(folder) == NULL)
    return -1;
  snprintf(path, sizeof path, "%s/models", folder);
  if (mkdir(path, 0777) != 0)
    return -1;

  // a model folder of one mesh and its recipe
  snprintf(path, sizeof path, "%s/models/beam.msh", folder);
  if (!write_bar(path))
    return -1;
  snprintf(path, sizeof path, "%s/models/beam.json", folder);
  if (!write_bar_recipe(path, "1e6"))
    return -1;

  // models that are made stay in the test's own folder
  snprintf(path, sizeof path, "%s/cache", folder);
  return setenv("XDG_CACHE_HOME", path, 1);
}

static int remove_models(void **state) {
  (void)state;
  test_folder_remove(folder);
  return 0;
}

static cJSON *json_of(program_result run, int exit_code) {
  if (run.exit_code != exit_code)
    print_error("%s", run.err);
  assert_int_equal(run.exit_code, exit_code);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

static const char *text_of(const cJSON *object, const char *key) {
  const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
  return cJSON_IsString(item) ? item->valuestring : "";
}

static bool file_is_there(const char *name) {
  char path[192];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  return file_exists(path);
}

/* Returns whether a page has that many plots (where gnuplot draws them), only finite numbers, and
 * its end. */
static bool report_is_whole(const char *name, int pictures) {
  const int expected = system("gnuplot --version >/dev/null 2>&1") == 0 ? pictures : 0;
  char path[192];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  char *text = text_file_read(path);
  if (text == NULL)
    return false;

  // each plot is a whole element of the page
  int begun = 0, ended = 0;
  for (const char *at = strstr(text, "<svg"); at != NULL; at = strstr(at + 1, "<svg"))
    begun++;
  for (const char *at = strstr(text, "</svg>"); at != NULL; at = strstr(at + 1, "</svg>"))
    ended++;

  // a key of several plots is a picture beside them
  const int keys = text_count(text, "<div class=wide><svg");
  const bool whole = begun == expected + keys && ended == begun && strstr(text, ">nan") == NULL &&
                     strstr(text, ">inf") == NULL && strstr(text, "</body></html>") != NULL;
  free(text);
  return whole;
}

static void a_reduced_matrix_runs_whole(void **state) {
  (void)state;
  cJSON *object = json_of(thrum_run(folder, "--models-dir", "models", "experiments", "-o", "matrix",
                                    "--models", "beam", "--time", "1.5", "--threads", "2",
                                    "--schemes", "imexv,newmark,energy", "--json", NULL),
                          0);
  const cJSON *runs = cJSON_GetObjectItem(object, "runs"), *run = NULL;

  int undamped = 0;
  assert_int_equal(cJSON_GetArraySize(runs), 3 * 2 * 3);

  // every run came to its end
  cJSON_ArrayForEach(run, runs) {
    assert_string_equal(text_of(run, "status"), "done");
    assert_string_equal(text_of(run, "model"), "beam");
    assert_true(fabs(json_value(run, "simulated_s") - 1.5) < 1e-9);
    assert_true(json_value(run, "us_per_step") > 0);
    assert_true(json_value(run, "energy_peak_j") > 0);
    assert_true(json_value(run, "energy_end_j") >= 0);
    assert_true(cJSON_IsObject(cJSON_GetObjectItem(run, "fallback_levels")));

    // the force is called for without damping
    if (json_value(run, "damping") > 0)
      continue;
    const bool sine = strcmp(text_of(run, "load"), "sine") == 0;
    const double amplitude = json_value(run, "peak_amplitude");
    assert_true(amplitude >= (sine ? 0.1 : 0.05) && amplitude < (sine ? 0.2 : 0.1));
    undamped++;

    // without a load and without damping the energy is conserved
    if (!sine && strcmp(text_of(run, "scheme"), "energy") == 0)
      assert_true(fabs(json_value(run, "energy_change")) < 1e-10);
  }

  assert_int_equal(undamped, 9);
  cJSON_Delete(object);
  assert_true(file_is_there("matrix/runs.csv"));
  assert_true(file_is_there("matrix/curves.csv"));
  assert_true(report_is_whole("matrix/report.html", 6));
}

static void damping_takes_energy_out(void **state) {
  (void)state;
  cJSON *object = json_of(thrum_run(folder, "--models-dir", "models", "experiments", "-o", "damped",
                                    "--models", "beam", "--loads", "impulse", "--time", "3",
                                    "--schemes", "imexv,energy", "--json", "-q", NULL),
                          0);
  const cJSON *runs = cJSON_GetObjectItem(object, "runs");
  assert_int_equal(cJSON_GetArraySize(runs), 4);

  // the damped runs follow the free ones
  for (int n = 0; n < 2; n++) {
    const cJSON *free_run = cJSON_GetArrayItem(runs, n), *damped = cJSON_GetArrayItem(runs, 2 + n);
    assert_true(json_value(damped, "damping") == 0.3);
    assert_string_equal(text_of(free_run, "scheme"), text_of(damped, "scheme"));

    // D = alpha 1: the energy falls as exp(-alpha t) over whole swings
    const double ratio = json_value(damped, "energy_end_j") / json_value(free_run, "energy_end_j");
    assert_true(fabs(ratio / exp(-0.3 * 3) - 1) < 0.15);
  }
  cJSON_Delete(object);
}

static void the_sweep_tells_integrators_apart(void **state) {
  (void)state;
  cJSON *object = json_of(thrum_run(folder, "--models-dir", "models", "experiments", "--sweep",
                                    "-o", "sweep", "--models", "beam", "--time", "1", "--schemes",
                                    "newmark,energy", "--json", NULL),
                          0);
  const cJSON *runs = cJSON_GetObjectItem(object, "runs"), *run = NULL;
  double newmark_fine = 0, newmark_coarse = 0, error_fine = 0, error_coarse = 0;
  assert_int_equal(cJSON_GetArraySize(runs), 10 * 2);

  // the conserving integrator has no error at any step
  cJSON_ArrayForEach(run, runs) {
    const double error = json_value(run, "energy_error");
    assert_true(fabs(json_value(run, "simulated_s") - 1) < 0.03);
    if (strcmp(text_of(run, "scheme"), "energy") == 0) {
      assert_true(error < 1e-8);
    } else if (json_value(run, "dt_s") == 1e-4) {
      newmark_fine = error;
      error_fine = json_value(run, "error");
      assert_true(json_value(run, "reference_error") < 0.01 * error_fine);
    } else if (json_value(run, "dt_s") == 1e-3) {
      newmark_coarse = error;
      error_coarse = json_value(run, "error");
    }
  }

  // newmark is of order 2
  assert_true(newmark_coarse > 30 * newmark_fine && newmark_coarse < 300 * newmark_fine);
  assert_true(error_coarse > 30 * error_fine && error_coarse < 300 * error_fine);
  cJSON_Delete(object);
  assert_true(file_is_there("sweep/sweep.csv"));
  assert_true(report_is_whole("sweep/sweep.html", 2));
}

static void energy_survives_the_long_run(void **state) {
  (void)state;
  cJSON *object =
      json_of(thrum_run(folder, "experiments", "--long", "-o", "long", "--models", "beam",
                        "--steps", LENGTH_OF_RUN("100000", "25000"), "--amplitudes", "0.05",
                        "--schemes", "imexv,energy", "--threads", "2", "--json", "-q", NULL),
              0);
  const cJSON *runs = cJSON_GetObjectItem(object, "runs"), *run = NULL;
  assert_int_equal(cJSON_GetArraySize(runs), 2);

  // windows of 35 s in 300 s, or in 75 s
  cJSON_ArrayForEach(run, runs) {
    const bool conserving = strcmp(text_of(run, "scheme"), "energy") == 0;
    assert_string_equal(text_of(run, "status"), "done");
    assert_true(json_value(run, "steps") == LENGTH_OF_RUN(100000, 25000));
    assert_true(json_value(run, "windows") == LENGTH_OF_RUN(8, 2));
    assert_true(fabs(json_value(run, "reached") - 0.05) < 1e-3);
    assert_true(fabs(json_value(run, "total_change")) <= (conserving ? 1e-12 : IMEXV_CHANGE));
    assert_true(fabs(json_value(run, "total_worst")) <= (conserving ? 1e-12 : IMEXV_WORST));
  }

  cJSON_Delete(object);
  assert_true(file_is_there("long/long.csv"));
  assert_true(file_is_there("long/long_windows.csv"));
  assert_true(report_is_whole("long/long.html", 2));
}

static char *text_in_folder(const char *name) {
  char path[192];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  char *text = text_file_read(path);
  assert_non_null(text);
  return text;
}

/* The time a step took would differ in the last digits if a run were done again. */
static void a_long_run_resumes(void **state) {
  (void)state;
  cJSON_Delete(json_of(thrum_run(folder, "--models-dir", "models", "experiments", "--long", "-o",
                                 "resumed", "--models", "beam", "--steps", "50000", "--amplitudes",
                                 "0.05", "--schemes", "newmark", "--json", "-q", NULL),
                       0));
  char *before = text_in_folder("resumed/long.csv");

  // the same run and one more: the first is taken from the table
  cJSON *object =
      json_of(thrum_run(folder, "--models-dir", "models", "experiments", "--long", "-o", "resumed",
                        "--models", "beam", "--steps", "50000", "--amplitudes", "0.02,0.05",
                        "--schemes", "newmark", "--json", "-q", "--resume", NULL),
              0);
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(object, "runs")), 2);
  cJSON_Delete(object);
  char *after = text_in_folder("resumed/long.csv");

  const char *row = strstr(before, "\nbeam,newmark,0.05,");
  assert_non_null(row);
  assert_non_null(strstr(after, row));
  assert_non_null(strstr(after, "\nbeam,newmark,0.02,"));
  free(before);
  free(after);
}

static void mistakes_are_named(void **state) {
  (void)state;
  static const char *const wrong[][3] = {
      {"--loads", "wind", "there is no 'wind'"},
      {"--schemes", "imexv,", "names with commas"},
      {"--amplitudes", "0.1,2", "shares of the length"},
      {"--threads", "0", "whole number from 1"},
      {"--dt", "-1", "a number above 0 s"},
      {"--models", "", "names with commas"},
  };

  for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
    program_result run =
        thrum_run(folder, "experiments", "-o", "wrong", wrong[n][0], wrong[n][1], NULL);
    assert_int_equal(run.exit_code, 2);
    assert_non_null(strstr(run.err, wrong[n][2]));
    program_result_free(&run);
  }

  // the steps of a sweep are its own, whatever --dt says
  program_result endless = thrum_run(folder, "experiments", "-o", "wrong", "--sweep", "--time",
                                     "1e300", "--dt", "1e300", NULL);
  assert_int_equal(endless.exit_code, 2);
  assert_non_null(strstr(endless.err, "too many steps"));
  program_result_free(&endless);
  program_result nowhere = thrum_run(folder, "experiments", NULL);
  assert_int_equal(nowhere.exit_code, 2);
  program_result_free(&nowhere);

  program_result missing =
      thrum_run(folder, "experiments", "-o", "wrong", "--models", "none.npz", NULL);
  assert_int_equal(missing.exit_code, 1);
  assert_non_null(strstr(missing.err, "none.npz"));
  program_result_free(&missing);
}

static void newmark_loses_wide_swings_at_long_steps_and_the_sweep_says_so(void **state) {
  (void)state;
  cJSON *object = json_of(thrum_run(folder, "--models-dir", "models", "experiments", "--sweep",
                                    "-o", "wide", "--models", "beam", "--time", "4", "--amplitudes",
                                    "1", "--schemes", "imexv,newmark,energy", "--json", NULL),
                          0);
  const cJSON *runs = cJSON_GetObjectItem(object, "runs"), *run = NULL;
  int lost = 0;

  // lost means that the mean energy more than doubled, or that the run ended at ten times of it
  cJSON_ArrayForEach(run, runs) {
    const bool is_lost = strcmp(text_of(run, "status"), "lost") == 0;
    const bool ended = json_value(run, "simulated_s") < 3.9;
    assert_true(is_lost == (ended || json_value(run, "energy_change") > 1));
    if (strcmp(text_of(run, "scheme"), "newmark") != 0)
      assert_string_equal(text_of(run, "status"), "done");
    lost += is_lost;
  }
  assert_true(lost > 0);
  cJSON_Delete(object);
}

static void extremes_run_or_are_refused_with_a_reason(void **state) {
  (void)state;
  cJSON *object = json_of(thrum_run(folder, "experiments", "--extremes", "-o", "extremes",
                                    "--subjects", "tet,snap", "--steps", "20", "--schemes",
                                    "imexv,newmark,energy", "--json", NULL),
                          0);
  const cJSON *runs = cJSON_GetObjectItem(object, "runs"), *run = NULL;

  int refused = 0;
  assert_int_equal(cJSON_GetArraySize(runs), 5 * 3);
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(object, "units")), 6 * 2);

  // a run that is refused says why, and only such a run
  cJSON_ArrayForEach(run, runs) {
    const bool no = strcmp(text_of(run, "outcome"), "refused") == 0;
    refused += no;
    assert_true(no == (text_of(run, "reason")[0] != 0));
  }
  assert_int_equal(refused, 3);

  cJSON_Delete(object);
  assert_true(file_is_there("extremes/extremes.csv") && file_is_there("extremes/units.csv"));
  assert_true(report_is_whole("extremes/extremes.html", 0));
  program_result wrong =
      thrum_run(folder, "experiments", "--extremes", "-o", "extremes", "--models", "beam", NULL);
  assert_int_equal(wrong.exit_code, 2);
  program_result_free(&wrong);
}

/* Stoermer-Verlet cannot step this body at 0.01 s: its fastest mode has h omega far above 2. */
static void a_scheme_alone_that_is_lost_is_a_row_that_says_when(void **state) {
  (void)state;
  cJSON *object = json_of(thrum_run(folder, "--models-dir", "models", "experiments", "--step-sizes",
                                    "-o", "alone", "--time", "2", "--schemes",
                                    "verlet,thesis,energy", "--json", "-q", NULL),
                          0);
  const cJSON *runs = cJSON_GetObjectItem(object, "runs"), *run = NULL;
  int lost = 0;
  assert_int_equal(cJSON_GetArraySize(runs), 3 * 3);

  // it ends before its time and says why; the others go on after it, with nothing that stands in
  cJSON_ArrayForEach(run, runs) {
    const bool is_lost = strcmp(text_of(run, "status"), "lost") == 0;
    assert_true(is_lost == (json_value(run, "simulated_s") < 1.9));
    assert_true(is_lost == (text_of(run, "reason")[0] != 0));
    assert_true(json_value(run, "own_steps") == json_value(run, "steps"));
    assert_true(isfinite(json_value(run, "energy_peak_j")));
    lost += is_lost;
    if (is_lost)
      assert_string_equal(text_of(run, "scheme"), "verlet");
  }
  assert_true(lost >= 1);
  cJSON_Delete(object);

  // neither the tables nor the page have a number that is none
  char *table = text_in_folder("alone/runs.csv");
  assert_null(strstr(table, "nan"));
  assert_null(strstr(table, "inf"));
  assert_non_null(strstr(table, ",verlet,lost,"));
  free(table);
  assert_true(report_is_whole("alone/runs.html", 3));
}

static void drawn_steps_keep_the_energy_of_the_energy_integrator(void **state) {
  (void)state;
  cJSON *object = json_of(thrum_run(folder, "--models-dir", "models", "experiments", "--variable",
                                    "-o", "variable", "--models", "beam", "--time", "2",
                                    "--schemes", "energy", "--json", "-q", NULL),
                          0);
  const cJSON *runs = cJSON_GetObjectItem(object, "runs"), *run = NULL;
  int drawn = 0;
  cJSON_ArrayForEach(run, runs) {
    const double longest = json_value(run, "dt_s"), shortest = json_value(run, "shortest_dt_s");
    assert_true(json_value(run, "energy_error") < 1e-8);

    // the mean of many drawn steps lies in the middle
    const double mean = json_value(run, "simulated_s") / json_value(run, "steps");
    assert_true(fabs(mean - 0.5 * (longest + shortest)) < 0.1 * longest);
    drawn += shortest < longest;
  }
  assert_int_equal(drawn, 4);
  cJSON_Delete(object);
  assert_true(report_is_whole("variable/variable.html", 2));
}

static void work_falls_and_the_error_grows_with_the_step(void **state) {
  (void)state;
  cJSON *object = json_of(thrum_run(folder, "--models-dir", "models", "experiments",
                                    "--work-precision", "-o", "work", "--models", "beam", "--time",
                                    "0.3", "--schemes", "newmark", "--json", "-q", NULL),
                          0);
  const cJSON *runs = cJSON_GetObjectItem(object, "runs");
  const int each = cJSON_GetArraySize(runs) / 2;
  assert_int_equal(each, 10);

  // after both starts: from 0.1 ms to 2 ms the time falls by 20, were all steps alike
  for (int start = 0; start < 2; start++) {
    const cJSON *fine = cJSON_GetArrayItem(runs, start * each),
                *coarse = cJSON_GetArrayItem(runs, start * each + 4);
    assert_string_equal(text_of(fine, "start"), start == 0 ? "impulse" : "smooth");
    assert_true(json_value(coarse, "dt_s") == 2e-3);
    assert_true(json_value(coarse, "cost_s_per_s") < 0.5 * json_value(fine, "cost_s_per_s"));
    assert_true(json_value(coarse, "error") > 30 * json_value(fine, "error"));
  }
  cJSON_Delete(object);
  assert_true(report_is_whole("work/work_precision.html", 2));
}

static void
without_python_the_tables_are_there_and_the_message_says_how_to_make_the_page(void **state) {
  (void)state;
  char path[256], before[4096];
  snprintf(before, sizeof before, "%s", getenv("PATH"));
  snprintf(path, sizeof path, "%s/models", folder);
  assert_int_equal(setenv("PATH", path, 1), 0);
  program_result run =
      thrum_run(folder, "--models-dir", "models", "experiments", "--sweep", "-o", "bare",
                "--models", "beam", "--time", "0.1", "--schemes", "energy", "-q", NULL);
  assert_int_equal(setenv("PATH", before, 1), 0);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "report.py sweep bare/sweep.csv"));
  assert_true(file_is_there("bare/sweep.csv") && file_is_there("bare/sweep.about.json"));
  assert_false(file_is_there("bare/sweep.html"));
  program_result_free(&run);
}

static void linear_analysis_fails_at_some_deflection(void **state) {
  (void)state;
  cJSON *object = json_of(thrum_run(folder, "--models-dir", "models", "experiments", "--linear",
                                    "-o", "linear", "--models", "beam", "--json", "-q", NULL),
                          0);
  const cJSON *runs = cJSON_GetObjectItem(object, "runs"), *run = cJSON_GetArrayItem(runs, 0);
  assert_int_equal(cJSON_GetArraySize(runs), 1);

  const double first = json_value(run, "static_5"), second = json_value(run, "static_20");

  // the error grows with the deflection
  assert_true(first > 0.005 && second > first && second < 1);
  assert_true(json_value(run, "dynamic_5") > 0);
  assert_true(json_value(run, "dynamic_20") > json_value(run, "dynamic_5"));
  assert_true(json_value(run, "nonlinear_us") > 0);

  cJSON_Delete(object);
  assert_true(file_is_there("linear/linear.csv") && file_is_there("linear/linear_curves.csv"));
  assert_true(report_is_whole("linear/linear.html", 1));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(linear_analysis_fails_at_some_deflection),
      cmocka_unit_test(a_reduced_matrix_runs_whole),
      cmocka_unit_test(damping_takes_energy_out),
      cmocka_unit_test(the_sweep_tells_integrators_apart),
      cmocka_unit_test(energy_survives_the_long_run),
      cmocka_unit_test(a_long_run_resumes),

      // mistakes and losses are said
      cmocka_unit_test(mistakes_are_named),
      cmocka_unit_test(newmark_loses_wide_swings_at_long_steps_and_the_sweep_says_so),
      cmocka_unit_test(extremes_run_or_are_refused_with_a_reason),
      cmocka_unit_test(a_scheme_alone_that_is_lost_is_a_row_that_says_when),

      // what the comparisons rest on
      cmocka_unit_test(drawn_steps_keep_the_energy_of_the_energy_integrator),
      cmocka_unit_test(work_falls_and_the_error_grows_with_the_step),
      cmocka_unit_test(
          without_python_the_tables_are_there_and_the_message_says_how_to_make_the_page),
  };
  return cmocka_run_group_tests(tests, make_models, remove_models);
}
