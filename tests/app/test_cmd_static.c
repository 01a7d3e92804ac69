/* Tests of `thrum static` as a command: its output and files, a run that starts from its
 * equilibrium, and what it refuses. SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "io/npy_file.h"
#include "io/npz.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"
#include "tests/support/program_object.h"
#include "tests/support/sanitized.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"
#include "thrum/displacement.h"
#include "thrum/polynomial.h"

/* Saves a column that buckles at half of the load that is asked for; see test_equilibrium.c. */
static bool save_column(const char *path) {
  static const int32_t format[2] = {1, 0};
  static const double omega2[2] = {1, 100}, axis_mass[6] = {0, 1};
  double c3[4] = {0}, c4[5] = {0};
  c3[thrum_c3_index(2, 0, 0, 1)] = -5;
  c4[thrum_c4_index(2, 0, 0, 0, 0)] = 1;
  const thrum_model model = {.rank = 2,
                             .c3_count = 4,
                             .c4_count = 5,
                             .format = format,
                             .omega2 = omega2,
                             .c3 = c3,
                             .c4 = c4,
                             .axis_mass = axis_mass};
  return thrum_model_save(path, &model, NULL) == THRUM_OK;
}

static int make_models(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL || !save_column(in_folder("column.npz")))
    return 1;
  return !precompute_beam("8x2x2@1x0.1x0.1", "5", "10");
}

static const char *text_of(const cJSON *object, const char *key) {
  const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
  assert_true(cJSON_IsString(item));
  return item->valuestring;
}

static void a_place_says_which_vertex_it_takes(void **state) {
  (void)state;
  cJSON *object =
      program_object(thrum_run(folder, "static", "beam.npz", "--load", "constant:0,0,-20@tip",
                               "--at", "near:0,0,0", "--json", NULL),
                     0);
  const cJSON *corner =
      cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(object, "displacements"), 0);
  assert_true(json_value(corner, "vertex") >= 1);
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(corner, "place_m")), 3);
  cJSON_Delete(object);
}

static void the_files_hold_the_equilibrium(void **state) {
  (void)state;
  cJSON *object =
      program_object(thrum_run(folder, "static", "beam.npz", "--load", "constant:0,0,-20@tip", "-o",
                               "sag.npy", "--vtu", "sag.vtu", "--path", "sag.csv", "--json", NULL),
                     0);

  assert_string_equal(text_of(object, "status"), "done");
  assert_true(json_value(object, "residual") < 1e-10);

  // the file has the same coordinates as the line on standard output
  const cJSON *q = cJSON_GetObjectItemCaseSensitive(object, "q");
  double *values = NULL;
  int64_t rows = 0, columns = 0;
  assert_int_equal(thrum_npy_read_f8(in_folder("sag.npy"), &values, &rows, &columns, NULL), 0);
  assert_int_equal(rows, 10);
  assert_int_equal(columns, 0);
  for (int i = 0; i < 10; i++)
    assert_true(cJSON_GetArrayItem(q, i)->valuedouble == values[i]);

  // the mean of the loaded group, by the library and here
  const thrum_model *model = NULL;
  const int32_t *tip = NULL;
  int64_t count = 0;
  assert_int_equal(thrum_model_load(in_folder("beam.npz"), &model, NULL), 0);
  assert_int_equal(thrum_model_group(model, "tip", &tip, &count, NULL), 0);

  double mean = 0;
  for (int64_t n = 0; n < count; n++) {
    double u[3];
    assert_int_equal(thrum_displacement(model, values, tip[n], 1, u, NULL), 0);
    mean += u[2] / (double)count;
  }

  const cJSON *shown =
      cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(object, "displacements"), 0);
  assert_string_equal(text_of(shown, "at"), "tip");
  const double told =
      cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(shown, "mean_m"), 2)->valuedouble;
  assert_true(mean < 0 && fabs(told - mean) <= 1e-12 * fabs(mean));

  // the energy of a load at full strength is minus its force times the displacement
  const double energy = json_value(object, "energy_j");
  assert_true(fabs(json_value(object, "load_energy_j") - 20 * mean) <= 1e-9 * energy);

  // the path begins at rest and ends at the full load
  char *csv = text_file_read(in_folder("sag.csv"));
  assert_non_null(csv);
  assert_true(strstr(csv, "factor,energy_j,least_eigenvalue,jumped,x1_m,y1_m,z1_m\n0,0,") == csv);
  assert_non_null(strstr(csv, "\n1,"));
  assert_true(file_exists(in_folder("sag.vtu")));

  free(csv);
  free(values);
  thrum_model_destroy(model);
  cJSON_Delete(object);
}

/* A body that starts at rest under its load does not move; without the load it swings. */
static void a_run_starts_from_the_equilibrium(void **state) {
  (void)state;
  cJSON *object = program_object(thrum_run(folder, "simulate", "beam.npz", "-o", "rest", "--time",
                                           "0.3", "--load", "constant:0,0,-20@tip", "--start",
                                           "static:constant:0,0,-20@tip", "--json", NULL),
                                 0);

  const double first = json_value(object, "energy_first_j");
  assert_true(first > 0);
  assert_true(fabs(json_value(object, "energy_max_j") - first) <= 1e-8 * first);
  assert_true(fabs(json_value(object, "energy_min_j") - first) <= 1e-8 * first);
  cJSON_Delete(object);

  // two loads act together on one equilibrium, and a file is the same start
  object =
      program_object(thrum_run(folder, "static", "beam.npz", "--load", "constant:0,0,-20@tip",
                               "--load", "gravity:0,0,-9.81", "-o", "both.npy", "--json", NULL),
                     0);
  const double both = json_value(object, "energy_j");
  cJSON_Delete(object);

  // two starts are one equilibrium under both loads, from which the body swings
  object = program_object(thrum_run(folder, "simulate", "beam.npz", "-o", "two", "--time", "0.3",
                                    "--start", "static:constant:0,0,-20@tip", "--start",
                                    "static:gravity:0,0,-9.81", "--json", NULL),
                          0);

  assert_true(fabs(json_value(object, "energy_first_j") - both) <= 1e-12 * both);
  assert_true(json_value(object, "energy_max_j") <= 1.01 * both);
  cJSON_Delete(object);

  // the file of the equilibrium is the same start
  object = program_object(thrum_run(folder, "simulate", "beam.npz", "-o", "two", "--time", "0.3",
                                    "--start", "static:both.npy", "--json", NULL),
                          0);
  assert_true(fabs(json_value(object, "energy_first_j") - both) <= 1e-12 * both);
  cJSON_Delete(object);
}

static void a_mesh_is_taken_whole(void **state) {
  (void)state;
  static const char mesh[] = "beam:8x2x2@1x0.2x0.2";

  cJSON *whole =
      program_object(thrum_run(folder, "static", mesh, "--fix", "x<0.001", "--young", "1e7",
                               "--load", "gravity:0,0,-9.81", "--full", "--json", NULL),
                     0);
  assert_true(json_value(whole, "peak_displacement_m") > 0);
  assert_true(cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(whole, "stable")));
  cJSON_Delete(whole);

  // too small for ten modes
  whole =
      program_object(thrum_run(folder, "static", "beam:1x1x1@1x1x1", "--order", "1", "--fix",
                               "x<0.001", "--load", "gravity:0,0,-9.81", "--full", "--json", NULL),
                     0);
  assert_true(json_value(whole, "components") == 12);
  cJSON_Delete(whole);

  // the mesh is made no model of, but for q; what only a mesh tells of an option is said with it
  program_result straight = thrum_run(folder, "static", mesh, "--fix", "x<0.001", "--full",
                                      "--moment", "0,-1,0@tip", NULL);
  assert_int_equal(straight.exit_code, 1);
  assert_null(strstr(straight.err, "thrum precompute"));
  assert_non_null(strstr(straight.err, "--moment '0,-1,0@tip': "));
  assert_non_null(strstr(straight.err, "these 1 lie on a line"));
  program_result_free(&straight);

  // without --full a mesh is refused, and the message names the option
  program_result run = thrum_run(folder, "static", mesh, "--load", "gravity:0,0,-9.81", NULL);
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, "is a mesh"));
  assert_non_null(strstr(run.err, "--full"));
  program_result_free(&run);
}

/* The whole mesh gives way a little more than the reduced model, and no less. */
static void the_full_order_rests_near_the_reduced_model(void **state) {
  (void)state;
  cJSON *reduced = program_object(
      thrum_run(folder, "static", "beam.npz", "--load", "gravity:0,0,-9.81", "--json", NULL), 0);
  cJSON *full =
      program_object(thrum_run(folder, "static", "beam.npz", "--load", "gravity:0,0,-9.81",
                               "--full", "--vtu", "whole.vtu", "--json", NULL),
                     0);

  // the full order has the least total potential energy, which any reduced model can only approach
  const double least = json_value(full, "energy_j") + json_value(full, "load_energy_j");
  const double energy = json_value(reduced, "energy_j") + json_value(reduced, "load_energy_j");
  assert_true(least <= energy && energy < 0 && energy - least <= 0.02 * fabs(least));

  // the displacement agrees with it to 2 %
  const double peak = json_value(full, "peak_displacement_m");
  assert_true(fabs(json_value(reduced, "peak_displacement_m") - peak) <= 0.02 * peak);
  assert_true(cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(full, "stable")));

  // it is as stiff as the reduced model says, and stable all the way
  assert_string_equal(text_of(full, "instability"), "none");
  assert_true(cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(full, "critical_factor")));
  const double hertz = json_value(full, "frequency_hz");
  assert_true(fabs(json_value(reduced, "frequency_hz") - hertz) <= 0.02 * hertz);

  // three for each of the 9 x 8 vertices that move
  assert_true(json_value(full, "components") == 3 * 9 * 8);
  assert_true(file_exists(in_folder("whole.vtu")));

  cJSON_Delete(reduced);
  cJSON_Delete(full);
}

/* A group that is moved is where it was to go, by either solver, and nothing else loads the body.
 */
static void a_group_is_brought_to_where_it_is_to_go(void **state) {
  (void)state;
  static const char *const solvers[] = {"cholesky", "cg"};
  double energy[2];
  for (int n = 0; n < 2; n++) {
    cJSON *object = program_object(thrum_run(folder, "static", "beam.npz", "--full", "--move",
                                             "0.01,0,-0.2@tip", "--at", "tip", "--linear-solver",
                                             solvers[n], "--json", NULL),
                                   0);

    const cJSON *shown =
        cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(object, "displacements"), 0);
    const cJSON *mean = cJSON_GetObjectItemCaseSensitive(shown, "mean_m");
    assert_true(fabs(cJSON_GetArrayItem(mean, 0)->valuedouble - 0.01) <= 1e-12);
    assert_true(fabs(cJSON_GetArrayItem(mean, 2)->valuedouble + 0.2) <= 1e-12);

    // what was asked is said under the option's name
    const cJSON *moves = cJSON_GetObjectItemCaseSensitive(object, "move");
    assert_string_equal(cJSON_GetStringValue(cJSON_GetArrayItem(moves, 0)), "0.01,0,-0.2@tip");

    assert_true(json_value(object, "load_energy_j") == 0);
    energy[n] = json_value(object, "energy_j");
    cJSON_Delete(object);
  }

  // both solvers find the same equilibrium
  assert_true(energy[0] > 0 && fabs(energy[1] - energy[0]) <= 1e-8 * energy[0]);
}

/* An answer that goes on from another is the same as one from rest, in the model and in the mesh.
 */
static void an_answer_goes_on_from_another(void **state) {
  (void)state;
  static const char *const forms[][4] = {{"-o", "half.npy", "--monitor", "off"},
                                         {"--full", "--displacements", "half.npy", "--json"}};
  for (int n = 0; n < 2; n++) {
    program_result half = thrum_run(folder, "static", "beam.npz", "--load", "constant:0,0,-20@tip",
                                    forms[n][0], forms[n][1], forms[n][2], forms[n][3], NULL);
    assert_int_equal(half.exit_code, 0);
    program_result_free(&half);

    const char *form = n == 0 ? "--json" : "--full";
    cJSON *on =
        program_object(thrum_run(folder, "static", "beam.npz", "--load", "constant:0,0,-60@tip",
                                 "--from", "half.npy", "--json", form, NULL),
                       0);
    cJSON *whole = program_object(thrum_run(folder, "static", "beam.npz", "--load",
                                            "constant:0,0,-60@tip", "--json", form, NULL),
                                  0);
    const double energy = json_value(whole, "energy_j");
    assert_true(energy > 0 && fabs(json_value(on, "energy_j") / energy - 1) < 1e-8);
    cJSON_Delete(on);
    cJSON_Delete(whole);
  }

  // without a load it comes back to rest, of which rounding tells nothing
  program_result bent = thrum_run(folder, "static", "beam.npz", "--load", "constant:0,0,-20@tip",
                                  "-o", "bent.npy", NULL);
  assert_int_equal(bent.exit_code, 0);
  program_result_free(&bent);
  cJSON *rest =
      program_object(thrum_run(folder, "static", "beam.npz", "--load", "constant:0,0,0@tip",
                               "--from", "bent.npy", "--json", NULL),
                     0);
  assert_true(json_value(rest, "peak_displacement_m") == 0);
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(rest, "status")->valuestring, "done");
  const cJSON *left = cJSON_GetObjectItemCaseSensitive(rest, "reactions");
  assert_true(json_value(left, "imbalance_share") == 0);
  cJSON_Delete(rest);

  // a file of another shape is refused
  program_result run = thrum_run(folder, "static", "beam.npz", "--load", "constant:0,0,-60@tip",
                                 "--from", "half.npy", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "wanted is q of 10"));
  program_result_free(&run);
}

/* Two modes have no stretch that goes with bending, and bend by half of what the mesh does. */
static void a_basis_that_cannot_bend_so_far_is_warned_of(void **state) {
  (void)state;
  static const char *const modes[] = {"2", "5"}, *const ranks[] = {"2", "10"},
                           *const models[] = {"few.npz", "more.npz"};
  for (int n = 0; n < 2; n++) {
    program_result run =
        thrum_run(folder, "precompute", "beam:8x2x2@1x0.1x0.1", "--fix", "x<0.001", "--modes",
                  modes[n], "--rank", ranks[n], "-q", "-o", models[n], NULL);
    assert_int_equal(run.exit_code, 0);
    program_result_free(&run);
    run = thrum_run(folder, "static", models[n], "--load", "constant:0,0,-200@tip", "--json", NULL);
    assert_int_equal(run.exit_code, n == 0 ? 3 : 0);
    assert_true((strstr(run.err, "the basis cannot show this shape") != NULL) == (n == 0));
    cJSON *object = json_line(run.out);
    const cJSON *estimate = cJSON_GetObjectItemCaseSensitive(object, "error_estimate");
    const double share = json_value(estimate, "share");
    assert_true(n == 0 ? share > 0.1 : share < 0.05);
    assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "status")->valuestring,
                        n == 0 ? "basis_wrong" : "done");
    cJSON_Delete(object);
    program_result_free(&run);
  }

  // as it is accepted, it is no flag
  program_result run = thrum_run(folder, "static", "few.npz", "--load", "constant:0,0,-200@tip",
                                 "--accept-error", "100%", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
}

/* A steel column of 3 m buckles at Euler's load, pi^2 E I / (4 L^2), of the usual basis too: one
 * that left modes out said a fifth less. */
static void a_column_buckles_at_eulers_load(void **state) {
  (void)state;
  const double euler = 3.14159265358979 * 3.14159265358979 * 2.1e11 * 1e-4 / 12 / 36;
  program_result run = thrum_run(folder, "precompute", "beam:30x1x1@3x0.1x0.1", "--order", "2",
                                 "--fix", "x<1e-9", "--young", "2.1e11", "--poisson", "0.28",
                                 "--density", "7850", "-q", "-o", "steel.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "static", "steel.npz", "--load", "constant:-980665,0,0@right", "--json",
                  "--accept-error", "100%", NULL);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  assert_true(fabs(980665 * json_value(object, "critical_factor") / euler - 1) < 0.01);
  cJSON_Delete(object);
  program_result_free(&run);
}

/* What is said of a model's answer under a load, over how far it is from the mesh's. */
static double said_over_found(const char *model, const char *load) {
  program_result half = thrum_run(folder, "static", model, "--load", load, "--displacements",
                                  "half_field.npy", "--json", NULL);
  program_result whole = thrum_run(folder, "static", model, "--load", load, "--displacements",
                                   "whole_field.npy", "--full", NULL);
  assert_int_equal(half.exit_code, 0);
  assert_int_equal(whole.exit_code, 0);
  double *u = NULL, *v = NULL, apart = 0, moved = 0;
  int64_t rows = 0, columns = 0;
  assert_int_equal(thrum_npy_read_f8(in_folder("half_field.npy"), &u, &rows, &columns, NULL), 0);
  assert_int_equal(thrum_npy_read_f8(in_folder("whole_field.npy"), &v, &rows, &columns, NULL), 0);
  for (int64_t n = 0; n < rows * columns; n++) {
    apart += (u[n] - v[n]) * (u[n] - v[n]);
    moved += v[n] * v[n];
  }
  cJSON *object = json_line(half.out);
  const double said =
      json_value(cJSON_GetObjectItemCaseSensitive(object, "error_estimate"), "share");
  print_message("said %.5f, found %.5f\n", said, sqrt(apart / moved));
  cJSON_Delete(object);
  free(u);
  free(v);
  program_result_free(&half);
  program_result_free(&whole);
  return said / sqrt(apart / moved);
}

/* The estimate of an answer is the difference from the mesh, to a few per cent of it: of slender
 * bodies that are well bent too, where a correction by the factor at rest said a fortieth. */
static void the_estimate_is_what_the_mesh_does_otherwise(void **state) {
  (void)state;
  assert_true(fabs(said_over_found("beam.npz", "constant:0,3,-5@tip") - 1) < 0.05);
  program_result run = thrum_run(folder, "precompute", "beam:20x2x2@1x0.05x0.05", "--fix", "left",
                                 "-q", "-o", "slender.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  assert_true(fabs(said_over_found("slender.npz", "gravity:0,0,-9.81") - 1) < 0.05);
  assert_true(fabs(said_over_found("slender.npz", "constant:0,0,-10@right") - 1) < 0.05);
}

/* StVK carries no more under such a compression, which the whole mesh tells as the reduced model.
 */
static void a_block_pressed_by_half_is_warned_of(void **state) {
  (void)state;
  program_result made = thrum_run(folder, "precompute", "beam:2x1x1@1x0.5x0.5", "--order", "1",
                                  "--fix", "x<1e-9", "--modes", "2", "-o", "block.npz", NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);
  static const char *const laws[] = {"stvk", "neo-hookean"}, *const moves[] = {"-0.45,0,0@right",
                                                                               "-0.1,0,0@right"};

  // each law, pressed by nearly half and by a tenth
  for (int n = 0; n < 4; n++) {
    char move[40];
    snprintf(move, sizeof move, "--move=%s", moves[n / 2]);
    program_result run = thrum_run(folder, "static", "block.npz", "--full", move, "--law",
                                   laws[n % 2], "--json", NULL);
    assert_true((strstr(run.err, "StVK gives way") != NULL) == (n == 0));
    cJSON *object = json_line(run.out);
    const double stretch =
        json_value(cJSON_GetObjectItemCaseSensitive(object, "monitor"), "least_stretch");
    assert_true(n < 2 ? stretch > 0 && stretch < 0.577 : stretch > 0.8 && stretch < 0.95);
    cJSON_Delete(object);
    program_result_free(&run);
  }
}

/* A face that is turned by a right angle in one run, and brought in a straight line to its place on
 * the circle, bends the strip to the arc: E I theta^2/2. */
static void a_path_stays_on_its_branch(void **state) {
  (void)state;
  program_result made = thrum_run(folder, "precompute", "beam:16x1x1@1x0.02x0.02", "--order", "2",
                                  "--fix", "x<1e-9", "--fix", "y>-1e9:y", "--young", "1e6",
                                  "--poisson", "0", "--modes", "4", "-o", "strip.npz", NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);
  cJSON *object =
      program_object(thrum_run(folder, "static", "strip.npz", "--full", "--rotate", "0,-90,0@right",
                               "--move=-0.36338,0,0.63662@right", "--json", NULL),
                     0);
  const double arc = 1e6 * pow(0.02, 4) / 12 * pow(1.5707963267948966, 2) / 2;
  assert_true(fabs(json_value(object, "energy_j") / arc - 1) < 0.01);
  assert_true(cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(object, "lower_energy_j")));
  cJSON_Delete(object);
}

static const cJSON *list_of(const cJSON *object, const char *key) {
  const cJSON *list = cJSON_GetObjectItemCaseSensitive(object, key);
  assert_true(cJSON_IsArray(list));
  return list;
}

static double item(const cJSON *object, const char *key, int n) {
  return cJSON_GetArrayItem(list_of(object, key), n)->valuedouble;
}

/* Of the whole mesh, what holds a body is the load with the other sign, and its moment too where
 * the body is now; the file has the same force by force, and a group is a part of it. */
static void reactions_balance_the_load(void **state) {
  (void)state;
  cJSON *object =
      program_object(thrum_run(folder, "static", "beam.npz", "--full", "--load",
                               "constant:3,0,-20@tip", "--load", "gravity:0,1,-9.81", "--follow",
                               "0,0,-2@right", "--reactions", "held.csv", "--json", NULL),
                     0);
  const cJSON *found = cJSON_GetObjectItemCaseSensitive(object, "reactions");
  for (int axis = 0; axis < 3; axis++) {
    assert_true(fabs(item(found, "force_n", axis) + item(found, "load_force_n", axis)) <=
                1e-9 * fabs(item(found, "load_force_n", 2)));
    assert_true(fabs(item(found, "moment_nm", axis) + item(found, "load_moment_nm", axis)) <=
                1e-9 * fabs(item(found, "load_moment_nm", 1)));
  }
  assert_true(item(found, "load_force_n", 2) < -22 && json_value(found, "imbalance_share") < 1e-9);
  assert_true(json_value(object, "inverted_tets") == 0);

  // the file has the numbers of the held vertices
  char *csv = text_file_read(in_folder("held.csv"));
  assert_non_null(csv);
  assert_true(strstr(csv, "vertex,x_m,y_m,z_m,fx_n,fy_n,fz_n\n") == csv);
  double sum = 0, fz = 0;
  int rows = 0;
  for (const char *at = strchr(csv, '\n') + 1; *at != 0; at = strchr(at, '\n') + 1, rows++) {
    assert_int_equal(sscanf(at, "%*d,%*f,%*f,%*f,%*f,%*f,%lf", &fz), 1);
    sum += fz;
  }
  assert_true(rows == 9 && json_value(found, "vertices") == 9);
  assert_true(fabs(sum - item(found, "force_n", 2)) <= 1e-9 * sum);
  const cJSON *group = cJSON_GetArrayItem(list_of(found, "groups"), 0);
  assert_string_equal(text_of(group, "target"), "left");
  assert_true(item(group, "force_n", 2) == item(found, "force_n", 2));
  free(csv);
  cJSON_Delete(object);
}

/* A moved group is held by a force as well, against which the clamp holds. */
static void what_is_moved_has_a_reaction(void **state) {
  (void)state;
  cJSON *object = program_object(
      thrum_run(folder, "static", "beam.npz", "--full", "--move", "0,0,-0.05@tip", "--json", NULL),
      0);
  const cJSON *groups = list_of(cJSON_GetObjectItemCaseSensitive(object, "reactions"), "groups");
  const cJSON *left = cJSON_GetArrayItem(groups, 0), *tip = NULL, *row;
  cJSON_ArrayForEach(row, groups) tip =
      cJSON_IsString(cJSON_GetObjectItemCaseSensitive(row, "option")) ? row : tip;
  assert_string_equal(text_of(tip, "target"), "tip");
  assert_string_equal(text_of(tip, "option"), "move");
  assert_true(item(tip, "force_n", 2) < 0);
  assert_true(fabs(item(left, "force_n", 2) / item(tip, "force_n", 2) + 1) < 1e-7);
  cJSON_Delete(object);
}

/* Of gravity alone the share that is left over is that of the weight, also where ten nodes turn
 * some of it round at their corners: the lengths of these forces are 1.4 times the weight. */
static void the_share_that_is_left_of_gravity_is_that_of_the_weight(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "precompute", "beam:4x1x1@1x0.1x0.1", "--order", "2", "--fix", "x<0.001",
                "--modes", "2", "--rank", "4", "-o", "ten.npz", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  cJSON *object =
      program_object(thrum_run(folder, "static", "ten.npz", "--load", "gravity:0,0,-0.1",
                               "--accept-error", "99%", "--json", NULL),
                     0);
  const cJSON *found = cJSON_GetObjectItemCaseSensitive(object, "reactions");
  double left = 0, weight = 0;
  for (int axis = 0; axis < 3; axis++) {
    left += pow(item(found, "imbalance_n", axis), 2);
    weight += pow(item(found, "load_force_n", axis), 2);
  }
  const double share = json_value(found, "imbalance_share");
  assert_true(share > 0.001 && fabs(share / sqrt(left / weight) - 1) < 1e-9);
  cJSON_Delete(object);
}

/* A model balances the load as far as its basis goes, and says how far that is. */
static void a_model_says_what_its_reactions_lack(void **state) {
  (void)state;
  cJSON *object = program_object(
      thrum_run(folder, "static", "beam.npz", "--load", "constant:0,0,-20@tip", "--json", NULL), 0);
  const cJSON *found = cJSON_GetObjectItemCaseSensitive(object, "reactions");
  const double share = json_value(found, "imbalance_share");
  assert_true(share > 1e-6 && share < 0.5);
  assert_true(fabs(item(found, "force_n", 2) - 20) <= 20 * share * 1.0001);
  assert_true(item(found, "load_force_n", 2) == -20 ||
              fabs(item(found, "load_force_n", 2) + 20) < 1e-12);
  cJSON_Delete(object);
}

/* Reactions that leave over a tenth of the load are warned of, and beyond all of it, as of a column
 * that has buckled, no file is written. */
static void reactions_that_are_wrong_are_said_or_refused(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "static", "beam.npz", "--load", "constant:0,0,-200@tip",
                                 "--reactions", "said.csv", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "the reactions are wrong by about"));
  program_result_free(&run);
  run = thrum_run(folder, "precompute", "beam:20x1x1@1x0.02x0.02", "--order", "2", "--fix", "left",
                  "--young", "2.1e11", "--poisson", "0.3", "--density", "7850", "-q", "-o",
                  "thin.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "static", "thin.npz", "--load", "constant:-9000,0,0@right", "--reactions",
                  "refused.csv", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_string_equal(run.out, "");
  assert_non_null(strstr(run.err, "--reactions refused.csv: not written"));
  assert_null(fopen(in_folder("refused.csv"), "r"));
  program_result_free(&run);
}

/* What is held bears a load on it by itself, and the body stays as it is. */
static void a_load_that_moves_nothing_is_warned_of(void **state) {
  (void)state;
  static const char *const modes[] = {NULL, "--full"};
  for (int n = 0; n < 2; n++) {
    program_result run = thrum_run(folder, "static", "beam.npz", "--load", "constant:0,0,-20@left",
                                   "--json", modes[n], NULL);
    assert_int_equal(run.exit_code, 0);
    assert_non_null(strstr(run.err, "the load moves nothing"));
    program_result_free(&run);
  }

  // what is moved needs no load
  program_result run = thrum_run(folder, "static", "beam.npz", "--full", "--load",
                                 "constant:0,0,-20@left", "--move", "0.001,0,0@right", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_null(strstr(run.err, "moves nothing"));
  program_result_free(&run);
}

/* Weight moves a free body as a whole, and what is left of it in the mesh is rounding. */
static void a_weight_that_bends_nothing_says_nothing_of_the_basis(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "precompute", "beam:8x2x2@1x0.1x0.1", "-o", "free.npz", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  cJSON *object = program_object(
      thrum_run(folder, "static", "free.npz", "--load", "gravity:3,-4,-9.81", "--json", NULL), 0);
  assert_true(json_value(cJSON_GetObjectItem(object, "error_estimate"), "share") == 0);
  cJSON_Delete(object);
}

/* A pulled bar bears the traction everywhere, and what is said of it is at the nodes. */
static void the_stress_is_said_with_its_place(void **state) {
  (void)state;
  for (int order = 1; order <= 2; order++) {
    cJSON *object =
        program_object(thrum_run(folder, "static", "beam:4x2x2@1x0.1x0.1", "--order",
                                 order == 1 ? "1" : "2", "--full", "--fix", "x<1e-9", "--young",
                                 "1e9", "--poisson", "0", "--density", "1000", "--load",
                                 "traction:1e4,0,0@right", "--vtu", "pulled.vtu", "--json", NULL),
                       0);
    const cJSON *stress = cJSON_GetObjectItemCaseSensitive(object, "stress");
    assert_string_equal(text_of(stress, "kind"), order == 1 ? "patch average" : "nodes");
    assert_true(fabs(json_value(stress, "peak_von_mises_pa") / 1e4 - 1) < 1e-3);
    assert_true(json_value(stress, "peak_region") == 1 && json_value(stress, "peak_vertex") >= 1);
    assert_int_equal(cJSON_GetArraySize(list_of(stress, "peak_place_m")), 3);
    char *vtu = text_file_read(in_folder("pulled.vtu"));
    assert_non_null(strstr(vtu, order == 1 ? "\"von_mises_patch_average\"" : "\"von_mises\""));
    free(vtu);
    cJSON_Delete(object);
  }
}

/* The root of a cantilever of solid-shells bears 6 F (L - h/2)/(b t^2), h the length of its
 * elements, and a frame has the elements as they are. */
static void solid_shells_bear_the_stress_of_bending(void **state) {
  (void)state;
  cJSON *object = program_object(thrum_run(folder, "static", "beam:20x1x1@1x0.1x0.01,hex", "--full",
                                           "--fix", "left", "--young", "7e10", "--poisson", "0",
                                           "--density", "2700", "--load", "constant:0,0,-1@right",
                                           "--vtu", "bent.vtu", "--json", NULL),
                                 0);
  const cJSON *stress = cJSON_GetObjectItemCaseSensitive(object, "stress");
  assert_string_equal(text_of(stress, "kind"), "nodes");
  assert_true(fabs(json_value(stress, "peak_von_mises_pa") / (6 * 0.975 / (0.1 * 1e-4)) - 1) <
              2e-3);
  cJSON_Delete(object);
  program_result run = thrum_run(folder, "check", "bent.vtu", NULL);
  assert_non_null(strstr(run.out, "20 solid-shell hexahedra"));
  program_result_free(&run);
}

/* A shape with elements inside out is no answer, of the mesh or of a model. */
static void a_body_inside_out_is_flagged(void **state) {
  (void)state;
  cJSON *object = program_object(thrum_run(folder, "static", "block.npz", "--full", "--move",
                                           "-1.2,0,0@right", "--json", NULL),
                                 3);
  assert_string_equal(text_of(object, "status"), "inverted");
  assert_true(json_value(object, "inverted_tets") > 0);
  cJSON_Delete(object);
  program_result run =
      thrum_run(folder, "static", "block.npz", "--load", "constant:-2e6,0,0@right", "--json", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.err, "turned inside out"));
  program_result_free(&run);
}

/* The mesh tells about where it buckles, by a model that has that right and by one that has not:
 * Euler's pi^2 E I/(4 L^2) is 479.77 kN. */
static void a_critical_load_is_judged_by_the_mesh(void **state) {
  (void)state;
  static const char *const ranks[] = {"12", "40"};
  for (int n = 0; n < 2; n++) {
    program_result run =
        thrum_run(folder, "precompute", "beam:30x2x2@3x0.1x0.1", "--order", "2", "--fix", "x<1e-9",
                  "--young", "2.1e11", "--poisson", "0.28", "--density", "7850", "--modes", "10",
                  "--rank", ranks[n], "-o", "euler.npz", NULL);
    assert_int_equal(run.exit_code, 0);
    program_result_free(&run);
    run = thrum_run(folder, "static", "euler.npz", "--load", "constant:-600000,0,0@right", "--json",
                    NULL);
    assert_int_equal(run.exit_code, 3);
    cJSON *object = json_line(run.out);
    const double critical = json_value(object, "critical_factor") * 600 / 479.77;
    const double mesh = json_value(object, "critical_factor_mesh") * 600 / 479.77;
    assert_true(fabs(mesh - 1) < 0.04);
    assert_true((strstr(run.err, "has the critical load wrong") != NULL) ==
                (fabs(critical / mesh - 1) > 0.05));
    assert_true(n == 0 || fabs(critical - 1) < 0.01);
    cJSON_Delete(object);
    program_result_free(&run);
  }
}

/* Writes a block of length 1 and height 0.02, bent to a cosine arch of rise 0.03, in the form of
 * Gmsh 2.2; returns the vertex (from 1) at the middle of its crown. */
static int64_t write_arch(const char *block, const char *path) {
  thrum_mesh mesh;
  assert_int_equal(thrum_mesh_read(block, 1, &mesh, NULL), THRUM_OK);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fprintf(file, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n", (int)mesh.vertex_count);
  int64_t crown = 0;
  double nearest = 1;
  for (int64_t v = 0; v < mesh.vertex_count; v++) {
    const double *x = mesh.vertices + 3 * v, z = x[2] + 0.015 * (1 - cos(6.283185307179586 * x[0]));
    const double apart = fabs(x[0] - 0.5) + fabs(x[1]) + fabs(x[2] - 0.01);
    crown = apart < nearest ? v + 1 : crown;
    nearest = fmin(apart, nearest);
    fprintf(file, "%d %.17g %.17g %.17g\n", (int)v + 1, x[0], x[1], z);
  }
  fprintf(file, "$EndNodes\n$Elements\n%d\n", (int)mesh.tet_count);
  for (int64_t t = 0; t < mesh.tet_count; t++) {
    const int32_t *tet = mesh.tets + 4 * t;
    fprintf(file, "%d 4 2 1 1 %d %d %d %d\n", (int)t + 1, tet[0] + 1, tet[1] + 1, tet[2] + 1,
            tet[3] + 1);
  }
  fprintf(file, "$EndElements\n");
  assert_int_equal(fclose(file), 0);
  thrum_mesh_free(&mesh);
  assert_true(nearest < 1e-9);
  return crown;
}

/* A clamped cosine arch gives way under 2.24 N at its crown. The model that precompute makes of it
 * by default finds that, however far beyond it is loaded. */
static void the_default_model_of_an_arch_snaps_through(void **state) {
  (void)state;
  const int64_t crown = write_arch("beam:20x2x2@1x0.05x0.02", in_folder("arch.msh"));
  program_result run =
      thrum_run(folder, "precompute", "arch.msh", "--fix", "x<1e-9", "--fix", "x>0.999999999",
                "--young", "1e7", "--poisson", "0.3", "--density", "1000", "-o", "arch.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  static const double loads[] = {3, 100};
  for (int n = 0; n < 2; n++) {
    char load[64];
    snprintf(load, sizeof load, "constant:0,0,-%g@vertex=%d", loads[n], (int)crown);
    cJSON *object =
        program_object(thrum_run(folder, "static", "arch.npz", "--load", load, "--json", NULL), 3);
    assert_string_equal(text_of(object, "instability"), "limit point");
    assert_true(fabs(json_value(object, "critical_factor") * loads[n] / 2.24 - 1) < 0.01);
    cJSON_Delete(object);
  }
}

/* The rows of a path by --full: how many fell, and the last factor that is stable before one did.
 */
static int fallen_rows(const char *csv, double *before) {
  int fell = 0, read = 0, rows = 0;
  double factor, energy, least, last = 0;
  *before = NAN;
  const char *row = strchr(csv, '\n');
  for (; row && row[1]; row = strchr(row + 1, '\n'), rows++) {
    int jumped = 0;
    read = sscanf(row + 1, "%lf,%lf,%lf,%d", &factor, &energy, &least, &jumped);
    assert_int_equal(read, 4);
    assert_true(factor >= last && least > 0);
    if (jumped && fell++ == 0)
      *before = last;
    last = factor;
  }
  assert_true(rows > 3 && last == 1);
  return fell;
}

/* The path of the whole mesh begins at rest, ends at the load, and shows where the body fell. */
static void the_path_of_the_mesh_shows_the_snap(void **state) {
  (void)state;
  const int64_t crown = write_arch("beam:20x2x2@1x0.05x0.02", in_folder("flat.msh"));
  char load[64];
  snprintf(load, sizeof load, "constant:0,0,-8@vertex=%d", (int)crown);
  cJSON *object =
      program_object(thrum_run(folder, "static", "flat.msh", "--full", "--fix", "x<1e-9", "--fix",
                               "x>0.999999999", "--young", "1e7", "--poisson", "0.3", "--density",
                               "1000", "--load", load, "--path", "snap.csv", "--json", NULL),
                     3);
  assert_string_equal(text_of(object, "instability"), "limit point");
  char *csv = text_file_read(in_folder("snap.csv"));
  assert_non_null(csv);
  assert_true(strstr(csv, "factor,energy_j,least_eigenvalue,jumped,x1_m,y1_m,z1_m\n0,0,") == csv);
  double before;
  assert_int_equal(fallen_rows(csv, &before), (int)json_value(object, "jumps"));
  const double critical = json_value(object, "critical_factor");
  assert_true(before <= critical && before > critical * (1 - 1e-5));
  free(csv);
  cJSON_Delete(object);

  // loads that turn are followed as well, and nothing is known of stability there
  object =
      program_object(thrum_run(folder, "static", "beam.npz", "--full", "--follow", "0,0,-1@right",
                               "--at", "right", "--path", "turn.csv", "--json", NULL),
                     0);
  cJSON_Delete(object);
  csv = text_file_read(in_folder("turn.csv"));
  assert_true(csv && strstr(csv, "\n0,0,nan,0,0,0,0\n") && strstr(csv, "\n1,"));
  free(csv);

  // a search that ends nowhere leaves no file
  program_result run = thrum_run(folder, "static", "beam.npz", "--full", "--load",
                                 "constant:0,0,-1@nowhere", "--path", "none.csv", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_true(!file_exists(in_folder("none.csv")));
  program_result_free(&run);
}

/* An arch as wide as high leaves its plane first. Its stiffness does not fall in proportion to the
 * load, and its mesh bears its model out all the same. */
static void a_mesh_bears_out_the_critical_load_of_an_arch(void **state) {
  (void)state;
  char load[64];
  snprintf(load, sizeof load, "constant:0,0,-0.15@vertex=%d",
           (int)write_arch("beam:20x2x2@1x0.02x0.02", in_folder("narrow.msh")));
  program_result run =
      thrum_run(folder, "precompute", "narrow.msh", "--fix", "x<1e-9", "--fix", "x>0.999999999",
                "--young", "1e6", "--poisson", "0", "--density", "1000", "-o", "narrow.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "static", "narrow.npz", "--load", load, "--json", NULL);
  assert_null(strstr(run.err, "has the critical load wrong"));
  cJSON *object = program_object(run, 3);

  // 0.0760 N by static --full
  assert_string_equal(text_of(object, "instability"), "bifurcation");
  assert_true(fabs(json_value(object, "critical_factor") * 0.15 / 0.0760 - 1) < 0.01);
  assert_true(fabs(json_value(object, "critical_factor_mesh") * 0.15 / 0.0760 - 1) < 0.01);
  cJSON_Delete(object);
}

/* Two bending modes buckle at the same load, and the valley that the column falls along is curved.
 */
static void a_square_column_is_followed_beyond_its_critical_load(void **state) {
  (void)state;
  program_result made = thrum_run(folder, "precompute", "beam:20x1x1@1x0.05x0.05", "--order", "2",
                                  "--fix", "x<0.001", "--young", "1e6", "--poisson", "0", "--modes",
                                  "6", "--rank", "10", "-o", "square.npz", NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);
  static const char *const factors[] = {"3", "4", "6", "20"};
  for (int n = 0; n < 4; n++) {
    cJSON *object =
        program_object(thrum_run(folder, "static", "square.npz", "--load", "constant:-1,0,0@tip",
                                 "--factor", factors[n], "--monitor", "off", "--json", NULL),
                       3);
    assert_string_equal(text_of(object, "status"), "buckled");

    // Euler's load, pi^2 E I/(4 L^2)
    const double euler = 9.8696044 * 1e6 * pow(0.05, 4) / 12 / 4;
    assert_true(fabs(json_value(object, "critical_factor") / euler - 1) < 0.02);
    cJSON_Delete(object);
  }
}

/* A search that comes to nothing beyond Euler's load, pi^2 E I/(4 L^2), says that the body buckles
 * there and keeps the path; a small load across leads it on. */
static void what_is_not_found_beyond_buckling_is_named(void **state) {
  (void)state;
  char load[64];
  snprintf(load, sizeof load, "constant:%.17g,0,0@right",
           -1.02 * 9.8696044 * 2.1e11 * pow(0.006, 4) / 12 / 4);
  static const char *const across[] = {"constant:0,0,0@right", "constant:0,0,0.05@right"};
  for (int n = 0; n < LENGTH_OF_RUN(2, 1); n++) {
    program_result run =
        thrum_run(folder, "static", "beam:12x1x1@1x0.006x0.006", "--order", "2", "--fix", "left",
                  "--young", "2.1e11", "--poisson", "0.3", "--density", "7850", "--load", load,
                  "--load", across[n], "--full", "--path", n == 0 ? "to.csv" : "on.csv", NULL);
    assert_int_equal(run.exit_code, n == 0 ? 1 : 0);
    const char *place = strstr(run.err, "the body buckles at ");
    assert_true((place != NULL) == (n == 0));
    if (place != NULL)
      assert_true(fabs(1.02 * strtod(place + strlen("the body buckles at "), NULL) - 1) < 0.02);
    program_result_free(&run);
  }

  // up to the critical load
  char *csv = text_file_read(in_folder("to.csv"));
  assert_non_null(csv);
  assert_non_null(strstr(csv, "\n0.99"));
  free(csv);
}

/* The frequency at rest is that of the body, and not an estimate on the way: of a cube two modes
 * are alike, and it was 1e-4 too high. */
static void the_frequency_at_rest_is_exact(void **state) {
  (void)state;
  cJSON *object = program_object(thrum_run(folder, "static", "beam:5x5x5@1x1x1", "--order", "1",
                                           "--fix", "left", "--load", "constant:0,0,-1e-3@right",
                                           "--full", "--json", NULL),
                                 0);
  const double rest = json_value(object, "frequency_rest_hz");
  assert_true(fabs(json_value(object, "frequency_hz") / rest - 1) < 1e-6);
  cJSON_Delete(object);
}

static void buckling_is_flagged_with_its_load(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "static", "column.npz", "--load", "gravity:20,0,0", "--json", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.err, "buckles at 0.5 of the load"));

  // half of the load is critical, and the answer lies on the stable branch
  cJSON *object = json_line(run.out);
  assert_string_equal(text_of(object, "status"), "buckled");
  assert_string_equal(text_of(object, "instability"), "bifurcation");
  assert_true(fabs(json_value(object, "critical_factor") - 0.5) <= 1e-8);
  assert_true(cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(object, "stable")));
  cJSON_Delete(object);
  program_result_free(&run);

  // with --stay the answer is on the branch that is no longer stable
  object = program_object(thrum_run(folder, "static", "column.npz", "--load", "gravity:20,0,0",
                                    "--stay", "--json", NULL),
                          3);
  assert_string_equal(text_of(object, "status"), "unstable");
  assert_true(cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(object, "frequency_hz")));
  cJSON_Delete(object);
}

typedef struct refusal {
  int code;
  const char *says;
  const char *arguments[6];
} refusal;

static void slips_are_refused_in_one_line(void **state) {
  (void)state;
  static const refusal cases[] = {
      // mistakes of usage
      {2, "under which load?", {"beam.npz"}},
      {2, "no model given", {"--load", "gravity:0,0,-9.81"}},
      {2, "begins with impulse", {"beam.npz", "--load", "weight:1,2,3"}},
      {2, "did you mean 'cholesky'?", {"beam.npz", "--full", "--linear-solver", "choleski"}},
      {1, "did you mean 'top'?", {"beam.npz", "--load", "constant:0,0,1@tep"}},
      {2, "a number above 0", {"beam.npz", "--load", "gravity:0,0,-1", "--factor", "-2"}},
      {2, ".npy", {"beam.npz", "--load", "gravity:0,0,-1", "-o", "sag.npz"}},
      {2, "vertex= takes", {"beam.npz", "--load", "gravity:0,0,-1", "--at", "vertex=0"}},
      {2, "--move goes with --full", {"beam.npz", "--move", "0,0,1@tip"}},
      {2, "X,Y,Z@TARGET", {"beam.npz", "--full", "--move", "0,1@tip"}},
      {2, "--stay is of a reduced", {"beam.npz", "--full", "--load", "gravity:0,0,-1", "--stay"}},

      // what the model, the mesh or the folder lacks
      {1, "no group 'nose'", {"beam.npz", "--full", "--move", "0,0,1@nose"}},
      {1, "one vertex has no direction", {"beam.npz", "--full", "--rotate", "0,9,0@near:1,0,0"}},
      {1, "no mesh", {"column.npz", "--full", "--load", "gravity:0,0,-1"}},
      {1, "no group 'nose'", {"beam.npz", "--load", "gravity:0,0,-1", "--at", "nose"}},
      {1, "no group 'nose'", {"beam.npz", "--load", "constant:0,0,-1@nose"}},
      {1, "vertices 1 to", {"beam.npz", "--load", "constant:0,0,-1@vertex=9999"}},
      {1, "no basis", {"column.npz", "--load", "constant:0,0,-1@all"}},
      {1,
       "--reactions: the model has no mesh",
       {"column.npz", "--load", "gravity:1,0,0", "--reactions", "column.csv"}},
      {1, "missing.npz", {"missing.npz", "--load", "gravity:0,0,-1"}},
      {1, "cannot", {"beam.npz", "--load", "gravity:0,0,-1", "-o", "nowhere/q.npy"}},
      {1, "nowhere", {"beam.npz", "--load", "gravity:0,0,-1", "--vtu", "nowhere/q.vtu"}},
  };

  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    const char *const *a = cases[n].arguments;
    program_result run = thrum_run(folder, "static", a[0], a[1], a[2], a[3], a[4], a[5], NULL);
    if (run.exit_code != cases[n].code || strstr(run.err, cases[n].says) == NULL)
      fail_msg("case %d: exit %d: %s", (int)n, run.exit_code, run.err);
    assert_true(line_count_is(run.err, 1));
    assert_string_equal(run.out, "");
    program_result_free(&run);
  }
}

/* A file that cannot be written is found before the search, and the others are left as they are. */
static void an_output_that_cannot_be_written_leaves_no_other(void **state) {
  (void)state;
  static const char *const kinds[] = {"-o", "--reactions", "--displacements", "--vtu"};
  static const char *const names[] = {"nowhere/q.npy", "nowhere/r.csv", "nowhere/u.npy",
                                      "nowhere/b.vtu"};
  for (int full = 0; full < 2; full++)
    for (int n = 0; n < 4; n++) {
      program_result run =
          thrum_run(folder, "static", "beam.npz", "--load", "constant:0,0,-1@tip", "--path",
                    "other.csv", kinds[n], names[n], full ? "--full" : NULL, NULL);
      assert_int_equal(run.exit_code, 1);
      assert_non_null(strstr(run.err, "cannot be created"));
      assert_true(!file_exists(in_folder("other.csv")));
      program_result_free(&run);
    }
}

/* A law that hexahedra have not cuts them. */
static void other_laws_cut_hexahedra(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "static", "beam:2x1x1@1x0.3x0.3,hex", "--full", "--law", "neo-hookean",
                "--fix", "x<0.001", "--load", "constant:0,0,-1@right", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "2 hexahedra were cut into 12 tetrahedra; laws other than"));
  program_result_free(&run);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_place_says_which_vertex_it_takes),
      cmocka_unit_test(the_files_hold_the_equilibrium),
      cmocka_unit_test(a_run_starts_from_the_equilibrium),
      cmocka_unit_test(the_full_order_rests_near_the_reduced_model),

      // the whole mesh, by either solver
      cmocka_unit_test(a_mesh_is_taken_whole),
      cmocka_unit_test(a_group_is_brought_to_where_it_is_to_go),
      cmocka_unit_test(an_answer_goes_on_from_another),

      // answers that must not be believed as they are
      cmocka_unit_test(a_basis_that_cannot_bend_so_far_is_warned_of),
      cmocka_unit_test(a_column_buckles_at_eulers_load),
      cmocka_unit_test(the_estimate_is_what_the_mesh_does_otherwise),
      cmocka_unit_test(a_block_pressed_by_half_is_warned_of),
      cmocka_unit_test(a_path_stays_on_its_branch),
      cmocka_unit_test(reactions_balance_the_load),
      cmocka_unit_test(the_share_that_is_left_of_gravity_is_that_of_the_weight),
      cmocka_unit_test(what_is_moved_has_a_reaction),
      cmocka_unit_test(a_model_says_what_its_reactions_lack),
      cmocka_unit_test(reactions_that_are_wrong_are_said_or_refused),
      cmocka_unit_test(a_load_that_moves_nothing_is_warned_of),
      cmocka_unit_test(a_weight_that_bends_nothing_says_nothing_of_the_basis),
      cmocka_unit_test(the_stress_is_said_with_its_place),
      cmocka_unit_test(solid_shells_bear_the_stress_of_bending),
      cmocka_unit_test(a_body_inside_out_is_flagged),
      cmocka_unit_test(a_critical_load_is_judged_by_the_mesh),
      cmocka_unit_test(the_default_model_of_an_arch_snaps_through),
      cmocka_unit_test(the_path_of_the_mesh_shows_the_snap),
      cmocka_unit_test(a_mesh_bears_out_the_critical_load_of_an_arch),
      cmocka_unit_test(a_square_column_is_followed_beyond_its_critical_load),
      cmocka_unit_test(what_is_not_found_beyond_buckling_is_named),
      cmocka_unit_test(the_frequency_at_rest_is_exact),
      cmocka_unit_test(buckling_is_flagged_with_its_load),

      // mistakes on the command line
      cmocka_unit_test(an_output_that_cannot_be_written_leaves_no_other),
      cmocka_unit_test(slips_are_refused_in_one_line),
      cmocka_unit_test(other_laws_cut_hexahedra),
  };
  return cmocka_run_group_tests(tests, make_models, remove_folder);
}
