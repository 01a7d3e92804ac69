/* Tests of what happens to an earlier run where a new one takes its place: it is replaced as a
 * whole or stays as it was, whatever stands in the way, whichever other process writes there, and
 * whenever the process is killed. SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <math.h>
#include <signal.h>
#include <time.h>

#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

#define NOBODY 65534

static int make_models(void **state) {
  (void)state;
  const char *scene = "{\"time\": 0.03, \"bodies\": [{\"name\": \"a\", \"model\": "
                      "\"particle.npz\", \"start\": \"mode:1,0.1\"}]}";
  const bool made = test_folder_make(folder) != NULL &&
                    save_particle(in_folder("particle.npz"), 100, 400) &&
                    text_file_write(in_folder("scene.json"), scene);
  return !made;
}

static program_result simulate(const char *name, const char *time) {
  return thrum_run(folder, "simulate", "particle.npz", "-o", name, "--time", time, "--start",
                   "mode:1,0.1", "--frames", "every-10", "-q", NULL);
}

static void run_ok(const char *name, const char *time) {
  program_result run = simulate(name, time);
  if (run.exit_code != 0)
    print_error("%s", run.err);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
}

/* Steps of the run in a folder; the run is whole, as run.json says as much as energy.csv has. */
static double steps_of(const char *name) {
  char path[200];
  snprintf(path, sizeof path, "%s/%s/run.json", folder, name);
  char *text = text_file_read(path);
  if (text == NULL)
    fail_msg("there is no %s", path);
  cJSON *object = cJSON_Parse(text);
  const double steps = json_value(object, "steps"), rows = json_value(object, "rows");
  cJSON_Delete(object);
  free(text);

  // the rows of the file are those that run.json counts
  int64_t count = 0;
  snprintf(path, sizeof path, "%s/%s/energy.csv", folder, name);
  energy_row *energies = read_energies(path, &count);
  assert_true((double)count == rows);
  free(energies);
  return steps;
}

/* The run is refused or fails in one line that says this. */
static void expect_refused(program_result run, const char *says) {
  if (run.exit_code != 1 || !line_count_is(run.err, 1) || strstr(run.err, says) == NULL)
    fail_msg("exit code %d, not '%s': %s", run.exit_code, says, run.err);
  program_result_free(&run);
}

/* Entries of the test's folder whose name begins like this; counted. */
static int count_named(const char *start) {
  int count = 0;
  DIR *entries = opendir(folder);
  assert_non_null(entries);
  for (const struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries))
    count += strncmp(entry->d_name, start, strlen(start)) == 0;
  closedir(entries);
  return count;
}

/* --- what stands in the way ------------------------------------------------------------------- */

static void a_folder_with_the_name_of_a_file_leaves_the_earlier_run(void **state) {
  (void)state;
  run_ok("way", "0.3");
  assert_int_equal(mkdir(in_folder("way/places.npy"), 0777), 0);
  expect_refused(simulate("way", "0.15"), "way/places.npy: is no part of a run");
  assert_true(steps_of("way") == 100 && file_exists(in_folder("way/frames/frame_000010.vtu")));
  assert_int_equal(count_named("way"), 1);

  // without it the run is replaced
  assert_int_equal(rmdir(in_folder("way/places.npy")), 0);
  run_ok("way", "0.15");
  assert_true(steps_of("way") == 50);
}

static void the_same_goes_for_scenes(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "both", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // folders of the user's have names of files, in the folder of the scene and in that of its body
  static const char *const ways[] = {"both/probes.csv", "both/a/end.npy.tmp", "both/a/q.npy"};
  for (int n = 0; n < 3; n++) {
    remove(in_folder(ways[n]));
    assert_int_equal(mkdir(in_folder(ways[n]), 0777), 0);
    expect_refused(thrum_run(folder, "simulate", "scene.json", "-o", "both", "-q", NULL), ways[n]);
    assert_true(file_exists(in_folder("both/scene.json")));
    assert_true(file_exists(in_folder("both/a/energy.csv")));
    assert_int_equal(count_named("both"), 1);
    assert_int_equal(rmdir(in_folder(ways[n])), 0);
  }
}

static void the_folder_that_the_program_runs_in_is_not_replaced(void **state) {
  (void)state;
  run_ok("here", "0.3");
  expect_refused(thrum_run(in_folder("here"), "simulate", "../particle.npz", "-o", ".", "--start",
                           "mode:1,0.1", "-q", NULL),
                 "the folder that the program runs in");
  assert_true(steps_of("here") == 100);
}

static void a_link_to_an_earlier_run_stays_a_link(void **state) {
  (void)state;
  run_ok("target", "0.3");
  assert_int_equal(symlink("target", in_folder("link")), 0);
  run_ok("link", "0.15");
  struct stat status;
  assert_true(lstat(in_folder("link"), &status) == 0 && S_ISLNK(status.st_mode));
  assert_true(steps_of("target") == 50);
}

/* Runs simulate as a user who may not write everywhere. */
static program_result simulate_as_nobody(const char *name) {
  char setpriv[] = "/usr/bin/setpriv", user[] = "--reuid=65534", groups[] = "--clear-groups";
  char program[] = THRUM_PROGRAM, command[] = "simulate", model[] = "particle.npz", o[] = "-o";
  char run[64], start[] = "--start", mode[] = "mode:1,0.1", quiet[] = "-q";
  snprintf(run, sizeof run, "%s", name);
  char *argv[] = {setpriv, user, groups, program, command, model, o, run, start, mode, quiet, NULL};
  return program_execute(folder, geteuid() == 0 ? argv : argv + 3);
}

static void a_folder_that_may_not_be_changed_leaves_the_earlier_run(void **state) {
  (void)state;
  run_ok("locked", "0.3");
  static const char *const paths[] = {"", "locked", "locked/frames"};
  for (int n = 0; geteuid() == 0 && n < 3; n++)
    if (chown(in_folder(paths[n]), NOBODY, NOBODY) != 0)
      skip();

  // permissions do not stop root, so another user tries
  assert_int_equal(chmod(in_folder("locked/frames"), 0555), 0);
  program_result run = simulate_as_nobody("locked");
  if (run.exit_code == 127 || run.exit_code == 126) {
    print_message("skipped: no program sets another user here\n");
    program_result_free(&run);
    skip();
  }
  expect_refused(run, "locked/frames: cannot be replaced (Permission denied)");
  assert_true(steps_of("locked") == 100);
  assert_true(file_exists(in_folder("locked/frames/frame_000010.vtu")));
  assert_int_equal(count_named("locked"), 1);
  assert_int_equal(chmod(in_folder("locked/frames"), 0755), 0);
}

/* --- other processes -------------------------------------------------------------------------- */

static void wait_a_little(void) {
  const struct timespec moment = {0, 20000000};
  nanosleep(&moment, NULL);
}

/* Starts a run that would take for ever; it is under way when its first files are there. */
static pid_t start_run(const char *name) {
  fflush(NULL);
  const pid_t child = fork();
  assert_true(child >= 0);
  if (child == 0) {
    if (chdir(folder) == 0 && freopen("stopped.err", "w", stderr) != NULL &&
        freopen("/dev/null", "w", stdout) != NULL)
      execl(THRUM_PROGRAM, THRUM_PROGRAM, "simulate", "particle.npz", "-o", name, "--time", "1e8",
            "--record-every", "100000", "--start", "mode:1,0.1", (char *)NULL);
    _exit(126);
  }

  // the child has its work folder before it has stepped for long
  char work[100];
  snprintf(work, sizeof work, "%s.thrum-partial/q.npy", name);
  for (int n = 0; n < 1000 && !file_exists(in_folder(work)); n++)
    wait_a_little();
  assert_true(file_exists(in_folder(work)));
  return child;
}

static int end_run(pid_t child, int signal_number) {
  int status = 0;
  assert_int_equal(kill(child, signal_number), 0);
  assert_true(waitpid(child, &status, 0) == child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void of_two_processes_into_one_run_the_later_is_refused(void **state) {
  (void)state;

  // both where there is no run yet and where there is one
  for (int n = 0; n < 2; n++) {
    const pid_t child = start_run("shared");
    expect_refused(simulate("shared", "0.15"), "another process is writing a run there");
    wait_a_little();
    assert_int_equal(end_run(child, SIGINT), 3);
    assert_true(steps_of("shared") > 0);
    assert_int_equal(count_named("shared"), 1);
  }
  run_ok("shared", "0.15");
  assert_true(steps_of("shared") == 50);
}

static void what_comes_into_the_way_meanwhile_costs_neither_run(void **state) {
  (void)state;
  run_ok("meanwhile", "0.3");
  const pid_t child = start_run("meanwhile");
  assert_int_equal(mkdir(in_folder("meanwhile/end.npy.d"), 0777), 0);
  assert_int_equal(rename(in_folder("meanwhile/end.npy"), in_folder("meanwhile/end.npy.d/e")), 0);
  assert_int_equal(rename(in_folder("meanwhile/end.npy.d"), in_folder("meanwhile/end.npy")), 0);
  wait_a_little();
  assert_int_equal(end_run(child, SIGINT), 1);

  // the message says why, and where the new run is
  char *text = text_file_read(in_folder("stopped.err"));
  assert_non_null(strstr(text, "meanwhile/end.npy: is no part of a run"));
  assert_non_null(strstr(text, "meanwhile.new-1"));
  free(text);
  assert_true(steps_of("meanwhile") == 100);
  assert_true(steps_of("meanwhile.new-1") > 0);
}

/* --- killed processes ------------------------------------------------------------------------- */

static void what_a_killed_run_left_is_cleared_by_the_next(void **state) {
  (void)state;
  run_ok("killed", "0.3");
  assert_int_equal(end_run(start_run("killed"), SIGKILL), -1);
  assert_true(file_exists(in_folder("killed.thrum-partial")));
  assert_true(steps_of("killed") == 100);
  run_ok("killed", "0.15");
  assert_int_equal(count_named("killed"), 1);

  // the same where a scene is run next
  assert_int_equal(end_run(start_run("scene"), SIGKILL), -1);
  program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "scene", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  assert_int_equal(count_named("scene.thrum"), 0);
}

static void a_kill_after_the_exchange_leaves_the_users_files_for_the_next(void **state) {
  (void)state;

  // the earlier run has been exchanged and not removed
  run_ok("late", "0.3");
  run_ok("late.thrum", "0.3");
  assert_int_equal(rename(in_folder("late.thrum"), in_folder("late.thrum-partial")), 0);
  assert_true(text_file_write(in_folder("late.thrum-partial/notes.txt"), "mine\n"));
  assert_true(text_file_write(in_folder("late.thrum-partial/frames/view.pvsm"), "mine too\n"));
  run_ok("late", "0.15");
  assert_true(steps_of("late") == 50);
  assert_true(file_exists(in_folder("late/notes.txt")));
  assert_true(file_exists(in_folder("late/frames/view.pvsm")));
  assert_int_equal(count_named("late"), 1);

  // where folders are not exchanged in one step, the earlier run was moved aside
  assert_int_equal(rename(in_folder("late"), in_folder("late.thrum-earlier")), 0);
  run_ok("late", "0.3");
  assert_true(steps_of("late") == 100 && file_exists(in_folder("late/notes.txt")));
  assert_int_equal(count_named("late"), 1);
}

static void files_in_the_work_folder_that_no_run_writes_stay(void **state) {
  (void)state;
  assert_int_equal(mkdir(in_folder("own.thrum-partial"), 0777), 0);
  assert_true(text_file_write(in_folder("own.thrum-partial/notes.txt"), "mine\n"));
  expect_refused(simulate("own", "0.15"), "own.thrum-partial: holds files that are no run");
  assert_true(file_exists(in_folder("own.thrum-partial/notes.txt")));
  expect_refused(simulate("own.thrum-partial", "0.15"), "for runs in the making");
}

int main(void) {
  signals_as_in_a_terminal();
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_folder_with_the_name_of_a_file_leaves_the_earlier_run),
      cmocka_unit_test(the_same_goes_for_scenes),
      cmocka_unit_test(the_folder_that_the_program_runs_in_is_not_replaced),
      cmocka_unit_test(a_link_to_an_earlier_run_stays_a_link),
      cmocka_unit_test(of_two_processes_into_one_run_the_later_is_refused),
      cmocka_unit_test(what_comes_into_the_way_meanwhile_costs_neither_run),
      cmocka_unit_test(what_a_killed_run_left_is_cleared_by_the_next),
      cmocka_unit_test(a_kill_after_the_exchange_leaves_the_users_files_for_the_next),
      cmocka_unit_test(files_in_the_work_folder_that_no_run_writes_stay),
      cmocka_unit_test(a_folder_that_may_not_be_changed_leaves_the_earlier_run),
  };
  return cmocka_run_group_tests(tests, make_models, remove_folder);
}
