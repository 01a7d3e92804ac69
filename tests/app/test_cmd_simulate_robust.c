/* Tests of runs that `thrum simulate` loses with a fixed split: they complete, flagged or not, with
 * energies that make sense and with figures of what was done. SPDX-License-Identifier: Apache-2.0
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "io/file.h"
#include "tests/support/sanitized.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

static int make_beam(void **context) {
  (void)context;
  if (test_folder_make(folder) == NULL)
    return 1;
  program_result result =
      thrum_run(folder, "precompute", "beam:20x3x3@1x0.15x0.15,split=6", "--order", "1", "--fix",
                "x<0.001", "--modes", "10", "--rank", "15", "-o", "beam.npz", "--quiet", NULL);
  const int code = result.exit_code;
  program_result_free(&result);
  return code;
}

/* Runs the beam once; the caller deletes the object. */
static cJSON *run(const char *load, const char *start, const char *split, const char *integrator,
                  const char *time, const char *adaptive, int *exit_code) {
  program_result result =
      thrum_run(folder, "simulate", "--judge", "off", "beam.npz", "-o", "run", "--quiet", "--json",
                "--split", split, "--time", time, "--integrator", integrator, "--adaptive",
                adaptive, "--fallback", adaptive, "--accept-error", "100%",
                load[0] ? "--load" : "--start", load[0] ? load : start, NULL);
  cJSON *object = json_line(result.out);
  if (object == NULL)
    fail_msg("%s", result.err);
  *exit_code = result.exit_code;
  program_result_free(&result);
  return object;
}

static const char *text(const cJSON *object, const char *key) {
  const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
  return cJSON_IsString(item) ? item->valuestring : "";
}

/* The load at the tip swings at 1 Hz. The next test shows what a fixed split does with it. */
static void the_adaptive_split_runs_loads_of_forty_to_a_thousand_newtons(void **context) {
  (void)context;
  static const struct {
    const char *load;
    double most; /* energy [J] */
  } cases[4] = {{"sine:0,0,-40@tip,f=1", 3},
                {"sine:0,0,-160@tip,f=1", 50},
                {"sine:0,0,-320@tip,f=1", 160},
                {"sine:0,0,-1000@tip,f=1", 1000}};
  for (int n = 0; n < 4; n++) {
    int code = 0;
    cJSON *object = run(cases[n].load, "", "9", "imexv", "6", "on", &code);

    const cJSON *stability = cJSON_GetObjectItemCaseSensitive(object, "stability");
    const cJSON *fallback_levels = cJSON_GetObjectItemCaseSensitive(object, "fallback_levels");

    // every step succeeds, and the energy is that of the swing and no more
    assert_int_equal(json_value(object, "steps"), 2000);
    assert_int_equal(json_value(fallback_levels, "failures"), 0);
    assert_true(json_value(object, "energy_max_j") < cases[n].most);
    assert_true(json_value(object, "energy_max_j") > 0.1 * cases[n].most);

    // wide swings come near to the stability bound, and the widest need a change
    assert_true(json_value(stability, "h_sqrt_rho_peak") > 0.6);
    if (n > 1)
      assert_true(
          json_value(stability, "split_changes") + json_value(stability, "scheme_switches") > 0);
    cJSON_Delete(object);
  }
}

static void a_fixed_split_loses_what_the_stability_monitor_saves(void **context) {
  (void)context;
  int code = 0;
  cJSON *object = run("sine:0,0,-320@tip,f=1", "", "9", "imexv", "6", "off", &code);
  assert_int_equal(code, 3);
  assert_string_equal(text(object, "status"), "not_converged");
  assert_true(cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(object, "stability")));
  const cJSON *fallback_levels = cJSON_GetObjectItemCaseSensitive(object, "fallback_levels");
  assert_int_equal(json_value(fallback_levels, "failures"), 1);
  cJSON_Delete(object);
}

/* A straight mode of large amplitude holds far more energy than its frequency tells. */
static void a_violent_start_completes_with_its_energy(void **context) {
  (void)context;
  static const char *const integrators[2] = {"imexv", "energy"};
  for (int n = 0; n < 2; n++) {
    int code = 0;
    cJSON *object =
        run("", "mode:1,0.1", "cfl", integrators[n], LENGTH_OF_RUN("30", "6"), "on", &code);
    assert_int_equal(code, 0);
    assert_string_equal(text(object, "status"), "done");
    const double first = json_value(object, "energy_first_j");
    assert_true(fabs(json_value(object, "energy_last_j") / first - 1) < (n == 0 ? 1e-9 : 1e-11));
    cJSON_Delete(object);
  }
}

/* Without the monitor this run ends at 10^13 J. */
static void so_little_tangent_damping_that_it_takes_nothing_feeds_nothing_in(void **context) {
  (void)context;
  static const char *const forms[2] = {"rest", "tangent"};
  program_result made =
      thrum_run(folder, "precompute", "beam:20x3x3@1x0.15x0.15,split=6", "--order", "1", "--fix",
                "x<0.001", "--modes", "15", "--rank", "30", "-o", "fine.npz", "--quiet", NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);

  // with both forms nothing may come into the body but the work of the load
  for (int n = 0; n < 2; n++) {
    program_result result =
        thrum_run(folder, "simulate", "--judge", "off", "fine.npz", "-o", "run", "--quiet",
                  "--json", "--time", LENGTH_OF_RUN("3", "0.5"), "--load", "impulse:0,0,26000@tip",
                  "--damping", "0,1e-12", "--damping-form", forms[n], NULL);
    cJSON *object = json_line(result.out);
    assert_non_null(object);
    const cJSON *work = cJSON_GetObjectItemCaseSensitive(object, "work");
    assert_true(fabs(json_value(work, "balance_j")) < 0.1 * json_value(work, "load_j"));
    assert_true(json_value(work, "dissipated_j") < 0.1);
    assert_true(json_value(object, "energy_max_j") < 1.01 * json_value(work, "load_j"));
    cJSON_Delete(object);
    program_result_free(&result);
  }
}

/* The load bends the beam until the modes with h omega near 1 leap from side to side, near the
 * limit of fox-goodwin. Damping takes next to nothing from a leap. When the whole increment counted
 * as damped, the monitor missed energy that was there, and switched to `energy`, which took out 11
 * J of the 14 J to make the account right. */
static void fox_goodwin_counts_no_leaps_as_dissipation(void **context) {
  (void)context;
  double end[2];
  static const char *const integrators[2] = {"fox-goodwin", "newmark"};

  // the case is of linear tetrahedra, whose beam is stiffer
  program_result made =
      thrum_run(folder, "precompute", "beam", "--order", "1", "-o", "linear.npz", "--quiet", NULL);
  program_result_free(&made);

  // each steps itself to the end, with an account that adds up
  for (int n = 0; n < 2; n++) {
    program_result result =
        thrum_run(folder, "simulate", "--judge", "off", "linear.npz", "-o", "run", "--quiet",
                  "--json", "--time", "1", "--load", "square:0,0,-300@load", "--damping", "0,1e-3",
                  "--integrator", integrators[n], NULL);
    cJSON *object = json_line(result.out);
    assert_non_null(object);
    const cJSON *work = cJSON_GetObjectItemCaseSensitive(object, "work");
    assert_true(fabs(json_value(work, "balance_j")) < 0.05 * json_value(work, "dissipated_j"));
    assert_string_equal(text(object, "stepped_by"), integrators[n]);
    end[n] = json_value(object, "energy_last_j");
    cJSON_Delete(object);
    program_result_free(&result);
  }
  assert_true(fabs(end[0] / end[1] - 1.0) < 0.06);
}

/* Energy that grows is no drift where damping acts, and flags the run all the same. */
static void energy_that_grows_flags_a_damped_run_too(void **context) {
  (void)context;
  program_result result =
      thrum_run(folder, "simulate", "--judge", "off", "fine.npz", "-o", "run", "--quiet", "--json",
                "--time", "0.3", "--load", "impulse:0,0,26000@tip", "--damping", "0,1e-12",
                "--adaptive", "off", "--integrator=imexv", "--split-form", "thesis", NULL);
  cJSON *object = json_line(result.out);
  assert_non_null(object);
  assert_int_equal(result.exit_code, 3);
  assert_string_equal(text(object, "status"), "energy_grew");
  assert_true(cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(object, "drift")));
  assert_non_null(strstr(result.err, "the energy grew") ? result.err
                                                        : strstr(result.err, "the body gained"));
  cJSON_Delete(object);
  program_result_free(&result);
}

/* A load that moves nothing to speak of hides no growth, and one that does is no growth. */
static void a_tiny_load_hides_no_growth(void **context) {
  (void)context;
  static const struct {
    const char *load, *newmark;
    int code;
  } cases[] = {{"constant:0,0,1e-12@tip", "0.25,0.45", 3},
               {"sine:0,0,1e-12@tip,f=3", "0.25,0.45", 3},
               {"constant:0,0,1e-12@tip", "0.25,0.5", 0},
               {"constant:0,0,-20@tip", "0.25,0.5", 0}};
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    program_result result =
        thrum_run(folder, "simulate", "--judge", "off", "fine.npz", "-o", "run", "--quiet",
                  "--json", "--time", "1", "--dt", "0.004", "--integrator", "newmark", "--newmark",
                  cases[n].newmark, "--start", "mode:1,0.001", "--load", cases[n].load, NULL);
    if (result.exit_code != cases[n].code)
      fail_msg("%s, %s: %d, %s", cases[n].load, cases[n].newmark, result.exit_code, result.err);
    if (cases[n].code != 0)
      assert_non_null(strstr(result.err, "though the loads did next to no work"));
    program_result_free(&result);
  }
}

/* A momentum from a file, in the first modes and large: no row has another energy, but for the
 * ripple of explicit modes near the stability limit. */
static void a_violent_momentum_from_a_file_keeps_its_energy_in_every_row(void **context) {
  (void)context;
  for (double times = 1; times < 2e4; times *= 10) {
    // smaller momenta in higher modes, of both signs
    char path[200];
    double rows[30] = {0};
    for (int i = 0; i < 15; i++)
      rows[15 + i] = times * sin(1.7 * i + 1) / (1 + i);
    snprintf(path, sizeof path, "%s/kick.npy", folder);
    assert_true(save_npy(path, rows, 2, 15));

    int code = 0;
    cJSON *object = run("", "kick.npy", "cfl", "imexv", "0.3", "on", &code);
    const double first = json_value(object, "energy_first_j");
    if (!(json_value(object, "energy_max_j") < 1.15 * first &&
          json_value(object, "energy_min_j") > 0.85 * first))
      fail_msg("a kick of %g", times);
    cJSON_Delete(object);
  }
}

/* A smooth swing of a sixth of the length, in whose windows the energy ripples far more than it
 * drifts: 300 s without an edit. */
static void a_run_without_drift_is_not_edited(void **context) {
  (void)context;
  char path[200];
  const double rows[30] = {[15] = 5};
  snprintf(path, sizeof path, "%s/swing.npy", folder);
  assert_true(save_npy(path, rows, 2, 15));
  int code = 0;
  cJSON *object = run("", "swing.npy", "cfl", "imexv", LENGTH_OF_RUN("300", "30"), "on", &code);
  assert_int_equal(code, 0);
  const cJSON *stability = cJSON_GetObjectItemCaseSensitive(object, "stability");
  assert_int_equal(json_value(stability, "corrections"), 0);
  assert_true(cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(stability, "untouched")));
  assert_true(fabs(json_value(object, "drift")) < 1e-5);
  assert_true(json_value(object, "peak_displacement_m") > 0.15);
  cJSON_Delete(object);
}

/* The scheme that stepped a run stands where its integrator does: in the table, not in the JSON
 * alone. */
static void a_run_that_switches_to_the_energy_integrator_says_so(void **context) {
  (void)context;
  static const char *const integrators[2] = {"imexv", "energy"};
  for (int n = 0; n < 2; n++) {
    program_result result =
        thrum_run(folder, "simulate", "--judge", "off", "beam.npz", "-o", "run", "--quiet",
                  "--integrator", integrators[n], "--time", "3", "--start", "mode:1,0.1",
                  "--accept-error", "100%", n == 0 ? "--split=9" : NULL, NULL);
    assert_int_equal(result.exit_code, 0);

    // the headline and run.json have it too
    char path[200];
    snprintf(path, sizeof path, "%s/run/run.json", folder);
    char *json = text_file_read(path);
    assert_non_null(json);
    if (n == 0) {
      assert_non_null(strstr(result.out, "integrator   imexv, switched to energy after "));
      assert_non_null(strstr(json, "\"stepped_by\":\"imexv, switched to energy after "));
    } else {
      assert_non_null(strstr(json, "\"stepped_by\":\"energy\""));
    }
    free(json);

    // the energy integrator asked for by name has nothing to say
    const char *line = strstr(result.out, "\nswitched     ");
    if (n == 0)
      assert_non_null(line);
    else
      assert_null(line);
    program_result_free(&result);
  }
}

/* Its table, run.json and the animation of its glTF name what stepped it. */
static void fox_goodwin_says_that_it_gave_way(void **context) {
  (void)context;
  program_result result = thrum_run(folder, "simulate", "--judge", "off", "beam.npz", "-o", "fox",
                                    "--quiet", "--integrator", "fox-goodwin", "--dt", "0.006",
                                    "--time", "0.6", "--start", "mode:1,1", NULL);
  assert_true(result.exit_code == 0 || result.exit_code == 3);
  assert_non_null(strstr(result.out, "integrator   fox-goodwin, switched to energy after "));
  assert_non_null(strstr(result.out, "to which fox-goodwin switched"));
  program_result_free(&result);

  // the animation carries the same name
  result = thrum_run(folder, "export", "fox", "--glb", "fox.glb", NULL);
  assert_int_equal(result.exit_code, 0);
  program_result_free(&result);
  char path[200];
  void *bytes = NULL;
  size_t size = 0;
  snprintf(path, sizeof path, "%s/fox.glb", folder);
  assert_true(thrum_file_read(path, &bytes, &size, NULL) >= 0);
  cJSON *json = cJSON_ParseWithLength((const char *)bytes + 20, size - 20);
  const cJSON *animation = cJSON_GetArrayItem(cJSON_GetObjectItem(json, "animations"), 0);
  assert_non_null(strstr(text(animation, "name"), "fox-goodwin, switched to energy after "));
  cJSON_Delete(json);
  free(bytes);
}

static void a_newmark_run_that_is_lost_is_flagged_by_its_steps(void **context) {
  (void)context;
  program_result result =
      thrum_run(folder, "simulate", "--judge", "off", "beam.npz", "-o", "run", "--quiet", "--json",
                "--integrator", "newmark", "--newmark", "0.25,0.45", "--time", "6", "--load",
                "sine:0,0,1@tip,f=1", NULL);
  cJSON *object = json_line(result.out);
  assert_non_null(object);
  assert_int_equal(result.exit_code, 3);
  assert_string_equal(text(object, "status"), "energy_grew");
  assert_true(json_value(object, "grown_steps") > 0);
  cJSON_Delete(object);
  program_result_free(&result);
}

/* The first tenth of a run that is lost at once is large already: growth is told from the start. */
static void growth_is_told_from_the_start_of_the_free_motion(void **context) {
  (void)context;
  program_result result = thrum_run(folder, "simulate", "--judge", "off", "beam.npz", "-o", "run",
                                    "--quiet", "--json", "--integrator", "newmark", "--newmark",
                                    "0.25,0.45", "--time", "2", "--start", "mode:1,0.05", NULL);
  cJSON *object = json_line(result.out);
  assert_non_null(object);
  assert_int_equal(result.exit_code, 3);
  char told[100];
  snprintf(told, sizeof told, "the energy grew from %.3g J to ",
           json_value(object, "energy_first_j"));
  if (strstr(result.err, told) == NULL)
    fail_msg("no '%s' in: %s", told, result.err);
  cJSON_Delete(object);
  program_result_free(&result);
}

static void the_quadratic_split_needs_no_iterations_and_says_so(void **context) {
  (void)context;
  program_result result =
      thrum_run(folder, "simulate", "--judge", "off", "beam.npz", "-o", "run", "--quiet", "--json",
                "--integrator=imexv", "--split-form", "quadratic", "--time", "3", "--load",
                "impulse:0,0,-40@tip", "--dt", "0.001", NULL);

  // it ends, and has solved nothing
  cJSON *object = json_line(result.out);
  assert_non_null(object);
  assert_int_equal(result.exit_code, 0);
  assert_int_equal(json_value(object, "mean_iterations"), 0);

  // what was asked for is what stepped to the end
  const cJSON *stability = cJSON_GetObjectItemCaseSensitive(object, "stability");
  assert_string_equal(text(stability, "scheme"), "quadratic");
  const cJSON *options = cJSON_GetObjectItemCaseSensitive(object, "options");
  assert_string_equal(text(options, "split_form"), "quadratic");
  cJSON_Delete(object);
  program_result_free(&result);
}

static void a_switch_that_is_neither_on_nor_off_is_a_usage_error(void **context) {
  (void)context;
  static const char *const options[3][2] = {
      {"--adaptive", "yes"}, {"--fallback", "1"}, {"--split-form", "cubic"}};
  for (int n = 0; n < 3; n++) {
    program_result result = thrum_run(folder, "simulate", "--judge", "off", "beam.npz", "-o",
                                      "other", options[n][0], options[n][1], NULL);
    assert_int_equal(result.exit_code, 2);
    assert_non_null(strstr(result.err, options[n][0]));
    program_result_free(&result);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_adaptive_split_runs_loads_of_forty_to_a_thousand_newtons),
      cmocka_unit_test(a_fixed_split_loses_what_the_stability_monitor_saves),
      cmocka_unit_test(a_violent_start_completes_with_its_energy),
      cmocka_unit_test(so_little_tangent_damping_that_it_takes_nothing_feeds_nothing_in),
      cmocka_unit_test(fox_goodwin_counts_no_leaps_as_dissipation),
      cmocka_unit_test(energy_that_grows_flags_a_damped_run_too),
      cmocka_unit_test(a_tiny_load_hides_no_growth),
      cmocka_unit_test(a_violent_momentum_from_a_file_keeps_its_energy_in_every_row),
      cmocka_unit_test(a_run_without_drift_is_not_edited),

      // runs that say what stepped them
      cmocka_unit_test(a_run_that_switches_to_the_energy_integrator_says_so),
      cmocka_unit_test(fox_goodwin_says_that_it_gave_way),
      cmocka_unit_test(a_newmark_run_that_is_lost_is_flagged_by_its_steps),
      cmocka_unit_test(growth_is_told_from_the_start_of_the_free_motion),
      cmocka_unit_test(the_quadratic_split_needs_no_iterations_and_says_so),
      cmocka_unit_test(a_switch_that_is_neither_on_nor_off_is_a_usage_error),
  };
  return cmocka_run_group_tests(tests, make_beam, remove_folder);
}
