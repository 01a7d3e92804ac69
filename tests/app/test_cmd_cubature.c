/* Tests of `thrum precompute --cubature` and of what is done with its models: figures, a run, cut
 * down ones, and what such a model cannot do.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "io/npy_file.h"
#include "tests/support/model_archive.h"
#include "tests/support/test_folder.h"
#include "thrum/thrum.h"

#define BODY "beam:8x2x2@1x0.15x0.15,split=6"
#define PRECOMPUTE(...)                                                                            \
  thrum_run(folder, "precompute", BODY, "--order", "1", "-o", "cub.npz", "--fix", "x<0.001",       \
            "--modes", "4", "--rank", "9", "-q", __VA_ARGS__, NULL)

static double number_of(const cJSON *object, const char *key) {
  const cJSON *found = cJSON_GetObjectItemCaseSensitive(object, key);
  assert_non_null(found);
  return found->valuedouble;
}

static void a_model_of_points_says_its_error_and_runs(void **state) {
  (void)state;
  program_result run = PRECOMPUTE("--cubature", "--cubature-error", "0.02", "--json");
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  cJSON *object = json_line(run.out);
  const cJSON *cubature = cJSON_GetObjectItemCaseSensitive(object, "cubature");
  const double points = number_of(cubature, "points");
  assert_true(points > 5 && points < number_of(object, "tets"));
  assert_true(number_of(cubature, "test_error") <= 0.02);
  assert_true(number_of(cubature, "train_error") > 0);

  // so few points are cheap as they are, and nothing is said of learning them
  assert_true(cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(cubature, "if_learned")));

  // the stage that makes the points is not called one of the polynomial
  const cJSON *stages = cJSON_GetObjectItemCaseSensitive(object, "stages");
  assert_non_null(cJSON_GetObjectItemCaseSensitive(stages, "cubature"));
  assert_null(cJSON_GetObjectItemCaseSensitive(stages, "polynomial"));

  // 12 points and coordinates for each of the 660 coefficients of 9 coordinates
  assert_true(fabs(number_of(cubature, "force_cost") - 12 * points * 9 / 660) < 1e-9);
  cJSON_Delete(object);
  program_result_free(&run);

  // the file says so too
  run = thrum_run(folder, "info", "cub.npz", "--json", NULL);
  assert_int_equal(run.exit_code, 0);
  object = json_line(run.out);
  assert_true(number_of(object, "cubature_points") == points);
  assert_true(number_of(object, "format_minor") == 4);
  cJSON_Delete(object);
  program_result_free(&run);
  run = thrum_run(folder, "info", "cub.npz", NULL);
  assert_non_null(strstr(run.out, "points in place of the polynomial"));
  program_result_free(&run);

  // it runs and rests as other models do
  run = thrum_run(folder, "simulate", "cub.npz", "--accept-error", "100%", "--start", "mode:1,0.2",
                  "--time", "0.3", "-q", "-o", "run", NULL);
  if (run.exit_code != 0)
    fail_msg("%s%s", run.out, run.err);
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "cub.npz", "--integrator", "imexv", "--time", "0.1", "-q",
                  "-o", "run2", NULL);
  if (run.exit_code != 0)
    fail_msg("%s%s", run.out, run.err);
  program_result_free(&run);
  run = thrum_run(folder, "static", "cub.npz", "--load", "gravity:0,0,-1", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s%s", run.out, run.err);
  program_result_free(&run);

  // nothing of it can follow
  run = thrum_run(folder, "simulate", "cub.npz", "--condense", "3", "--time", "0.1", "-q", "-o",
                  "run3", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "no polynomial to condense"));
  program_result_free(&run);
  run = thrum_run(folder, "export", "cub.npz", "--vega-cubic", "cub.cub", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "has cubature points and no polynomial to export"));
  program_result_free(&run);
}

/* The rms of the difference of two runs of q over that of the second. */
static double difference(const char *name, const char *other) {
  double *q[2] = {NULL, NULL}, off = 0, size = 0;
  const char *const names[] = {name, other};
  int64_t rows = 0, columns = 0;
  for (int n = 0; n < 2; n++)
    assert_int_equal(thrum_npy_read_f8(in_folder(names[n]), &q[n], &rows, &columns, NULL), 0);
  for (int64_t k = 0; k < rows * columns; k++) {
    off += (q[0][k] - q[1][k]) * (q[0][k] - q[1][k]);
    size += q[1][k] * q[1][k];
  }
  free(q[0]);
  free(q[1]);
  return sqrt(off / size);
}

/* Points and the polynomial of the same basis are stepped beside each other: the error of the
 * motion is far from that of the force, and is what precompute and info say. */
static void the_error_of_motion_is_that_beside_the_polynomial(void **state) {
  (void)state;
  double said[2], beyond[2], found[2];
  static const char *const errors[] = {"0.1", "0.005"};
  for (int n = 0; n < 2; n++) {
    program_result run = PRECOMPUTE("--cubature", "--cubature-error", errors[n], "--json");
    assert_int_equal(run.exit_code, 0);
    cJSON *object = json_line(run.out);
    const cJSON *cubature = cJSON_GetObjectItemCaseSensitive(object, "cubature");
    said[n] = number_of(cubature, "motion_error");
    beyond[n] = number_of(cubature, "motion_error_beyond");
    assert_true(number_of(cubature, "step_us") > 0);
    cJSON_Delete(object);
    program_result_free(&run);
    run = thrum_run(folder, "info", "cub.npz", NULL);
    assert_non_null(strstr(run.out, "motion"));
    program_result_free(&run);

    // the polynomial of the same basis, from the same velocity
    run = thrum_run(folder, "precompute", BODY, "--order", "1", "-o", "whole.npz", "--fix",
                    "x<0.001", "--modes", "4", "--rank", "9", "-q", NULL);
    assert_int_equal(run.exit_code, 0);
    program_result_free(&run);
    for (int m = 0; m < 2; m++) {
      run = thrum_run(folder, "simulate", m == 0 ? "cub.npz" : "whole.npz", "-o",
                      m == 0 ? "points" : "whole", "-q", "--time", "0.7", "--load",
                      "square:0,0,-600@tip,until=0.05", "--accept-error", "100%", NULL);
      assert_int_equal(run.exit_code, 0);
      program_result_free(&run);
    }
    found[n] = difference("points/q.npy", "whole/q.npy");
    print_message("said %.3g, %.3g beyond; found %.3g\n", said[n], beyond[n], found[n]);
  }

  // fewer points are worse, and what is said is of the size of what another motion has
  assert_true(said[1] < said[0] && beyond[0] > said[0]);
  for (int n = 0; n < 2; n++)
    assert_true(found[n] > said[n] / 4 && found[n] < 4 * beyond[n]);
}

/* The error of the force of 12 points of a law that are refined in so many steps; a run of them by
 * `energy` conserves the energy whatever their gradients are. */
static double error_of_refined(const char *law, const char *steps) {
  program_result run = PRECOMPUTE("--cubature", "--cubature-error", "1e-9", "--cubature-points",
                                  "12", "--cubature-refine", steps, "--law", law, "--json");
  assert_int_equal(run.exit_code, 3);
  cJSON *object = json_line(run.out);
  const cJSON *cubature = cJSON_GetObjectItemCaseSensitive(object, "cubature");
  assert_true(number_of(cubature, "points") == 12 && number_of(cubature, "refine") == atof(steps));
  const double error = number_of(cubature, "test_error");
  cJSON_Delete(object);
  program_result_free(&run);

  // the work of a load that ends is what the body has from then on
  run = thrum_run(folder, "simulate", "cub.npz", "--load", "square:0,0,-20@tip,until=0.1", "--time",
                  "1", "-q", "--json", "-o", "run", NULL);
  if (run.exit_code != 0)
    fail_msg("%s%s", run.out, run.err);
  object = json_line(run.out);
  const cJSON *work = cJSON_GetObjectItemCaseSensitive(object, "work");
  assert_true(number_of(work, "load_j") > 0);
  assert_true(fabs(number_of(work, "balance_j")) <= 1e-12 * number_of(work, "load_j"));
  cJSON_Delete(object);
  program_result_free(&run);
  return error;
}

/* The model of the test before, which is of neo-Hookean material and was refined. */
static void check_flow_of_learned_points(void) {
  program_result run = thrum_run(folder, "info", "cub.npz", NULL);
  assert_non_null(strstr(run.out, "learned in 500 steps"));
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "cub.npz", "--yield", "0.02", "--time", "0.01", "-q", "-o",
                  "learned", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "were learned, so that what flows is"));
  program_result_free(&run);
}

static void refined_points_are_nearer_and_keep_the_energy(void **state) {
  (void)state;
  static const char *const laws[] = {"stvk", "corotational", "neo-hookean"};
  for (int n = 0; n < 3; n++) {
    const double chosen = error_of_refined(laws[n], "0"),
                 refined = error_of_refined(laws[n], "500");
    if (!(refined < 0.5 * chosen))
      fail_msg("%s: %g of %g", laws[n], refined, chosen);
  }
  check_flow_of_learned_points();
}

static void a_law_of_its_own_is_in_the_file_and_in_runs(void **state) {
  (void)state;
  program_result run =
      PRECOMPUTE("--cubature", "--cubature-error", "0.1", "--law", "neo-hookean", "--young", "1e6");
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  assert_non_null(strstr(run.out, "neo-hookean, by which the points alone answer"));
  program_result_free(&run);
  run = thrum_run(folder, "info", "cub.npz", "--json", NULL);
  cJSON *object = json_line(run.out);
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "law")->valuestring, "neo-hookean");
  assert_true(number_of(object, "format_major") == 3);
  cJSON_Delete(object);
  program_result_free(&run);

  // a swing of a third of the length keeps its energy, and the unreduced mesh has the same law
  run = thrum_run(folder, "simulate", "cub.npz", "--accept-error", "100%", "--start", "mode:1,0.3",
                  "--time", "0.5", "-q", "--json", "-o", "run", NULL);
  assert_int_equal(run.exit_code, 0);
  object = json_line(run.out);
  assert_true(fabs(number_of(object, "drift")) < 1e-13);
  cJSON_Delete(object);
  program_result_free(&run);
  run = thrum_run(folder, "static", "cub.npz", "--full", "--load", "gravity:0,0,-1", "-q", "--json",
                  NULL);
  object = json_line(run.out);
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "law")->valuestring, "neo-hookean");
  cJSON_Delete(object);
  program_result_free(&run);
}

/* Strain energy is in the fourth column of the rows. */
static void assert_strain_energy_is_not_negative(void) {
  char path[512], line[512];
  snprintf(path, sizeof path, "%s/few/energy.csv", folder);
  FILE *file = fopen(path, "r");
  assert_non_null(file);
  assert_non_null(fgets(line, sizeof line, file));
  int rows = 0;
  for (; fgets(line, sizeof line, file); rows++) {
    double kinetic, potential;
    assert_int_equal(sscanf(line, "%*[^,],%*[^,],%lf,%lf", &kinetic, &potential), 2);
    assert_true(kinetic >= 0 && potential >= 0);
  }
  fclose(file);
  assert_true(rows > 100);
}

/* Runs with this yield are refused in a line that says why, and so is a scene, but with the key
 * that accepts it, which warns. */
static void assert_flow_is_refused(const char *model, const char *yield, const char *says) {
  program_result run =
      thrum_run(folder, "simulate", model, yield, "--time", "0.01", "-q", "-o", "none", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_true(line_count_is(run.err, 1));
  if (!strstr(run.err, says) || !strstr(run.err, "precompute it with --yield"))
    fail_msg("%s", run.err);
  program_result_free(&run);
  static const char *const accepted[] = {"", "\"untrained_flow\": true, "};
  for (int n = 0; n < 2; n++) {
    char scene[400];
    snprintf(scene, sizeof scene,
             "{%s\"time\": 0.01, \"bodies\": [{\"model\": \"%s\", \"material\": {\"yield\": "
             "%s}}]}",
             accepted[n], model, yield + strlen("--yield="));
    assert_true(text_file_write(in_folder("flow.json"), scene));
    run = thrum_run(folder, "simulate", "flow.json", "-q", "-o", "flow", NULL);
    if (run.exit_code != (n == 0) || !strstr(run.err, says))
      fail_msg("%s", run.err);
    program_result_free(&run);
  }
}

static void few_points_flow_no_more_than_the_load_gives(void **state) {
  (void)state;
  program_result run = PRECOMPUTE("--cubature", "--cubature-error", "0.05", "--law", "neo-hookean",
                                  "--young", "1e6");
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // what they were trained on is said, and flow, which is none of it, is refused
  run = thrum_run(folder, "info", "cub.npz", NULL);
  assert_non_null(strstr(run.out, "trained on        strains up to "));
  assert_non_null(strstr(run.out, ", no plastic flow"));
  program_result_free(&run);
  assert_flow_is_refused("cub.npz", "--yield=0.01", "not trained on plastic flow: strain");

  // they have a little more stiffness than the body along some shape, as the flow once showed
  run = thrum_run(folder, "simulate", "cub.npz", "--yield", "0.01", "--untrained-flow", "on",
                  "--load", "square:0,0,-200@tip,until=0.3", "--time", "0.4", "-q", "--json", "-o",
                  "few", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "were not trained on plastic flow"));
  cJSON *object = json_line(run.out);
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "status")->valuestring, "done");
  const cJSON *work = cJSON_GetObjectItemCaseSensitive(object, "work");
  const double load = number_of(work, "load_j"), taken = number_of(work, "plastic_j");
  assert_true(taken > 0.1 * load && taken <= load);
  assert_true(fabs(number_of(work, "balance_j")) <= 1e-12 * load);
  assert_true(number_of(object, "point_stiffness") > 1);
  cJSON_Delete(object);
  program_result_free(&run);
  assert_strain_energy_is_not_negative();

  // where it is much more, that is said
  run = thrum_run(folder, "precompute", "beam:10x2x2@1x0.15x0.15", "--order", "1", "-o", "cub.npz",
                  "--fix", "x<0.001", "--modes", "4", "--rank", "9", "--selection", "mass", "-q",
                  "--cubature", "--cubature-error", "0.05", "--law", "neo-hookean", "--young",
                  "1e6", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "cub.npz", "--yield", "0.01", "--untrained-flow", "on",
                  "--load", "square:0,0,-200@tip,until=0.3", "--time", "0.4", "-q", "--json", "-o",
                  "few", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "cubature points are too few for plastic flow"));
  object = json_line(run.out);
  assert_true(number_of(object, "point_stiffness") > 2);
  cJSON_Delete(object);
  program_result_free(&run);
  assert_strain_energy_is_not_negative();
}

static void points_flow_and_their_account_closes(void **state) {
  (void)state;
  program_result run = PRECOMPUTE("--cubature", "--cubature-error", "0.02", "--law", "corotational",
                                  "--young", "1e6", "--yield", "0.02", "--train",
                                  "square:0,0,-200@tip,until=0.1", "--train-time", "0.2", "--json");
  if (run.exit_code != 0)
    fail_msg("%s", run.err);

  // the body ends where the unreduced mesh does
  cJSON *object = json_line(run.out);
  assert_true(number_of(cJSON_GetObjectItemCaseSensitive(object, "training"), "error") < 0.03);
  assert_true(number_of(cJSON_GetObjectItemCaseSensitive(object, "cubature"), "yield") == 0.02);
  cJSON_Delete(object);
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "cub.npz", "--yield", "0.02", "--load",
                  "square:0,0,-200@tip,until=0.3", "--time", "0.4", "-q", "--json", "-o", "bent",
                  NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  object = json_line(run.out);
  const cJSON *work = cJSON_GetObjectItemCaseSensitive(object, "work");
  const double load = number_of(work, "load_j"), taken = number_of(work, "plastic_j");
  assert_true(taken > 0.01 * load && taken == number_of(work, "dissipated_j"));
  assert_true(fabs(number_of(work, "balance_j")) <= 1e-9 * load);
  assert_true(number_of(object, "plastic_strain") > 0.001);
  cJSON_Delete(object);
  program_result_free(&run);

  // info says what the points know, and a run that flows further is told
  run = thrum_run(folder, "info", "cub.npz", NULL);
  assert_non_null(strstr(run.out, ", flow beyond 0.02, plastic strains up to "));
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "cub.npz", "--yield", "0.02", "--load",
                  "square:0,0,-20000@tip,until=0.02", "--time", "0.03", "-q", "-o", "far", NULL);
  assert_non_null(strstr(run.err, "were trained on up to "));
  program_result_free(&run);

  // the table names law, yield and what has flowed
  run = thrum_run(folder, "simulate", "cub.npz", "--yield", "0.02", "--time", "0.01", "-q", "-o",
                  "bent", NULL);
  assert_non_null(strstr(run.out, "material     corotational, flows beyond a strain of 0.02: 0 J"));
  program_result_free(&run);

  // what does not flow is refused in one line
  static const struct {
    const char *says, *arguments[4];
  } cases[] = {
      {"--yield: plastic.yield is 0.02, and the integrator imexv",
       {"--yield", "0.02", "--integrator", "imexv"}},
      {"--stress is of a material that does not flow", {"--yield", "0.02", "--stress"}},
      {"--creep wants a --yield", {"--creep", "2"}},
      {"--largest-plastic-strain wants a --yield", {"--largest-plastic-strain", "1"}},
  };
  for (int n = 0; n < 4; n++) {
    const char *const *a = cases[n].arguments;
    run = thrum_run(folder, "simulate", "cub.npz", "-o", "none", a[0], a[1], a[2], a[3], NULL);
    assert_true(run.exit_code == 1 || run.exit_code == 2);
    if (!strstr(run.err, cases[n].says))
      fail_msg("%s", run.err);
    assert_true(line_count_is(run.err, 1));
    program_result_free(&run);
  }
}

static void training_runs_and_their_errors_are_of_the_law(void **state) {
  (void)state;
  double errors[2];
  for (int n = 0; n < 2; n++) {
    program_result run =
        PRECOMPUTE("--cubature", "--cubature-error", "0.05", "--law", n ? "corotational" : "stvk",
                   "--young", "1e6", "--train", "square:0,0,-60@tip", "--train-time", "0.1",
                   "--cubature-refine", "1000", "--json");
    if (run.exit_code != 0)
      fail_msg("%s", run.err);

    // the same pull, to the unreduced mesh of another law
    cJSON *object = json_line(run.out);
    errors[n] = number_of(cJSON_GetObjectItemCaseSensitive(object, "training"), "error");
    assert_true(errors[n] < 0.05);
    cJSON_Delete(object);
    program_result_free(&run);
  }
  assert_true(errors[0] != errors[1]);

  // tradeoff takes the model with its law, and no polynomial beside it
  program_result run =
      thrum_run(folder, "tradeoff", "cub.npz", "--load", "square:0,0,-60@tip", "-o", "trade",
                "--time", "0.1", "--quick", "--ranks", "0", "--json", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  cJSON *object = json_line(run.out);
  const cJSON *law = cJSON_GetObjectItem(cJSON_GetObjectItem(object, "full"), "law");
  assert_string_equal(law->valuestring, "corotational");
  assert_true(number_of(cJSON_GetObjectItem(object, "recommended"), "error") < 0.05);
  cJSON_Delete(object);
  program_result_free(&run);
  run = thrum_run(folder, "tradeoff", "cub.npz", "--load", "square:0,0,-1@tip", "-o", "trade",
                  "--cubature", "off", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(
      strstr(run.err, "cub.npz is of corotational material, which a polynomial cannot"));
  program_result_free(&run);
}

/* The smallest model of points: one of them, of two coordinates, that may flow. */
static archive one_point(void) {
  static const int32_t format[2] = {3, 0};
  static const double weight = 1e-3, moduli[2] = {1e6, 4e5};
  double gradients[18];
  for (int n = 0; n < 18; n++)
    gradients[n] = 0.1 * (n % 5) - 0.2;
  archive a = {.count = 0};
  archive_add(&a, "format.npy", "<i4", "(2,)", format, sizeof format);
  archive_add(&a, "omega2.npy", "<f8", "(2,)", sample_omega2, sizeof sample_omega2);
  archive_add(&a, "point_weights.npy", "<f8", "(1,)", &weight, sizeof weight);
  archive_add(&a, "point_moduli.npy", "<f8", "(2, 1)", moduli, sizeof moduli);
  archive_add(&a, "point_gradients.npy", "<f8", "(9, 2)", gradients, sizeof gradients);
  archive_add(&a, "point_law.npy", "|u1", "(13,)", "corotational", 13);
  return a;
}

/* Steps the model of an archive by simulate. */
static program_result step_archive(const archive *a) {
  static unsigned char bytes[ARCHIVE_MAX];
  const size_t size = archive_build(a, bytes);
  FILE *file = fopen(in_folder("one.npz"), "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, 1, size, file), size);
  assert_int_equal(fclose(file), 0);
  return thrum_run(folder, "simulate", "one.npz", "--time", "0.01", "-q", "-o", "one", NULL);
}

static void bad_points_of_a_file_are_refused_in_one_line(void **state) {
  (void)state;
  archive a = one_point();
  program_result run = step_archive(&a);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  program_result_free(&run);

  // a number out of its range, each in a file of its own
  static const struct {
    const char *array;
    int entry;
    double value;
    const char *says;
  } numbers[] = {
      {"point_weights", 0, -1e-3, "weights are volumes and > 0"},
      {"point_weights", 0, 0, "weights are volumes and > 0"},
      {"point_weights", 0, NAN, "not finite"},
      {"point_moduli", 1, -4e5, "mu > 0 and 3 lambda + 2 mu > 0 are needed"},
      {"point_moduli", 0, -1e9, "mu > 0 and 3 lambda + 2 mu > 0 are needed"},
      {"point_gradients", 17, INFINITY, "not finite"},
  };
  for (size_t n = 0; n < sizeof numbers / sizeof numbers[0]; n++) {
    a = one_point();
    archive_set_f8(&a, numbers[n].array, numbers[n].entry, numbers[n].value);
    run = step_archive(&a);
    assert_int_equal(run.exit_code, 1);
    if (!strstr(run.err, numbers[n].says) || !strstr(run.err, numbers[n].array))
      fail_msg("%s", run.err);
    assert_true(line_count_is(run.err, 1));
    program_result_free(&run);
  }

  // arrays that do not go together, and a law that there is none of
  for (int n = 0; n < 4; n++) {
    static const char *const says[] = {"come together", "point_rows", "polynomial cannot hold it",
                                       "none of the names"};
    a = one_point();
    if (n == 0)
      archive_remove(&a, "point_moduli");
    if (n == 1)
      archive_find(&a, "point_gradients")->shape = "(8, 2)";
    if (n == 1)
      archive_find(&a, "point_gradients")->size = 8 * 16;
    if (n == 2) {
      archive_remove(&a, "point_weights");
      archive_remove(&a, "point_moduli");
      archive_remove(&a, "point_gradients");
    }
    if (n == 3)
      archive_find(&a, "point_law")->data[0] = 'k';
    run = step_archive(&a);
    assert_int_equal(run.exit_code, 1);
    if (!strstr(run.err, says[n]))
      fail_msg("%s", run.err);
    assert_true(line_count_is(run.err, 1));
    program_result_free(&run);
  }
}

static void plastic_flow_out_of_its_range_is_refused_in_one_line(void **state) {
  (void)state;

  // a model that is stepped without these options
  archive a = one_point();
  program_result run = step_archive(&a);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  static const char *const cases[][3] = {
      {"--yield=0", "--yield=0", "--yield wants a number above 0"},
      {"--yield=-1", "--yield=-1", "--yield wants a number above 0"},
      {"--yield=nan", "--yield=nan", "--yield wants a number above 0"},
      {"--yield=inf", "--yield=inf", "--yield wants a number above 0"},
      {"--yield=0.02", "--creep=0", "--creep wants a number above 0"},
      {"--yield=0.02", "--creep=-1", "--creep wants a number above 0"},
      {"--yield=0.02", "--largest-plastic-strain=0", "--largest-plastic-strain wants"},
      {"--yield=0.02", "--largest-plastic-strain=-1", "--largest-plastic-strain wants"},
      {"--law=neo-hookean", "-q", "--law goes with --full"},
  };

  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    run = thrum_run(folder, "simulate", "one.npz", "-o", "none", cases[n][0], cases[n][1], NULL);
    assert_int_equal(run.exit_code, 2);
    if (!strstr(run.err, cases[n][2]))
      fail_msg("%s", run.err);
    assert_true(line_count_is(run.err, 1));
    program_result_free(&run);
  }
}

static void an_error_that_is_missed_is_flagged(void **state) {
  (void)state;
  program_result run = PRECOMPUTE("--cubature", "--cubature-points", "3");
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.err, "the force by 3 cubature points is wrong by"));
  assert_non_null(strstr(run.out, " recommended: a force takes about 0.49 times as long"));
  program_result_free(&run);

  // with more points a force costs less than by the polynomial, and a step does not
  run = PRECOMPUTE("--cubature", "--cubature-points", "5");
  assert_non_null(
      strstr(run.out, "not recommended, leave --cubature out: a force takes about 0.8"));
  assert_non_null(strstr(run.out, "a step gains below a half"));
  program_result_free(&run);
}

/* Where points miss their error, the message names only options that help: it asks for more points
 * only where their number was bounded. */
static void the_advice_is_one_that_helps(void **state) {
  (void)state;
  static const char *const cases[][3] = {
      {"--cubature-points=1", "--cubature-refine=0",
       "by 1 cubature point is wrong by 1 (rms), not by 1e-12 as asked: raise --cubature-points, "
       "or "
       "lower --cubature-range\n"},
      {"--cubature-points=2000", "--cubature-refine=0",
       "as asked: learn the points' gradients by --cubature-refine, or lower --cubature-range\n"},
      {"--cubature-points=20", "--cubature-refine=40",
       "as asked: raise --cubature-refine or --cubature-points, or lower --cubature-range\n"},
      {"--cubature-points=2000", "--cubature-refine=2",
       "as asked: raise --cubature-refine, or lower --cubature-range\n"},
  };

  // all of them miss the error, and say what helps
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    program_result run =
        PRECOMPUTE("--cubature", "--cubature-error=1e-12", cases[n][0], cases[n][1]);
    assert_int_equal(run.exit_code, 3);
    if (strstr(run.err, cases[n][2]) == NULL)
      fail_msg("%s", run.err);
    program_result_free(&run);
  }
}

static void what_does_not_go_with_points_is_refused(void **state) {
  (void)state;
  static const char *const wrong[][3] = {
      {"--cubature-error", "0.01", "go with --cubature"},
      {"--cubature-refine", "100", "go with --cubature"},
      {"--cubature", "--cubature-refine=-1", "--cubature-refine"},
      {"--cubature", "--yield=0.02", "--yield needs --law"},
      {"--law=corotational", "--yield=-1", "--yield"},
      {"--cubature", "--condense", "goes without --condense"},
      {"--cubature", "--cubature-error=0", "--cubature-error"},
      {"--cubature", "--cubature-error=1.01", "--cubature-error"},
      {"--cubature", "--cubature-points=0", "--cubature-points"},
      {"--cubature", "--cubature-range=-1", "--cubature-range"},
      {"--cubature", "--cubature-range=1e30", "--cubature-range"},
      {"--cubature", "--precision=single", "--precision single"},
      {"--law", "neo-hookean", "a polynomial cannot hold it"},
      {"--law", "rubber", "--law"},
  };

  // learned points have no place, and so no strain that flows
  program_result flows = PRECOMPUTE("--cubature", "--law", "corotational", "--yield", "0.02",
                                    "--cubature-refine", "9");
  assert_int_equal(flows.exit_code, 2);
  assert_non_null(strstr(flows.err, "--cubature-refine goes without --yield"));
  program_result_free(&flows);

  // the message names what is wrong
  for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
    program_result run = PRECOMPUTE(wrong[n][0], wrong[n][1]);
    assert_int_equal(run.exit_code, 2);
    if (!strstr(run.err, wrong[n][2]))
      fail_msg("%s", run.err);
    program_result_free(&run);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_model_of_points_says_its_error_and_runs),
      cmocka_unit_test(the_error_of_motion_is_that_beside_the_polynomial),
      cmocka_unit_test(refined_points_are_nearer_and_keep_the_energy),
      cmocka_unit_test(a_law_of_its_own_is_in_the_file_and_in_runs),
      cmocka_unit_test(few_points_flow_no_more_than_the_load_gives),
      cmocka_unit_test(points_flow_and_their_account_closes),
      cmocka_unit_test(training_runs_and_their_errors_are_of_the_law),
      cmocka_unit_test(bad_points_of_a_file_are_refused_in_one_line),
      cmocka_unit_test(plastic_flow_out_of_its_range_is_refused_in_one_line),
      cmocka_unit_test(an_error_that_is_missed_is_flagged),
      cmocka_unit_test(the_advice_is_one_that_helps),
      cmocka_unit_test(what_does_not_go_with_points_is_refused),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
