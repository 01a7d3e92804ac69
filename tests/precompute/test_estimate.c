/* The estimate of a precompute's memory and time is near what the run takes, and a run that does
 * not fit is refused beforehand. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <sys/resource.h>
#include <sys/stat.h>

#include "platform/clock.h"
#include "platform/memory_limit.h"
#include "precompute/basis/mode_check.h"
#include "precompute/estimate.h"
#include "tests/support/test_folder.h"

#define BEAM "beam:30x8x8@1x0.2x0.2,split=6"

static void the_estimate_is_near_what_the_run_takes(void **state) {
  (void)state;
  program_result dry = thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "left",
                                 "--rank", "30", "--dry-run", "--json", NULL);
  assert_int_equal(dry.exit_code, 0);
  program_result wet = thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "left",
                                 "--rank", "30", "-o", "made.npz", "--json", NULL);
  assert_int_equal(wet.exit_code, 0);

  // the sizes are exactly known from the symbolic analysis
  cJSON *said = json_line(dry.out), *took = json_line(wet.out);
  static const char *const exact[] = {"free_dofs", "factor_nonzeros", "tets", "vertices"};
  for (int n = 0; n < 4; n++)
    assert_true(json_value(said, exact[n]) == json_value(took, exact[n]));

  // the memory is an estimate; the bounds are loose, because sanitizers take memory of their own
  const double ratio = json_value(said, "memory_mb") / json_value(took, "peak_mb");
  print_message("memory said over memory taken: %.2f\n", ratio);
  assert_true(ratio > 0.2 && ratio < 1.6);
  assert_true(json_value(cJSON_GetObjectItem(said, "seconds"), "total") > 0);

  cJSON_Delete(said);
  cJSON_Delete(took);
  program_result_free(&dry);
  program_result_free(&wet);
}

/* A figure of a run of the beam with as many points as may be, after `steps` of learning. */
static double cubature_figure(const char *steps, const char *how, const char *name) {
  program_result run = thrum_run(
      folder, "precompute", "beam:12x3x3@1x0.2x0.2", "--order", "1", "--fix", "left", "--modes",
      "8", "--rank", "40", "--cubature", "--cubature-error", "1e-9", "--cubature-points", "300",
      "--cubature-refine", steps, "--json", how, "-o", "points.npz", NULL);
  if (run.exit_code != 0 && run.exit_code != 3)
    fail_msg("%s", run.err);
  cJSON *object = json_line(run.out);
  const double figure = json_value(object, name);
  cJSON_Delete(object);
  program_result_free(&run);
  return figure;
}

static void learned_gradients_take_the_memory_that_is_said(void **state) {
  (void)state;
  const double said = cubature_figure("1", "--dry-run", "memory_mb") -
                      cubature_figure("0", "--dry-run", "memory_mb");
  const double took = cubature_figure("1", "-q", "peak_mb") - cubature_figure("0", "-q", "peak_mb");
  print_message("memory of learning said %.1f MB, taken %.1f MB\n", said, took);
  assert_true(said > 20 && said / took > 0.6 && said / took < 1.6);
}

/* Points of another law are learned one by one, which is nearly all the time of a small body. */
static void learning_another_law_is_said_to_take_longer(void **state) {
  (void)state;
  static const char *const laws[] = {"stvk", "neo-hookean", "corotational"};
  double seconds[3];
  for (int n = 0; n < 3; n++) {
    program_result dry =
        thrum_run(folder, "precompute", "beam:2x1x1@1x0.2x0.2", "--order", "1", "--fix", "left",
                  "--modes", "2", "--rank", "3", "--cubature", "--cubature-refine", "100000",
                  "--law", laws[n], "--dry-run", "--json", NULL);
    assert_int_equal(dry.exit_code, 0);
    cJSON *said = json_line(dry.out);
    seconds[n] = json_value(cJSON_GetObjectItem(said, "seconds"), "cubature");
    cJSON_Delete(said);
    program_result_free(&dry);
  }

  // the times stand in the order of what one stress takes with each law
  assert_true(seconds[0] > 0);
  assert_true(seconds[1] > 1.3 * seconds[0] && seconds[2] > 1.3 * seconds[1]);
}

static void a_given_basis_is_estimated_too(void **state) {
  (void)state;

  // a basis to import, written by a run of its own
  program_result run = thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "left",
                                 "--rank", "30", "-o", "own.npz", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "export", "own.npz", "--vega-basis", "own.U", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // the same import, estimated and run
  program_result dry = thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "left",
                                 "--import-basis", "own.U", "--dry-run", "--json", NULL);
  assert_int_equal(dry.exit_code, 0);
  program_result wet =
      thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "left", "--import-basis",
                "own.U", "-o", "again.npz", "--json", "-q", NULL);
  assert_int_equal(wet.exit_code, 0);
  cJSON *said = json_line(dry.out), *took = json_line(wet.out);
  const double ratio = json_value(said, "memory_mb") / json_value(took, "peak_mb");
  print_message("memory said over memory taken: %.2f\n", ratio);
  assert_true(ratio > 0.2 && ratio < 1.6);
  cJSON_Delete(said);
  cJSON_Delete(took);
  program_result_free(&dry);
  program_result_free(&wet);

  // too little memory: refused before the arrays are allocated, and no file is written
  run = thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "left", "--import-basis",
                  "own.U", "-o", "small.npz", "--memory", "2", "-q", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "this takes about"));
  program_result_free(&run);
  char path[128];
  snprintf(path, sizeof path, "%s/small.npz", folder);
  assert_false(file_exists(path));
}

// only a part of a polynomial is made where the model is to be condensed, which takes less time
static void a_condensed_model_is_estimated_to_take_less(void **state) {
  (void)state;
  double seconds[2];
  for (int n = 0; n < 2; n++) {
    program_result run =
        thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "left", "--modes", "20",
                  "--rank", "60", "--dry-run", "--json", n == 0 ? NULL : "--condense", NULL);
    assert_int_equal(run.exit_code, 0);
    cJSON *said = json_line(run.out);
    seconds[n] = json_value(cJSON_GetObjectItem(said, "seconds"), "polynomial");
    cJSON_Delete(said);
    program_result_free(&run);
  }
  // columns: 270 against 1890, and their number squared; two probes of the machine may differ
  assert_true(seconds[1] > 0 && seconds[1] < 0.2 * seconds[0]);
}

static void a_dry_run_writes_nothing_and_says_when_it_would_not_fit(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "left", "-o",
                                 "dry.npz", "--dry-run", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.out, "it fits"));
  program_result_free(&run);
  char path[160];
  snprintf(path, sizeof path, "%s/dry.npz", folder);
  assert_false(file_exists(path));
  run = thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "left", "--memory", "2",
                  "--dry-run", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.out, "does NOT fit"));
  program_result_free(&run);
}

static void a_dry_run_refuses_what_the_run_would_refuse(void **state) {
  (void)state;
  static const char *const cases[][5] = {
      {"--fix", "left", "--rank", "66", "their derivatives give (65)"},
      {"--fix", "left:x", "--rank", "20", "too little is fixed"},
      {"--fix", "left", "--rank", "600", "must lie between 1 and 512"},
      {"--fix", "left", "--modes", "9000", "must lie between 1 and 512"},
      {"--fix", "left", "--modes", "500", "500 modes make a rank of 1000"},
  };

  // the run and the dry run refuse alike, in one line and without output
  for (int n = 0; n < 5; n++)
    for (int dry = 0; dry < 2; dry++) {
      program_result run = thrum_run(folder, "precompute", BEAM, "--order", "1", cases[n][0],
                                     cases[n][1], cases[n][2], cases[n][3], "-q", "-o",
                                     "refused.npz", dry ? "--dry-run" : NULL, NULL);
      assert_int_equal(run.exit_code, 1);
      assert_true(line_count_is(run.err, 1));
      assert_non_null(strstr(run.err, cases[n][4]));
      assert_string_equal(run.out, "");
      program_result_free(&run);
    }
}

static double said_mb(const char *check) {
  program_result dry = thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "left",
                                 "--check", check, "--dry-run", "--json", NULL);
  assert_int_equal(dry.exit_code, 0);
  cJSON *said = json_line(dry.out);
  const double mb = json_value(said, "memory_mb");
  cJSON_Delete(said);
  program_result_free(&dry);
  return mb;
}

static void the_inertia_count_is_counted_where_it_is_made(void **state) {
  (void)state;
  if (thrum_inertia_available())
    assert_true(said_mb("inertia") > said_mb("search") + 1);
  assert_true(fabs(said_mb("auto") - said_mb(thrum_inertia_available() ? "inertia" : "search")) <
              1);
}

static void a_model_that_does_not_fit_into_memory_is_refused_in_one_line(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "left", "-o",
                                 "large.npz", "--memory", "2", "-q", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_true(line_count_is(run.err, 1));
  assert_non_null(strstr(run.err, "of the limit given are left"));
  assert_non_null(strstr(run.err, "use a coarser mesh or fewer modes"));
  assert_null(strstr(run.err, "--cubature-refine"));
  program_result_free(&run);

  // what else would do is said where it would
  run = thrum_run(folder, "precompute", BEAM, "--order", "1", "--fix", "left", "-o", "large.npz",
                  "--memory", "60", "--modes", "20", "--rank", "100", "--cubature",
                  "--cubature-refine", "1000000", "-q", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_true(line_count_is(run.err, 1));
  assert_non_null(strstr(run.err, ", or a lower --rank"));
  assert_non_null(strstr(run.err, "leave --cubature-refine out"));
  program_result_free(&run);
  char path[160];
  snprintf(path, sizeof path, "%s/large.npz", folder);
  assert_false(file_exists(path));
}

/* A row of boxes, each a region of its own. */
static void write_regions(int count) {
  char path[160];
  snprintf(path, sizeof path, "%s/regions.inp", folder);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fputs("*NODE\n", file);
  for (int n = 0; n < 4 * (count + 1); n++)
    fprintf(file, "%d, %d, %d, %d\n", n + 1, n / 4, n % 4 == 1 || n % 4 == 2, n % 4 > 1);
  for (int g = 0; g < count; g++) {
    fprintf(file, "*ELEMENT, TYPE=C3D8, ELSET=R%d\n%d", g, g + 1);
    for (int n = 1; n < 9; n++)
      fprintf(file, ", %d", 4 * g + n);
    fprintf(file, "\n*SOLID SECTION, ELSET=R%d, MATERIAL=S\n", g);
  }
  fputs("*MATERIAL, NAME=S\n*ELASTIC\n5e6, 0.3\n*DENSITY\n1000\n", file);
  fclose(file);
}

static program_result run_regions(const char *modes, const char *rank, const char *how) {
  return thrum_run(folder, "precompute", "regions.inp", "--order", "1", "--fix", "x<0.001",
                   "--modes", modes, "--rank", rank, "--parameters", "--json", how, "-o",
                   "regions.npz", NULL);
}

/* Each region has a polynomial for each of its two moduli, of a rank that grows with all of them.
 */
static void what_parameters_add_is_said_before(void **state) {
  (void)state;
  write_regions(6);
  program_result dry = run_regions("3", "6", "--dry-run"), wet = run_regions("3", "6", "-q");
  assert_int_equal(dry.exit_code, 0);
  assert_int_equal(wet.exit_code, 0);
  cJSON *said = json_line(dry.out), *took = json_line(wet.out);
  char path[160];
  struct stat made;
  snprintf(path, sizeof path, "%s/regions.npz", folder);
  assert_int_equal(stat(path, &made), 0);
  assert_true(json_value(said, "rank") == json_value(took, "rank"));
  assert_true(fabs(json_value(said, "file_mb") * 1048576 / (double)made.st_size - 1) < 0.05);
  cJSON_Delete(said);
  cJSON_Delete(took);
  program_result_free(&dry);
  program_result_free(&wet);

  // more than a model may have is refused before anything is computed
  write_regions(90);
  dry = run_regions("3", "6", "-q");
  assert_int_equal(dry.exit_code, 1);
  assert_non_null(strstr(dry.err, "parameters of 90 regions make a rank of 540"));
  program_result_free(&dry);
}

/* A given basis has its rank, so neither a lower rank nor other points can save memory, whatever
 * was in the estimate before. */
static void what_would_do_is_known_of_a_basis_that_is_given(void **state) {
  (void)state;
  int64_t begin[1] = {0};
  const thrum_imported_basis imported = {.rows = 3000, .rank = 20};
  const thrum_fem fem = {.free_count = 2900, .vertex_count = 1000, .tet_count = 4000};
  const thrum_sparse stiffness = {.begin = begin};
  thrum_precompute_options options = thrum_default_precompute_options();
  options.imported = &imported;

  // the estimate holds other bytes before, which must not show
  for (int fits = 0; fits < 2; fits++) {
    thrum_estimate estimate;
    memset(&estimate, 1, sizeof estimate);
    options.memory_limit = fits ? 1e12 : 1;
    thrum_estimate_memory(&fem, &stiffness, NULL, &options, &estimate);
    assert_true(estimate.fits == fits && estimate.more > 0);
    assert_false(estimate.by_rank || estimate.by_refine);
    assert_true(estimate.seconds[0] == 0);
  }
}

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED
#endif
#if defined(SANITIZED) /* they need terabytes of address space */
#define LIMIT ""
enum { LIMITED = 0 };
#else
#define LIMIT "ulimit -s 1024; ulimit -v 150000; " /* small stacks, for machines of many cores */
enum { LIMITED = 1 };
#endif

static program_result run_limited(const char *arguments) {
  char command[400], program[] = "/bin/sh", option[] = "-c";
  snprintf(command, sizeof command, LIMIT "exec timeout -s KILL 60 %s %s", THRUM_PROGRAM,
           arguments);
  char *argv[] = {program, option, command, NULL};
  return program_execute(folder, argv);
}

/* OpenBLAS's threads retry without end when they get no memory, and so delay the program's exit. */
static void a_program_without_room_for_its_libraries_ends_and_says_so(void **state) {
  (void)state;

  // a command that needs no numerical library runs within the limit
  program_result run = run_limited("--version");
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // the others end with one line that names the reason
  static const char *const commands[] = {
      "precompute beam:4x2x2@1x0.2x0.2 --order 1 --fix left -q -o limited.npz",
      "precompute beam:4x2x2@1x0.2x0.2 --order 1 --fix left -q -o limited.npz --threads 2",
      "precompute beam:4x2x2@1x0.2x0.2 --order 1 --fix left -q --dry-run"};
  for (int n = 0; n < 3; n++) {
    run = run_limited(commands[n]);
    assert_int_equal(run.exit_code, LIMITED);
    if (LIMITED) {
      assert_true(line_count_is(run.err, 1));
      assert_non_null(strstr(run.err, "no memory for the numerical libraries"));
    }
    program_result_free(&run);
  }
}

/* This runs in a child process, which limits itself to 64 MiB of further address space. */
static void judge_limited(void) {
  const double before = thrum_memory_available(NULL);

  // the limit is set a fixed amount above what the process already takes
  struct rlimit limit;
  FILE *file = fopen("/proc/self/statm", "r");
  double pages = 0;
  if (file == NULL || fscanf(file, "%lf", &pages) != 1 || getrlimit(RLIMIT_AS, &limit) != 0)
    _exit(1);
  fclose(file);
  limit.rlim_cur = (rlim_t)(pages * (double)sysconf(_SC_PAGESIZE) + 67108864.0);
  if (setrlimit(RLIMIT_AS, &limit) != 0)
    _exit(2);

  // the memory said to be left is bounded by the process's own limit
  const char *what = NULL;
  const double left = thrum_memory_available(&what);
  if (before < 67108864.0)
    _exit(0);
  _exit(left > 0 && left <= 67108864.0 && strcmp(what, "of the process's limit") == 0 ? 0 : 3);
}

static void the_least_of_all_limits_is_what_is_left(void **state) {
  (void)state;
  assert_true(thrum_memory_available(NULL) > 0);
  assert_true(thrum_memory_resident() > 1e5);
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0)
    judge_limited();
  int status = 0;
  assert_true(waitpid(child, &status, 0) == child);
  assert_true(WIFEXITED(status));
  assert_int_equal(WEXITSTATUS(status), 0);
}

/* The mesh of a generator is judged before it is made: never too much, and early enough. */
static void a_grid_that_cannot_fit_is_refused_before_it_is_made(void **state) {
  (void)state;
  static const int64_t grids[][3] = {{200, 6, 6}, {16, 16, 16}, {4, 30, 30}};
  thrum_precompute_options options = thrum_default_precompute_options();
  for (size_t n = 0; n < sizeof grids / sizeof grids[0]; n++) {
    char name[96];
    snprintf(name, sizeof name, "beam:%dx%dx%d@1x1x1", (int)grids[n][0], (int)grids[n][1],
             (int)grids[n][2]);
    program_result dry = thrum_run(folder, "precompute", name, "--order", "1", "--fix", "left",
                                   "--modes", "2", "--rank", "4", "--dry-run", "--json", NULL);
    assert_int_equal(dry.exit_code, 0);
    cJSON *said = json_line(dry.out);

    // where the whole estimate fits, the first look says nothing
    options.modes = 2;
    options.rank = 4;
    options.memory_limit = thrum_memory_resident() + json_value(said, "memory_mb") * 1048576;
    assert_int_equal(thrum_estimate_grid(grids[n], &options, NULL), THRUM_OK);
    cJSON_Delete(said);
    program_result_free(&dry);
  }

  // 56 letters that ask for 200 million tets
  thrum_error error;
  const int64_t large[3] = {320, 320, 320};
  options.memory_limit = 16e9;
  assert_int_equal(thrum_estimate_grid(large, &options, &error), THRUM_OUT_OF_MEMORY);
  const double began = clock_seconds();
  for (int dry = 0; dry < 2; dry++) {
    program_result run =
        thrum_run(folder, "precompute", "beam:320x320x320@1x1x1", "--fix", "left", "-o",
                  "large.npz", "--memory", "16000", dry ? "--dry-run" : NULL, NULL);
    assert_int_equal(run.exit_code, 1);
    assert_non_null(strstr(run.err, "this takes about"));
    assert_string_equal(run.out, "");
    program_result_free(&run);
  }
  assert_true(clock_seconds() - began < 20);
}

/* Refusals are those of this program: none goes on as thrum-mpi, which may lie beside it. */
static int make_folder_without_mpi(void **state) {
  const int made = make_folder(state);
  return made != 0 ? made : setenv("THRUM_MPI", in_folder("nothing"), 1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_estimate_is_near_what_the_run_takes),
      cmocka_unit_test(learned_gradients_take_the_memory_that_is_said),
      cmocka_unit_test(learning_another_law_is_said_to_take_longer),
      cmocka_unit_test(a_given_basis_is_estimated_too),
      cmocka_unit_test(a_condensed_model_is_estimated_to_take_less),

      // dry runs
      cmocka_unit_test(a_dry_run_writes_nothing_and_says_when_it_would_not_fit),
      cmocka_unit_test(a_dry_run_refuses_what_the_run_would_refuse),
      cmocka_unit_test(the_inertia_count_is_counted_where_it_is_made),

      // memory that does not suffice
      cmocka_unit_test(a_model_that_does_not_fit_into_memory_is_refused_in_one_line),
      cmocka_unit_test(what_parameters_add_is_said_before),
      cmocka_unit_test(what_would_do_is_known_of_a_basis_that_is_given),
      cmocka_unit_test(a_grid_that_cannot_fit_is_refused_before_it_is_made),
      cmocka_unit_test(a_program_without_room_for_its_libraries_ends_and_says_so),
      cmocka_unit_test(the_least_of_all_limits_is_what_is_left),
  };
  return cmocka_run_group_tests(tests, make_folder_without_mpi, remove_folder);
}
