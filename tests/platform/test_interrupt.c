/* A program that is stopped while it makes a file leaves neither a partial file nor a temporary
 * one. SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include "io/file.h"
#include "io/folder.h"
#include "platform/interrupt.h"
#include "platform/stop_request.h"
#include "tests/support/test_folder.h"

static int count_files(void) {
  DIR *entries = opendir(folder);
  assert_non_null(entries);
  int count = 0;
  for (const struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries))
    count += entry->d_name[0] != '.';
  closedir(entries);
  return count;
}

/* Runs in a child process, which stops itself by the signal `number` while it writes a file. */
static void stop_while_writing(const char *path, int number) {
  const int silent = open("/dev/null", O_WRONLY);
  dup2(silent, STDERR_FILENO);
  thrum_interrupt_clean("stopped\n");
  thrum_file_writer writer = {NULL, NULL, NULL};
  if (thrum_file_writer_open(path, &writer, NULL) != THRUM_OK ||
      thrum_file_writer_put(&writer, "half", 4, NULL) != THRUM_OK || count_files() != 2)
    _exit(1);
  raise(number);
  _exit(2);
}

static void a_signal_while_a_file_is_written_leaves_the_old_one_alone(void **state) {
  (void)state;
  static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};

  // a complete file from earlier
  char path[160];
  snprintf(path, sizeof path, "%s/kept.npz", folder);
  assert_true(text_file_write(path, "earlier"));

  // each signal ends the child, which leaves no temporary file
  for (int n = 0; n < 3; n++) {
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0)
      stop_while_writing(path, numbers[n]);
    int status = 0;
    assert_true(waitpid(child, &status, 0) == child);
    assert_true(WIFSIGNALED(status));
    assert_int_equal(WTERMSIG(status), numbers[n]);
    assert_int_equal(count_files(), 1);
  }

  // the earlier file is unchanged
  char *text = text_file_read(path);
  assert_string_equal(text, "earlier");

  free(text);
  unlink(path);
}

/* A folder that a command makes goes again while it is empty, when a signal or a failure ends it;
 * one that was there before, or holds something, stays. */
static void a_new_folder_goes_while_it_is_empty(void **state) {
  (void)state;
  for (int n = 0; n < 6; n++) {
    const bool by_signal = n < 3, before = n % 3 == 1, filled = n % 3 == 2;
    char path[160], inside[200];
    snprintf(path, sizeof path, "%s/made", folder);
    snprintf(inside, sizeof inside, "%s/some", path);
    if (before)
      assert_int_equal(folder_make(path, NULL), THRUM_OK);
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
      const int silent = open("/dev/null", O_WRONLY);
      dup2(silent, STDERR_FILENO);
      thrum_interrupt_clean("stopped\n");
      if (folder_make_output(path, NULL) < 0 || (filled && !text_file_write(inside, "some")))
        _exit(1);
      if (by_signal)
        raise(SIGINT);
      folder_give_up(path);
      _exit(0);
    }
    int status = 0;
    assert_true(waitpid(child, &status, 0) == child);
    assert_int_equal(WIFSIGNALED(status) != 0, by_signal);
    assert_int_equal(access(path, F_OK) == 0, before || filled);
    unlink(inside);
    rmdir(path);
  }
}

/* Starts the program and stops it by SIGINT once it reports `stage`; it says `line`. Returns how it
 * ended, as waitpid does. */
static int stop_program(const char *const *arguments, const char *stage, const char *line) {
  // the child's output is collected outside of the folder whose files are counted
  const char *argv[20] = {THRUM_PROGRAM};
  char said[160];
  for (int n = 0; arguments[n] != NULL; n++)
    argv[n + 1] = arguments[n];
  snprintf(said, sizeof said, "/tmp/thrum-said-%ld", (long)getpid());
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    const int file = open(said, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (file < 0 || dup2(file, STDERR_FILENO) < 0 || dup2(file, STDOUT_FILENO) < 0)
      _exit(126);
    execv(THRUM_PROGRAM, (char *const *)(uintptr_t)argv);
    _exit(127);
  }

  // the signal comes as soon as the stage is reported
  const struct timespec pause = {0, 5000000};
  bool there = false;
  for (int n = 0; n < 12000 && !there; n++) {
    char *text = text_file_read(said);
    there = text != NULL && strstr(text, stage) != NULL;
    free(text);
    nanosleep(&pause, NULL);
  }
  kill(child, there ? SIGINT : SIGKILL);
  int status = 0;
  assert_true(waitpid(child, &status, 0) == child);
  char *text = text_file_read(said);
  assert_non_null(text);
  if (strstr(text, line) == NULL)
    fail_msg("expected '%s' in %s", line, text);
  free(text);
  unlink(said);
  return status;
}

/* A precompute of some seconds with up to four more options. */
static void stop_in_stage(const char *mesh, const char *stage, const char *line,
                          const char *const options[4]) {
  char model[160];
  snprintf(model, sizeof model, "%s/made.npz", folder);
  const char *const arguments[] = {"precompute", mesh,       "--fix",    "left",     "-o", model,
                                   options[0],   options[1], options[2], options[3], NULL};

  // the signal ends it, and it says what it has written
  const int status = stop_program(arguments, stage, line);
  assert_true(WIFSIGNALED(status));
  assert_int_equal(WTERMSIG(status), SIGINT);
  assert_int_equal(count_files(), 0);
}

static void a_signal_in_a_stage_leaves_no_file(void **state) {
  (void)state;
  static const char large[] = "beam:30x12x12@1x0.2x0.2", nothing[] = "stopped; nothing was written";
  static const char *const linear[4] = {"--order", "1"};
  stop_in_stage(large, "stiffness and mass", nothing, linear);
  // one long call of a library
  stop_in_stage(large, "stiffness solver", nothing, linear);

  // a training goes on with the runs that it has kept, here in the folder itself
  const char *const kept[4] = {"--train=gravity:0,0,-1", "--train-time=1000", "--keep-runs",
                               folder};
  stop_in_stage("beam:8x2x2@1x0.2x0.2", "training ", "goes on with the runs that are kept", kept);
}

static void a_signal_in_a_search_leaves_no_file(void **state) {
  (void)state;
  char output[160];
  snprintf(output, sizeof output, "%s/search", folder);
  const char *const arguments[] = {
      "tradeoff", "beam:8x2x2@1x0.2x0.2",   "--order", "1",   "--fix", "left",
      "--load",   "constant:0,0,-10@right", "--time",  "300", "-o",    output,
      NULL};
  const int status = stop_program(arguments, "full order", "stopped; nothing was written");
  assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT);

  // the folder that it made is gone too
  assert_int_equal(access(output, F_OK), -1);
}

/* A run that is over is written, with the mesh beside it as far as it came. */
static void a_signal_beside_the_mesh_leaves_the_run(void **state) {
  (void)state;
  char model[160], output[160], path[200];
  snprintf(model, sizeof model, "%s/beam.npz", folder);
  snprintf(output, sizeof output, "%s/run", folder);
  program_result made =
      thrum_run(folder, "precompute", "beam:8x2x2@1x0.2x0.2", "--order", "1", "--fix", "left",
                "--modes", "3", "--rank", "3", "-o", model, NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);
  const char *const arguments[] = {"simulate",       model,   "--load",  "constant:0,0,-1@right",
                                   "--time",         "60",    "--judge", "off",
                                   "--dt",           "0.005", "-o",      output,
                                   "--against-mesh", "600s",  NULL};
  const int status = stop_program(arguments, "against the mesh", "of 60 s: stopped");
  assert_true(WIFEXITED(status));
  snprintf(path, sizeof path, "%s/run.json", output);
  char *text = text_file_read(path);
  assert_non_null(text);
  cJSON *object = cJSON_Parse(text);
  assert_non_null(object);
  const cJSON *against = cJSON_GetObjectItemCaseSensitive(object, "against_mesh");
  assert_string_equal(cJSON_GetObjectItemCaseSensitive(against, "ended")->valuestring, "stopped");
  cJSON_Delete(object);
  free(text);

  // rows of the comparison are whole
  snprintf(path, sizeof path, "%s/against_mesh.csv", output);
  text = text_file_read(path);
  assert_non_null(text);
  assert_true(text[0] != 0 && text[strlen(text) - 1] == '\n');
  free(text);
}

/* A command that has no line of its own says the same. */
static void a_signal_while_a_sheet_is_made_leaves_no_file(void **state) {
  (void)state;
  enum { CELLS = 200 };
  char surface[160], output[160];
  snprintf(surface, sizeof surface, "%s/roof.obj", folder);
  snprintf(output, sizeof output, "%s/roof.vtu", folder);
  FILE *file = fopen(surface, "w");
  assert_non_null(file);
  for (int n = 0; n < (CELLS + 1) * (CELLS + 1); n++)
    fprintf(file, "v %d %d 0\n", n / (CELLS + 1), n % (CELLS + 1));
  for (int n = 0; n < CELLS * CELLS; n++) {
    const int first = n / CELLS * (CELLS + 1) + n % CELLS + 1;
    fprintf(file, "f %d %d %d %d\n", first, first + CELLS + 1, first + CELLS + 2, first + 1);
  }
  assert_int_equal(fclose(file), 0);
  const char *const arguments[] = {"mesh", surface, "-o", output, "--thickness", "0.1", NULL};
  const int status = stop_program(arguments, "making the sheet", "stopped; nothing was written");
  assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT);
  assert_int_equal(access(output, F_OK), -1);
  unlink(surface);
}

/* A curve that is stopped when it is followed again, for its stability, is that of the first time.
 */
static void a_signal_in_the_second_pass_of_a_curve_keeps_the_first(void **state) {
  (void)state;
  char model[160], output[160];
  snprintf(model, sizeof model, "%s/curve.npz", folder);
  snprintf(output, sizeof output, "%s/curve", folder);
  program_result made =
      thrum_run(folder, "precompute", "beam:8x2x2@1x0.2x0.2", "--order", "1", "--fix", "left",
                "--modes", "3", "--rank", "9", "-o", model, NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);
  const char *const arguments[] = {
      "response", model,    "--mode", "1",        "--amplitude", "0.3", "--no-check", "--stability",
      "off",      "--step", "2e-5",   "--points", "20000",       "-o",  output,       NULL};
  const int status = stop_program(arguments, "curve, 9 harmonics", "what was found is kept");
  assert_true(WIFEXITED(status));
  assert_int_equal(WEXITSTATUS(status), 3);
}

static void end_with_seven(void *context) {
  _exit(*(int *)context);
}

/* How a child process ends that stops itself, and goes on for a while in a call that cannot be
 * broken off: with or without another way to end, heeding the request or not. */
static int stopped_in_a_call(bool way, bool heeds) {
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    int seven = 7;
    const struct timespec pause = {0, 100000000};
    thrum_stop_request_catch();
    thrum_stop_request_end_by(way ? end_with_seven : NULL, &seven);
    raise(SIGINT);
    for (int n = 0; n < 15; n++) {
      nanosleep(&pause, NULL);
      if (heeds && !thrum_stop_requested())
        _exit(1);
    }
    _exit(thrum_stop_requested() ? 3 : 2);
  }
  int status = 0;
  assert_true(waitpid(child, &status, 0) == child);
  assert_true(WIFEXITED(status));
  return WEXITSTATUS(status);
}

static void a_long_call_is_not_waited_for_where_there_is_another_way_to_end(void **state) {
  (void)state;
  assert_int_equal(stopped_in_a_call(true, false), 7);
  assert_int_equal(stopped_in_a_call(true, true), 3);
  assert_int_equal(stopped_in_a_call(false, false), 3);
}

int main(void) {
  signals_as_in_a_terminal();
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_new_folder_goes_while_it_is_empty),
      cmocka_unit_test(a_signal_while_a_file_is_written_leaves_the_old_one_alone),
      cmocka_unit_test(a_signal_in_a_stage_leaves_no_file),
      cmocka_unit_test(a_signal_while_a_sheet_is_made_leaves_no_file),
      cmocka_unit_test(a_signal_in_the_second_pass_of_a_curve_keeps_the_first),
      cmocka_unit_test(a_long_call_is_not_waited_for_where_there_is_another_way_to_end),
      cmocka_unit_test(a_signal_in_a_search_leaves_no_file),
      cmocka_unit_test(a_signal_beside_the_mesh_leaves_the_run),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
