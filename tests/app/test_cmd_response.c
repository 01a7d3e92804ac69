/* Tests of `thrum response` as a command: its files, a run that goes on from a point of the curve,
 * and what it refuses. SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "driver/make/named_model.h"
#include "driver/response/response_report.h"
#include "io/file.h"
#include "io/npy_file.h"
#include "platform/stop_request.h"
#include "tests/support/program_object.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

#define LOAD "sine:0,0,400@near:0.5,0,0"

static int make_models(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL)
    return 1;
  program_result run =
      thrum_run(folder, "precompute", "beam:8x1x1@1x0.05x0.04", "--order", "2", "--fix", "x<0.001",
                "--fix", "x>0.999", "--young", "2e9", "--poisson", "0.3", "--density", "1000",
                "--modes", "2", "--rank", "5", "-o", "beam.npz", "-q", NULL);
  const int code = run.exit_code;
  program_result_free(&run);
  return code;
}

/* The numbers of an .npy file; the caller frees them. */
static double *numbers_of(const char *name, int64_t rows, int64_t columns) {
  double *values = NULL;
  int64_t found_rows = 0, found_columns = 0;
  assert_int_equal(thrum_npy_read_f8(in_folder(name), &values, &found_rows, &found_columns, NULL),
                   0);
  assert_int_equal(found_rows, rows);
  assert_int_equal(found_columns, columns);
  return values;
}

static void refuse(int code, const char *words, program_result run) {
  if (!is_refusal(&run, code, words))
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  program_result_free(&run);
}

static void a_forced_curve_has_its_files_and_its_folds(void **state) {
  (void)state;
  cJSON *object =
      program_object(thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--damping-ratio",
                               "0.01", "--from", "60", "--to", "100", "--harmonics", "5", "-o",
                               "forced", "--start", "9", "--no-check", "--json", NULL),
                     0);
  const int points = (int)json_value(object, "points");
  assert_true(json_value(object, "folds") == 2);
  assert_true(json_value(object, "balance") < 1e-9);
  assert_true(json_value(object, "coordinates") == 2);
  assert_true(json_value(object, "end_hz") == 100);
  cJSON_Delete(object);

  // a row for each point under the names, and the same object in the folder
  char *csv = text_file_read(in_folder("forced/response.csv"));
  assert_true(line_count_is(csv, points + 1));
  assert_int_equal(text_count(csv, ",fold,"), 2);
  free(csv);
  char *json = text_file_read(in_folder("forced/response.json"));
  assert_non_null(strstr(json, "\"kind\":\"fold\""));
  free(json);
  double *moving = numbers_of("forced/coefficients.npy", points, 11 * 2);

  // at the phase 0 all coordinates of a row are those of its start, also those that follow
  double *all = numbers_of("forced/motions.npy", points, 21 * 5);
  double *start = numbers_of("forced/point_9.npy", 2, 5);
  for (int i = 0; i < 5; i++) {
    double q = 0;
    for (int k = 0; k <= 10; k++)
      q += all[8 * 105 + 5 * k + i];
    assert_true(fabs(q - start[i]) < 1e-12 * fabs(start[0]));
  }
  assert_true(fabs(start[2]) + fabs(start[3]) + fabs(start[4]) > 1e-6 * fabs(start[0]));
  assert_true(fabs(all[8 * 105 + 5] - moving[8 * 22 + 2]) < 1e-12 * fabs(start[0]));
  free(moving);
  free(all);
  free(start);

  // quality factors are ratios in other words
  object = program_object(thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--q", "50",
                                    "--no-check", "--from", "60", "--to", "100", "--harmonics", "5",
                                    "--json", NULL),
                          0);
  assert_true(json_value(object, "points") == points);
  cJSON_Delete(object);
}

static void a_run_goes_on_from_a_point_of_the_curve(void **state) {
  (void)state;
  cJSON *object =
      program_object(thrum_run(folder, "response", "beam.npz", "--load", LOAD ",phase=90",
                               "--damping", "8,0", "--condense", "none", "--from", "60", "--to",
                               "70", "--start", "12", "-o", "start", "--json", NULL),
                     0);
  cJSON_Delete(object);
  program_result fixed = thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--damping",
                                   "8,0", "--condense", "none", "--from", "64", "--to", "70",
                                   "--start", "1", "-o", "start", "--json", NULL);
  cJSON_Delete(program_object(fixed, 0));

  // after ten periods of 64 Hz it is where it began
  cJSON_Delete(
      program_object(thrum_run(folder, "simulate", "beam.npz", "--load", LOAD ",f=64", "--damping",
                               "8,0", "--start", "start/point_1.npy", "--dt", "6.103515625e-05",
                               "--time", "0.15625", "-o", "run", "--json", "-q", NULL),
                     0));
  double *begin = numbers_of("start/point_1.npy", 2, 5), *end = numbers_of("run/end.npy", 2, 5);
  double apart = 0, size = 0;
  for (int i = 5; i < 10; i++) {
    apart += (end[i] - begin[i]) * (end[i] - begin[i]);
    size += begin[i] * begin[i];
  }
  assert_true(size > 0);
  assert_true(sqrt(apart / size) < 1e-3);
  free(begin);
  free(end);
}

static void a_run_with_damping_ratios_is_back_after_ten_periods(void **state) {
  (void)state;
  cJSON_Delete(
      program_object(thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--damping-ratio",
                               "0.02,0.001", "--condense", "none", "--from", "64", "--to", "70",
                               "--start", "1", "-o", "ratio", "--json", NULL),
                     0));
  cJSON *object = program_object(thrum_run(folder, "simulate", "beam.npz", "--load", LOAD ",f=64",
                                           "--damping-ratio", "0.02,0.001", "--start",
                                           "ratio/point_1.npy", "--dt", "6.103515625e-05", "--time",
                                           "0.15625", "-o", "run", "--json", "-q", NULL),
                                 0);
  const cJSON *work = cJSON_GetObjectItemCaseSensitive(object, "work");
  assert_true(fabs(json_value(work, "dissipated_j") / json_value(work, "load_j") - 1) < 1e-3);
  double *begin = numbers_of("ratio/point_1.npy", 2, 5), *end = numbers_of("run/end.npy", 2, 5);
  for (int i = 5; i < 10; i++)
    assert_true(fabs(end[i] - begin[i]) < 1e-3 * (fabs(begin[5]) + fabs(begin[6])));
  free(begin);
  free(end);
  cJSON_Delete(object);
}

static void a_curve_begins_on_the_branch_that_it_is_shown(void **state) {
  (void)state;
  cJSON *object =
      program_object(thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--damping-ratio",
                               "0.01", "--from", "60", "--to", "90", "--harmonics", "5",
                               "--no-check", "-o", "upper", "--json", "-q", NULL),
                     0);
  char last[16];
  snprintf(last, sizeof last, "%d", (int)json_value(object, "points"));
  const double peak = json_value(object, "peak_m");
  cJSON_Delete(object);
  object =
      program_object(thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--damping-ratio",
                               "0.01", "--from", "60", "--to", "90", "--harmonics", "5",
                               "--no-check", "-o", "upper", "--start", last, "--json", "-q", NULL),
                     0);
  cJSON_Delete(object);

  // down from 90 Hz, where a small motion is stable too
  char start[64];
  snprintf(start, sizeof start, "upper/point_%s.npy", last);
  for (int shown = 0; shown < 2; shown++) {
    object = program_object(thrum_run(folder, "response", "beam.npz", "--load", LOAD,
                                      "--damping-ratio", "0.01", "--from", "90", "--to", "89",
                                      "--harmonics", "5", "--no-check", "--json", "-q",
                                      shown ? "--start-from" : NULL, start, NULL),
                            0);
    const double found = json_value(object, "peak_m");
    assert_true(shown ? fabs(found / peak - 1) < 1e-6 : found < 0.1 * peak);
    cJSON_Delete(object);
  }
  refuse(2, "goes with --from",
         thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--start-from", start, NULL));
  refuse(1, "a state has 2 rows",
         thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--q", "50", "--from", "90",
                   "--start-from", "upper/coefficients.npy", "-q", NULL));
}

/* The tip of a bending bar without Poisson's effect swings by F phi^2 / (2 zeta omega^2), phi^2 = 4
 * / m, where the modes alone are damped; what follows them takes less than 1 % more. */
static void what_follows_the_modes_brakes_no_resonance(void **state) {
  (void)state;
  program_result made =
      thrum_run(folder, "precompute", "beam:20x1x1@1x0.025x0.01", "--order", "2", "--fix",
                "x<0.001", "--young", "2e11", "--poisson", "0", "--density", "7800", "--modes", "3",
                "--rank", "9", "-o", "bar.npz", "-q", NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);
  static const struct {
    double force;
    const char *masters;
  } cases[] = {{1, "3"}, {2, "3"}, {1, "none"}};
  const double mass = 7800 * 0.025 * 0.01;
  for (int n = 0; n < 3; n++) {
    char load[40];
    snprintf(load, sizeof load, "sine:0,0,%g@near:1,0,0", cases[n].force);
    cJSON *object = program_object(thrum_run(folder, "response", "bar.npz", "--load", load,
                                             "--damping-ratio", "0.005", "--from", "8", "--to",
                                             "8.4", "--condense", cases[n].masters, "--stability",
                                             "off", "--no-check", "--json", "-q", NULL),
                                   0);
    const cJSON *modes = cJSON_GetObjectItemCaseSensitive(object, "mode_hz");
    const double omega = 2 * acos(-1) * cJSON_GetArrayItem(modes, 0)->valuedouble;
    const double closed = cases[n].force * 4 / mass / (2 * 0.005 * omega * omega);
    const double found = json_value(object, "peak_m") / closed;
    if (!(found > 0.99 && found < 1.002))
      fail_msg("case %d: the peak is %g of the closed form", n, found);
    cJSON_Delete(object);
  }
}

static void cubature_points_have_the_curve_of_the_polynomial(void **state) {
  (void)state;
  program_result made = thrum_run(
      folder, "precompute", "beam:8x1x1@1x0.05x0.04", "--order", "2", "--fix", "x<0.001", "--fix",
      "x>0.999", "--young", "2e9", "--poisson", "0.3", "--density", "1000", "--modes", "2",
      "--rank", "5", "--cubature", "--cubature-error", "1e-6", "-o", "points.npz", "-q", NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);

  // the coefficients of the last motion; a mode may have the other sign
  double found[2][11 * 5], peak[2];
  for (int n = 0; n < 2; n++) {
    cJSON *object = program_object(
        thrum_run(folder, "response", n == 0 ? "beam.npz" : "points.npz", "--load", LOAD,
                  "--damping-ratio", "0.01", "--condense", "none", "--from", "70", "--to", "80",
                  "--harmonics", "5", "--no-check", "-o", "both", "--json", "-q", NULL),
        0);
    const int points = (int)json_value(object, "points");
    peak[n] = json_value(object, "peak_m");
    double *all = numbers_of("both/coefficients.npy", points, 11 * 5);
    memcpy(found[n], all + (points - 1) * 11 * 5, sizeof *found[n] * 11 * 5);
    free(all);
    cJSON_Delete(object);
  }
  assert_true(fabs(peak[1] / peak[0] - 1) < 1e-4);
  for (int i = 0; i < 11 * 5; i++)
    assert_true(fabs(fabs(found[1][i]) - fabs(found[0][i])) < 1e-3 * fabs(found[0][5]) + 1e-6);
}

static void a_sharp_resonance_of_a_harmonic_does_not_lose_the_curve(void **state) {
  (void)state;
  program_result made =
      thrum_run(folder, "precompute", "beam:8x1x1@1x0.05x0.04", "--order", "1", "--fix", "x<0.001",
                "--fix", "x>0.999", "--young", "2e9", "--poisson", "0.3", "--density", "1000",
                "--modes", "2", "--rank", "5", "-o", "linear.npz", "-q", NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);

  // twice 98.8 Hz meets the first mode
  cJSON *object =
      program_object(thrum_run(folder, "response", "linear.npz", "--load", LOAD, "--damping-ratio",
                               "0.01", "--condense", "none", "--from", "60", "--to", "140",
                               "--harmonics", "5", "--no-check", "--json", "-q", NULL),
                     0);
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "end")->valuestring, "arrived");
  cJSON_Delete(object);
}

static void a_backbone_ends_at_its_amplitude(void **state) {
  (void)state;
  cJSON *object =
      program_object(thrum_run(folder, "response", "beam.npz", "--mode", "1", "--amplitude", "0.02",
                               "--harmonics", "auto", "--check-error", "1", "--json", NULL),
                     0);
  const cJSON *end = cJSON_GetObjectItemCaseSensitive(object, "end");
  assert_string_equal(end->valuestring, "amplitude");
  assert_true(json_value(object, "peak_m") <= 0.02 && json_value(object, "peak_m") > 0.01998);
  assert_true(json_value(object, "tail") < 1e-6);

  // the mesh of a small body is stepped on three motions without being asked for
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(object, "mesh")), 3);
  cJSON_Delete(object);

  // one that leaves the range before says so
  program_result run =
      thrum_run(folder, "response", "beam.npz", "--mode", "1", "--amplitude", "0.02", "--harmonics",
                "3", "--to", "63", "--stability", "off", "--no-check", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "--amplitude 0.02 m was not reached"));
  program_result_free(&run);
}

/* Curves that do not come to an end take the longer the more harmonics they have: after two that do
 * not help, that of the least share is taken and said. */
static void harmonics_that_do_not_help_are_given_up(void **state) {
  (void)state;
  program_result made =
      thrum_run(folder, "precompute", "beam:4x1x1@1x0.15x0.15,split=6", "--order", "1", "--fix",
                "left", "--modes", "4", "--rank", "12", "-o", "wild.npz", "-q", NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);
  cJSON *object = program_object(thrum_run(folder, "response", "wild.npz", "--mode", "3",
                                           "--condense", "none", "--points", "100", "--stability",
                                           "off", "--no-check", "--json", "-q", NULL),
                                 3);
  assert_true(json_value(object, "harmonics") < 25 && json_value(object, "tail") > 1e-3);
  cJSON_Delete(object);
}

/* A subharmonic of a third, lightly damped, crosses the motions of the other mode at two places and
 * turns back at two. It comes back to where it began, and not to itself a period of the load later.
 */
static void a_subharmonic_closes_with_all_of_its_special_points(void **state) {
  (void)state;
  program_result made =
      thrum_run(folder, "precompute", "beam:8x1x1@1x0.02x0.04", "--fix", "x<0.001", "--fix",
                "x>0.999", "--modes", "2", "--rank", "5", "-o", "thin.npz", "-q", NULL);
  program_result_free(&made);
  cJSON *object = program_object(thrum_run(folder, "response", "thin.npz", "--mode", "1",
                                           "--amplitude", "0.03", "--at", "vertex=17", "--no-check",
                                           "--start", "9", "-o", "thin", "--json", NULL),
                                 0);
  cJSON_Delete(object);
  object = program_object(thrum_run(folder, "response", "thin.npz", "--load",
                                    "sine:0,0.2,0@vertex=17", "--damping-ratio", "0.001", "--from",
                                    "5.24965644", "--to", "40", "--periods", "3", "--start-from",
                                    "thin/point_9.npy", "--no-check", "--json", NULL),
                          0);
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "end")->valuestring, "closed");
  int kinds[2] = {0, 0};
  const cJSON *special;
  cJSON_ArrayForEach(special, cJSON_GetObjectItemCaseSensitive(object, "special")) {
    const char *kind = cJSON_GetObjectItemCaseSensitive(special, "kind")->valuestring;
    kinds[0] += strcmp(kind, "fold") == 0;
    kinds[1] += strcmp(kind, "branch point") == 0;
  }
  assert_int_equal(kinds[0], 2);
  assert_int_equal(kinds[1], 2);
  cJSON_Delete(object);
}

/* Of two modes near 1:1 all terms to order 7 are there, and they agree less far than of one. */
static void two_modes_near_a_ratio_have_one_normal_form(void **state) {
  (void)state;
  program_result made = thrum_run(folder, "precompute", "beam:6x1x1@1x0.05x0.0515", "--order", "2",
                                  "--fix", "x<0.001", "--fix", "x>0.999", "--young", "2e9",
                                  "--modes", "2", "--rank", "5", "-o", "near.npz", "-q", NULL);
  program_result_free(&made);
  cJSON *object = program_object(thrum_run(folder, "response", "near.npz", "--mode", "1",
                                           "--points", "3", "--no-check", "--json", NULL),
                                 3);
  const cJSON *one = cJSON_GetObjectItem(object, "normal_form");
  const cJSON *two = cJSON_GetObjectItem(object, "normal_form_pair");
  assert_true(json_value(two, "ratio") == 1);
  assert_true(json_value(two, "order") == 7);
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(two, "terms")), 76);
  for (int n = 0; n < 2; n++) {
    const double of_one = cJSON_GetArrayItem(cJSON_GetObjectItem(one, "good_to_m"), n)->valuedouble;
    const double of_two = cJSON_GetArrayItem(cJSON_GetObjectItem(two, "good_to_m"), n)->valuedouble;
    assert_true(of_two > 0.1 * of_one && of_two < of_one * (1 + 1e-9));
  }
  cJSON_Delete(object);
}

static void a_backbone_ends_at_the_size_of_the_body(void **state) {
  (void)state;
  cJSON *object =
      program_object(thrum_run(folder, "response", "bar.npz", "--mode", "1", "--harmonics", "5",
                               "--stability", "off", "--no-check", "--json", NULL),
                     0);
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "end")->valuestring, "amplitude");
  assert_true(json_value(object, "peak_m") > 0.9 && json_value(object, "peak_m") < 1.5);
  cJSON_Delete(object);
}

static void a_mesh_that_misses_its_orbit_flags_the_curve(void **state) {
  (void)state;
  cJSON *object =
      program_object(thrum_run(folder, "response", "beam.npz", "--mode", "1", "--amplitude", "0.01",
                               "--check", "1", "--check-error", "10%", "--json", "-q", NULL),
                     0);
  const cJSON *mesh = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(object, "mesh"), 0);
  const double missed = json_value(mesh, "missed");
  assert_true(missed > 1e-6 && missed < 0.1);
  assert_true(json_value(mesh, "missed_by_model") < 0.01);
  cJSON_Delete(object);
  object =
      program_object(thrum_run(folder, "response", "beam.npz", "--mode", "1", "--amplitude", "0.01",
                               "--check", "1", "--check-error", "1e-7", "--json", "-q", NULL),
                     3);
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "status")->valuestring, "missed");
  cJSON_Delete(object);
}

/* The largest miss of a mesh near one mode. */
static double missed_by(const char *model, const char *load, const char *ratio, const char *from,
                        const char *to) {
  cJSON *object = program_object(
      thrum_run(folder, "response", model, "--load", load, "--damping-ratio", ratio, "--from", from,
                "--to", to, "--stability", "off", "--check", "1", "--json", "-q", NULL),
      0);
  const cJSON *mesh = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(object, "mesh"), 0);
  const double missed = json_value(mesh, "missed");
  assert_true(missed > 0 && json_value(mesh, "missed_by_model") < 0.005);
  cJSON_Delete(object);
  return missed;
}

/* Modes that move alone lose their energy at 2 zeta omega, each at its own. */
static void a_mesh_is_damped_as_the_mode_that_swings(void **state) {
  (void)state;
  assert_true(missed_by("beam.npz", "sine:0,0.02,0@near:0.5,0,0", "0.1", "70", "80") < 0.02);
}

/* A load on a free body swings its shape about the motion of the whole. */
static void a_free_mesh_feels_what_bends_it(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "precompute", "beam:6x1x1@1x0.05x0.04", "--order", "1",
                                 "--modes", "2", "--rank", "5", "-o", "free.npz", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  assert_true(missed_by("free.npz", "sine:0,0,0.001@tip", "0.02", "12", "14") < 0.01);

  // what holds it does not move it, where nothing holds it
  refuse(1, "nothing holds the body",
         thrum_run(folder, "response", "free.npz", "--base-motion", "sine:0,0,1", NULL));
}

/* The same miss is worth more of a loss that is smaller. */
static void the_mesh_gains_little_of_what_damping_takes(void **state) {
  (void)state;
  double gain[2];
  for (int n = 0; n < 2; n++) {
    cJSON *object = program_object(thrum_run(folder, "response", "beam.npz", "--load", LOAD,
                                             "--damping-ratio", n == 0 ? "0.01" : "0.001", "--from",
                                             "60", "--to", "75", "--stability", "off", "--check",
                                             "1", "--check-error", "20%", "--json", "-q", NULL),
                                   0);
    const cJSON *mesh = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(object, "mesh"), 0);
    gain[n] = json_value(mesh, "gain");
    cJSON_Delete(object);
  }
  assert_true(fabs(gain[0]) < 0.1);
  assert_true(gain[1] / gain[0] > 8);
}

static void too_few_harmonics_flag_the_curve(void **state) {
  (void)state;
  cJSON *object =
      program_object(thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--damping-ratio",
                               "0.01", "--from", "20", "--to", "25", "--harmonics", "3",
                               "--stability", "off", "--no-check", "--json", "-q", NULL),
                     3);
  assert_true(json_value(object, "tail") > 1e-3);
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "status")->valuestring, "coarse");
  cJSON_Delete(object);
}

/* The last two of two are the load's and the one above it. */
static void harmonics_that_none_judge_flag_the_curve(void **state) {
  (void)state;
  cJSON *object =
      program_object(thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--damping-ratio",
                               "0.01", "--from", "20", "--to", "25", "--harmonics", "2",
                               "--stability", "off", "--no-check", "--json", "-q", NULL),
                     3);
  assert_true(isnan(json_value(object, "tail")));
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "status")->valuestring, "coarse");
  cJSON_Delete(object);
}

/* In a process of its own, as a signal stays noted. */
static void a_check_that_is_broken_off_is_no_check(void **state) {
  (void)state;
  char model[300], *words[] = {"response", model,     "--mode", "1",  "--amplitude",
                               "0.002",    "--check", "2",      "-q", NULL};
  snprintf(model, sizeof model, "%s", in_folder("beam.npz"));
  const pid_t child = fork();
  if (child == 0) {
    response_request request = {0};
    load_target target = {0};
    const char *at = NULL;
    const thrum_model *loaded = NULL;
    response_curve curve = {0};
    response_worth worth = {0};
    request.targets = &target;
    request.at = &at;
    if (response_options_read(9, words, &request) != 0 ||
        named_model_load(model, true, &loaded, NULL, NULL) < 0 ||
        response_curve_open(&request, loaded, &curve, NULL) < 0 ||
        response_curve_find(&curve, NULL) < 0)
      _exit(2);
    thrum_stop_request_catch();
    raise(SIGINT);
    if (response_worth_find(&curve, &worth, NULL) < 0)
      _exit(3);
    const char *flag = response_flag(&curve, &worth);
    _exit(worth.count == 0 && flag != NULL && strcmp(flag, "stopped") == 0 ? 0 : 4);
  }
  int status = -1;
  assert_true(child > 0 && waitpid(child, &status, 0) == child);
  assert_true(WIFEXITED(status));
  assert_int_equal(WEXITSTATUS(status), 0);
}

/* A straight beam is symmetric: nothing crosses its curve, which is the same over two periods. */
static void a_curve_of_two_periods_is_that_of_one(void **state) {
  (void)state;
  double peak[2];
  for (int n = 0; n < 2; n++) {
    cJSON *object =
        program_object(thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--damping-ratio",
                                 "0.01", "--from", "60", "--to", "100", "--stability", "off",
                                 "--no-check", "--json", "-q", "--harmonics", n == 0 ? "5" : "10",
                                 n == 0 ? NULL : "--periods", "2", "--branch", "1", NULL),
                       n == 0 ? 0 : 3);
    assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "status")->valuestring,
                        n == 0 ? "done" : "unbranched");
    const cJSON *special = cJSON_GetObjectItemCaseSensitive(object, "special");
    assert_int_equal(cJSON_GetArraySize(special), 2);
    peak[n] = json_value(cJSON_GetArrayItem(special, 0), "frequency_hz");
    cJSON_Delete(object);
  }
  assert_true(fabs(peak[1] / peak[0] - 1) < 1e-7);
}

/* A zip archive of one empty member, whose name is that of another kind of file. */
static void put_archive(const char *name) {
  static const char member[] = "modelDescription.xml";
  unsigned char bytes[200] = {'P', 'K', 3, 4, 20};
  const size_t length = sizeof member - 1;
  bytes[26] = (unsigned char)length;
  memcpy(bytes + 30, member, length);
  unsigned char *central = bytes + 30 + length, *end = central + 46 + length;
  memcpy(central, "PK\1\2\24\0\24", 7);
  central[28] = (unsigned char)length;
  memcpy(central + 46, member, length);
  memcpy(end, "PK\5\6", 4);
  end[8] = end[10] = 1;
  end[12] = (unsigned char)(46 + length);
  end[16] = (unsigned char)(30 + length);
  assert_true(thrum_file_write_atomic(in_folder(name), bytes, 30 + 46 + 22 + 2 * length, NULL) >=
              0);
}

static void bad_input_is_one_line(void **state) {
  (void)state;
  refuse(2, "which curve", thrum_run(folder, "response", "beam.npz", NULL));
  refuse(2, "the frequency goes from",
         thrum_run(folder, "response", "beam.npz", "--load", LOAD ",f=3", NULL));
  refuse(2, "loads that swing",
         thrum_run(folder, "response", "beam.npz", "--load", "impulse:0,0,1@all", NULL));
  refuse(2, "leave out the loads",
         thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--mode", "1", NULL));
  refuse(2, "without damping",
         thrum_run(folder, "response", "beam.npz", "--mode", "1", "--q", "9", NULL));
  refuse(2, "say the same thing",
         thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--q", "9", "--damping-ratio",
                   "0.1", NULL));
  refuse(2, "0.5 % is 0.005",
         thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--damping-ratio", "5", NULL));
  refuse(
      2, "0.5 % is 0.005",
      thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--damping-ratio", "0.5%", NULL));
  refuse(2, "from 0.5",
         thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--q", "0.005", NULL));
  refuse(2, "is of a load",
         thrum_run(folder, "response", "beam.npz", "--mode", "1", "--periods", "2", NULL));
  refuse(2, "the load alone",
         thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--periods", "5", "--harmonics",
                   "4", NULL));
  refuse(2, "--other-side is of",
         thrum_run(folder, "response", "beam.npz", "--load", LOAD, "--other-side", NULL));
  refuse(2, "--from",
         thrum_run(folder, "response", "beam.npz", "--mode", "1", "--from", "0", NULL));
  refuse(1, "coordinates that move",
         thrum_run(folder, "response", "beam.npz", "--mode", "4", NULL));
  refuse(1, "--load: ",
         thrum_run(folder, "response", "beam.npz", "--load", "sine:0,0,1@nowhere", "-q", NULL));
  refuse(1, "moves nothing",
         thrum_run(folder, "response", "beam.npz", "--load", "sine:0,0,1@near:0,0,0", "-q", NULL));
  put_archive("body.fmu");
  refuse(1, "thrum precompute writes model files",
         thrum_run(folder, "response", "body.fmu", "--mode", "1", NULL));
  refuse(1, "curve has points",
         thrum_run(folder, "response", "beam.npz", "--mode", "1", "--start", "999999", "-o", "none",
                   "-q", NULL));
  assert_false(file_exists(in_folder("none/response.csv")));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_forced_curve_has_its_files_and_its_folds),
      cmocka_unit_test(a_run_goes_on_from_a_point_of_the_curve),
      cmocka_unit_test(a_run_with_damping_ratios_is_back_after_ten_periods),
      cmocka_unit_test(a_curve_begins_on_the_branch_that_it_is_shown),
      cmocka_unit_test(what_follows_the_modes_brakes_no_resonance),
      cmocka_unit_test(cubature_points_have_the_curve_of_the_polynomial),
      cmocka_unit_test(a_sharp_resonance_of_a_harmonic_does_not_lose_the_curve),
      cmocka_unit_test(a_backbone_ends_at_its_amplitude),
      cmocka_unit_test(harmonics_that_do_not_help_are_given_up),
      cmocka_unit_test(a_backbone_ends_at_the_size_of_the_body),
      cmocka_unit_test(two_modes_near_a_ratio_have_one_normal_form),
      cmocka_unit_test(a_subharmonic_closes_with_all_of_its_special_points),
      cmocka_unit_test(a_mesh_that_misses_its_orbit_flags_the_curve),
      cmocka_unit_test(a_mesh_is_damped_as_the_mode_that_swings),
      cmocka_unit_test(a_free_mesh_feels_what_bends_it),
      cmocka_unit_test(the_mesh_gains_little_of_what_damping_takes),
      cmocka_unit_test(too_few_harmonics_flag_the_curve),
      cmocka_unit_test(harmonics_that_none_judge_flag_the_curve),
      cmocka_unit_test(a_check_that_is_broken_off_is_no_check),
      cmocka_unit_test(a_curve_of_two_periods_is_that_of_one),
      cmocka_unit_test(bad_input_is_one_line),
  };
  return cmocka_run_group_tests(tests, make_models, remove_folder);
}
