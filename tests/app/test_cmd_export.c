/* Models are written by `thrum export` and read back by the import of `thrum precompute`.
 * SPDX-License-Identifier: Apache-2.0
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/support/test_folder.h"

#define BEAM "beam:6x2x2@1x0.2x0.15"

static int make_model(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL)
    return 1;
  program_result made =
      thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "x<0.001", "--modes", "4",
                "-o", "beam.npz", "--export-modes", "modes.vtu", "-q", NULL);
  const int code = made.exit_code;
  program_result_free(&made);
  return code;
}

static void expect_refusal(program_result result, int code, const char *line) {
  if (!is_refusal(&result, code, line))
    fail_msg("wanted %d '%s', got %d '%s'", code, line, result.exit_code, result.err);
  program_result_free(&result);
}

static void an_export_can_be_imported(void **state) {
  (void)state;
  program_result out = thrum_run(folder, "export", "beam.npz", "--vega-basis", "b.U",
                                 "--vega-cubic", "b.cub", "--matrices", "b", "--json", NULL);
  assert_int_equal(out.exit_code, 0);

  // the basis, the polynomial and three matrices, each in the place that is listed
  cJSON *line = json_line(out.out);
  const cJSON *files = cJSON_GetObjectItemCaseSensitive(line, "files");
  assert_int_equal(cJSON_GetArraySize(files), 5);
  const cJSON *file = NULL;
  cJSON_ArrayForEach(file, files) {
    char path[160];
    snprintf(path, sizeof path, "%s/%s", folder, file->valuestring);
    assert_true(file_exists(path));
  }

  cJSON_Delete(line);
  program_result_free(&out);

  // the imported model differs from the exported one by rounding
  out = thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "x<0.001", "--import-basis",
                  "b.U", "--import-cubic", "b.cub", "-o", "again.npz", "--json", "-q", NULL);
  assert_int_equal(out.exit_code, 0);
  line = json_line(out.out);

  const cJSON *import = cJSON_GetObjectItemCaseSensitive(line, "import");
  assert_true(cJSON_IsFalse(cJSON_GetObjectItemCaseSensitive(import, "basis_changed")));
  assert_true(json_value(import, "orthonormality") < 1e-11);
  assert_true(json_value(import, "energy_difference") < 1e-11);
  assert_true(json_value(line, "rank") == 9);
  assert_true(json_value(line, "modes") == 0);

  // stages that a given basis does not need are not listed as if they took no time
  const cJSON *stages = cJSON_GetObjectItemCaseSensitive(line, "stages");
  assert_null(cJSON_GetObjectItemCaseSensitive(stages, "modes"));
  assert_non_null(cJSON_GetObjectItemCaseSensitive(stages, "polynomial"));

  cJSON_Delete(line);
  program_result_free(&out);

  // the model can be shown and run, and says where it comes from
  out = thrum_run(folder, "info", "again.npz", NULL);
  assert_int_equal(out.exit_code, 0);
  assert_non_null(strstr(out.out, "from b.U, |U^T M U - 1| was "));
  assert_non_null(strstr(out.out, "\nresiduals         orthonormality "));
  program_result_free(&out);
}

static void outputs_that_could_not_be_written_are_refused_before_the_work(void **state) {
  (void)state;
  static const char *const cases[][3] = {
      {"new.npz", "nowhere/modes.vtu", "its folder does not exist"},
      {"new.npz", ".", "is a folder"},
      {"new.npz", "./new.npz", "name one file"},
      {"new.npz", "new.npz", "name one file"},
      {"/dev/null", "modes.vtu", "is no regular file"},
  };

  for (int n = 0; n < 5; n++) {
    expect_refusal(thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "x<0.001", "-o",
                             cases[n][0], "--export-modes", cases[n][1], "-q", NULL),
                   1, cases[n][2]);

    // the model, which could have been written, is not there either
    char path[160];
    snprintf(path, sizeof path, "%s/new.npz", folder);
    assert_false(file_exists(path));
  }
}

static void an_export_does_not_take_the_place_of_its_model(void **state) {
  (void)state;
  expect_refusal(thrum_run(folder, "export", "beam.npz", "--vega-basis", "./beam.npz", NULL), 2,
                 "is the model");
  expect_refusal(thrum_run(folder, "export", "beam.npz", "--vega-basis", "new.U", "--vega-cubic",
                           "./new.U", NULL),
                 2, "name one file");
  program_result still = thrum_run(folder, "info", "beam.npz", NULL);
  assert_int_equal(still.exit_code, 0);
  program_result_free(&still);
}

static void modes_are_named_by_their_frequencies(void **state) {
  (void)state;
  char path[160];
  snprintf(path, sizeof path, "%s/modes.vtu", folder);
  char *text = text_file_read(path);
  assert_non_null(text);
  for (int n = 1; n <= 4; n++) {
    char name[32];
    snprintf(name, sizeof name, "Name=\"mode_%02d_", n);
    assert_non_null(strstr(text, name));
  }
  assert_null(strstr(text, "mode_05"));
  free(text);
}

static void a_handle_takes_the_pull_into_the_basis(void **state) {
  (void)state;
  program_result out = thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "x<0.001",
                                 "--modes", "4", "--handles", "tip", "-o", "pull.npz", "-q", NULL);
  assert_int_equal(out.exit_code, 0);
  program_result_free(&out);

  // the share of the static response that lies outside the basis, without and with a handle
  const char *const models[] = {"beam.npz", "pull.npz"};
  double share[2];
  for (int n = 0; n < 2; n++) {
    out = thrum_run(folder, "info", models[n], "--load", "constant:0,0,-1@tip", "--json", NULL);
    assert_int_equal(out.exit_code, 0);
    cJSON *line = json_line(out.out);
    const cJSON *load = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(line, "loads"), 0);
    share[n] = json_value(load, "static_share_outside");
    cJSON_Delete(line);
    program_result_free(&out);
  }

  assert_true(share[0] > 0.01 && share[1] < 1e-8);

  // a load that does not fit the model, and one that is misspelt
  expect_refusal(thrum_run(folder, "info", "beam.npz", "--load", "constant:0,0,-1@nix", NULL), 1,
                 "nix");
  expect_refusal(thrum_run(folder, "info", "beam.npz", "--load", "pull:1", NULL), 2, "pull:1");
}

static void mistakes_are_named(void **state) {
  (void)state;
  expect_refusal(thrum_run(folder, "export", "beam.npz", NULL), 2, "--vega-basis");
  expect_refusal(thrum_run(folder, "export", "--vega-basis", "x.U", NULL), 2, "no model");
  expect_refusal(thrum_run(folder, "export", "beam.npz", "--float", "--vega-cubic", "x", NULL), 2,
                 "--float");
  expect_refusal(thrum_run(folder, "export", "beam.npz", "--vega-basis", "no/x.U", NULL), 1,
                 "no/x.U");
  expect_refusal(thrum_run(folder, "precompute", BEAM, "--order", "1", "-o", "x.npz",
                           "--import-cubic", "b.cub", NULL),
                 2, "--import-basis");
  expect_refusal(thrum_run(folder, "precompute", BEAM, "--order", "1", "-o", "x.npz",
                           "--import-basis", "beam.npz", "--fix", "x<0.001", "-q", NULL),
                 1, "beam.npz");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_export_can_be_imported),
      cmocka_unit_test(outputs_that_could_not_be_written_are_refused_before_the_work),
      cmocka_unit_test(an_export_does_not_take_the_place_of_its_model),
      cmocka_unit_test(modes_are_named_by_their_frequencies),
      cmocka_unit_test(a_handle_takes_the_pull_into_the_basis),
      cmocka_unit_test(mistakes_are_named),
  };
  return cmocka_run_group_tests(tests, make_model, remove_folder);
}
