/* --order auto: a mesh of linear tetrahedra that would lock is taken with ten nodes, by every
 * command that makes a model; where linear ones stay, each says by how much they lock.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "io/percent.h"
#include "tests/support/sanitized.h"
#include "tests/support/test_folder.h"

#define THIN "beam:12x1x1@1x0.1x0.1"
#define MATERIAL "--young", "1e6", "--poisson", "0.3", "--density", "1000"
#define HELD "--fix", "x<1e-6", MATERIAL

static cJSON *object_of(program_result run, bool warns) {
  if (run.exit_code != 0)
    fail_msg("exit %d: %s", run.exit_code, run.err);
  assert_int_equal(strstr(run.err, "its linear tetrahedra are too stiff") != NULL, warns);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

static double number_at(const cJSON *object, const char *key, int n) {
  const cJSON *item = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(object, key), n);
  assert_true(cJSON_IsNumber(item));
  return item->valuedouble;
}

static void expect_order(const cJSON *object, int order, const char *by) {
  assert_true(json_value(object, "order") == order);
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "order_by")->valuestring, by);
}

/* Timoshenko's beam of 1 x 0.1 x 0.1 m under its weight rho A g = w: w l^4 / 8 E I + w l^2 / 2 k G
 * A with k = 5/6, 0.0150 + 0.0002 m at 0.1 m/s^2. Linear tetrahedra give a quarter of it. */
static void statics_of_a_mesh_are_right_by_default(void **state) {
  (void)state;
#define SAG "--full", HELD, "--load", "gravity:0,0,-0.1", "--at", "right", "--json", "-q"
  cJSON *object = object_of(thrum_run(folder, "static", THIN, SAG, NULL), false);
  const cJSON *moved = cJSON_GetObjectItem(
      cJSON_GetArrayItem(cJSON_GetObjectItem(object, "displacements"), 0), "mean_m");
  if (moved == NULL)
    fail_msg("%s", cJSON_PrintUnformatted(object));
  const double sag = -cJSON_GetArrayItem(moved, 2)->valuedouble;
  print_message("sag %g m\n", sag);
  assert_true(fabs(sag / 0.0152 - 1) < 0.05);
  expect_order(object, 2, "auto");
  cJSON_Delete(object);

  // four nodes are there for who asks, with a word
  object = object_of(thrum_run(folder, "static", THIN, "--order", "1", SAG, NULL), true);
  expect_order(object, 1, "user");
  assert_true(number_at(object, "order_error", 0) > 0.5);
  cJSON_Delete(object);
}

/* A thread of which linear tetrahedra make a rod: shares are told without an exponent. */
static void a_body_that_hardly_moves_is_told_in_words(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "precompute", "beam:20x1x1@1x0.001x0.001", "-o",
                                 "thread.npz", "--order", "1", HELD, NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "loads move it by more than 99 % too little; make"));
  assert_null(strstr(run.err, "e+"));
  program_result_free(&run);

  char text[PERCENT_MAX];
  static const double shares[] = {0.00114, 0.93, 0.999, 2.5, 1e-9};
  static const char *const texts[] = {"0.11", "93", "100", "250", "<0.0001"};
  for (int n = 0; n < 5; n++)
    assert_string_equal(percent_text(shares[n], text), texts[n]);
}

/* Ten nodes near incompressibility lock too on a coarse mesh: every command tells by how much, and
 * a model that does not know it is told so. */
static void ten_nodes_that_lock_say_so(void **state) {
  (void)state;
#define STIFF "beam:4x1x1@1x0.2x0.2"
  static const char *const said = "ten-node tetrahedra are too stiff: first frequencies are about ";
  program_result run = thrum_run(folder, "precompute", STIFF, "-o", "stiff.npz", HELD, "--poisson",
                                 "0.49", "--json", "-q", NULL);
  assert_non_null(strstr(run.err, said));
  cJSON *object = json_line(run.out);
  const double error = number_at(object, "ten_node_error", 0);
  assert_true(error > 0.1 && error < 0.3);
  cJSON_Delete(object);
  program_result_free(&run);

  // what uses the model, and what takes the whole mesh
  static const char *const runs[][6] = {
      {"simulate", "stiff.npz", "--time=0.01", "-q", "-o", "stiff"},
      {"static", "stiff.npz", "--load=constant:0,0,-1@tip"},
      {"static", "stiff.npz", "--full", "--load=constant:0,0,-1@tip"},
      {"simulate", "stiff.npz", "--full", "--time=0.01", "-q", "--output=whole"},
  };
  for (int n = 0; n < 4; n++) {
    const char *const *a = runs[n];
    run = thrum_run(folder, a[0], a[1], a[2], a[3], a[4], a[5], NULL);
    if (!strstr(run.err, said))
      fail_msg("%s: %s", a[0], run.err);
    program_result_free(&run);
  }
  run = thrum_run(folder, "info", "stiff.npz", NULL);
  assert_non_null(strstr(run.out, "ten nodes, by which the first frequencies are about "));
  program_result_free(&run);
}

static void precompute_says_what_it_chose(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "precompute", THIN, "-o", "thin.npz", HELD, NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, THIN ": its tetrahedra are taken with ten nodes, as with four"));
  assert_non_null(strstr(run.out, "72 tetrahedra of ten nodes, by --order auto"));
  program_result_free(&run);

  // the model knows, and runs of it have nothing to warn of
  cJSON *object = object_of(thrum_run(folder, "info", "thin.npz", "--json", NULL), false);
  expect_order(object, 2, "auto");
  assert_true(number_at(object, "order_error", 0) > 0.5);
  cJSON_Delete(object);

  // the same with the user's word for it
  object = object_of(
      thrum_run(folder, "precompute", THIN, "-o", "two.npz", HELD, "--order", "2", "--json", NULL),
      false);
  expect_order(object, 2, "user");
  cJSON_Delete(object);
}

/* A bar that can only stretch is right to 1 % with forty cells, and so is a mesh that has ten
 * nodes.
 */
static void meshes_that_do_not_lock_stay_as_they_are(void **state) {
  (void)state;
  cJSON *object = object_of(thrum_run(folder, "precompute", "beam:40x1x1@1x0.1x0.1", "--poisson",
                                      "0", "--fix", "y>-1e9:yz", "--fix", "x<0.001", "--modes", "1",
                                      "--rank", "1", "-o", "bar.npz", "--json", NULL),
                            false);
  expect_order(object, 1, "auto");
  assert_true(number_at(object, "order_error", 0) <= 0.01);
  cJSON_Delete(object);

  program_result run = thrum_run(folder, "convert", THIN, "ten.msh", "--order", "2", NULL);
  program_result_free(&run);
  object = object_of(
      thrum_run(folder, "precompute", "ten.msh", "-o", "ten.npz", HELD, "--json", NULL), false);
  expect_order(object, 2, "mesh");
  cJSON_Delete(object);
}

/* Few hexahedra are too stiff, which a finer mesh tells: within a third of what one says that is
 * finer still. Each command that runs the model repeats it. */
static void few_hexahedra_say_their_error(void **state) {
  (void)state;
  static const char *const meshes[] = {"beam:4x2x2@1x0.1x0.1,hex", "beam:24x4x4@1x0.1x0.1,hex"};
  double frequency[2];
  cJSON *coarse = NULL;
  for (int n = 0; n < 2; n++) {
    program_result run = thrum_run(folder, "precompute", meshes[n], "--element", "solid", "--fix",
                                   "x<0.001", "--modes", "2", "--rank", "5", "-o",
                                   n == 0 ? "few.npz" : "many.npz", "--json", NULL);
    assert_true((strstr(run.err, "by a finer mesh") != NULL) == (n == 0));
    cJSON *object = json_line(run.out);
    frequency[n] = number_at(object, "frequencies_hz", 0);
    if (n == 0)
      coarse = object;
    else
      cJSON_Delete(object);
    program_result_free(&run);
  }
  const double said = number_at(coarse, "finer_error", 0), found = frequency[0] / frequency[1] - 1;
  if (!(found > 0.02 && fabs(said / found - 1) < 1.0 / 3))
    fail_msg("said %g, found %g", said, found);
  cJSON_Delete(coarse);
  program_result run = thrum_run(folder, "simulate", "few.npz", "-o", "few", "--time", "0.01",
                                 "--load", "constant:0,0,1@right", NULL);
  assert_non_null(strstr(run.err, "by a finer mesh"));
  program_result_free(&run);
}

/* What does not fit into the memory stays linear, and says why and by how much it errs. Sanitizers
 * take some 300 MB themselves. */
static void memory_decides_too(void **state) {
  (void)state;
  program_result run = thrum_run(
      folder, "precompute", "beam:40x6x6@1x0.1x0.1", "--fix", "x<0.001", "--modes", "2", "--rank",
      "2", "--memory", LENGTH_OF_RUN("120", "365"), "-o", "large.npz", "--json", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  assert_non_null(strstr(run.err, "its linear tetrahedra are too stiff"));
  assert_non_null(strstr(run.err, "ten nodes would take about"));
  cJSON *object = json_line(run.out);
  expect_order(object, 1, "auto");
  assert_true(number_at(object, "order_error", 0) > 0.01);
  cJSON_Delete(object);
  program_result_free(&run);
}

static void every_command_says_by_how_much_a_linear_model_locks(void **state) {
  (void)state;
  cJSON *object = object_of(thrum_run(folder, "precompute", THIN, "-o", "linear.npz", HELD,
                                      "--order", "1", "--json", "-q", NULL),
                            true);
  expect_order(object, 1, "user");
  cJSON_Delete(object);

#define GRAVITY "--load", "gravity:0,0,-0.1", "--json", "-q"
#define SHORT GRAVITY, "--time", "0.03", "-o", "run"
  object = object_of(thrum_run(folder, "static", "linear.npz", GRAVITY, NULL), true);
  expect_order(object, 1, "user");
  cJSON_Delete(object);
  cJSON_Delete(object_of(thrum_run(folder, "static", "linear.npz", "--full", GRAVITY, NULL), true));
  cJSON_Delete(object_of(thrum_run(folder, "simulate", "linear.npz", SHORT, NULL), true));
  cJSON_Delete(object_of(thrum_run(folder, "simulate", "linear.npz", "--full", SHORT, NULL), true));

  // a scene, of the model and of the mesh
  static const char *const bodies[] = {"\"model\": \"linear.npz\"",
                                       "\"model\": \"" THIN "\", \"fix\": \"x<1e-6\", \"order\": 1",
                                       "\"model\": \"" THIN "\", \"fix\": \"x<1e-6\""};
  for (int n = 0; n < 3; n++) {
    char text[300];
    snprintf(text, sizeof text, "{\"time\": 0.01, \"bodies\": [{%s}]}", bodies[n]);
    assert_true(text_file_write(in_folder("scene.json"), text));
    cJSON_Delete(object_of(
        thrum_run(folder, "simulate", "scene.json", "-o", "scene", "--json", "-q", NULL), n < 2));
  }

  // info has a line, and the page of view a warning
  program_result run = thrum_run(folder, "info", "linear.npz", NULL);
  assert_non_null(strstr(run.out, "four nodes, by which the first frequencies are about"));
  program_result_free(&run);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(statics_of_a_mesh_are_right_by_default),
      cmocka_unit_test(a_body_that_hardly_moves_is_told_in_words),
      cmocka_unit_test(precompute_says_what_it_chose),
      cmocka_unit_test(ten_nodes_that_lock_say_so),
      cmocka_unit_test(meshes_that_do_not_lock_stay_as_they_are),
      cmocka_unit_test(few_hexahedra_say_their_error),
      cmocka_unit_test(memory_decides_too),
      cmocka_unit_test(every_command_says_by_how_much_a_linear_model_locks),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
