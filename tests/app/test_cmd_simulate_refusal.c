/* Tests of what `thrum simulate` refuses, of what it does with a folder that is there already, and
 * of how it ends when it is stopped: one clear line, the right exit code, nothing half-written.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <math.h>
#include <signal.h>
#include <time.h>

#include "io/npy_file.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

static int make_models(void **state) {
  (void)state;
  static const double zeros[6] = {0};
  const double infinite[2] = {INFINITY, 0}, huge[2] = {1e300, 1e300}, far[1] = {5};

  // two models, starts of wrong shapes and values, and folders that hold something else
  const bool made =
      test_folder_make(folder) != NULL && save_particle(in_folder("particle.npz"), 100, 400) &&
      save_oscillator(in_folder("bare.npz"), 400, 1e4) &&
      save_npy(in_folder("bare.npy"), zeros, 1, 0) && save_npy(in_folder("far.npy"), far, 1, 0) &&
      save_npy(in_folder("three.npy"), zeros, 3, 0) &&
      save_npy(in_folder("rows.npy"), zeros, 3, 2) &&
      save_npy(in_folder("infinite.npy"), infinite, 2, 0) &&
      save_npy(in_folder("huge.npy"), huge, 2, 0) &&
      text_file_write(in_folder("text.npz"), "no model\n") &&
      text_file_write(in_folder("file"), "a file\n") && mkdir(in_folder("foreign"), 0777) == 0 &&
      text_file_write(in_folder("foreign/notes.txt"), "mine\n") &&
      mkdir(in_folder("other"), 0777) == 0 &&
      text_file_write(in_folder("other/run.json"), "{\"program\":\"else\"}\n") &&
      mkdir(in_folder("scene"), 0777) == 0 &&
      text_file_write(in_folder("scene/scene.json"),
                      "{\"program\":\"thrum\",\"command\":\"simulate\"}\n");

  return !made;
}

/* Counts the entries of a folder, hidden ones included. */
static int count_entries(const char *path) {
  int count = 0;
  DIR *entries = opendir(path);
  assert_non_null(entries);
  while (readdir(entries) != NULL)
    count++;
  closedir(entries);
  return count - 2;
}

typedef struct refusal {
  const char *arguments[8]; /* after "simulate" */
  const char *says;         /* part of the line */
} refusal;

/* Runs each case: this exit code, this many lines, and no new entry in the folder. */
static void assert_refusals(const refusal *cases, size_t count, int code, int lines) {
  const int before = count_entries(folder);
  for (size_t n = 0; n < count; n++) {
    const char *const *a = cases[n].arguments;
    program_result run = thrum_run(folder, "simulate", a[0], a[1], a[2], a[3], a[4], a[5], a[6],
                                   a[7], (const char *)NULL);

    // a refusal is the right exit code and lines, nothing on standard output, no new file
    const bool as_should = run.exit_code == code && line_count_is(run.err, lines) &&
                           strstr(run.err, cases[n].says) != NULL && run.out[0] == 0 &&
                           count_entries(folder) == before;
    if (!as_should)
      print_error("case %zu (%s): exit code %d, %s\n", n, cases[n].says, run.exit_code, run.err);
    assert_true(as_should);
    program_result_free(&run);
  }
}

static void mistakes_of_usage_exit_with_two_and_write_nothing(void **state) {
  (void)state;
  static const refusal cases[] = {
      {{"particle.npz", "-o", "never", "--dt", "1e9"}, "is longer than the whole run, --time 10"},
      {{NULL}, "no model given"},
      {{"particle.npz"}, "-o RUN"},
      {{"particle.npz", "more", "-o", "run"}, "'more'"},
      {{"particle.npz", "-o"}, "needs a value"},
      {{"particle.npz", "-o", "run", "--bogus"}, "--bogus"},
      {{"particle.npz", "-o", "run", "--json=1"}, "takes no value"},

      // values out of their range, or no number at all
      {{"particle.npz", "-o", "run", "--integrator", "euler"}, "euler"},
      {{"particle.npz", "-o", "run", "--dt", "0"}, "--dt"},
      {{"particle.npz", "-o", "run", "--dt", "-0.1"}, "--dt"},
      {{"particle.npz", "-o", "run", "--dt", "0.1s"}, "0.1s"},
      {{"particle.npz", "-o", "run", "--dt", "nan"}, "--dt"},
      {{"particle.npz", "-o", "run", "--time", "0"}, "--time"},
      {{"particle.npz", "-o", "run", "--time", "inf"}, "--time"},
      {{"particle.npz", "-o", "run", "--time", "1e300"}, "steps"},
      {{"particle.npz", "-o", "run", "--damping", "-1"}, "--damping"},
      {{"particle.npz", "-o", "run", "--damping", "1,x"}, "--damping"},
      {{"particle.npz", "-o", "run", "--damping-form", "none"}, "--damping-form"},
      {{"particle.npz", "-o", "run", "--split", "-1"}, "--split"},
      {{"particle.npz", "-o", "run", "--split", "fast"}, "--split"},
      {{"particle.npz", "-o", "run", "--split-form", "thesis"},
       "--split-form is of imexv, and energy steps"},
      {{"particle.npz", "-o", "run", "--integrator=newmark", "--split=1"},
       "--split is of imexv, and newmark"},
      {{"particle.npz", "-o", "run", "--safety", "0"}, "--safety"},
      {{"particle.npz", "-o", "run", "--safety", "1.1"}, "--safety"},
      {{"particle.npz", "-o", "run", "--newmark", "0.25"}, "--newmark"},
      {{"particle.npz", "-o", "run", "--newmark", "0.25,1.5"}, "--newmark"},
      {{"particle.npz", "-o", "run", "--tolerance", "-1e-9"}, "--tolerance"},
      {{"particle.npz", "-o", "run", "--tolerance", "0.1"}, "--tolerance"},
      {{"particle.npz", "-o", "run", "--iterations", "0"}, "--iterations"},

      // output rates and starts
      {{"particle.npz", "-o", "run", "--frames", "0"}, "--frames"},
      {{"particle.npz", "-o", "run", "--frames", "every-0"}, "--frames"},
      {{"particle.npz", "-o", "run", "--frames", "every-1.5"}, "--frames"},
      {{"particle.npz", "-o", "run", "--record-every", "0"}, "--record-every"},
      {{"particle.npz", "-o", "run", "--start", ""}, "--start"},
      {{"particle.npz", "-o", "run", "--start", "mode:1"}, "mode:NUMBER,METRES"},
      {{"particle.npz", "-o", "run", "--start", "mode:0,1"}, "mode:NUMBER,METRES"},
      {{"particle.npz", "-o", "run", "--start", "mode:1,nan"}, "mode:NUMBER,METRES"},
      {{"particle.npz", "-o", "run", "--start", "mode:1,"}, "mode:NUMBER,METRES"},
  };

  assert_refusals(cases, sizeof cases / sizeof cases[0], 2, 1);
}

static void misspelt_loads_exit_with_two_and_say_what_is_wrong(void **state) {
  (void)state;
#define LOAD(load, says)                                                                           \
  { {"particle.npz", "-o", "run", "--load", load}, says }
  static const refusal cases[] = {
      // the kind of the load and its vector
      LOAD("", "begins with impulse:"),
      LOAD("push:0,0,1@tip", "begins with impulse:"),
      LOAD("impulse", "begins with impulse:"),
      LOAD("squar:0,0,1@tip", "did you mean square:?"),
      LOAD("impulse:", "x,y,z"),
      LOAD("ramp:0,0,1@tip", "a ramp needs its end in s, such as until=1"),
      LOAD("impulse:0,1@tip", "'0,1' is not x,y,z"),
      LOAD("impulse:0,0,1e999@tip", "is not x,y,z"),
      LOAD("impulse:0,0,nan@tip", "is not x,y,z"),

      // the place where it acts
      LOAD("impulse:0,0,1", "say where it acts"),
      LOAD("impulse:0,0,1@", "say where it acts"),
      LOAD("impulse:0,0,1@vertex=0", "from 1"),
      LOAD("impulse:0,0,1@vertex=-2", "from 1"),
      LOAD("impulse:0,0,1@vertex=", "from 1"),
      LOAD("impulse:0,0,1@vertex=99999999999999999999", "from 1"),

      // its keys and their values
      LOAD("impulse:0,0,1@tip,f=1", "only a sine"),
      LOAD("impulse:0,0,1@tip,untl=1", "unknown key 'untl'"),
      LOAD("impulse:0,0,1@tip,until=", "'' is not a number"),
      LOAD("impulse:0,0,1@tip,until=0", "end after that"),
      LOAD("impulse:0,0,1@tip,from=-1", "begin at 0 s"),
      LOAD("impulse:0,0,1@tip,from=2,until=1", "end after that"),
      LOAD("impulse:0,0,1@tip,until=1,until=2", "given twice"),
      LOAD("sine:0,0,1@tip", "f=1"),
      LOAD("sine:0,0,1@tip,f=0", "f=1"),

      // gravity, which acts on the whole body
      LOAD("gravity:0,-9.81", "m/s^2"),
      LOAD("gravity:0,0,-9.81@tip", "whole body"),
  };

#undef LOAD
  assert_refusals(cases, sizeof cases / sizeof cases[0], 2, 1);
}

static void requests_beyond_the_model_and_its_files_are_refused_in_one_line(void **state) {
  (void)state;
  static const refusal cases[] = {
      {{"nowhere.npz", "-o", "run"}, "nowhere.npz"},
      {{"text.npz", "-o", "run"}, "text.npz"},
      {{"foreign", "-o", "run"}, "foreign"},
      {{"hors", "-o", "run"}, "did you mean 'horse'?"},

      // targets, starts and numbers that the model does not have
      {{"particle.npz", "-o", "run", "--load", "impulse:0,0,1@top"}, "tip, a, b, held"},
      {{"particle.npz", "-o", "run", "--load", "impulse:0,0,1@vertex=5"}, "1 to 4"},
      {{"particle.npz", "-o", "run", "--start", "mode:3,1"}, "modes 1 to 2"},
      {{"particle.npz", "-o", "run", "--start", "nowhere.npy"}, "nowhere.npy"},
      {{"particle.npz", "-o", "run", "--start", "three.npy"}, "three.npy: 1 x 3"},
      {{"particle.npz", "-o", "run", "--start", "rows.npy"}, "rows.npy: 3 x 2"},
      {{"particle.npz", "-o", "run", "--start", "infinite.npy"}, "finite"},
      {{"particle.npz", "-o", "run", "--start", "huge.npy"}, "--start: "},
      {{"particle.npz", "-o", "run", "--start", "text.npz"}, "text.npz"},
      {{"particle.npz", "-o", "run", "--start", "mode:1,1e308"}, "--start"},
      {{"particle.npz", "-o", "run", "--integrator=imexv", "--split=3"}, "--split 3"},
      {{"particle.npz", "-o", "run", "--rank", "3"},
       "--rank: rank 3 is asked for; the model has 1 to 2"},
      {{"particle.npz", "-o", "run", "--dt", "1e308", "--time", "1e308"}, "thrum: --dt: "},

      // a model without a mesh
      {{"bare.npz", "-o", "run", "--load", "constant:0,0,1@all"}, "no basis"},
      {{"bare.npz", "-o", "run", "--load", "gravity:0,0,1"}, "axis_mass"},
      {{"bare.npz", "-o", "run", "--start", "mode:1,1"}, "no basis"},
      {{"bare.npz", "-o", "run", "--frames", "30"}, "no mesh"},

      // places that a run cannot be written to
      {{"particle.npz", "-o", ""}, "-o"},
      {{"particle.npz", "-o", "file"}, "is a file"},
      {{"particle.npz", "-o", "no/such/run"}, "no/such/run"},
      {{"particle.npz", "-o", "foreign"}, "no earlier run"},
      {{"particle.npz", "-o", "other"}, "no earlier run"},
      {{"particle.npz", "-o", "scene"}, "holds a run of a scene, not of a model"},
  };

  assert_refusals(cases, sizeof cases / sizeof cases[0], 1, 1);

  // what was there is as it was
  assert_int_equal(count_entries(in_folder("foreign")), 1);
  char *notes = text_file_read(in_folder("foreign/notes.txt"));
  assert_string_equal(notes, "mine\n");
  free(notes);
}

static void run_ok(const char *run, const char *time) {
  program_result result = thrum_run(folder, "simulate", "particle.npz", "-o", run, "--time", time,
                                    "--start", "mode:1,0.1", "--frames", "every-10", NULL);
  if (result.exit_code != 0)
    print_error("%s", result.err);
  assert_int_equal(result.exit_code, 0);
  program_result_free(&result);
}

static void an_earlier_run_is_replaced_and_other_files_are_kept(void **state) {
  (void)state;

  // a run with frames up to number 10, and two files of the user in its folders
  run_ok("again", "0.3");
  assert_true(file_exists(in_folder("again/frames/frame_000010.vtu")));
  assert_true(text_file_write(in_folder("again/notes.txt"), "mine\n"));
  assert_true(text_file_write(in_folder("again/frames/view.pvsm"), "mine too\n"));

  // the second run, with frames up to number 5, takes its place
  const int before = count_entries(in_folder("again"));
  run_ok("again//", "0.15");
  assert_int_equal(count_entries(in_folder("again")), before);

  // the frames of the first run are gone; its other files are replaced
  assert_true(file_exists(in_folder("again/frames/frame_000005.vtu")));
  assert_false(file_exists(in_folder("again/frames/frame_000006.vtu")));

  // the user's files are as they were
  char *notes = text_file_read(in_folder("again/notes.txt"));
  assert_string_equal(notes, "mine\n");
  free(notes);
  assert_true(file_exists(in_folder("again/frames/view.pvsm")));

  int64_t count = 0;
  energy_row *rows = read_energies(in_folder("again/energy.csv"), &count);
  assert_int_equal(count, 51);
  free(rows);
}

static void an_empty_folder_is_used(void **state) {
  (void)state;
  assert_int_equal(mkdir(in_folder("empty"), 0777), 0);
  run_ok("empty", "0.15");
  assert_true(file_exists(in_folder("empty/run.json")));

  // a refusal leaves an earlier run as it was
  program_result run =
      thrum_run(folder, "simulate", "particle.npz", "-o", "empty", "--start", "mode:9,1", NULL);
  assert_int_equal(run.exit_code, 1);
  program_result_free(&run);
  assert_true(file_exists(in_folder("empty/run.json")));
}

static void a_run_that_cannot_be_written_leaves_nothing(void **state) {
  (void)state;
  char command[400], program[] = "/bin/sh", option[] = "-c";

  // files end at 8 blocks of 512 bytes here, long before the series does
  snprintf(command, sizeof command,
           "ulimit -f 8; exec %s simulate particle.npz -o limited --time 30 --start mode:1,0.1",
           THRUM_PROGRAM);

  char *argv[] = {program, option, command, NULL};
  const int before = count_entries(folder);

  program_result run = program_execute(folder, argv);
  assert_int_equal(run.exit_code, 1);
  assert_true(line_count_is(run.err, 1));
  assert_non_null(strstr(run.err, "could not be written"));
  program_result_free(&run);
  assert_int_equal(count_entries(folder), before);

  // an earlier run stays as it was
  run_ok("limited", "0.03");
  const int files = count_entries(in_folder("limited"));
  run = program_execute(folder, argv);
  assert_int_equal(run.exit_code, 1);
  program_result_free(&run);
  assert_int_equal(count_entries(in_folder("limited")), files);

  int64_t count = 0;
  energy_row *rows = read_energies(in_folder("limited/energy.csv"), &count);
  assert_int_equal(count, 11);
  free(rows);
}

/* Returns whether the run's folder of unfinished output is there, that is whether it is under way.
 */
static bool is_under_way(const char *run) {
  char start[80];
  snprintf(start, sizeof start, "%s.thrum-partial", run);
  bool found = false;
  DIR *entries = opendir(folder);
  assert_non_null(entries);
  for (const struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries))
    found = found || strncmp(entry->d_name, start, strlen(start)) == 0;
  closedir(entries);
  return found;
}

static void wait_a_little(void) {
  const struct timespec moment = {0, 20000000};
  nanosleep(&moment, NULL);
}

/* Starts a run that would take for ever, sends it a signal; returns its exit code. */
static int stop_run(const char *name, int signal_number) {
  const pid_t child = fork();
  assert_true(child >= 0);

  // the child's signal acts as usual, whatever the parent's disposition is
  if (child == 0) {
    signal(signal_number, SIG_DFL);
    if (chdir(folder) == 0 && freopen("/dev/null", "w", stderr) != NULL &&
        freopen("stopped.json", "w", stdout) != NULL)
      execl(THRUM_PROGRAM, THRUM_PROGRAM, "simulate", "particle.npz", "-o", name, "--time", "1e8",
            "--record-every", "100000", "--start", "mode:1,0.1", "--json", (char *)NULL);
    _exit(126);
  }

  // let it begin, and then make some steps
  for (int n = 0; n < 1000 && !is_under_way(name); n++)
    wait_a_little();
  for (int n = 0; n < 10; n++)
    wait_a_little();
  assert_int_equal(kill(child, signal_number), 0);

  int status = 0;
  assert_true(waitpid(child, &status, 0) == child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void a_run_without_a_step_is_flagged_and_shows_no_nan(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "simulate", "bare.npz", "-o", "stuck", "--integrator", "midpoint",
                "--fallback", "off", "--iterations", "1", "--start", "far.npy", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.out, "steps        0 (0 s)\n"));
  assert_null(strstr(run.out, "nan"));
  program_result_free(&run);
}

static void a_stopped_run_is_written_and_flagged(void **state) {
  (void)state;
  static const int signals[] = {SIGINT, SIGTERM};
  char name[40];
  for (int n = 0; n < 2; n++) {
    snprintf(name, sizeof name, "stopped%d", n);
    assert_int_equal(stop_run(name, signals[n]), 3);
    assert_false(is_under_way(name));

    // the rows are those of the steps that were made
    char *text = text_file_read(in_folder("stopped.json"));
    cJSON *object = json_line(text);
    assert_non_null(object);
    assert_string_equal(cJSON_GetObjectItemCaseSensitive(object, "status")->valuestring,
                        "interrupted");
    const double steps = json_value(object, "steps"), rows = json_value(object, "rows");
    assert_true(steps > 0 && rows == floor(steps / 100000) + 1);

    // and so are those of the file
    double *q = NULL;
    int64_t got_rows = 0, columns = 0;
    snprintf(name, sizeof name, "stopped%d/q.npy", n);
    assert_int_equal(thrum_npy_read_f8(in_folder(name), &q, &got_rows, &columns, NULL), 0);
    assert_true((double)got_rows == rows && columns == 2);

    free(q);
    cJSON_Delete(object);
    free(text);
  }
}

static void help_goes_to_standard_output(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "simulate", "--help", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_true(run.err[0] == 0);
  assert_non_null(strstr(run.out, "usage: thrum simulate MODEL -o RUN"));
  program_result_free(&run);
}

int main(void) {
  signals_as_in_a_terminal();
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(mistakes_of_usage_exit_with_two_and_write_nothing),
      cmocka_unit_test(misspelt_loads_exit_with_two_and_say_what_is_wrong),
      cmocka_unit_test(requests_beyond_the_model_and_its_files_are_refused_in_one_line),
      cmocka_unit_test(an_earlier_run_is_replaced_and_other_files_are_kept),
      cmocka_unit_test(an_empty_folder_is_used),
      cmocka_unit_test(a_run_that_cannot_be_written_leaves_nothing),
      cmocka_unit_test(a_run_without_a_step_is_flagged_and_shows_no_nan),
      cmocka_unit_test(a_stopped_run_is_written_and_flagged),
      cmocka_unit_test(help_goes_to_standard_output),
  };
  return cmocka_run_group_tests(tests, make_models, remove_folder);
}
