/* `thrum precompute --train`: a trained basis errs less under its load, says so, and what cannot be
 * trained is refused. SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cjson/cJSON.h>
#include <cmocka.h>
#include <dirent.h>
#include <math.h>
#include <sys/stat.h>

#include "io/npy_file.h"

#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

#define MESH "beam:8x2x2@1x0.2x0.2"
#define PULL "square:0,0,-300@vertex=30"

/* The training of --json of a precompute with more options; the caller frees. */
static cJSON *train(const char *modes, const char *rank) {
  program_result run =
      thrum_run(folder, "precompute", MESH, "--order", "1", "--fix", "x<0.001", "-o", "trained.npz",
                "--modes", modes, "--rank", rank, "--train", PULL, "--test", "gravity:0,2,-9.81",
                "--train-time", "0.3", "--json", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

static void a_larger_trained_basis_errs_less_and_both_errors_are_said(void **state) {
  (void)state;
  cJSON *small = train("4", "6"), *large = train("4", "14");
  const cJSON *of_small = cJSON_GetObjectItem(small, "training"),
              *of_large = cJSON_GetObjectItem(large, "training");
  assert_true(json_value(of_large, "shapes") == 7);
  assert_true(json_value(of_large, "error") < 0.5 * json_value(of_small, "error"));
  assert_true(json_value(of_large, "error") < 0.03);
  assert_true(json_value(of_large, "test_error") > 0);
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(of_large, "loads")), 2);
  cJSON_Delete(small);
  cJSON_Delete(large);
}

static void each_stage_of_a_training_is_shown_once_and_all_of_them_are_accounted_for(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "precompute", MESH, "--order", "1", "--fix", "x<0.001",
                                 "-o", "shown.npz", "--modes", "4", "--rank", "8", "--train", PULL,
                                 "--train-time", "0.1", "--json", NULL);
  assert_int_equal(run.exit_code, 0);

  // the bases on both sides of the runs are told apart, and a stage ends before the next begins
  static const char *const begins[] = {
      "untrained: linear modes ...\n", "untrained: reduced polynomial ...\nuntrained: reduced p",
      "training " PULL " ...\ntraining " PULL ": ", "trained: linear modes ...\n",
      "errors under the loads ...\nerrors under the loads: "};
  for (size_t n = 0; n < sizeof begins / sizeof begins[0]; n++)
    if (text_count(run.err, begins[n]) != (n == 3 ? 2 : 1))
      fail_msg("'%s' in: %s", begins[n], run.err);

  // the stages of the model and the training are nearly all of the time
  cJSON *object = json_line(run.out);
  const cJSON *stage = NULL, *stages = cJSON_GetObjectItem(object, "stages");
  double sum = 0;
  cJSON_ArrayForEach(stage, stages) sum += json_value(stage, "seconds");
  const double total = json_value(cJSON_GetObjectItem(object, "seconds"), "total");
  assert_true(json_value(cJSON_GetObjectItem(stages, "training"), "seconds") > 0);
  assert_true(sum > 0.5 * total && sum <= total);
  cJSON_Delete(object);
  program_result_free(&run);
}

/* The error of a training under its loads. */
static double error_of(const char *mesh, const char *load) {
  program_result run =
      thrum_run(folder, "precompute", mesh, "--order", "1", "-o", "one.npz", "--modes", "4",
                "--rank", "10", "--train", load, "--train-time", "0.2", "--train-dt", "0.005",
                "--fix", "x<0.001", "--json", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  cJSON *object = json_line(run.out);
  const double error = json_value(cJSON_GetObjectItem(object, "training"), "error");
  cJSON_Delete(object);
  program_result_free(&run);
  return error;
}

static void loads_of_one_training_act_together(void **state) {
  (void)state;
  const double both = error_of(MESH, PULL ";gravity:0,0,-9.81"), one = error_of(MESH, PULL);
  assert_true(both > 0 && one > 0 && both != one);
}

/* The error of the usual basis in a case, without a training. */
static double untrained_error(const char *test, const char *time) {
  program_result run =
      thrum_run(folder, "precompute", MESH, "--order", "1", "-o", "one.npz", "--modes", "4",
                "--rank", "10", "--test", test, "--train-time", time, "--train-dt", "0.005",
                "--fix", "x<0.001", "--keep-runs", "tested", "--json", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  cJSON *object = json_line(run.out);
  const double error = json_value(cJSON_GetObjectItem(object, "training"), "test_error");
  cJSON_Delete(object);
  program_result_free(&run);
  return error;
}

static void a_base_that_accelerates_is_gravity_against_it(void **state) {
  (void)state;
  FILE *file = fopen(in_folder("steady.csv"), "w");
  assert_non_null(file);
  fputs("t,ax,ay,az\n0,0,-2,9\n1,0,-2,9\n", file);
  fclose(file);
  const double gravity = untrained_error("gravity:0,2,-9", "0.2");
  assert_true(fabs(untrained_error("base-motion:steady.csv", "0.2") - gravity) < 1e-9);

  // and a basis is trained on it
  const double trained = error_of(MESH, "base-motion:steady.csv");
  assert_true(trained > 0 && trained < 0.5 * gravity);
}

static void a_body_that_its_load_holds_stays(void **state) {
  (void)state;
  static const char held[] = "start:static:constant:0,0,-100@vertex=30;constant:0,0,-100@vertex=30";
  const double at_rest = untrained_error(held, "0.1");
  assert_true(at_rest > 1e-4 && at_rest < 0.2);
  assert_true(fabs(untrained_error(held, "0.2") - at_rest) < 1e-3 * at_rest);

  // a start by a mode is released and swings, which the usual basis shows
  const double mode = untrained_error("start:mode:1,0.05", "0.2");
  assert_true(mode > 0 && mode < 0.1);
  assert_true(error_of(MESH, "start:mode:1,0.05;start:static:constant:0,0,-50@tip") < 0.05);
}

static void a_model_file_stands_for_its_mesh(void **state) {
  (void)state;
  const double of_mesh = error_of(MESH, PULL);
  program_result run = thrum_run(folder, "precompute", "one.npz", "-o", "two.npz", "--modes", "4",
                                 "--rank", "10", "--train", PULL, "--train-time", "0.2",
                                 "--train-dt", "0.005", "--reproducible", "--json", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  cJSON *object = json_line(run.out);

  // materials, held vertices and groups came with it
  assert_true(json_value(cJSON_GetObjectItem(object, "training"), "error") == of_mesh);
  assert_true(json_value(object, "fixed") == 9);
  cJSON_Delete(object);
  program_result_free(&run);
  run = thrum_run(folder, "info", "two.npz", NULL);
  assert_non_null(strstr(run.out, "tip"));
  program_result_free(&run);

  // what belongs to the file of a mesh is refused, and so is a model without one
  run = thrum_run(folder, "precompute", "two.npz", "-o", "three.npz", "--order", "2", "-q", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "are of its mesh's file"));
  program_result_free(&run);
}

/* Trains with runs that are kept, and finds the file of the one run: the error of the training, and
 * the file's number, which another file has when it was made anew. */
static double train_with_kept_runs(char *kept, size_t size, ino_t *number) {
  program_result run =
      thrum_run(folder, "precompute", MESH, "--order", "1", "--fix", "x<0.001", "-o", "k.npz",
                "--modes", "4", "--rank", "10", "--train", PULL, "--train-time", "0.2",
                "--keep-runs", "kept", "--json", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  cJSON *object = json_line(run.out);
  const double error = json_value(cJSON_GetObjectItem(object, "training"), "error");
  cJSON_Delete(object);
  program_result_free(&run);

  // files of full-order runs begin with an f
  DIR *dir = opendir(in_folder("kept"));
  struct stat about;
  assert_non_null(dir);
  for (struct dirent *entry = readdir(dir); entry != NULL; entry = readdir(dir))
    if (entry->d_name[0] == 'f')
      snprintf(kept, size, "kept/%.90s", entry->d_name);
  closedir(dir);
  assert_int_equal(stat(in_folder(kept), &about), 0);
  *number = about.st_ino;
  return error;
}

static void a_run_that_is_kept_is_not_made_again(void **state) {
  (void)state;
  char kept[100] = "";
  ino_t first = 0, next = 0;
  const double error = train_with_kept_runs(kept, sizeof kept, &first);
  assert_true(error < 0.2 && train_with_kept_runs(kept, sizeof kept, &next) == error);
  assert_true(next == first);

  // a file of which one bit of a displacement is another one is made again, beside the old one
  FILE *file = fopen(in_folder(kept), "r+b");
  assert_non_null(file);
  assert_int_equal(fseek(file, 1000, SEEK_SET), 0);
  const int byte = fgetc(file);
  assert_int_equal(fseek(file, 1000, SEEK_SET), 0);
  assert_int_equal(fputc(byte ^ 1, file), byte ^ 1);
  assert_int_equal(fclose(file), 0);
  assert_true(train_with_kept_runs(kept, sizeof kept, &next) == error && next != first);

  // so is one that was cut short
  first = next;
  assert_int_equal(truncate(in_folder(kept), 1000), 0);
  assert_true(train_with_kept_runs(kept, sizeof kept, &next) == error && next != first);
}

static void shares_make_another_model_that_is_as_good(void **state) {
  (void)state;
  double errors[2];
  for (int n = 0; n < 2; n++) {
    program_result run =
        thrum_run(folder, "precompute", MESH, "--order", "1", "--fix", "x<0.001", "-o", "s.npz",
                  "--modes", "4", "--rank", "12", "--train", PULL, "--train-time", "0.2",
                  "--keep-runs", "kept", "--json", "-q", n == 0 ? NULL : "--by-share", NULL);
    assert_int_equal(run.exit_code, 0);
    cJSON *object = json_line(run.out);
    errors[n] = json_value(cJSON_GetObjectItem(object, "training"), "error");
    cJSON_Delete(object);
    program_result_free(&run);
  }
  assert_true(errors[0] != errors[1] && errors[1] > 0 && errors[1] < 2 * errors[0] + 0.02);
}

static void handles_and_a_training_share_the_rank(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "precompute", MESH, "--order", "1", "--fix", "x<0.001",
                                 "-o", "h.npz", "--modes", "4", "--handles", "vertex=30", "--train",
                                 PULL, "--train-time", "0.2", "--json", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  cJSON *object = json_line(run.out);

  // four modes and five directions of their derivatives, and six of the handle beside them
  assert_true(json_value(object, "rank") == 15);
  cJSON_Delete(object);
  program_result_free(&run);
}

/* The object of a training that grows for an error; *code: the exit code. */
static cJSON *grow(const char *error, const char *rank_max, int *code) {
  program_result run = thrum_run(
      folder, "precompute", MESH, "--order", "1", "--fix", "x<0.001", "-o", "grown.npz", "--modes",
      "3", "--rank", "5", "--train", PULL, "--test", "gravity:0,2,-9.81", "--train-time", "0.2",
      "--keep-runs", "kept", "--error", error, "--rank-max", rank_max, "--json", NULL);
  *code = run.exit_code;
  cJSON *object = json_line(run.out);
  if (object == NULL)
    fail_msg("%s", run.err);

  // each trial is told
  assert_non_null(strstr(run.err, "thrum: rank 5 of 3 modes"));

  // and each run of the training, kept or not
  assert_non_null(strstr(run.err, "training " PULL));
  program_result_free(&run);
  return object;
}

static void a_basis_grows_until_no_load_errs_by_more(void **state) {
  (void)state;
  int code = 0;
  cJSON *coarse = grow("20%", "60", &code);
  assert_int_equal(code, 0);
  cJSON *fine = grow("3%", "60", &code);
  assert_int_equal(code, 0);
  const cJSON *training = cJSON_GetObjectItem(fine, "training");
  assert_true(json_value(training, "error") <= 0.03);
  assert_true(json_value(training, "test_error") <= 0.03);
  assert_true(json_value(fine, "rank") > json_value(coarse, "rank"));

  // the limit says no, and the model is there all the same
  cJSON *limited = grow("0.01%", "10", &code);
  assert_int_equal(code, 3);
  assert_true(json_value(limited, "rank") <= 10);
  assert_true(file_exists(in_folder("grown.npz")));
  cJSON_Delete(coarse);
  cJSON_Delete(fine);
  cJSON_Delete(limited);
}

#define LONG_BEAM "beam:20x6x6@1x0.2x0.2"
#define FALL "gravity:0,0,-9.81"

static void the_memory_of_a_training_is_counted(void **state) {
  (void)state;
  double memory[2];
  for (int n = 0; n < 2; n++) {
    program_result run = thrum_run(folder, "precompute", LONG_BEAM, "--order", "1", "--fix",
                                   "x<0.001", "--dry-run", "--json", n == 0 ? NULL : "--train",
                                   FALL, "--test", FALL, "--test", FALL, "--test", FALL, NULL);
    assert_int_equal(run.exit_code, 0);
    cJSON *object = json_line(run.out);
    memory[n] = json_value(object, "memory_mb");
    cJSON_Delete(object);
    program_result_free(&run);
  }

  // five times 128 fields of 1029 vertices are 15 MB
  assert_true(memory[1] - memory[0] > 10 && memory[1] - memory[0] < 30);

  // a limit that leaves room for the model alone
  char limit[32];
  snprintf(limit, sizeof limit, "%.0f", memory[0] + 3);
  program_result run = thrum_run(folder, "precompute", LONG_BEAM, "--order", "1", "--fix",
                                 "x<0.001", "-o", "none.npz", "--memory", limit, "--train", FALL,
                                 "--test", FALL, "--test", FALL, "--test", FALL, "-q", NULL);
  assert_int_equal(run.exit_code, 1);
  if (strstr(run.err, "of the limit given are left") == NULL || strstr(run.err, "--train") == NULL)
    fail_msg("%s", run.err);
  program_result_free(&run);
}

static void what_cannot_be_trained_is_refused(void **state) {
  (void)state;
  static const char *const cases[][5] = {
      {"--test", PULL, "--condense", NULL, "--test judge the whole model"},
      {"--train", "start:end.npy", NULL, NULL, "'start:end.npy': the coordinates in a file"},
      {"--train", "start:mode:99,1", NULL, NULL, "--train 'mode:99,1': the model has modes 1 to"},
      {"--train", "base-motion:none.csv", NULL, NULL, "none.csv: cannot be read"},
      {"--error", "5%", NULL, NULL, "--error goes with --train"},
      {"--by-share", NULL, NULL, NULL, "--by-share goes with --train"},
      {"--train", "push:1,2,3", NULL, NULL, "--train 'push:1,2,3'"},
      {"--train", "square:0,0,-1@nowhere", NULL, NULL, "--train 'square:0,0,-1@nowhere': no group"},
      {"--train", PULL, "--rank", "10", "leaves nothing beside 10 modes"},
      {"--train", PULL, "--import-basis", "none.U", "--train and --test go without"},
      {"--train", PULL, "--condense", NULL, "--test judge the whole model"},
      {"--train", PULL, "--train-time", "1e300", "--train-time 1e+300 is more than"},
      {"--train", "gravity:0,0,0", NULL, NULL, "--train: the loads move nothing"},
  };
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    program_result run =
        thrum_run(folder, "precompute", MESH, "--order", "1", "--fix", "x<0.001", "-o", "none.npz",
                  "-q", cases[n][0], cases[n][1], cases[n][2], cases[n][3], NULL);
    assert_true(run.exit_code == 1 || run.exit_code == 2);
    if (strstr(run.err, cases[n][4]) == NULL)
      fail_msg("case %zu: %s", n, run.err);
    assert_false(file_exists(in_folder("none.npz")));
    program_result_free(&run);
  }

  // a free body would fly away
  program_result run = thrum_run(folder, "precompute", MESH, "--order", "1", "-o", "none.npz", "-q",
                                 "--train", PULL, NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "nothing is held"));
  program_result_free(&run);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      // what is shown and said
      cmocka_unit_test(each_stage_of_a_training_is_shown_once_and_all_of_them_are_accounted_for),
      cmocka_unit_test(a_larger_trained_basis_errs_less_and_both_errors_are_said),

      // what is trained on
      cmocka_unit_test(loads_of_one_training_act_together),
      cmocka_unit_test(a_base_that_accelerates_is_gravity_against_it),
      cmocka_unit_test(a_body_that_its_load_holds_stays),
      cmocka_unit_test(a_model_file_stands_for_its_mesh),
      cmocka_unit_test(a_run_that_is_kept_is_not_made_again),
      cmocka_unit_test(shares_make_another_model_that_is_as_good),
      cmocka_unit_test(handles_and_a_training_share_the_rank),
      cmocka_unit_test(a_basis_grows_until_no_load_errs_by_more),
      cmocka_unit_test(the_memory_of_a_training_is_counted),
      cmocka_unit_test(what_cannot_be_trained_is_refused),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
